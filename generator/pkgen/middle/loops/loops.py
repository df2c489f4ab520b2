"""What the derivation of a model hands on whose families stay loops."""

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
    """A sum that is computed once, into that place of an array; its index variables are counters,
    and `inside` are sums in each of its terms."""

    place: int
    ranges: tuple[tuple[str, Affine, Affine], ...]
    node: Node
    inside: tuple[Summed, ...]


@record
class Assigned:
    """Members lo..hi of a declared name take the value of a node, m being the index; some sums come
    before all of them, others before each."""

    name: str
    order: int  # 1: of a rate
    lo: Affine | None
    hi: Affine | None
    node: Node
    before: tuple[Summed, ...] = ()
    each: tuple[Summed, ...] = ()


@record
class Observed:
    """An output: one, where `lo` is None, or one for each index m."""

    item: Definition
    lo: Affine | None
    hi: Affine | None
    node: Node

    @property
    def count(self) -> Affine:
        return Affine(1) if self.lo is None else self.hi - self.lo + 1


@record
class Along:
    """A `let` by index that outputs alone have, or with ' its rate: each member in its turn."""

    name: str
    group: Group
    parts: tuple[Part, ...]  # by index, each without the others


@record
class Limit:
    """A size is large enough where `needs` >= 0, or where the range `unless` is empty."""

    needs: Affine
    unless: Affine | None  # its length - 1


@record
class Bounded:
    """Where the members of a declared parameter may lie; nodes in its index m."""

    lo: Node | None
    hi: Node | None


@record
class LoopSingularity:
    """The equations end where one of `terms` vanishes, each for itself: a member's, a pair's, or a
    constant. `name` is the expression in i, of a pair in i and j; `use` as of a Singularity."""

    name: str
    use: str
    terms: Total


@record
class LoopSwitch:
    """The equations are smooth on either side of the zeros of an expression, which has a value for
    each index m of the `ranges`, of () one alone. See switches.py and equations.Switch."""

    name: str  # the expression in i
    node: Node
    inner: Node  # the same away from the ends
    ranges: tuple[tuple[Affine, ...], ...]
    held: bool


@record
class LoopEquations:
    model: Model
    graph: Graph
    slots: tuple[Slot, ...]
    coordinates: tuple[Group, ...]  # and then the states, each as the rate of one
    parameters: tuple[Group, ...]
    orders: tuple[int, ...]  # derivatives of each input that occur

    gradient: Vector
    momenta: Vector
    pdot: Vector
    force: Vector
    mass: Band
    kinetic: Total | None
    potential: Total | None
    lagrangian: Total | None  # None, like the energy, of states alone
    energy: Total | None
    sums: tuple[Total, ...]  # inside expressions, in the order in which they can be computed
    fixed: frozenset[int]  # those of parameters and sizes alone
    outputs: tuple[Observed, ...]
    conserved: tuple[Node, ...]
    events: tuple[Node, ...]
    # The value of each given cell beyond an end and its first two derivatives, by its End.
    given: dict[tuple[str, Affine], tuple[Node, Node, Node]]
    defaults: tuple[Assigned, ...]  # one for each declared parameter
    bounds: tuple[Bounded, ...]
    starts: tuple[Assigned, ...]
    limits: tuple[Limit, ...]
    wraps: dict[str, int] = field(default_factory=dict)  # how far beyond a periodic family's ends
    along: tuple[tuple[Along, ...], ...] = ()  # those of one are computed together
    summed: int = 0  # how many sums are computed once, in starts and parameters
    facts: Facts | None = None
    singularities: tuple[LoopSingularity, ...] = ()
    switches: tuple[LoopSwitch, ...] = ()
    pivots: bool = False  # those of M are singularities too, before the others
    carried: tuple[Carried, ...] = ()  # by level
    # Whether the accelerations of carried values are unknowns of M a = f, with rows that say what
    # they are made of; else they are eliminated place by place.
    extended: bool = False
    bound: tuple[Bound, ...] = ()  # rows of constraints, the holonomic ones first
    # Whether implicit methods take p = v, p' = a: a momentum depends on a state, as of a body whose
    # inertia its attitude changes.
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
        """What has a row for each index where L is taken as it stands."""
        return (*self.families, *self.carried_groups)

    @property
    def banded(self) -> tuple[Group, ...]:
        """What has a place in the band of M for each index, in this order."""
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
        """Those whose values mean nothing: of body rates, and of states."""
        return tuple(g for g in self.coordinates if g.is_turn or g.is_state)

    @property
    def first_order(self) -> Affine:
        """How many of them have but a rate that means something."""
        return sum((g.count for g in self.unseen), Affine())
