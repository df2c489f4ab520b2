"""Checks the values that a scene gives: parameters, inputs, starts, held coordinates, a swarm."""

from __future__ import annotations

from ... import limits
from ... import model as m
from ...source import Span
from ...tree import Expr, Range, names
from .. import statements as st
from .dynamics import Dynamics
from .names import KIND_TEXT, Entry, Members
from .scope import DECLARED, PLACES, Scope
from .shared import Checks, Shared, as_is, name_span

Taken = dict[str, Members]  # name of a coordinate -> indices; 0 if it has none


class Given(Checks):
    """Collects the values of one scene. Its methods are called for the clauses of the scene in
    order, and then `finish` is called."""

    def __init__(self, shared: Shared, dynamics: Dynamics, swarm: Range | None) -> None:
        super().__init__(shared)
        self.dynamics = dynamics
        self.assignments: list[m.Assignment] = []
        self.starts: list[m.Start] = []
        self.holds: list[m.Hold] = []
        self.started: Taken = {}
        self.held: Taken = {}
        self.given: dict[str, set[tuple[int, int]]] = {}  # name -> ranges of indices
        self.wrong_start = False
        self.consistent: Span | None = None
        self.members = swarm
        self.around = self._swarm(swarm) if swarm is not None else None

    def _swarm(self, swarm: Range) -> Scope | None:
        """Returns the scope of starts within the swarm's loop; None after an error."""
        scope = Scope(PLACES["start"])
        lo, hi = (self.indices.value(end, scope) for end in (swarm.lo, swarm.hi))
        inside = None
        if lo is not None and hi is not None and self._swarm_fits(swarm, lo, hi):
            inside = self.indices.enter((swarm,), scope)
        if inside is None:
            self.names.reported.add(swarm.variable)  # Avoids further errors about this name.
        return inside

    def _swarm_fits(self, swarm: Range, lo: int, hi: int) -> bool:
        if lo > hi:
            self.error(
                f"an empty swarm: {lo}..{hi}", swarm, "the lower end comes first: k = 1..1000"
            )
        elif hi - lo + 1 > limits.SWARM:
            message = f"a swarm of {hi - lo + 1:,} members; the limit is {limits.SWARM:,}"
            help = "their starts are all in memory: run it in several parts"
            self.error(message, swarm, help)
        return 0 < hi - lo + 1 <= limits.SWARM

    def swarm_of(self, expressions: tuple[Expr | None, ...], help: str = "") -> bool:
        """Reports each expression that wrongly contains the loop variable of the swarm; returns
        whether there is one."""
        if self.members is None:
            return False
        wrong = [e for e in expressions if e is not None and self.members.variable in names(e)]
        for expr in wrong:
            self.error(
                f"'{self.members.variable}' counts the members of the swarm: only starts differ"
                " from one to the next",
                expr,
                help or "parameters that do are columns of a file: --ensemble FILE.csv",
            )
        return bool(wrong)

    # start

    def start(self, clause: st.StartAt) -> None:
        if self.dynamics.solved(clause):
            self.consistent = clause.span
        for item in clause.items:
            left = item.left
            index = left.index
            checked = None
            if index is None or not self.swarm_of((index,)):
                checked = self.dynamics.start_item(item, self.around)
            if checked is None:
                self.wrong_start = True
                continue
            self.starts += checked
            taken = self.members_of(left)
            if taken is None:
                continue
            what = f"omega({left.name})" if item.function else left.name + "'" * item.order
            self._once(what, "started", taken, left.span)
            self.started.setdefault(left.name, Members()).add(*taken)
            if self._touches(self.held, left.name, taken):
                self._held_and_started(name_span(left), left.name)

    # hold

    def hold(self, clause: st.Pairs) -> None:
        for left, value in clause.items:
            checked = self._hold(left, value)
            if checked is not None:
                self.holds.append(checked)

    def _hold(self, left: st.Left, value: Expr | None) -> m.Hold | None:
        kinds = ("coordinate", "state") if self.names.states else ("coordinate",)
        nouns = " and ".join(f"{kind}s" for kind in kinds)
        known = sorted(self.names.coordinates | self.names.states)[:12]
        missing = f"the {nouns} are: {', '.join(known)}"
        entry = self.assigned(left, kinds, f"'hold' is for {nouns}", missing)
        if entry is None or entry.kind == "poisoned":
            return None
        scope = self.member_scope(left, entry, Scope(PLACES["held"]))
        if scope is None:
            return None
        taken = self.members_of(left)
        if taken is not None:
            if self._touches(self.held, left.name, taken):
                self.error(f"'{left.name}' is held already", left)
            elif self._touches(self.started, left.name, taken):
                self._held_and_started(name_span(left), left.name)
            self.held.setdefault(left.name, Members()).add(*taken)
        new = None
        if value is not None:
            target = as_is(left.name, entry.facts.dimension)
            new, _ = self.wanted(value, scope, target)
        return m.Hold(left.name, left.index, left.range, new, left.span)

    def _held_and_started(self, span: Span, name: str) -> None:
        message = f"'{name}' is held and started: what is held has no start of its own"
        self.error(message, span, f"say where it is held: hold {name} = …")

    def _once(self, name: str, what: str, members: tuple[int, int], span: Span) -> None:
        """Reports a value that a scene sets twice. A value of one member is allowed after a value
        of its whole family, which it overrides."""
        given, (lo, hi) = self.given.setdefault(name, set()), members
        if members in given or (lo < hi and any(lo <= a and b <= hi for a, b in given)):
            shown = f"a member of '{name}'" if lo < hi else f"'{name}'"
            self.error(f"{shown} is {what} already", span, "leave one of them out")
        given.add(members)

    @staticmethod
    def _touches(taken: Taken, name: str, members: tuple[int, int]) -> bool:
        return name in taken and taken[name].touch(*members)

    # set

    def set(self, clause: st.Pairs) -> None:
        for left, value in clause.items:
            checked = self._assignment(left, value)
            if checked is not None:
                self.assignments.append(checked)

    def _assignment(self, left: st.Left, value: Expr) -> m.Assignment | None:
        if first := self.shared.driven.get(left.name):
            message = f"'{left.name}' is set already, at {self.source.place(first)}"
            self.error(message, left, "leave one of them out")
            return None
        kinds, message = ("parameter", "input"), "'set' gives parameters and inputs"
        entry = self.assigned(left, kinds, message, DECLARED)
        if entry is None or entry.kind == "poisoned":
            return None
        if left.name in self.sampled:
            message = f"'{left.name}' is set by the sample block '{self.sampled[left.name]}'"
            self.error(message, name_span(left), "set a parameter of the block")
            return None
        place = PLACES["setting" if entry.kind == "parameter" else "driving"]
        scope = self.member_scope(left, entry, Scope(place))
        if scope is None:
            return None
        target = as_is(left.name, entry.facts.dimension)
        new, facts = self.wanted(value, scope, target)
        taken = self.members_of(left)
        if taken is not None:
            self._once(left.name, "set", taken, left.span)
        return m.Assignment(left.name, left.index, left.range, new, facts.time, left.span)

    def assigned(
        self, left: st.Left, kinds: tuple[str, ...], message: str, missing: str
    ) -> Entry | None:
        entry = self.names.table.get(left.name)
        if entry is None:
            self.names.unknown(left.name, name_span(left), missing=missing)
            return None
        entry.used = True
        if entry.kind not in (*kinds, "poisoned"):
            moves = entry.kind in ("coordinate", "state")
            help = f"{KIND_TEXT[entry.kind]} is started or held" if moves else ""
            if entry.kind == "parameter":
                help = f"a parameter is set: set {left.name} = …"
            self.error(
                f"{message}; '{left.name}' is {KIND_TEXT[entry.kind]}", name_span(left), help
            )
            return None
        return entry

    # the whole scene

    def finish(self) -> None:
        if self.around is not None and not self.wrong_start:
            variable = self.members.variable
            some = min(self.names.coordinates or self.names.states, default="x")
            if not any(variable in names(item.value) for item in self.starts):
                message = f"no start uses '{variable}': all members of the swarm would be the same"
                self.error(message, self.members, f"e.g. start {some} = {variable}/10")
        if self.holds and self._holds_all():
            kinds = {"coordinate": self.names.coordinates, "state": self.names.states}
            moves = " and ".join(kind for kind, names in kinds.items() if names)
            message = f"every {moves} is held: nothing is left to move"
            self.error(message, self.holds[-1], "leave out one 'hold'")

    def _holds_all(self) -> bool:
        if self.names.rotations:  # `hold` does not accept rotations.
            return False
        for coordinate in (*self.parts["coordinates"], *self.parts["states"]):
            whole = (0, 0) if coordinate.range is None else self.range_of(coordinate.name)
            held = self.held.get(coordinate.name)
            if held is None or not held.hold(*whole):
                return False
        return True
