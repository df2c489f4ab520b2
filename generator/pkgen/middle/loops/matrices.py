"""Makes Jacobian matrices: the derivatives of quantities by members of families and by scalars."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable
from typing import TypeVar

from ...graph.affine import ROW, Affine, variable
from ...graph.differentiate import gradient
from ...graph.graph import BIT, ZERO, Kind, Node
from ...record import record
from .indexed_ir import Part, Row, Total, Unrolled
from .slots import Slots

M = variable(ROW)
# An unknown is (kind, name). The kinds are "v" and "a" for rates and accelerations, "lambda" for
# multipliers, "place", "rate", "hung_p" and "hung_f" for recurrences (jacobians_recurrences.py),
# and "sum" for sums over members, with their number as name.
Unknown = tuple[str, str]
# The kinds of symbols (see Slot) by which derivatives are taken: positions, rates, additional
# unknowns (including those of recurrences), and sums over members.
BY_PLACE, BY_RATE = ("q",), ("v", "s", "d")
BY_MORE = ("a", "lambda", "sum", "hung_p", "hung_f")
BY_TOTALS = ("sum",)
_OF = {**dict.fromkeys((*BY_PLACE, *BY_RATE), "v"), **{kind: kind for kind in BY_MORE}}
_OF_CARRIED = {"q": "place", **dict.fromkeys(BY_RATE, "rate"), **{kind: kind for kind in BY_MORE}}
_MASKS = {
    BY_PLACE: BIT[Kind.COORDINATE],
    BY_RATE: BIT[Kind.RATE] | BIT[Kind.STATE],
    BY_MORE: BIT[Kind.INPUT] | BIT[Kind.COORDINATE] | BIT[Kind.RATE],
    BY_TOTALS: BIT[Kind.INPUT],
}
_By = dict[tuple[Unknown, Affine | None], Node]
K = TypeVar("K")


@record
class Matrix:
    """A banded matrix of derivatives with a border.

    In the band, `entries` maps (quantity, unknown, d) to the derivative of the quantity's value at
    index m by the unknown's value at index m + d. In the border, `right` has derivatives of values
    at index m by scalars, `bottom` has derivatives of scalars by values at index m, and `corner`
    has derivatives of scalars by scalars.
    """

    entries: dict[tuple[Unknown, Unknown, int], Row]
    right: dict[tuple[Unknown, Unknown], Row]
    bottom: dict[tuple[Unknown, Unknown], Row]
    corner: dict[tuple[Unknown, Unknown], Total]

    def __or__(self, other: Matrix) -> Matrix:
        """Returns a matrix with the entries of both matrices, which have none in common."""
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return Matrix(*(one | more for one, more in pairs))


@record
class Stated:
    """Quantities to differentiate. `rows` have a value for each index, `totals` a single value."""

    rows: dict[Unknown, Row]
    totals: dict[Unknown, Total]


class Derive:
    def __init__(self, slots: Slots, fixed: frozenset[int], carried: frozenset[str] = frozenset()):
        self.slots, self.g, self.carried = slots, slots.graph, carried
        self.fixed = fixed  # numbers of the sums over members that depend on parameters only

    def by(self, of: Stated) -> Callable[[tuple[str, ...]], Matrix]:
        return lambda kinds: self.matrix(of, kinds)

    def matrix(self, of: Stated, kinds: tuple[str, ...]) -> Matrix:
        entries: dict[tuple[Unknown, Unknown, int], list[Part]] = defaultdict(list)
        right: dict[tuple[Unknown, Unknown], list[Part]] = defaultdict(list)
        bottom: dict[tuple[Unknown, Unknown], list[Part]] = defaultdict(list)
        corner: dict[tuple[Unknown, Unknown], Total] = defaultdict(Total)
        for family, row in of.rows.items():
            for part in row.parts:
                for (name, at), found in self._by_part(part, kinds).items():
                    if at is None:
                        right[family, name].append(found)
                    else:
                        entries[family, name, _distance(at, part)].append(found)
        for scalar, total in of.totals.items():
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
                        found = seen_from(self.slots, found, _distance(at, part))
                        bottom[scalar, name].append(found)
        return Matrix(_rows(entries), _rows(right), _rows(bottom), dict(corner))

    def _by_part(
        self, part: Part, kinds: tuple[str, ...]
    ) -> dict[tuple[Unknown, Affine | None], Part]:
        inner = self._by(part.node if part.inner is None else part.inner, kinds)
        return {
            key: Part(part.lo, part.hi, node, inner.get(key, ZERO))
            for key, node in self._by(part.node, kinds).items()
        }

    def _by(self, node: Node, kinds: tuple[str, ...]) -> _By:
        """Returns the nonzero derivatives of a node. The keys are (unknown, index of its
        member)."""
        found: _By = {}
        for symbol, slope in gradient(self.g, node, _MASKS[kinds]).items():
            slot = self.slots.of(symbol)
            if slope == ZERO or slot is None:
                continue
            if slot.kind == "sum" and int(slot.name) in self.fixed:
                continue
            own = slot.name in self.carried
            if kinds == BY_MORE if own else slot.kind in kinds:
                key = ((_OF_CARRIED if own else _OF)[slot.kind], slot.name), slot.at
                found[key] = self.g.add(found.get(key, ZERO), slope)
        return found

    def _with(self, total: Total, node: Node) -> Total:
        return Total(self.g.add(total.constant, node), total.parts)


def seen_from(slots: Slots, part: Part, distance: int) -> Part:
    """Returns the contribution `part` with all indices shifted: the member with the index m +
    distance gets the index m."""
    node, inner = (slots.shifted(x, -distance) for x in (part.node, part.inner))
    return Part(part.lo + distance, part.hi + distance, node, inner)


def _distance(at: Affine, part: Part) -> int:
    """Returns the difference between a member's index and the index m of the part's row. Raises
    Unrolled if it is not constant."""
    apart = at - (M if at.factor(ROW) or part.lo != part.hi else part.lo)
    if not apart.is_constant:
        raise Unrolled("two members far apart feel each other")
    return apart.constant


def _rows(found: dict[K, Iterable[Part]]) -> dict[K, Row]:
    return {key: Row(tuple(parts)) for key, parts in found.items()}
