"""Rows and totals, of which the equations of families kept as loops are made.

L is a sum of terms, each a sum over i = lo..hi of one body. Its derivative by a cell m of a family
gathers what the bodies around it say,

    row(m) = sum over terms, sum over offsets c,  [lo <= m - c <= hi] d body/d slot_c at i = m - c

so a row is a few parts, each with its condition; where all hold and no end is near, one
expression without any condition is left, the interior. A cell beyond an end (a ghost) is a
function of t (`fixed`), its neighbour (`free`) or wraps (`periodic`); by the chain rule its own
row, conditions and all, is added to the row of the cell that it stands for. That holds for every
length of a family down to one member.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field

from ...graph.affine import Affine
from ...graph.graph import Node
from ...model import Constraint, Coordinate, Definition, End, Parameter, State
from ...record import record


class Unrolled(Exception):
    """The model's families cannot stay loops; the text says why."""


@record
class Slot:
    """What a symbol of the graph stands for.

    kind: "q", "v", "s" (a first-order variable, which C has in v), "w" (the acceleration of a cell
    that is given as a function of t, 0 of a coordinate; of a carried value its acceleration where
    no coordinate has one), "d" (the rate of a coordinate, 0 of a given cell; of a carried value
    what the rates of coordinates make of it), "a" (its acceleration, 0 of a given cell, where that
    is an unknown; of a state its rate, of a given cell as well), "param", "size", "index", "input",
    "sum" (the total of that number), "lambda" (of the rows of that key), "hung_p" and "hung_f" (of
    a carried value, the momenta and forces that go over to what it is made of), "p" (a momentum, in
    outputs), "let" (a member of what is computed for outputs alone), "acc" (there, an acceleration,
    of a given cell as well), "side" (of the switch of that number), and "place", whose name is its
    text in C. `at` is the index of a family's member.
    """

    kind: str
    name: str
    at: Affine | None = None


CELLS = ("q", "v", "s")  # slots of what moves
REACHED = (*CELLS, "a", "acc")  # of members, which have to be there


@record
class Group:
    """A declared coordinate, state or parameter: one scalar (lo is None) or a family lo..hi, and
    its ends; or a carried value, see `Carried`."""

    declared: Coordinate | State | Parameter | Definition | Constraint
    lo: Affine | None
    hi: Affine | None
    ends: tuple[tuple[Affine, End], ...] = ()  # each given index outside the family
    periodic: bool = False
    component: str = ""  # of a vector

    @property
    def name(self) -> str:
        return self.declared.name + self.component

    @property
    def is_family(self) -> bool:
        return self.lo is not None

    @property
    def is_state(self) -> bool:
        return isinstance(self.declared, State)

    @property
    def is_carried(self) -> bool:
        return isinstance(self.declared, Definition)

    @property
    def is_turn(self) -> bool:
        """Whether its rate is a body rate, and its value nothing."""
        return isinstance(self.declared, Coordinate) and bool(self.declared.rate)

    @property
    def shown(self) -> str:
        """Its name where a reader sees it."""
        return self.declared.rate if self.is_turn else self.name

    @property
    def count(self) -> Affine:
        return Affine(1) if self.lo is None else self.hi - self.lo + 1


@record
class Part:
    """What one body, seen from one offset, adds to a row: only where lo <= m <= hi.

    `inner` is the same away from the ends, where no given cell is in reach.
    """

    lo: Affine
    hi: Affine
    node: Node
    inner: Node | None = None

    @property
    def is_point(self) -> bool:
        """Over a few cells however long the family is."""
        length = self.hi - self.lo
        return length.is_constant and length.constant <= 8


@record
class Row:
    """A quantity with a value for each cell of a family."""

    parts: tuple[Part, ...] = ()


@record
class PairPart:
    """A double sum over m = lo..hi and j = first..last; nodes by what they add to.

    `first` and `last` may contain m. Each pair is met once.
    """

    lo: Affine
    hi: Affine
    first: Affine
    last: Affine
    node: Node


@record
class Total:
    """A quantity with one value: a constant part, single sums, double sums."""

    constant: Node = 0
    parts: tuple[Part, ...] = ()
    pairs: tuple[PairPart, ...] = ()


@record
class PairForce:
    """The derivatives of one double sum by the cells and the scalar coordinates in it."""

    lo: Affine
    hi: Affine
    first: Affine
    last: Affine
    by_row: tuple[tuple[str, Node], ...]  # family, derivative by its member m
    by_other: tuple[tuple[str, Node], ...]  # by its member j
    by_scalar: tuple[tuple[str, Node], ...]


@record
class Vector:
    """A quantity with a value for each coordinate."""

    rows: dict[str, Row]  # by family
    totals: dict[str, Total]  # by scalar coordinate
    pairs: tuple[PairForce, ...] = ()


@record
class Band:
    """M as rows: entry (family, other, d) is M of cell m of one and m + d of the other;
    `border` is of a scalar coordinate with a family's cell m, `corner` of two scalars."""

    entries: dict[tuple[str, str, int], Row]
    border: dict[tuple[str, str], Row]
    corner: dict[tuple[str, str], Total]

    @property
    def is_diagonal(self) -> bool:
        off_corner = any(a != b for a, b in self.corner)
        return not (self.border or off_corner) and all(
            d == 0 and f == g for f, g, d in self.entries
        )


@record
class Piece:
    """What the members lo..hi of a carried value X are, in terms of lower ones and of q and t.

    `by` has the derivatives of X[m] by slots of q, X[m-1] among them; `by_rate` their rates.
    """

    lo: Affine
    hi: Affine
    value: Node
    rate: Node
    coasting: Node  # its second derivative in t where no coordinate accelerates
    own: Node  # its rate but for what changes with t
    by: dict[Slot, Node]
    by_rate: dict[Slot, Node]


@record
class Carried:
    """A `let` with a value for each member that is defined from lower members, such as a place
    along a chain of links: a family of its own in L, whose rows go over to what it is made of.

    One of a higher level uses those of lower ones at the same index.
    """

    group: Group
    pieces: tuple[Piece, ...]  # by index, without a gap
    level: int


@record
class Bound:
    """Rows J v + j0 of a `constraint` or a `rolling`, one for each member of a family, which lie in
    the band of M, or a single one, which is kept whole behind it as a scalar coordinate is.

    Of a family `entries` has J of row m by member m + shift of another, or by a scalar (None).
    Of a single row `border` has it by a family's member m, and `corner` by a scalar.
    """

    name: str  # as declared
    group: Group  # its name is the one in C, a number
    position: Row | Total  # phi; nothing of a rolling
    rate: Row | Total  # J v + j0
    coasting: Row | Total  # the rate of that where nothing accelerates but what is given
    sizes: tuple[Row | Total, Row | Total]  # of the terms of phi, and of J v + j0
    entries: dict[tuple[str, int | None], Row] = field(default_factory=dict)
    border: dict[str, Row] = field(default_factory=dict)
    corner: dict[str, Total] = field(default_factory=dict)

    @property
    def holonomic(self) -> bool:
        return isinstance(self.group.declared, Constraint) and self.group.declared.holonomic

    @property
    def is_single(self) -> bool:
        return not self.entries

    @property
    def ranged(self) -> Iterator[tuple[tuple[Affine, ...], Node]]:
        """Whatever a run computes of them, with the range of its index, () where it has none."""
        found = [self.position, self.rate, self.coasting]
        found += [*self.entries.values(), *self.border.values(), *self.corner.values()]
        for x in found:
            yield from (((part.lo, part.hi), part.node) for part in x.parts)
            if isinstance(x, Total):
                yield (), x.constant

    @property
    def nodes(self) -> list[Node]:
        return [node for _, node in self.ranged]
