"""Rows and totals: the intermediate representation of the equations of families kept as loops.

L is a sum of terms, each a sum over i = lo..hi of one body. Its derivative by a cell (member) m of
a family collects the derivatives of the bodies that contain the cell,

    row(m) = sum over terms, sum over offsets c,  [lo <= m - c <= hi] d body/d slot_c at i = m - c

A row is a few parts, each with its condition. Where all conditions hold and no end is near, the
row is one expression without conditions, the interior. A cell beyond an end (a ghost) is a function
of t (`fixed`), its neighbour (`free`) or a cell at the other end (`periodic`). By the chain rule
the row of a ghost, with its conditions, is added to the row of the cell that it stands for. This
holds for every length of a family down to one member.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field

from ...graph.affine import Affine
from ...graph.graph import Node
from ...model import Constraint, Coordinate, Definition, End, Parameter, State
from ...record import record


class Unrolled(Exception):
    """The model's families cannot stay loops; the text is the reason."""


@record
class Slot:
    """The meaning of a symbol of the graph. `at` is the index of a family's member. Kinds:

    "q", "v"; "s": a first-order variable, stored in v in C; "w": the acceleration of a given cell,
    0 for a coordinate, for a carried value its acceleration if no coordinate accelerates; "d": the
    rate of a coordinate, 0 for a given cell, for a carried value its rate due to the rates of
    coordinates; "a": the acceleration of a coordinate as an unknown, 0 for a given cell, for a
    state its rate, also in a given cell; "param", "size", "index", "input"; "sum": the total with
    this number; "lambda": a multiplier of the rows with this key; "hung_p" and "hung_f": the
    momenta and forces that a carried value passes on to the variables it depends on; "side": of
    the switch with this number; "flux": a bond's force (back/c/loops_interior.py); "place": its
    name is C text. In outputs alone: "p": a momentum; "let": a member of a `let`; "acc": an
    acceleration, also of a given cell.
    """

    kind: str
    name: str
    at: Affine | None = None


CELLS = ("q", "v", "s")  # kinds of slots of coordinates, rates and states
REACHED = (*CELLS, "a", "acc")  # kinds of slots whose member has to exist


@record
class Group:
    """A declared coordinate, state or parameter: one scalar (lo is None) or a family lo..hi, with
    its ends; or a carried value, see `Carried`."""

    declared: Coordinate | State | Parameter | Definition | Constraint
    lo: Affine | None
    hi: Affine | None
    ends: tuple[tuple[Affine, End], ...] = ()  # each given index outside the family
    periodic: bool = False
    component: str = ""  # suffix of the name, for a component of a vector

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
        """Whether its rate is a body rate; its value then has no meaning."""
        return isinstance(self.declared, Coordinate) and bool(self.declared.rate)

    @property
    def shown(self) -> str:
        """Its name in messages and output."""
        return self.declared.rate if self.is_turn else self.name

    @property
    def count(self) -> Affine:
        return Affine(1) if self.lo is None else self.hi - self.lo + 1


@record
class Part:
    """The contribution of one body at one offset to the rows lo <= m <= hi.

    `inner` is its form in the interior, where no given cell is in reach.
    """

    lo: Affine
    hi: Affine
    node: Node
    inner: Node | None = None

    @property
    def is_point(self) -> bool:
        """Whether it covers a few cells, however long the family is."""
        length = self.hi - self.lo
        return length.is_constant and length.constant <= 8


@record
class Row:
    """A quantity with a value for each cell of a family."""

    parts: tuple[Part, ...] = ()


@record
class PairPart:
    """A double sum of `node` over m = lo..hi and j = first..last, each pair once.

    `first` and `last` may contain m.
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
    """The derivatives of one double sum by the cells and scalar coordinates in it."""

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
    """M as rows: entry (family, other, d) couples cell m of one with cell m + d of the other;
    `border` couples a scalar coordinate with a family's cell m, `corner` two scalars."""

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
    """The recurrence of the members lo..hi of a carried value X, from lower members, q and t.

    `by` has the derivatives of X[m] by slots of kind q, including X[m-1]; `by_rate` their rates.
    """

    lo: Affine
    hi: Affine
    value: Node
    rate: Node
    coasting: Node  # its second derivative in t if no coordinate accelerates
    own: Node  # its rate without explicit dependence on t
    by: dict[Slot, Node]
    by_rate: dict[Slot, Node]


@record
class Carried:
    """A `let` by index with a recurrence from lower members, such as the positions along a chain of
    links. L takes it as a family; its rows are added, by the chain rule, to those it depends on.

    A carried value may use others of lower `level` at the same index.
    """

    group: Group
    pieces: tuple[Piece, ...]  # by index, without a gap
    level: int


@record
class Bound:
    """Rows J v + j0 of a `constraint` or a `rolling`: one for each index, placed in the band of M,
    or a single one, which follows the band like a scalar coordinate.

    For rows by index, `entries` has J of row m by member m + shift of a family, or by a scalar
    (None). For a single row, `border` has J by a family's member m, and `corner` by a scalar.
    """

    name: str  # as declared
    group: Group  # its name is a number, used in C
    position: Row | Total  # phi; 0 for a rolling
    rate: Row | Total  # J v + j0
    coasting: Row | Total  # (J v + j0)' if only given cells accelerate
    sizes: tuple[Row | Total, Row | Total]  # magnitudes of the terms of phi and of J v + j0
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
        """Yields all nodes that a run computes, each with the range of its index, () if none."""
        found = [self.position, self.rate, self.coasting]
        found += [*self.entries.values(), *self.border.values(), *self.corner.values()]
        for x in found:
            yield from (((part.lo, part.hi), part.node) for part in x.parts)
            if isinstance(x, Total):
                yield (), x.constant

    @property
    def nodes(self) -> list[Node]:
        return [node for _, node in self.ranged]
