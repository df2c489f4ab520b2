"""Checks `state` and `rate`: variables with first-order equations, each with exactly one rate."""

from __future__ import annotations

from fractions import Fraction

from ... import model as m
from ...tree import Call, Number
from .. import statements as st
from .. import units
from ..units import NONE, si_text
from .expr import Target
from .names import Entry, Facts, Members
from .scope import PLACES, Scope
from .shared import Checks, Shared, name_span


class States(Checks):
    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self.given: dict[str, Members] = {}  # name of a state -> indices with a rate
        self.wrong: set[str] = set()  # Names of states whose rate has an error.

    def declare(self, item: st.Declared, unit: units.Unit | None, description: str) -> None:
        found = self.variable(item, unit, "state", states=frozenset((item.name,)))
        if found is None:
            return
        new, *shown = found
        if not new:
            self.wrong.add(item.name)
        self.parts["states"].append(m.State(item.name, *shown, description, item.span))

    def rate(self, statement: st.Define) -> None:
        left = statement.left
        found = self.wanted_of(left, statement.value, "a rate", ("state",), "rate")
        if found is None:
            self.wrong.add(left.name)
            return
        entry, scope = found
        self._once(statement)
        dimension = units.over(entry.facts.dimension, self.time_dimension)
        needs = "a number" if dimension == NONE else f"[{si_text(dimension)}]"
        target = Target(dimension, f"the rate of {left.name} needs {needs}")
        value, facts = self.wanted(statement.value, scope, target)
        self.use_inputs(facts)
        self.parts["rates"].append(m.Rate(left.name, left.index, left.range, value, statement.span))

    def accumulate(self, statement: st.Accumulate) -> None:
        """Checks `observe NAME = integral(EXPR) while CONDITION`, a state with that rate."""
        left, value, condition = statement.left, statement.value, statement.condition
        at = statement.span
        if left.index is not None or left.range is not None:
            self.error("the name of an integral has no index", left)
        if value is None:
            value = Number(Fraction(1), at)
        elif isinstance(value, Call) and value.function == "integral":
            if len(value.arguments) != 1:
                self.error("integral takes one expression", value)
            value = value.arguments[0] if value.arguments else Number(Fraction(1), at)
        else:
            help = f"observe {left.name} = integral({self.text(value)}) while …"
            self.error("'while' needs an integral before it, or no expression", value, help)
        if condition is not None:
            value = Call("if", (condition, value, Number(Fraction(0), at)), at)
        value, facts = self.checked(value, Scope(PLACES["rate"]))
        self.use_inputs(facts)
        dimension = units.times(facts.dimension or NONE, self.time_dimension)
        own = Facts(dimension, united=True, states=frozenset((left.name,)))
        if not self.names.declare(Entry(left.name, "state", own, name_span(left))):
            return
        shown = si_text(dimension), si_text(facts.dimension or NONE)
        self.parts["states"].append(m.State(left.name, None, *shown, statement.description, at))
        self.parts["rates"].append(m.Rate(left.name, None, None, value, at))
        self.given[left.name] = Members((0, 0))

    def _once(self, statement: st.Define) -> None:
        left = statement.left
        members = self.members_of(left)
        if members is None:
            return
        lo, hi = members
        given = self.given.setdefault(left.name, Members())
        if given.touch(lo, hi):
            what = f"'{left.name}'"
            if left.range is not None or left.index is not None:
                what = f"'{left.name}[{lo}]'" if lo == hi else f"some of '{left.name}[{lo}..{hi}]'"
            self.error(f"{what} has its rate already", left, "a state has one rate: add them up")
        given.add(lo, hi)

    def finish(self) -> None:
        """Reports states without a rate."""
        for state in self.parts["states"]:
            if state.name in self.wrong:
                continue
            given = self.given.get(state.name, Members())
            lo, hi = (0, 0) if state.range is None else self.range_of(state.name)
            if given.hold(lo, hi):
                continue
            missing, say = state.name, f"rate {state.name} = …"
            if state.range is not None:
                first = next(i for i in range(lo, hi + 1) if not given.hold(i, i))
                missing = f"{state.name}[{first}]"
                whole = f"rate {state.name}[i = {lo}..{hi}] = …"
                say = f"rate {missing} = …" if given.intervals else whole
            self.error(f"the state '{missing}' has no rate", state, f"add '{say}'")
