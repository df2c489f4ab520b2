"""The intermediate representation of equations of families whose lengths are chosen at run time.

L is a sum of terms, each of which is a sum over i = lo..hi of one expression, the body. A member
of a family is also called a cell. The derivatives of a body by the cells in it are added to the
rows of these cells: an Addend is such an expression, with the range of its index and the cell to
which it is added. An index beyond an end of a family has a given value (`fixed` end), or stands for
the cell at this end (`free`) or for a cell at the other end (`periodic`). An addend to such an
index is left out, or added to the row of the cell for which the index stands. This is valid for
every length of a family, down to one member.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ...graph.affine import Affine
from ...graph.graph import ZERO, Graph, Node
from ...model import Constraint, Coordinate, Definition, End, Parameter, State
from ...record import record


class NotKept(Exception):
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
    "d": the rate of a coordinate; 0 for a given member, as in the work v.p of an energy. For a
        recurrence, the part of its rate that is due to the rates of coordinates.
    "a": the acceleration of a coordinate as an unknown; 0 for a given member. For a first-order
        variable, its time derivative, also in a given member.
    "param", "size", "index", "input": a parameter, a size, a loop variable, an input.
    "sum": the value of the sum over members whose number is the name.
    "lambda": a multiplier of the constraint whose name this is.
    "hung_p", "hung_f": unknowns of a recurrence (jacobians_recurrences.py).
    "side": the side of a switch, whose number is the name.
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


# A member of a family, as (name, index), or a scalar, as (name, None).
Cell = tuple[Any, Affine | None]
# Ranges of indices: () for a single expression, (lo, hi) for m, (lo, hi, first, last) for pairs m
# and j, where `first` and `last` may contain m.
Over = tuple[Affine, ...]


@record
class Addend:
    """The expression `node`, for each index in `over`, is added to a quantity: to its value for the
    cell in `to`, of a matrix to its entry in the row and column of the two cells in `to`, or, if
    `to` is (), to its only value."""

    over: Over
    node: Node
    to: tuple[Cell, ...] = ()


Sum = tuple[Addend, ...]  # All addends of a quantity.


def merged(found: Iterable[Addend], g: Graph) -> Sum:
    """Returns the addends, those with the same range and cells as one; without zeros."""
    nodes: dict[tuple[Over, tuple[Cell, ...]], Node] = {}
    for x in found:
        key = x.over, x.to
        nodes[key] = g.add(nodes[key], x.node) if key in nodes else x.node
    return tuple(Addend(over, node, to) for (over, to), node in nodes.items() if node != ZERO)


def nodes_of(*sums: Iterable[Addend]) -> list[Node]:
    return [x.node for found in sums for x in found]


def of_name(found: Iterable[Addend], name: Any) -> Sum:
    """Returns the addends to the cells with this name."""
    return tuple(x for x in found if x.to[0][0] == name)


def is_diagonal(matrix: Iterable[Addend]) -> bool:
    return all(x.to[0] == x.to[1] for x in matrix)


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
    the statement, or a single row if it has no index. The cells of the rows are (name of the group,
    m), or (name, None) for a single row."""

    # The declared name.
    name: str
    # In C, constraints are numbered: the name of this group is the number of the constraint.
    group: Group
    is_single: bool  # Whether the statement has no index, so that it has one row.
    # The function phi of a holonomic constraint phi = 0; for a `rolling` statement, 0.
    position: Sum
    # The left-hand side of the constraint J v + j0 = 0.
    rate: Sum
    # The time derivative of J v + j0 if the accelerations of all coordinates are 0.
    coasting: Sum
    # Bounds of the rounding errors of phi and of J v + j0 (graph/rounding.py).
    sizes: tuple[Sum, Sum]
    jacobian: Sum

    @property
    def holonomic(self) -> bool:
        return isinstance(self.group.declared, Constraint) and self.group.declared.holonomic

    @property
    def all(self) -> Sum:
        """All addends that are computed at run time, except sizes."""
        return (*self.position, *self.rate, *self.coasting, *self.jacobian)

    @property
    def nodes(self) -> list[Node]:
        return nodes_of(self.all)
