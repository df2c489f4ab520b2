"""Converts the statements about outputs, initial values, parameters and fixed ends of a model with
loops."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

from ...graph.affine import LOOPS, ROW, Affine
from ...graph.graph import BIT, ZERO, Kind, Node
from ...model import Definition, Event
from ...tree import Name, children
from ..quantities import error
from .constant_sums import assigned, moving
from .equations import Assigned, Bounded, Observed
from .expand import FamilyExpander
from .indexed_ir import NotKept, of_name
from .output_recurrences import Alongside
from .rows import Assembler


class Outputs:
    """Converts the expressions of `observe`, `conserve` and `event` statements to nodes. Sums over
    members in them are computed before (see totals.py)."""

    def __init__(self, x, assembler, kinetic, potential, lagrangian, energy, momenta):
        self.x, self.assembler = x, assembler
        x.watched, x.alongside = True, Alongside(x, assembler)
        named = {"T": kinetic, "V": potential, "L": lagrangian, "energy": energy}
        own = [g for g in x.coordinates.values() if not (g.is_state or g.is_carried)]
        x.momenta = {g.declared.momentum or f"p_{g.name}": g for g in own}
        for name, group in x.momenta.items():
            if not (group.is_family or x.carried):
                named[name] = of_name(momenta, group.name)
        used = {name for item in _outputs(x) for name in _names(item)}
        if "V_eff" in used - {item.name for item in x.model.definitions}:
            raise NotKept("'V_eff' is of single coordinates")
        for name, total in named.items():
            if total is not None and name in used:
                x.outputs[name] = x.totals.node(tuple(replace(a, to=()) for a in total))

    def observed(self) -> tuple[Observed, ...]:
        """Returns the quantities of `observe` statements."""
        found = []
        for item in self.x.model.observed:
            if item.range is None:
                [node] = self.nodes((item,))
                found.append(Observed(item, None, None, node))
            else:
                found.append(self._members(item))
                self.x.of_members[item.name] = item
        return tuple(found)

    def _members(self, item: Definition) -> Observed:
        x = self.x
        lo, hi, loop = x.over(item.range)
        return Observed(item, lo, hi, self._of_members(x.scalar(item.value, loop), lo, hi))

    def _of_members(self, node: Node, lo: Affine, hi: Affine) -> Node:
        """Returns the value for m = lo..hi, after a record of the members that must exist."""
        self.assembler.limits += self.x.limits_over(lo, hi)
        for slot in self.x.slots.below(node):
            if slot.at is not None and slot.at.factor(ROW):
                self.assembler.member(slot, lo, hi)
        return node

    def nodes(self, items: tuple[Definition | Event, ...]) -> tuple[Node, ...]:
        found = []
        for item in items:
            if isinstance(item, Definition) and item.range is not None:
                raise NotKept(f"'{item.name}' is claimed for each index")
            node = self.x.scalar(item.value)
            for slot in self.x.slots.below(node):
                self.assembler.limits += self.x.limits_of(None, {})
                assert slot.at is None or not any(slot.at.factor(v) for v in LOOPS)
            self.x.outputs[item.name] = node
            found.append(node)
        return tuple(found)

    def resets(self) -> tuple[tuple[Assigned, ...], ...]:
        """Returns for each event with values after it the assignments of these values."""
        return tuple(
            tuple(map(self._given, event.then)) for event in self.x.model.events if event.then
        )

    def _given(self, item) -> Assigned:
        x = self.x
        lo, hi, loop = x.over(item.range, item.index)
        group = x.coordinates.get(item.name)
        if group is None:  # a memory cell
            return Assigned(item.name, 0, None, None, x.scalar(item.value, loop))
        if item.range is not None and lo == hi:
            loop[item.range.variable] = lo
        order, node = 1 if group.is_state else item.order, x.scalar(item.value, loop)
        if lo is not None:
            x.members += [(group.lo, group.hi, lo), (group.lo, group.hi, hi)]
        if lo != hi:
            node = self._of_members(node, lo, hi)
        return Assigned(item.name, order, lo, hi, node)


def _outputs(x: FamilyExpander) -> Iterator[Any]:
    """Yields all statements whose values may be energies and momenta."""
    yield from (*x.model.observed, *x.model.conserved, *x.model.events)
    yield from (item for event in x.model.events for item in event.then)
    yield from (step for block in x.model.samples for step in block.steps)


def _names(item: Any) -> Iterable[str]:
    waiting = [item.value]
    while waiting:
        expr = waiting.pop()
        waiting.extend(children(expr))
        if isinstance(expr, Name):
            yield expr.id


def starts_of(x: FamilyExpander, assembler: Assembler) -> tuple[Assigned, ...]:
    found = []
    for item in x.model.starts:
        over = lo, hi, _ = x.over(item.range, item.index)
        group = x.coordinates[item.name]
        order = 1 if group.is_state else item.order
        made, nodes = assigned(x, item.name, order, over, item.value, assembler.limits)
        timed = any(x.graph.depends[node] & BIT[Kind.TIME] for node in nodes)
        if timed or moving(x.slots.below(*nodes)):
            message = "an initial value may use parameters and numbers only"
            raise error(x.model, message, item.value.span)
        if lo is not None:
            x.members += [(group.lo, group.hi, lo), (group.lo, group.hi, hi)]
        assembler.limits += x.limits_over(lo, hi)
        found.append(made)
    return tuple(found)


def defaults_of(x: FamilyExpander, assembler: Assembler) -> tuple[Assigned, ...]:
    found = []
    for group in x.parameters.values():
        over = lo, hi, _ = x.over(group.declared.range)
        made, _ = assigned(x, group.name, 0, over, group.declared.default, assembler.limits)
        assembler.limits += x.limits_of(None, {} if lo is None else {ROW: (lo, hi)})
        found.append(made)
    return tuple(found)


def bounds_of(x: FamilyExpander) -> tuple[Bounded, ...]:
    found = []
    for group in x.parameters.values():
        _, _, loop = x.over(group.declared.range)
        ends = group.declared.bounds.lo, group.declared.bounds.hi
        nodes = [None if end is None else x.plain(end, loop) for end in ends]
        if any(slot.kind == "sum" for n in nodes if n is not None for slot in x.slots.below(n)):
            raise NotKept(f"a sum stands in the bounds of '{group.name}'")
        found.append(Bounded(*nodes))
    x.members.clear()
    return tuple(found)


def given_of(x: FamilyExpander) -> dict[tuple[str, Affine], tuple[Node, Node, Node]]:
    """Returns the value, rate and acceleration at each fixed end of a family, by (family, index).
    Rates and accelerations that no equation uses are returned as ZERO."""
    rated = {
        s.name for s in x.slots.all if s.kind in ("v", "d", "w", "a", "acc") and s.at is not None
    }
    found = {}
    for group in x.coordinates.values():
        for at, end in group.ends:
            if end.kind != "fixed":
                continue
            value = x.given(group.name, at)
            rate = x.given_rate(group.name, at) if group.name in rated else ZERO
            needed = any(s.kind in ("w", "acc") and s.name == group.name for s in x.slots.all)
            found[group.name, at] = (value, rate, x.derivative(rate) if needed else ZERO)
    return found
