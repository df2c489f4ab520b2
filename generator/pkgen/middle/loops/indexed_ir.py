"""The intermediate representation of equations with loops over the members of families.

L is a sum of terms, each of which is a sum over i = lo..hi of one expression, the body. A member of
a family is also called a cell. The derivative of L by cell m of a family,

    row(m) = sum over terms, sum over offsets c,  [lo <= m - c <= hi] d body/d q[i+c] at i = m - c

has a contribution (Part) of each body and offset c. The brackets are 1 if the condition in them
holds, else 0. The members m for which all conditions hold and no cell beyond an end occurs are
called the interior; there the row is one expression without conditions. A cell beyond an end is a
given function of t (`fixed` end), equal to the cell at this end (`free`), or equal to a cell at the
other end (`periodic`). In the last two cases, by the chain rule, its row is added to the row of the
cell to which it is equal. This is valid for every length of a family, down to one member.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field

from ...graph.affine import Affine
from ...graph.graph import Node
from ...model import Constraint, Coordinate, Definition, End, Parameter, State
from ...record import record


class Unrolled(Exception):
    """The model cannot be compiled to loops over members. The text is the reason."""


@record
class Slot:
    """The meaning of a symbol of the graph: a kind, a name, and the index `at` of a family's member
    (None for a scalar). A member beyond a fixed end, whose value the model gives as a function of
    t, is called a given member here. The kinds are:

    "q": a coordinate.
    "v": a rate.
    "s": a first-order variable, which C stores among the rates.
    "w": the acceleration of a given member; 0 for other members. For a recurrence (`Carried`), its
        acceleration if the accelerations of all coordinates are 0.
    "d": the rate of a coordinate; 0 for a given member. For a recurrence, the part of its rate that
        is due to the rates of coordinates.
    "a": the acceleration of a coordinate as an unknown; 0 for a given member. For a first-order
        variable, its time derivative, also in a given member.
    "param", "size", "index", "input": a parameter, a size, a loop variable, an input.
    "sum": the value of the Total whose number is the name.
    "lambda": a multiplier of the constraint rows with this name.
    "hung_p", "hung_f": unknowns of a recurrence (jacobians_recurrences.py).
    "side": the side of a switch, whose number is the name.
    "flux": the force between two neighbouring members (back/c/loops_interior.py).
    "place": an element of a C array, with its C text as name.
    "p", "let", "acc": in outputs only, a momentum, a member of a `let` definition, and an
        acceleration, also of a given member.
    """

    kind: str
    name: str
    at: Affine | None = None


# The kinds of symbols (see Slot) that stand for coordinates, rates and first-order variables.
CELLS = ("q", "v", "s")
# The kinds of symbols whose index has to be that of an existing member of a family.
REACHED = (*CELLS, "a", "acc")


@record
class Group:
    """A declared coordinate, state, parameter, constraint or recurrence (`Carried`): a scalar (lo
    is None) or a family with the indices lo..hi."""

    declared: Coordinate | State | Parameter | Definition | Constraint
    lo: Affine | None
    hi: Affine | None
    # The indices outside the family to which the model gives values, with their declarations.
    ends: tuple[tuple[Affine, End], ...] = ()
    periodic: bool = False
    # A suffix of the name, for a component of a vector.
    component: str = ""

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
        """Whether the group is a coordinate of a rotation. Such a coordinate has a rate, which is a
        body rate, but no value."""
        return isinstance(self.declared, Coordinate) and bool(self.declared.rate)

    @property
    def shown(self) -> str:
        """The name of the group in messages and output."""
        return self.declared.rate if self.is_turn else self.name

    @property
    def count(self) -> Affine:
        return Affine(1) if self.lo is None else self.hi - self.lo + 1


@record
class Part:
    """The contribution of one body at one offset to the rows m = lo..hi.

    `inner` is the contribution to rows in the interior. There no member beyond a fixed end occurs.
    """

    lo: Affine
    hi: Affine
    node: Node
    inner: Node | None = None

    @property
    def is_point(self) -> bool:
        """Whether the range lo..hi has a constant length of a few members, which does not depend on
        the length of the family."""
        length = self.hi - self.lo
        return length.is_constant and length.constant <= 8


@record
class Row:
    """A quantity with a value for each member of a family."""

    parts: tuple[Part, ...] = ()


@record
class PairPart:
    """The double sum of `node` over m = lo..hi and j = first..last, where `first` and `last` may
    contain m. No pair (m, j) occurs twice."""

    lo: Affine
    hi: Affine
    first: Affine
    last: Affine
    node: Node


@record
class Total:
    """A quantity with a single value: a constant plus sums over members plus double sums."""

    constant: Node = 0
    parts: tuple[Part, ...] = ()
    pairs: tuple[PairPart, ...] = ()


@record
class PairForce:
    """The derivatives of the body of a double sum over m and j, by the members and scalar
    coordinates in it."""

    lo: Affine
    hi: Affine
    first: Affine
    last: Affine
    # Pairs (family, derivative of the summand by member m of this family).
    by_row: tuple[tuple[str, Node], ...]
    # Pairs (family, derivative of the summand by member j of this family).
    by_other: tuple[tuple[str, Node], ...]
    # Pairs (scalar coordinate, derivative of the summand by this coordinate).
    by_scalar: tuple[tuple[str, Node], ...]


@record
class Vector:
    """A quantity with a value for each coordinate: `rows` has the values of families, by name,
    `totals` the values of scalar coordinates."""

    rows: dict[str, Row]
    totals: dict[str, Total]
    pairs: tuple[PairForce, ...] = ()


@record
class Band:
    """The mass matrix M. `entries` maps (family, other family, d) to the entries of M in the row of
    member m of the first family and the column of member m + d of the other one. `border` has the
    entries that couple a scalar coordinate with member m of a family. `corner` has the entries that
    couple two scalar coordinates."""

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
    """The recurrence for the members lo..hi of a quantity X (see `Carried`). It gives X[m] from
    members of X with lower indices, coordinates and t.

    `by` has the partial derivatives of X[m] by coordinates and by members of X with lower indices.
    `by_rate` has the time derivatives of these partial derivatives.
    """

    lo: Affine
    hi: Affine
    value: Node
    rate: Node
    # The second time derivative of X[m] if the accelerations of all coordinates are 0.
    coasting: Node
    # The part of the time derivative of X[m] that is due to coordinates and lower members of X, not
    # to t itself.
    own: Node
    by: dict[Slot, Node]
    by_rate: dict[Slot, Node]


@record
class Carried:
    """A carried value: an indexed quantity X that a `let` defines by a recurrence from lower
    members, such as the positions along a chain of links.

    In L, X is treated like a family of coordinates. By the chain rule, its rows are then added to
    those of the variables in the recurrence. A recurrence may use the same index of other carried
    values if their `level` is lower.
    """

    group: Group
    pieces: tuple[Piece, ...]  # the recurrences for adjacent index ranges, in order
    level: int


@record
class Bound:
    """The constraint rows J v + j0 of a statement `constraint` or `rolling`: one for each index of
    the statement, or a single row if it has no index.

    For a statement with an index, `entries` maps (name, shift) to the entries of J in row m for
    member m + shift of a family; shift is None for a scalar coordinate. For a single row, `border`
    has the entries of J for member m of a family, `corner` the entries for scalar coordinates.
    """

    # The declared name.
    name: str
    # In C, constraints are numbered: the name of this group is the number of the constraint.
    group: Group
    # The function phi of a holonomic constraint phi = 0; for a `rolling` statement, 0.
    position: Row | Total
    # The left-hand side of the constraint J v + j0 = 0.
    rate: Row | Total
    # The time derivative of J v + j0 if the accelerations of all coordinates are 0.
    coasting: Row | Total
    # Bounds of the rounding errors of phi and of J v + j0 (graph/rounding.py).
    sizes: tuple[Row | Total, Row | Total]
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
        """Yields all nodes that are computed at run time, each with its index range (lo, hi), or ()
        for a single value."""
        found = [self.position, self.rate, self.coasting]
        found += [*self.entries.values(), *self.border.values(), *self.corner.values()]
        for x in found:
            yield from (((part.lo, part.hi), part.node) for part in x.parts)
            if isinstance(x, Total):
                yield (), x.constant

    @property
    def nodes(self) -> list[Node]:
        return [node for _, node in self.ranged]
