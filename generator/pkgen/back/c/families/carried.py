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

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from ....graph.affine import Affine
from ....graph.graph import CONSTANT, ZERO, Node
from ....middle.families.equations import FamilyEquations
from ....middle.families.indexed_ir import Carried, Piece, Slot
from ...targets import STORE, Target
from .blocks import INNER, Block
from .kernels import Builder, Terms
from .places import M, Places

BESIDE = 1  # This number, in place of an offset, marks a scalar coordinate.
Variable = tuple[int, int]  # (index relative to the loop's index m, at most 0; family's number)
# For each pass of a loop along a chain of links, the fields of Piece that the pass computes besides
# the value and the rate.
MODES = {"state": ("own",), "force": ("coasting", "by"), "motion": ("by", "by_rate")}


@dataclass
class Level:
    """Recurrence values of one level and index range, which one C function computes; `stores` has
    the C pointer of each value, at the first member."""

    terms: Terms
    stores: list[str]
    lo: str
    hi: str


@dataclass
class Clear:
    """A derivative, number `number` in memory, which is 0 but for the indices lo..hi (C text)."""

    array: str
    number: int
    lo: str
    hi: str


class Carrying:
    """The C blocks of one model's recurrence values; may add nodes to the graph."""

    def __init__(self, e: FamilyEquations, places: Places, make: Builder):
        self.e, self.g, self.places, self.make = e, e.graph, places, make
        self.slots = make.slots
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
        found += [
            (b - a).constant for (_, a), (_, b) in (x.to for x in self.e.mass) if None not in (a, b)
        ]
        return -min([-1, *found])

    # -- derivatives --------------------------------------------------------------------------

    def variable(self, slot: Slot) -> Variable:
        if slot.at is None:
            return (BESIDE, self.scalar[slot.name])
        return ((slot.at - M).constant, self.number[slot.name])

    def _is_low(self, item: Carried, piece: Piece) -> bool:
        """Returns whether a piece of a recurrence holds only near the first index, at a fixed
        distance from it."""
        length = piece.hi - piece.lo
        short = length.is_constant and length.constant <= 8
        return short and (piece.hi - item.group.lo).is_constant

    def _place_slopes(self) -> None:
        changing = []
        for item in self.e.carried:
            for slot in dict.fromkeys(z for piece in item.pieces for z in piece.by):
                key = (item.group.name, self.variable(slot))
                shared = self._same_for_all(item, slot)
                if shared is not None:
                    self._shared[key] = shared
                    continue
                self.slopes[key] = f"slopes[{len(self.slopes)} * span]"
                if any(piece.by_rate.get(slot, ZERO) != ZERO for piece in item.pieces):
                    changing.append(key)
        self.changes = {key: f"changes[{k} * span]" for k, key in enumerate(changing)}

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

    def outside(self, item: Carried, slot: Slot) -> bool:
        """Returns whether the index of a variable may be beyond an end of its family."""
        if slot.at is None or not self.groups[slot.name].ends:
            return False
        target, shift = self.groups[slot.name], (slot.at - M).constant
        uses = [piece for piece in item.pieces if slot in piece.by]
        return not all(
            _at_least(x.lo + shift - target.lo, 0) and _at_least(target.hi - x.hi - shift, 0)
            for x in uses
        )

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

    @property
    def mutual(self) -> bool:
        """Whether a recurrence value is made from one of a higher level, or of its level with other
        index ranges, at a lower index. Then all are computed index by index; else one behind the
        other."""
        items = {item.group.name: item for item in self.e.carried}

        def apart(item: Carried, other: Carried) -> bool:
            ranges = [[(p.lo, p.hi) for p in x.pieces] for x in (item, other)]
            return other.level > item.level or (
                other.level == item.level and ranges[0] != ranges[1]
            )

        return any(
            apart(item, items[z.name])
            for item in self.e.carried
            for piece in item.pieces
            for z in piece.by
            if z.name in items and z.name != item.group.name
        )

    def _levels(self, mode: str) -> Iterator[Level]:
        found: dict[tuple[int, Affine, Affine], list[tuple[str, Node]]] = {}
        for item in self.e.carried:
            for piece in item.pieces:
                values = found.setdefault((item.level, piece.lo, piece.hi), [])
                values += self._values(item, piece, mode)
        for k, ((_, lo, hi), values) in enumerate(found.items()):
            nodes = [node for _, node in values]
            terms = Terms(f"along_{mode}_{k}", (lo, hi), nodes, sequence=True)
            yield Level(
                terms, [store for store, _ in values], self.places.index(lo), self.places.index(hi)
            )

    def _values(self, item: Carried, piece: Piece, mode: str) -> Iterator[tuple[str, Node]]:
        """Yields the C pointer and the node of each value that the pass `mode` computes."""
        what, name, index = MODES[mode], item.group.name, self.places.index
        texts = {"value": "q", "rate": "v", "coasting": "w", "own": "d"}
        for key, kind in texts.items():
            if key in (*what, "value", "rate"):
                array, at = self.places.carried(kind, name, piece.lo)
                yield f"x.{array} + {index(at)}", getattr(piece, key)
        for key, stored, array in (
            ("by", self.slopes, "slopes"),
            ("by_rate", self.changes, "changes"),
        ):
            for slot in dict.fromkeys(z for each in item.pieces for z in each.by):
                at = (name, self.variable(slot))
                if key in what and at in stored:
                    number = [*stored].index(at)
                    place = f"x.{array} + {number} * x.span + ({index(piece.lo)}) - base"
                    yield place, getattr(piece, key).get(slot, ZERO)

    @property
    def clears(self) -> Iterator[Clear]:
        """Yields the derivatives with the index range outside which they are 0."""
        for item in self.e.carried:
            for slot in dict.fromkeys(z for piece in item.pieces for z in piece.by):
                key, lo, hi = (
                    (item.group.name, self.variable(slot)),
                    [item.group.lo],
                    [item.group.hi],
                )
                if slot.at is not None:
                    target, shift = self.groups[slot.name], (slot.at - M).constant
                    lo.append(target.lo - shift)
                    hi.append(target.hi - shift)
                for array, stored in (("slopes", self.slopes), ("changes", self.changes)):
                    if key in stored:
                        yield Clear(array, [*stored].index(key), self.most(lo), self.least(hi))

    def most(self, found: list[Affine], call: str = "pk_most") -> str:
        """Returns the largest of some indices in C."""
        text, *more = dict.fromkeys(map(self.places.index, found))
        for other in more:
            text = f"{call}({text}, {other})"
        return text

    def least(self, found: list[Affine]) -> str:
        return self.most(found, "pk_least")

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
