"""Derivatives of the momenta and of p' by coordinates and rates, as rows: a band with a border."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from typing import TypeVar

from ...graph.affine import ROW, Affine, variable
from ...graph.differentiate import gradient
from ...graph.graph import BIT, ZERO, Kind, Node
from ...record import record
from .loops import Band, LoopEquations, Part, Row, Total, Unrolled, Vector
from .slots import Slots

M = variable(ROW)
BY_PLACE, BY_RATE = ("q",), ("v", "s", "d")  # slots; "d" is the rate of a cell that is not given
_MASKS = {BY_PLACE: BIT[Kind.COORDINATE], BY_RATE: BIT[Kind.RATE] | BIT[Kind.STATE]}
_By = dict[tuple[str, Affine | None], Node]
K = TypeVar("K")


@record
class Matrix:
    """Entry (family, other, d) of `entries` is of cell m of one by m + d of the other; `right` is
    of a family's cell m by a scalar coordinate, `bottom` of a scalar by a family's cell m."""

    entries: dict[tuple[str, str, int], Row]
    right: dict[tuple[str, str], Row]
    bottom: dict[tuple[str, str], Row]
    corner: dict[tuple[str, str], Total]


@record
class Slopes:
    mass: Matrix
    p_q: Matrix
    pdot_q: Matrix
    pdot_v: Matrix

    @property
    def all(self) -> tuple[Matrix, ...]:
        return self.mass, self.p_q, self.pdot_q, self.pdot_v


def slopes_of(e: LoopEquations, slots: Slots) -> Slopes:
    """Raises Unrolled where a row reaches members at no fixed distance."""
    derive = _Derive(slots)
    return Slopes(
        _symmetric(e.mass),
        derive.matrix(e.momenta, BY_PLACE),
        derive.matrix(e.pdot, BY_PLACE),
        derive.matrix(e.pdot, BY_RATE),
    )


def _symmetric(mass: Band) -> Matrix:
    right = {(family, scalar): row for (scalar, family), row in mass.border.items()}
    return Matrix(mass.entries, right, mass.border, mass.corner)


class _Derive:
    def __init__(self, slots: Slots):
        self.slots, self.g = slots, slots.graph

    def matrix(self, vector: Vector, kinds: tuple[str, ...]) -> Matrix:
        if vector.pairs or any(total.pairs for total in vector.totals.values()):
            raise Unrolled("a sum over all members makes the derivatives dense")
        entries: dict[tuple[str, str, int], list[Part]] = defaultdict(list)
        right: dict[tuple[str, str], list[Part]] = defaultdict(list)
        bottom: dict[tuple[str, str], list[Part]] = defaultdict(list)
        corner: dict[tuple[str, str], Total] = defaultdict(Total)
        for family, row in vector.rows.items():
            for part in row.parts:
                for (name, at), found in self._by_part(part, kinds).items():
                    if at is None:
                        right[family, name].append(found)
                    else:
                        entries[family, name, _distance(at, part)].append(found)
        for scalar, total in vector.totals.items():
            for (name, at), node in self._by(total.constant, kinds).items():
                if at is None:
                    corner[scalar, name] = self._with(corner[scalar, name], node)
                else:
                    bottom[scalar, name].append(Part(at, at, node, node))
            for part in total.parts:
                for (name, at), found in self._by_part(part, kinds).items():
                    if at is None:
                        known = corner[scalar, name]
                        corner[scalar, name] = Total(known.constant, (*known.parts, found))
                    else:
                        bottom[scalar, name].append(self._seen_from(found, _distance(at, part)))
        return Matrix(_rows(entries), _rows(right), _rows(bottom), dict(corner))

    def _by_part(self, part: Part, kinds: tuple[str, ...]) -> dict[tuple[str, Affine | None], Part]:
        inner = self._by(part.node if part.inner is None else part.inner, kinds)
        return {
            key: Part(part.lo, part.hi, node, inner.get(key, ZERO))
            for key, node in self._by(part.node, kinds).items()
        }

    def _by(self, node: Node, kinds: tuple[str, ...]) -> _By:
        """The derivatives that are not zero, by the member or the scalar of each."""
        found: _By = {}
        for symbol, slope in gradient(self.g, node, _MASKS[kinds]).items():
            slot = self.slots.of(symbol)
            if slope != ZERO and slot is not None and slot.kind in kinds:
                key = slot.name, slot.at
                found[key] = self.g.add(found.get(key, ZERO), slope)
        return found

    def _with(self, total: Total, node: Node) -> Total:
        return Total(self.g.add(total.constant, node), total.parts)

    def _seen_from(self, part: Part, distance: int) -> Part:
        """From the row of the cell that is so far away."""
        node, inner = (self.slots.shifted(x, -distance) for x in (part.node, part.inner))
        return Part(part.lo + distance, part.hi + distance, node, inner)


def _distance(at: Affine, part: Part) -> int:
    """Of a member from the cell whose row it is in."""
    apart = at - (M if at.factor(ROW) or part.lo != part.hi else part.lo)
    if not apart.is_constant:
        raise Unrolled("two members far apart feel each other")
    return apart.constant


def _rows(found: dict[K, Iterable[Part]]) -> dict[K, Row]:
    return {key: Row(tuple(parts)) for key, parts in found.items()}
