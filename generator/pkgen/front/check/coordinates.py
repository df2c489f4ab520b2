"""Checks `coord`, `state`, `rotation` and `input`, and the ends of families.

`fixed`, `free` and `periodic` define the elements beyond the ends of a family, such as q[0] of
q[1..N].
"""

from __future__ import annotations

from ... import model as m
from ...indices import indexed
from ...source import Span
from ...tree import Expr
from .. import statements as st
from .. import units
from ..units import si_text
from .names import KIND_TEXT, Entry, Facts
from .rotation_statements import Rotations, ends_of
from .scope import PLACES, Scope
from .shared import Checks, Shared, as_is
from .states import States


class Coordinates(Checks):
    def __init__(self, shared: Shared, states: States, rotations: Rotations) -> None:
        super().__init__(shared)
        self.rotations = rotations
        self.kinds = {
            "coord": self._coordinate,
            "state": states.declare,
            "rotation": rotations.declare,
            "input": self._input,
        }
        # (name of a family, index of an end) -> source position of the statement about the end.
        self.own_ends: dict[tuple[str, int | None], Span] = {}

    def declare(self, statement: st.Declare) -> None:
        # The unit of `a, b [m]` applies to both names, so this loop goes backwards.
        given: list[units.Unit] = []
        unit: units.Unit | None = units.ONE
        for item in reversed(statement.items):
            if item.unit is not None:
                unit = self.expressions.unit(item.unit.text, item.unit.span)
                if unit is not None and not unit.is_si:
                    self.warn(
                        f"values of '{item.name}' are in SI,"
                        f" [{si_text(unit.dimension, unit.angle)}], not in [{item.unit.text}]",
                        item.unit,
                    )
            given.append(unit)
        for item, unit in zip(statement.items, reversed(given), strict=True):
            self.kinds[statement.keyword](item, unit, statement.description)

    def _coordinate(self, item: st.Declared, unit: units.Unit | None, description: str) -> None:
        own = frozenset((item.name,))
        found = self.variable(item, unit, "coordinate", coordinates=own)
        if found is None:
            return
        time, energy = self.time_dimension, self.energy_dimension
        momentum = units.over(units.times(energy, time), (unit or units.ONE).dimension)
        shown = *found[1:], si_text(momentum), description
        self.parts["coordinates"].append(m.Coordinate(item.name, *shown, item.span))

    def _input(self, item: st.Declared, unit: units.Unit | None, description: str) -> None:
        if item.lo is not None:
            self.error("a family of inputs cannot be compiled yet", item, "declare them one by one")
        dimension = None if unit is None else unit.dimension
        united, own = unit is not units.ONE, {item.name: 0}
        facts = Facts(dimension, united=united, known=unit is not None, inputs=own)
        self.names.declare(Entry(item.name, "input", facts, item.name_span))
        self.parts["inputs"].append((item, unit or units.ONE, description))

    def ends(self, statement: st.Pairs) -> None:
        keyword = statement.keyword
        for left, value in statement.items:
            entry = self.named(left, f"'{keyword}'", self.moving)
            if entry is None:
                if value is not None:
                    self.checked(value, Scope(PLACES["fixed"]))
                continue
            if entry.members is None:
                help = f"{KIND_TEXT[entry.kind]} is held fixed in a scene with 'hold'"
                self.error(f"'{left.name}' is not a family: it has no ends", left, help)
                continue
            if left.range is not None:
                self.error("an end is one index, not a range", left)
                continue
            self._end(keyword, left, entry, value, statement)

    def _fixed_value(self, value: Expr | None, entry: Entry) -> Expr | tuple[Expr, ...] | None:
        """Checks and returns the value of an end: a quaternion for a rotation, None if free."""
        if value is None:
            return None
        scope, target = Scope(PLACES["fixed"]), as_is(entry.name, entry.facts.dimension)
        if entry.kind == "rotation":
            example = f"fixed {entry.name}[0]"
            checked, facts = self.rotations.numbers("an end", example, value, scope)
        else:
            checked, facts = self.wanted(value, scope, target)
        for kind, names in (("coordinate", facts.coordinates), ("state", facts.states)):
            if not names:
                continue
            message = f"a fixed end cannot depend on the {kind} '{min(names)}'"
            self.error(message, value, "it may use parameters, inputs and t")
        self.use_inputs(facts)
        return checked

    def _end(
        self, keyword: str, left: st.Left, entry: Entry, value: Expr | None, statement: st.Pairs
    ) -> None:
        lo, hi = self.range_of(left.name)
        given = self._fixed_value(value, entry)
        if keyword == "periodic":
            if left.index is not None:
                self.error("a family is periodic as a whole", left, f"write 'periodic {left.name}'")
                entry.periodic = True
                return
            at: list[int | None] = [None]
            entry.periodic = True
        elif left.index is None:
            if keyword == "fixed":
                message = f"'fixed' names an end: {left.name}[{lo - 1}] or {left.name}[{hi + 1}]"
                help = f"e.g. fixed {left.name}[{lo - 1}] = 0, {left.name}[{hi + 1}] = 0"
                self.error(message, left, help)
                return
            at = [lo - 1, hi + 1]
        else:
            index = self.indices.value(left.index, Scope(PLACES["size"]))
            if index is None:
                entry.periodic = True  # avoids further errors
                return
            at = [index]
        for index in at:
            if self._end_allowed(keyword, left, index, lo, hi):
                turned = entry.kind == "rotation"
                own = None if turned else given
                end = m.End(keyword, left.name, index, own, statement.span, left.index)
                self.parts["ends"] += ends_of(end, given) if turned else (end,)
                if index is not None:
                    entry.members.add(index, index)

    def _end_allowed(
        self, keyword: str, left: st.Left, index: int | None, lo: int, hi: int
    ) -> bool:
        name = left.name
        if index is not None and lo <= index <= hi:
            self.error(
                f"{name}[{index}] is {KIND_TEXT[self.names.table[name].kind]};"
                f" an end lies outside {lo}..{hi}",
                left,
                f"the ends are {name}[{lo - 1}] and {name}[{hi + 1}]",
            )
            return False
        if keyword == "free" and index not in (lo - 1, hi + 1):
            message = f"a free end is next to the family: {name}[{lo - 1}] or {name}[{hi + 1}]"
            self.error(message, left)
            return False
        clash = [
            k for k in self.own_ends if k[0] == name and (k[1] == index or None in (k[1], index))
        ]
        if clash:
            line, what = self.names.line_of(self.own_ends[clash[0]]), indexed(name, index)
            self.error(f"the end {what} is given already in line {line}", left)
            return False
        self.own_ends[name, index] = left.span
        return True
