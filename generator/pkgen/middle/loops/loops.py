"""The output of derive_loops: the equations of a model whose families stay loops."""

from __future__ import annotations

from dataclasses import field

from ...equations import Facts, Quantity
from ...graph.affine import Affine
from ...graph.graph import Graph, Node
from ...model import Definition, Model
from ...record import record
from ..quantities import input_quantities
from .indexed_ir import Band, Bound, Carried, Group, Part, Slot, Total, Vector


@record
class Summed:
    """A sum computed once, into element `place` of an array. Its index variables are counters;
    `inside` are the sums in each of its terms."""

    place: int
    ranges: tuple[tuple[str, Affine, Affine], ...]
    node: Node
    inside: tuple[Summed, ...]


@record
class Assigned:
    """Members lo..hi of a declared name take the value of a node with index m. The sums `before`
    are computed before all members, those of `each` before each member."""

    name: str
    order: int  # 1 for a rate, else 0
    lo: Affine | None
    hi: Affine | None
    node: Node
    before: tuple[Summed, ...] = ()
    each: tuple[Summed, ...] = ()


@record
class Observed:
    """An output: one value if `lo` is None, else one for each index m = lo..hi."""

    item: Definition
    lo: Affine | None
    hi: Affine | None
    node: Node

    @property
    def count(self) -> Affine:
        return Affine(1) if self.lo is None else self.hi - self.lo + 1


@record
class Along:
    """A `let` by index that only outputs use (or with ' its rate), computed member by member."""

    name: str
    group: Group
    parts: tuple[Part, ...]  # by index; their ranges do not overlap


@record
class Limit:
    """A condition on sizes: `needs` >= 0, or `unless` < 0 (an empty range)."""

    needs: Affine
    unless: Affine | None  # length of a range, less 1


@record
class Bounded:
    """The bounds of a declared parameter; nodes with index m."""

    lo: Node | None
    hi: Node | None


@record
class LoopSingularity:
    """The equations end where any single one of `terms` vanishes: of a member, a pair, or the
    constant. `name` is the expression in i, or in i and j for a pair; `use` as in Singularity."""

    name: str
    use: str
    terms: Total


@record
class LoopSwitch:
    """An expression at whose zeros the equations have a kink or a jump, with a value for each index
    m of the `ranges`; () is a single value. See switches.py and equations.Switch."""

    name: str  # the expression in i
    node: Node
    inner: Node  # the same in the interior
    ranges: tuple[tuple[Affine, ...], ...]
    held: bool


@record
class LoopEquations:
    model: Model
    graph: Graph
    slots: tuple[Slot, ...]
    coordinates: tuple[Group, ...]  # followed by states; each state is the rate of a dummy
    parameters: tuple[Group, ...]
    orders: tuple[int, ...]  # derivatives of each input that occur

    gradient: Vector
    momenta: Vector
    pdot: Vector
    force: Vector
    mass: Band
    kinetic: Total | None
    potential: Total | None
    lagrangian: Total | None  # None, like the energy, for a model of states alone
    energy: Total | None
    sums: tuple[Total, ...]  # inside expressions, in the order in which they can be computed
    fixed: frozenset[int]  # numbers of the sums of parameters and sizes alone
    outputs: tuple[Observed, ...]
    conserved: tuple[Node, ...]
    events: tuple[Node, ...]
    # Value, rate and acceleration of each given cell beyond an end, by family and index.
    given: dict[tuple[str, Affine], tuple[Node, Node, Node]]
    defaults: tuple[Assigned, ...]  # one for each declared parameter
    bounds: tuple[Bounded, ...]
    starts: tuple[Assigned, ...]
    limits: tuple[Limit, ...]
    wraps: dict[str, int] = field(default_factory=dict)  # by family: reach beyond periodic ends
    along: tuple[tuple[Along, ...], ...] = ()  # members of an inner tuple are computed together
    summed: int = 0  # number of sums computed once, in starts and parameters
    facts: Facts | None = None
    singularities: tuple[LoopSingularity, ...] = ()
    switches: tuple[LoopSwitch, ...] = ()
    pivots: bool = False  # the pivots of M are singularities too, before the others
    carried: tuple[Carried, ...] = ()  # sorted by level
    # Whether the accelerations of carried values are unknowns of M a = f, with rows for their
    # recurrences; else they are eliminated index by index.
    extended: bool = False
    bound: tuple[Bound, ...] = ()  # constraint rows, the holonomic ones first
    # Whether implicit methods take p = v, p' = a: a momentum depends on a state, such as that of a
    # body with an inertia that depends on its attitude.
    solved: bool = False

    def group(self, name: str) -> Group:
        return next(g for g in (*self.coordinates, *self.carried_groups) if g.name == name)

    @property
    def carried_groups(self) -> tuple[Group, ...]:
        return tuple(x.group for x in self.carried)

    @property
    def families(self) -> tuple[Group, ...]:
        return tuple(g for g in self.coordinates if g.is_family)

    @property
    def rows(self) -> tuple[Group, ...]:
        """Groups with a row for each index, before rows of carried values are eliminated."""
        return (*self.families, *self.carried_groups)

    @property
    def banded(self) -> tuple[Group, ...]:
        """Groups with a row in the band of M for each index, in order."""
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
        """Coordinates without a meaningful value: their rates are body rates or states."""
        return tuple(g for g in self.coordinates if g.is_turn or g.is_state)

    @property
    def first_order(self) -> Affine:
        """The number of coordinates of which only the rate has a meaning."""
        return sum((g.count for g in self.unseen), Affine())
