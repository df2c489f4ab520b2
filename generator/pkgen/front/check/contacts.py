"""Checks `impact`, `contact`, `friction` and `mode`: constraints that hold at times.

A gap is a position that does not become negative. Its multiplier lambda_NAME pushes, along the
derivatives of the gap by the coordinates, while it is closed. Friction holds a slip at 0, up to a
bound of its force. Reference: B. Brogliato, Nonsmooth Mechanics, 3rd ed., Springer 2016.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

from ... import model as m
from ...indices import indexed, multipliers, parted, unrolled
from ...source import Span
from ...tree import Add, Expr, Name, Number, Prime, of_member
from .. import statements as st
from .. import units
from ..units import NONE, Dimension, si_text
from .expr import Target
from .names import UNKNOWN, Entry, Facts, Members
from .scope import Scope
from .settings import Settings
from .shared import name_span
from .written import written

Meeting = m.Contact | m.Friction
_SLIPS = ("coordinate", "definition")
MOST = 64  # rows of constraints beside contacts: PK_MOST_ROWS of runtime/src/events/act.h


class Contacts(Settings):
    def impact(self, statement: st.Contact) -> None:
        left, keyword = statement.left, statement.keyword
        scope, members = self.left_scope(left, "constraint")
        gap, at = statement.a, statement.a.span
        parts = [self.checked(statement.a, scope)]
        if statement.b is not None:
            at = at.to(statement.b.span)
            sides = statement.a, statement.b
            parts = [self.checked(side, scope) for side in sides]
            dimension = self.common(sides, [f for _, f in parts], f"'{keyword}'", numbers=True)
            gap, facts = self.expressions.summed(Add(sides, (1, -1), at), parts, dimension)
        else:
            (gap, facts), dimension = parts[0], parts[0][1].dimension
        if facts.vector:
            self.error("a gap is a number; this is a vector", at, "take a component, or norm(v)")
        elif facts.known and (facts.rates or facts.states or facts.state_rates):
            message = "a gap is a position: it has neither rates nor states"
            self.error(message, at, "friction NAME = FORCE is of rates")
        elif facts.known and not facts.coordinates:
            self.error("nothing that has an equation of motion is in this gap", at)
        self.use_inputs(facts)
        restitution = self._number("the restitution", statement.restitution, scope, 1)
        mu = self._number("the coefficient of friction", statement.mu, scope, None)
        along = None
        if statement.along is not None:
            along, _ = self._slip(statement.along, scope)
        multiplier = self._unit_of(self.energy_dimension, dimension)
        place, unit = name_span(left), si_text(multiplier.dimension or NONE)
        if self.names.declare(Entry(left.name, "contact", facts, place, members, used=True)):
            name = multipliers(left.name)[0]
            self.names.declare(Entry(name, "multiplier", multiplier, place, members))
        for name in self._members(left, members):
            rubs = f"{name}.rub" if statement.mu is not None else ""
            self._loses(name, f"{name}.lost", rubs, left.span)
        given = gap, restitution, mu, along, statement.poisson, unit
        said = statement.description, statement.span
        made = m.Contact(left.name, left.index, left.range, *given, *said)
        self.parts["contacts"].append(made)

    contact = impact

    def _number(self, what: str, value: Expr | None, scope: Scope, most: int | None) -> Expr | None:
        """Checks a coefficient, a number from 0 to `most`, of parameters, places and t."""
        if value is None:
            return None
        new, facts = self.wanted(value, scope, Target(NONE, f"{what} needs a number"))
        known = facts.value
        if facts.rates or facts.states:
            self.error(f"{what} has a rate in it", value, "it is of parameters, places and t")
        elif known is not None and (known < 0 or (most is not None and known > most)):
            ends = "at least 0" if most is None else f"from 0 to {most}"
            self.error(f"{what} is {ends}", value)
        return new

    def _slip(self, value: Expr, scope: Scope) -> tuple[Expr, Facts]:
        """Returns a slip, an expression of rates: the rate of a position."""
        new, facts = self.checked(value, scope)
        if facts.vector:
            message = f"{self.text(value)} is a vector: friction acts along one direction"
            self.error(message, value, "take the slip along it, e.g. P'.x")
        elif facts.known and not facts.rates and facts.coordinates:
            new, facts = self.checked(Prime(value, value.span), scope)
        elif facts.known and not facts.rates:
            self.error(f"{self.text(value)} does not move: it does not slip", value)
        if facts.states or facts.state_rates:
            self.error("a slip is of coordinates and their rates, not of states", value)
        self.use_inputs(facts)
        return new, facts

    def _unit_of(self, work: Dimension, dimension: Dimension | None) -> Facts:
        per = None if dimension is None else units.over(work, dimension)
        everything = self.names.moving
        known = dimension is not None
        return Facts(per, united=True, known=known, coordinates=everything, rates=everything)

    @staticmethod
    def _members(left: st.Left, members: Members | None) -> list[str]:
        """Returns the names of the members of a family, as many as may be contacts."""
        if members is None:
            return [left.name]
        ends = ((lo, min(hi, lo + MOST)) for lo, hi in members.intervals)
        return [indexed(left.name, i) for lo, hi in ends for i in range(lo, hi + 1)]

    def _loses(self, name: str, cell: str, friction: str, at: Span) -> None:
        """Makes loss(NAME) known: the sum of an input and of the state of a friction."""
        parts = [Name(x, None, at) for x in (cell, friction and f"loss({friction})") if x]
        states = frozenset((f"loss({friction})",) if friction else ())
        inputs = {cell: 0} if cell else {}
        facts = Facts(self.energy_dimension, united=True, states=states, inputs=inputs)
        sum_ = Add(tuple(parts), (1,) * len(parts), at) if len(parts) > 1 else parts[0]
        self.expressions.losses[name] = sum_, facts

    def friction(self, statement: st.Friction) -> None:
        left = statement.left
        scope, members = self.left_scope(left, "friction")
        entry = self.named(left, "a friction", _SLIPS)
        if entry is None:
            return
        index = left.index
        if left.range is not None:
            index = Name(left.range.variable, None, left.range.span)
        slip, facts = self._slip(Name(left.name, index, name_span(left)), scope)
        wanted = self._unit_of(self.power_dimension, facts.dimension).dimension
        needs = f"friction along {left.name} needs [{si_text(wanted or NONE)}]"
        target = Target(wanted, needs if wanted != NONE else "friction needs a number")
        value, known = self.wanted(statement.value, scope, target)
        static, more = None, UNKNOWN
        if statement.static is not None:
            static, more = self.wanted(statement.static, scope, target)
        for expr, f in ((statement.value, known), (statement.static, more)):
            if f.value is not None and f.value < 0:
                self.error("a bound of friction is not negative", expr, "its direction is found")
            self.use_inputs(f)
        if None not in (known.value, more.value) and more.value < known.value:
            message = "static friction is less than the friction of what slips"
            self.error(message, statement.static, "it holds up to static, and then slips with less")
        multiplier = self._unit_of(self.power_dimension, facts.dimension)
        name = multipliers(left.name)[0]
        self.names.declare(Entry(name, "multiplier", multiplier, name_span(left), members))
        for each in self._members(left, members):
            self._loses(each, "", each, left.span)
        given = slip, value, static, si_text(wanted or NONE)
        said = statement.description, statement.span
        made = m.Friction(left.name, left.index, left.range, *given, *said)
        self.parts["frictions"].append(made)

    def mode(self, statement: st.Mode) -> None:
        entry = Entry(statement.name, "mode", UNKNOWN, statement.name_span, used=True)
        self.names.declare(entry)
        for left in statement.constraints:
            known = self.named(left, "a mode", ("constraint",))
            taken = [x.name for x in self.parts["modes"] if left.name in x.constraints]
            if known is not None and taken:
                self.error(f"'{left.name}' is of the mode '{taken[0]}' already", left)
            if left.index is not None or left.range is not None:
                self.error("a mode has whole constraints, without an index", left)
        on, off = (
            "" if at is None else self.event(at, word)
            for at, word in ((statement.on, "on at"), (statement.off, "off at"))
        )
        if statement.on is None and statement.off is None:
            help = "mode foot: constraint a on at landing off at lift"
            self.error("a mode begins or ends at an event", statement.name_span, help)
        self._loses(statement.name, f"{statement.name}.lost", "", statement.name_span)
        names = tuple(left.name for left in statement.constraints)
        given = statement.name, names, on, off, statement.span
        self.parts["modes"].append(m.Mode(*given, begins=not on))

    def finish(self) -> None:
        """Writes families out, and adds what contacts, frictions and modes stand for: inputs that
        say which rows hold, and the events at which that changes. Names of what only the runtime
        reads begin with a digit."""
        if self.report.errors:
            return
        for item in (*self.parts["contacts"], *self.parts["frictions"]):
            ends = self.members_of(item) if item.range else None
            if ends is not None and ends[1] - ends[0] >= MOST:
                return self._too_many(ends[1] - ends[0] + 1, item)
        contacts = [*self._each("contacts", ("gap", "restitution", "mu", "along"))]
        frictions = [*self._each("frictions", ("slip", "value", "static"))]
        for x in contacts:
            pushes = _multiplier(x)
            self._inputs(x, "lost", self.energy_dimension)
            self._event(x.name, x.gap, x, 0, x.description)
            self._event(f"1{x.name}", pushes, x, 1)
            if x.mu is not None:
                force = written("a*b", x.mu.span, x.mu, pushes)
                given = x.along, force, None, "", x.description, x.span, x.name
                frictions.append(m.Friction(f"{x.name}.rub", None, None, *given))
        for x in frictions:
            self._inputs(x, "side", NONE)
            of = (_of(x, f"{x.name}.{end}") for end in ("side", "slip"))
            slip = written("select(a^2, a*b, 1)", x.span, *of)
            held = written("a^2 - b^2", x.span, x.static or x.value, _multiplier(x))
            self._event(f"2{x.name}", slip, x, 0)
            self._event(f"3{x.name}", held, x, 1)
            if (x.of or x.name) in self.expressions.lost:
                self._work(x)
        for k, x in enumerate(self.parts["modes"]):
            self._inputs(x, "lost", self.energy_dimension)
            for i, event in enumerate(self.parts["events"]):
                if event.name == x.on and not event.mode:
                    self.parts["events"][i] = replace(event, mode=x.name)
                elif event.name == x.off:
                    self.parts["events"][i] = replace(event, ends=True)
            begins = self.expressions.begins.get(x.name, x.begins)
            self.parts["modes"][k] = replace(x, begins=begins)
        self.parts["contacts"], self.parts["frictions"] = contacts, frictions
        count = len(contacts) + len(frictions) + len(self.parts["constraints"])
        if contacts + frictions and count > MOST:
            self._too_many(count, (contacts + frictions)[-1])

    def _too_many(self, count: int, item: Meeting) -> None:
        message = f"{count:,} contacts, frictions and constraints; the limit is {MOST}"
        help = "one contact may be with the nearest of many: min(a, b, c) >= 0"
        self.error(message, item, help)

    def _each(self, kind: str, exprs: tuple[str, ...]) -> Iterator[Meeting]:
        """Yields the statements of a kind, a family member by member."""
        for item in self.parts[kind]:
            for index, _ in unrolled(item, self.sizes):
                values = {name: getattr(item, name) for name in exprs}
                if item.range is not None:
                    at, variable = Number(Fraction(index), item.span), item.range.variable
                    values = {k: x and of_member(x, variable, at) for k, x in values.items()}
                name = indexed(item.name, index)
                yield replace(item, name=name, index=None, range=None, **values)

    def _inputs(self, x: Meeting | m.Mode, second: str, dimension: Dimension) -> None:
        """Adds the inputs of x; see struct pk_contact in runtime/include/pk/system_singular.h."""
        for end, of in (("on", NONE), (second, dimension), ("idle", NONE)):
            name = f"{x.name}.{end}"
            self.sampled[name] = x.name
            self.parts["inputs"].append(m.Input(name, 0, (si_text(of),), "", x.span, x.name))

    def _work(self, x: m.Friction) -> None:
        """Adds the state that sums up the work of a friction that slips."""
        names = (_of(x, f"{x.name}.{end}") for end in ("side", "slip"))
        value = written("a*b*c", x.span, *names, x.value)
        units = si_text(self.energy_dimension), si_text(self.power_dimension)
        name = f"loss({x.name})"
        self.parts["states"].append(m.State(name, None, *units, "", x.span))
        self.parts["rates"].append(m.Rate(name, None, None, value, x.span))

    def _event(self, name: str, value: Expr, x: Meeting, when: int, description: str = "") -> None:
        made = m.Event(name, value, -1, False, "", description, x.span, mode=x.name, when=when)
        self.parts["events"].append(made)


def _of(x: Meeting, name: str) -> Name:
    return Name(name, None, x.span)


def _multiplier(x: Meeting) -> Name:
    """Returns the multiplier of a contact or a friction, which may be a member of a family."""
    name, index = parted(x.name)
    at = None if index is None else Number(Fraction(index), x.span)
    return Name(multipliers(name)[0], at, x.span)
