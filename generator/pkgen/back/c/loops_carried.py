"""Recurrence values (`carried`) in C, and the elimination of M a = f with them.

Recurrence values X, such as the positions of the links of a chain, are defined index by index.
Their second derivatives are X'' = A a + ..., where a are the accelerations of the coordinates.
These obey

A~^T M~ A~ a = A~^T f~ A~ = (1, A)

M~ and f~ are the mass matrix and the force that the Lagrangian would have if X were coordinates. M~
couples only neighbours, and X''[m] = Phi_X X''[m-1] + Phi_q a[m] with the partial derivatives Phi_X
and Phi_q of the recurrence. From the last index to the first, this replaces X''[m], and a[m] is
eliminated. Each index passes a small symmetric matrix to the next lower one: the articulated-body
inertia of the rest of the chain. The pivots are those of the mass matrix M.

Reference: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, chapter 7.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

from ...graph.affine import Affine
from ...graph.graph import CONSTANT, ZERO, Node
from ...middle.loops.indexed_ir import Carried, Group, Part, Piece, Row, Slot
from ...middle.loops.loops import LoopEquations
from ..targets import STORE, Target
from .loops import INNER, Block, M, Places
from .loops_sets import Builder, RowSet

BESIDE = 1  # This number, in place of an offset, marks a scalar coordinate.
Variable = tuple[int, int]  # (index relative to the loop's index m, at most 0; family's number)
# For each pass of a loop along a chain of links, the fields of Piece that the pass computes besides
# the value and the rate.
MODES = {"state": ("own",), "force": ("coasting", "by"), "motion": ("by", "by_rate")}


@dataclass
class Level:
    """Recurrence values of one level and index range, which one loop computes."""

    rows: RowSet
    group: dict  # template variables of the first recurrence value
    stores: list[str]  # The C variable that stores r[k], for each k.
    guards: list[tuple[str, str]]  # (C condition, C variable that is 0 if the condition holds)

    @property
    def of_place(self) -> list[str]:
        """Returns those of `stores` that are derivatives; outside the index range they are 0."""
        return [x for x in self.stores if x.startswith(("slopes", "changes"))]


class Carrying:
    """The C blocks of one model's recurrence values; may add nodes to the graph."""

    def __init__(self, e: LoopEquations, places: Places, make: Builder):
        self.e, self.g, self.places, self.make = e, e.graph, places, make
        self.slots = make.interior.slots
        self.groups = {g.name: g for g in e.rows}
        self.number = {name: k for k, name in enumerate(self.groups)}
        self.scalar = {g.name: k for k, g in enumerate(e.scalars)}
        self.low = [p.hi + 1 for item in e.carried for p in item.pieces if self._is_low(item, p)]
        self.slopes: dict[tuple[str, Variable], str] = {}  # C variables of Phi
        self.changes: dict[tuple[str, Variable], str] = {}  # C variables of dPhi/dt
        self._shared: dict[tuple[str, Variable], Node] = {}  # Phi that is the same at all indices
        self._place_slopes()
        self.levels = {mode: list(self._levels(mode)) for mode in MODES}
        self.gathered = {low: self._gathered(low, False) for low in (False, True)}
        self.moved = {low: self._gathered(low, True) for low in (False, True)}

    @property
    def width(self) -> int:
        return len(self.groups)

    @cached_property
    def reach(self) -> int:
        """Returns the largest difference between the indices of rows that are coupled by a
        recurrence or by the mass matrix, at least 1."""
        found = [offset for _, (offset, _) in (*self.slopes, *self._shared)]
        found += [shift for _, _, shift in self.e.mass.entries]
        return -min([-1, *found])

    # -- derivatives --------------------------------------------------------------------------

    def variable(self, slot: Slot) -> Variable:
        if slot.at is None:
            return (BESIDE, self.scalar[slot.name])
        return ((slot.at - M).constant, self.number[slot.name])

    def _is_low(self, item: Carried, piece: Piece) -> bool:
        """Returns whether a piece of a recurrence holds only near the first index, at a fixed
        distance from it."""
        return Part(piece.lo, piece.hi, ZERO).is_point and (piece.hi - item.group.lo).is_constant

    def _place_slopes(self) -> None:
        changing = []
        for item in self.e.carried:
            for slot in dict.fromkeys(z for piece in item.pieces for z in piece.by):
                key = (item.group.name, self.variable(slot))
                shared = self._same_for_all(item, slot)
                if shared is not None:
                    self._shared[key] = shared
                    continue
                self.slopes[key] = f"slopes[{len(self.slopes)}]"
                if any(piece.by_rate.get(slot, ZERO) != ZERO for piece in item.pieces):
                    changing.append(key)
        self.changes = {key: f"changes[{k}]" for k, key in enumerate(changing)}

    def _same_for_all(self, item: Carried, slot: Slot) -> Node | None:
        """Returns the derivative of a recurrence value by the variable `slot`, if it is the same
        constant (mostly 1) at all indices; otherwise None."""
        nodes = {piece.by[slot] for piece in item.pieces if slot in piece.by}
        if len(nodes) > 1 or self.g.depends[node := nodes.pop()] & ~CONSTANT:
            return None
        if slot.at is None or self.outside(item, slot):
            return None
        target, shift = self.groups[slot.name], (slot.at - M).constant
        begins = all(_at_least(g.lo - target.lo, 0) for g in self.groups.values())
        rest = [piece for piece in item.pieces if slot not in piece.by]
        before = all(_at_least(target.lo - piece.hi - shift, 1) for piece in rest)
        return node if before and (begins or not rest) else None

    def outside(self, item: Carried, slot: Slot) -> str:
        """Returns the C condition that the index of a variable is beyond an end of its family; ""
        if the index never is."""
        if slot.at is None or not self.groups[slot.name].ends:
            return ""
        target, shift = self.groups[slot.name], (slot.at - M).constant
        uses = [piece for piece in item.pieces if slot in piece.by]
        if all(
            _at_least(x.lo + shift - target.lo, 0) and _at_least(target.hi - x.hi - shift, 0)
            for x in uses
        ):
            return ""
        return self.beyond(target, shift)

    def beyond(self, target: Group, shift: int) -> str:
        at = self.places.index(M + shift)
        return f"{at} < {self.places.index(target.lo)} || {at} > {self.places.index(target.hi)}"

    def slope(self, name: str, low: bool, change: bool = False) -> Iterator[tuple[Variable, Node]]:
        """Yields pairs (variable, derivative by it) for the variables in the definition of a
        recurrence value. With `change` it yields the time derivatives of these derivatives. Pieces
        that hold only near the first index count only if `low`."""
        [item] = [item for item in self.e.carried if item.group.name == name]
        pieces = [p for p in item.pieces if low or not self._is_low(item, p)]
        for slot in dict.fromkeys(z for piece in pieces for z in piece.by):
            key = (name, self.variable(slot))
            if change:
                node = self.place(self.changes[key]) if key in self.changes else ZERO
            else:
                node = self._shared.get(key) or self.place(self.slopes[key])
            yield key[1], node

    def place(self, text: str) -> Node:
        return self.slots.node("place", text)

    def cell(self, at: Variable, array: str = "cells") -> str:
        offset, number = at
        if offset == BESIDE:
            return f"{'beside' if array == 'cells' else 'beside_' + array}[{number}]"
        return f"{array}[{offset * self.width + number}]"

    # -- passes along the chain ----------------------------------------------------------------

    def _levels(self, mode: str) -> Iterator[Level]:
        found: dict[tuple[int, Affine, Affine], list[Carried]] = {}
        for item in self.e.carried:
            found.setdefault((item.level, item.group.lo, item.group.hi), []).append(item)
        for k, items in enumerate(found.values()):
            rows: list[Row] = []
            stores: list[str] = []
            guards: list[tuple[str, str]] = []
            for item in items:
                for store, outside, value in self._values(item, mode):
                    rows.append(self._row(item, value))
                    stores.append(store)
                    guards += [(outside, store)] if outside else []
            made = self.make.rows(f"{mode}_{k}", items[0].group, rows, ghosts=False)
            yield Level(made, self.places.group(items[0].group), stores, guards)

    def _values(
        self, item: Carried, mode: str
    ) -> Iterator[tuple[str, str, Callable[[Piece], Node]]]:
        """Yields a triple for each value that the pass `mode` computes: the C variable of the
        value, the C condition under which the value is 0, and a function that returns the node of
        the value for a piece of the recurrence."""
        what, name = MODES[mode], item.group.name
        texts = {"value": "q", "rate": "v", "coasting": "w", "own": "d"}
        for key, kind in texts.items():
            if key in (*what, "value", "rate"):
                array, at = self.places.carried(kind, name, M)
                text = f"{array}[{self.places.index(at)}]"
                yield text, "", lambda piece, key=key: getattr(piece, key)
        for key, stored in (("by", self.slopes), ("by_rate", self.changes)):
            for slot in dict.fromkeys(z for piece in item.pieces for z in piece.by):
                at = (name, self.variable(slot))
                if key in what and at in stored:
                    outside = self.outside(item, slot)
                    yield (
                        stored[at],
                        outside,
                        lambda piece, key=key, slot=slot: getattr(piece, key).get(slot, ZERO),
                    )

    def _row(self, item: Carried, value: Callable[[Piece], Node]) -> Row:
        parts = ((piece, value(piece)) for piece in item.pieces)
        carried = [g.name for g in self.e.carried_groups]
        inside = self.slots.inside
        return Row(tuple(Part(p.lo, p.hi, x, inside(x, carried)) for p, x in parts if x != ZERO))

    # -- from forces on recurrence values to forces on coordinates -------------------------------

    def hung(self, low: bool) -> Block:
        """Returns the block that _gathered makes with `moving`, extended by stores of the sums for
        the recurrence values themselves."""
        return self._gathered(low, True, own=True)

    def _gathered(self, low: bool, moving: bool, own: bool = False) -> Block:
        """Returns the block that converts the forces on the recurrence values of one index to
        forces on the variables that define these values, by the chain rule. With `moving` the block
        converts dL/dq and momenta. A momentum of a recurrence value also adds to dL/dq, since the
        rate of this value depends on coordinates."""
        known: dict[str, Node] = {}
        changed: dict[str, None] = {}

        def value(text: str) -> Node:
            return known.get(text) or self.place(text)

        def add(text: str, *nodes: Node) -> None:
            known[text] = self.g.sum((value(text), *nodes))
            changed[text] = None

        for item in reversed(self.e.carried):
            name = item.group.name
            cell = (0, self.number[name])
            slopes = list(self.slope(name, low))
            changes = dict(self.slope(name, low, change=True))
            force, momentum = value(self.cell(cell)), value(self.cell(cell, "pushes"))
            for at, slope in slopes:
                terms = [self.g.multiply(slope, force)]
                if moving:
                    terms.append(self.g.multiply(changes[at], momentum))
                    add(self.cell(at, "pushes"), self.g.multiply(slope, momentum))
                add(self.cell(at), *terms)
        kept = [text for text in changed if own or not self._is_carried_now(text)]
        return Block([Target(STORE, text, (known[text],)) for text in kept], INNER)

    def _is_carried_now(self, text: str) -> bool:
        numbers = [self.number[item.group.name] for item in self.e.carried]
        return any(text == self.cell((0, k), a) for k in numbers for a in ("cells", "pushes"))


def _at_least(at: Affine, least: int) -> bool:
    return at.is_constant and at.constant >= least
