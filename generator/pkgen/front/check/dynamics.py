"""Checks energies, forces, starts (initial values) and events."""

from __future__ import annotations

from dataclasses import replace

from ... import model as m
from ...indices import made_of, of_made
from ...source import Span
from ...tree import Call, Condition, Expr, Multiply, Name, Negate, Prime, names, within
from .. import statements as st
from .. import units
from ..table import STATEMENTS
from ..units import NONE
from .expr import Target
from .names import UNKNOWN, Entry
from .rotation_statements import Rotations
from .scope import PLACES, Scope
from .shared import Checks, Shared, as_is

CONSISTENT = "consistent"
_DIRECTIONS = {"rising": 1, "falling": -1, "either": 0}


class Dynamics(Checks):
    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self.rotations = Rotations(shared)

    def energy(self, statement: st.Single) -> None:
        keyword = statement.keyword
        row = STATEMENTS[keyword]
        power = row.needs == "power"
        dimension = self.power_dimension if power else self.energy_dimension
        needs = f"{keyword} needs {'a power [W]' if power else 'an energy [J]'}"
        if dimension == NONE:
            needs = f"{keyword} needs a number"
        place = PLACES["hamiltonian" if keyword == "hamiltonian" else "energy"]
        value, facts = self.wanted(statement.value, Scope(place), Target(dimension, needs))
        if facts.rough:
            families = "; of many members give --unroll" if self.sizes else ""
            self.warn(
                f"{keyword} contains {facts.rough} of the motion, which has no derivative where"
                " it bends or jumps",
                statement.value,
                f"the force jumps there, or the rates: steps of `pkgen run` end at it{families}",
            )
        if facts.state_rates:
            message = f"{keyword} cannot use the rate of the state '{min(facts.state_rates)}'"
            help = "rates follow from the energies: write what stands after 'rate' in its place"
            self.error(message, self._rate_of_a_state(statement.value), help)
        if keyword == "fast" and facts.rates:
            message = "fast names a part of the potential, and has a rate in it"
            self.error(message, statement.value, "leave the terms with rates out of it")
        if not power:
            self.energies.append(facts)
        self.use_inputs(facts)
        self.parts[row.fills].append(value)

    def _rate_of_a_state(self, value: Expr) -> Span:
        """Returns the position of the shortest part of `value` that contains the rate of a state,
        directly or through a defined name."""
        found = [value.span]
        for part in within(value):
            entry = self.names.table.get(part.id) if isinstance(part, Name) else None
            if (isinstance(part, Prime) and names(part.of) & self.names.states) or (
                entry is not None and entry.facts.state_rates
            ):
                found.append(part.span)
        return min(found, key=lambda span: (span.end - span.start, span.start))

    consistent: Span | None = None  # the position of the model's `start consistent`

    def solved(self, statement: st.StartAt) -> bool:
        """Whether a start is to be found by the constraints; reports where that cannot be."""
        if statement.how == CONSISTENT and self.names.rotations:
            message = "'start consistent' does not turn rotations"
            self.error(message, statement, "start where the constraints hold: start R = rot(…)")
        elif statement.how not in ("", CONSISTENT):
            help = f"start {statement.how} = VALUE, or start consistent"
            self.error(f"'{statement.how}' has no value here", statement, help)
        return statement.how == CONSISTENT

    def start(self, statement: st.StartAt) -> None:
        if self.solved(statement):
            self.consistent = statement.span
        for item in statement.items:
            self.parts["starts"] += self.start_item(item) or ()

    def start_item(
        self, item: st.StartItem, around: Scope | None = None
    ) -> tuple[m.Start, ...] | None:
        """Checks an initial value. Returns its Starts: one for a number, several for a rotation.
        Returns None after an error. `around` is the scope of a value that depends on the loop
        variable of a swarm, or of a value after an event."""
        left = item.left
        mode = self.names.table.get(left.name)
        if mode is not None and mode.kind == "mode" and around is None:
            return self._begin(item)
        around = around or Scope(PLACES["start"])
        if self.names.hamiltonian and (found := self._momentum(item, around)):
            return found
        entry = self.named(left, "a start", self.moving)
        if item.function or (entry is not None and entry.kind == "rotation"):
            return self.rotations.start(item, entry, around)
        scope = self.member_scope(left, entry, around)
        if entry is None or scope is None:
            self.checked(item.value, scope or around)
            return None
        if item.order and entry.kind == "state":
            self.error(
                f"'{left.name}' is a state: its rate is not started, 'rate {left.name}' gives it",
                item,
                f"start {left.name} = …",
            )
            return None
        if item.order > 1:
            self.error(f"a start gives {left.name} and {left.name}', not its acceleration", item)
            return None
        dimension = entry.facts.dimension
        if item.order and dimension is not None:
            dimension = units.over(dimension, self.time_dimension)
        target = as_is(left.name + "'" * item.order, dimension)
        value, _ = self.wanted(item.value, scope, target)
        return (m.Start(left.name, left.index, left.range, item.order, value, item.span),)

    def _begin(self, item: st.StartItem) -> tuple[m.Start, ...]:
        """Checks `start MODE = 1`: the mode is on at the start; 0: off."""
        _, facts = self.checked(item.value, Scope(PLACES["start"]))
        if facts.value not in (0, 1) or item.order:
            message = f"'{item.left.name}' is a mode: it starts with 1, on, or 0, off"
            self.error(message, item.value, f"start {item.left.name} = 1")
        else:
            self.expressions.begins[item.left.name] = facts.value == 1
        return ()

    def _momentum(self, item: st.StartItem, around: Scope) -> tuple[m.Start, ...]:
        """Checks the start of a momentum, in a model with `hamiltonian`. Returns () for a start of
        something else."""
        left, name = item.left, of_made("p_", item.left.name)
        entry = self.names.table.get(name)
        if entry is None or entry.kind != "coordinate":
            if item.order:
                help = f"start {made_of('p_{}', left.name)} = …"
                self.error("a model with 'hamiltonian' starts with momenta, not rates", item, help)
            return ()
        scope = self.member_scope(replace(left, name=name), entry, around) or around
        action = units.times(self.energy_dimension, self.time_dimension)
        target = as_is(left.name, units.over(action, entry.facts.dimension or NONE))
        value, _ = self.wanted(item.value, scope, target)
        return (m.Start(left.name, left.index, left.range, 0, value, item.span),)

    def event(self, statement: st.Event) -> None:
        at, scope, direction = statement.value.span, Scope(PLACES["event"]), statement.direction
        if isinstance(statement.value, Condition):
            if direction != "either":
                help = f"leave out '{direction}'"
                message = "an event of a condition has no direction"
                self.error(f"{message}: it is where that begins to hold", at, help)
            value, facts = self.expressions.positive(statement.value, scope)
            direction = "rising"
        else:
            value, facts = self.checked(statement.value, scope)
        if facts.vector:
            message = f"the event '{statement.name}' is a vector; it must be a number"
            self.error(message, at, "take a component (.x, .y, .z), dot(a, b) or norm(a)")
        elif facts.known and not facts.moves:
            message = f"the event '{statement.name}' never happens: nothing in it moves"
            help = "it is where an expression of the motion crosses zero, e.g. y - h falling"
            self.error(message, at, help)
        elif (step := _step_of(statement.value)) is not None:
            self.error(
                f"the event '{statement.name}' does not cross zero: a step is 0 on one whole side",
                step,
                "write what is in the step, which crosses zero where it jumps; or step(...) - 1/2",
            )
        self.use_inputs(facts)
        self.names.declare(Entry(statement.name, "event", UNKNOWN, statement.name_span, used=True))
        how = _DIRECTIONS[direction], statement.stop
        unit = self.shown_unit(statement.value, facts)
        shown = unit, statement.description, statement.span
        then = [start for item in statement.then for start in self._after(item, statement.then)]
        made = m.Event(statement.name, value, *how, *shown, statement.limit, tuple(then))
        self.parts["events"].append(made)

    def _after(self, item: st.StartItem, then: tuple[st.StartItem, ...]) -> tuple[m.Start, ...]:
        """Checks a value after an event: of what moves, or of a memory cell."""
        left, scope = item.left, Scope(PLACES["then"])
        same = [x for x in then if x.order == item.order and x.function == item.function]
        if [x.left.name for x in same if x.left.index is left.index].count(left.name) > 1:
            self.error(f"'{left.name}' gets two values at once", item, "give it one")
            return ()
        entry = self.names.table.get(left.name)
        if entry is None or entry.kind != "memory cell":
            return self.start_item(item, scope) or ()
        if item.order or left.index is not None or left.range is not None:
            self.error("a memory cell has neither a rate nor an index", item)
        value, _ = self.wanted(item.value, scope, as_is(left.name, entry.facts.dimension))
        return (m.Start(left.name, None, None, 0, value, item.span),)


def _step_of(value: Expr) -> Call | None:
    """Returns the call of step() if `value` is this call or has it as a factor, else None."""
    parts = [value]
    for part in parts:
        if isinstance(part, Call) and part.function == "step":
            return part
        if isinstance(part, Multiply):
            parts += part.factors
        elif isinstance(part, Negate):
            parts.append(part.of)
    return None
