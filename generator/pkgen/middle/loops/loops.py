"""The result of derive_loops: the equations of a model with loops over the members of families."""

from __future__ import annotations

from dataclasses import field

from ...equations import Facts, Quantity
from ...graph.affine import Affine
from ...graph.graph import Graph, Node
from ...model import Definition, Model
from ...record import record
from ..quantities import input_quantities
from .indexed_ir import Bound, Carried, Group, Over, Slot, Sum, is_diagonal


@record
class Summed:
    """A sum in an initial value or parameter, computed once and stored in element `place` of an
    array. `ranges` has (loop variable, lo, hi); `inside` are the sums in each of its terms."""

    place: int
    ranges: tuple[tuple[str, Affine, Affine], ...]
    node: Node
    inside: tuple[Summed, ...]


@record
class Assigned:
    """An assignment to the members m = lo..hi of a declared name. The value `node` may contain m.
    The sums `before` are computed before the loop over m. The sums `each` are computed inside this
    loop, for each m."""

    name: str
    order: int  # 1 if the assignment is to the rate of a coordinate, else 0
    lo: Affine | None
    hi: Affine | None
    node: Node
    before: tuple[Summed, ...] = ()
    each: tuple[Summed, ...] = ()


@record
class Observed:
    """An output: a single value if `lo` is None, else a value for each index m = lo..hi."""

    item: Definition
    lo: Affine | None
    hi: Affine | None
    node: Node

    @property
    def count(self) -> Affine:
        return Affine(1) if self.lo is None else self.hi - self.lo + 1


@record
class Along:
    """An indexed `let` definition that only outputs use, or the time derivative of such a
    definition: then `name` ends with a prime ('). The values are computed in a loop over the
    index."""

    name: str
    group: Group
    parts: Sum  # expressions for disjoint index ranges, in order


@record
class Limit:
    """A condition on the model's sizes, such as N in q[1..N]. It holds if `needs` >= 0, or if
    `unless` < 0, where `unless` is the length of an index range minus 1: if the range is empty,
    nothing is needed. None: `needs` >= 0 must hold."""

    needs: Affine
    unless: Affine | None


@record
class Bounded:
    """The bounds of a parameter, as nodes that may contain the index m; None for no bound."""

    lo: Node | None
    hi: Node | None


@record
class LoopSingularity:
    """An expression at whose zeros the equations are singular, with a value for each index in
    `over`. `name` is the expression with the index i, or with i and j for a pair; `use` is as in
    Singularity."""

    name: str
    use: str
    over: Over
    node: Node


@record
class LoopSwitch:
    """An expression at whose zeros the equations have a kink or a jump, with a value for each index
    m in `ranges`. A range is (lo, hi), or () for a single value. See switches.py and
    equations.Switch."""

    name: str  # The expression as text, with the index i.
    node: Node
    ranges: tuple[tuple[Affine, ...], ...]
    held: bool


@record
class LoopEquations:
    model: Model
    graph: Graph
    slots: tuple[Slot, ...]
    # Coordinates, followed by states. A state is the rate of a dummy coordinate.
    coordinates: tuple[Group, ...]
    parameters: tuple[Group, ...]
    # The number of time derivatives of each input.
    orders: tuple[int, ...]

    # Added to cells: vectors, and the entries of the mass matrix M.
    gradient: Sum
    momenta: Sum
    pdot: Sum
    force: Sum
    mass: Sum
    kinetic: Sum | None
    potential: Sum | None
    # The Lagrangian and the energy are None if the model has states only.
    lagrangian: Sum | None
    energy: Sum | None
    # Sums over members inside expressions, in the order in which they can be computed.
    sums: tuple[Sum, ...]
    # The indices of the elements of `sums` that depend on parameters and sizes only.
    fixed: frozenset[int]
    outputs: tuple[Observed, ...]
    conserved: tuple[Node, ...]
    events: tuple[Node, ...]
    # The value, rate and acceleration of each given member beyond an end, by (family, index).
    given: dict[tuple[str, Affine], tuple[Node, Node, Node]]
    # The default values of parameters, in the order of `parameters`.
    defaults: tuple[Assigned, ...]
    bounds: tuple[Bounded, ...]
    starts: tuple[Assigned, ...]
    limits: tuple[Limit, ...]
    # For each periodic family, the largest distance of an index beyond its ends.
    wraps: dict[str, int] = field(default_factory=dict)
    # `let` definitions that only outputs use. Each inner tuple is computed in one loop.
    along: tuple[tuple[Along, ...], ...] = ()
    # The number of sums in initial values and parameters.
    summed: int = 0
    facts: Facts | None = None
    singularities: tuple[LoopSingularity, ...] = ()
    switches: tuple[LoopSwitch, ...] = ()
    # Whether the pivots of M are singularities too. In numbering, they come before the elements of
    # `singularities`.
    pivots: bool = False
    # Recurrences, sorted by level.
    carried: tuple[Carried, ...] = ()
    # Whether the system M a = f is extended by the accelerations of the recurrences' values as
    # unknowns, and by the equations of the recurrences. If not, these accelerations are eliminated
    # index by index.
    extended: bool = False
    # The constraint rows. Rows of holonomic constraints come first.
    bound: tuple[Bound, ...] = ()
    # Whether implicit methods use the solved form p = v, p' = a, because a momentum depends on a
    # state, such as on the quaternion of a body.
    solved: bool = False

    def group(self, name: str) -> Group:
        return next(g for g in (*self.coordinates, *self.carried_groups) if g.name == name)

    @property
    def carried_groups(self) -> tuple[Group, ...]:
        return tuple(x.group for x in self.carried)

    @property
    def mass_diagonal(self) -> bool:
        return is_diagonal(self.mass)

    @property
    def has_pairs(self) -> bool:
        """Whether the forces have sums over pairs of members."""
        return any(len(x.over) == 4 for x in self.force)

    @property
    def families(self) -> tuple[Group, ...]:
        return tuple(g for g in self.coordinates if g.is_family)

    @property
    def rows(self) -> tuple[Group, ...]:
        """The groups with an equation for each index: families of coordinates, and values of
        recurrences."""
        return (*self.families, *self.carried_groups)

    @property
    def banded(self) -> tuple[Group, ...]:
        """The groups whose members have rows in the banded matrix of M a = f, in the order of these
        rows."""
        return (*self.carried_groups, *self.families) if self.extended else self.families

    @property
    def scalars(self) -> tuple[Group, ...]:
        return tuple(g for g in self.coordinates if not g.is_family)

    @property
    def states(self) -> tuple[Group, ...]:
        return tuple(g for g in self.coordinates if g.is_state)

    @property
    def inputs(self) -> tuple[Quantity, ...]:
        return input_quantities(self.model, self.orders)

    @property
    def observed(self) -> tuple[Node, ...]:
        return tuple(item.node for item in self.outputs)

    @property
    def observed_names(self) -> tuple[Quantity, ...]:
        return Quantity.each(self.model.observed)

    @property
    def conserved_names(self) -> tuple[Quantity, ...]:
        return Quantity.each(self.model.conserved)

    @property
    def event_names(self) -> tuple[Quantity, ...]:
        return Quantity.each(self.model.events)

    @property
    def count(self) -> Affine:
        return sum((g.count for g in self.coordinates), Affine())

    @property
    def unseen(self) -> tuple[Group, ...]:
        """The coordinates whose value means nothing. Their rates are a body's angular velocity, or
        stand for states of first-order equations."""
        return tuple(g for g in self.coordinates if g.is_turn or g.is_state)

    @property
    def first_order(self) -> Affine:
        """The number of scalar coordinates in `unseen`."""
        return sum((g.count for g in self.unseen), Affine())
