"""Checks `exact x = EXPR within TOL`, closed forms of the motion as functions of t."""

from __future__ import annotations

from ... import model as m
from ...source import Span
from ...tree import Expr
from .. import statements as st
from .names import Members
from .scope import PLACES, Scope
from .settings import Settings
from .shared import Checks, Shared, as_is

_KINDS = ("coordinate", "state", "output", "definition")


class Exacts(Checks):
    def __init__(self, shared: Shared, settings: Settings) -> None:
        super().__init__(shared)
        self.settings = settings

    def exact(self, statement: st.Exact) -> None:
        found = self._forms(statement, self.parts["exacts"])
        self.parts["exacts"] += found
        self.exacts += found  # so that error(x) may stand in what follows

    def of_scene(self, scene: st.Scene) -> tuple[m.Exact, ...]:
        """Returns the closed forms that are valid in a scene. Those of the model are of its own
        start: a scene that starts or holds anything has its own, or none."""
        words, own = {clause.keyword for clause in scene.clauses}, []
        for clause in scene.clauses:
            if isinstance(clause, st.Exact):
                own += self._forms(clause, own)
        if own and "swarm" in words:
            message = "the members of a swarm start differently: they have no closed form in common"
            self.error(message, own[0], "leave it out, and expect what they have in common")
        names = {form.name for form in own}
        models = () if words & {"start", "hold", "swarm"} else self.parts["exacts"]
        return (*(form for form in models if form.name not in names), *own)

    def _forms(self, statement: st.Exact, before: list[m.Exact]) -> list[m.Exact]:
        found: list[m.Exact] = []
        for left, value in statement.items:
            if (form := self._form(left, value, statement.within)) is None:
                continue
            if any(self._same(form, other) for other in (*before, *found)):
                self.error(f"'{left.name}' has its closed form already", left, "leave one out")
            found.append(form)
        return found

    def _form(self, left: st.Left, value: Expr, within: Expr | None) -> m.Exact | None:
        entry = self.named(left, "a closed form", _KINDS)
        scope = self.member_scope(left, entry, Scope(PLACES["exact"]))
        if entry is None or scope is None:
            self.checked(value, scope or Scope(PLACES["exact"]))
            return None
        dimension = entry.facts.dimension
        new, facts = self.wanted(value, scope, as_is(left.name, dimension))
        if entry.facts.vector or entry.facts.turns:
            help = "observe a component, which is a number: observe a = r.x"
            self.error(f"'{left.name}' is no number: it has no closed form", left, help)
        elif entry.facts.known and not entry.facts.moves:
            self.error(f"'{left.name}' does not move: it has no closed form", left)
        if moves := min((*facts.coordinates, *facts.states, *facts.inputs), default=""):
            message = f"a closed form is a function of t and parameters; '{moves}' is neither"
            self.error(message, value)
        if any(item.name == left.name for item in self.parts["conserved"]):
            self.error(f"'{left.name}' is constant: 'conserve' says so", left)
        if within is not None:
            within = self.settings.tolerance(within, dimension)
        span = Span(left.span.start, value.span.end)
        return m.Exact(left.name, left.index, left.range, new, span, within)

    def _same(self, a: m.Exact, b: m.Exact) -> bool:
        """Whether two closed forms are of the same quantity, or families have a member in
        common."""
        ends = self.members_of(a), self.members_of(b)
        return a.name == b.name and None not in ends and Members(ends[0]).touch(*ends[1])
