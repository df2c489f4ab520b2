"""The result of derive_families: the equations of a model whose families may have any length."""

from __future__ import annotations

from dataclasses import field

from ...equations import Declared, Quantity
from ...graph.affine import Affine
from ...graph.graph import Graph, Node
from ...model import Definition, Model
from ...record import record
from ..quantities import families, input_quantities, moving
from ..structure import Structure
from .indexed_ir import Bound, Carried, Group, Over, Slot, Sum, is_diagonal
from .indices import Limit, size_values


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
class Bounded:
    """The bounds of a parameter, as nodes that may contain the index m; None for no bound."""

    lo: Node | None
    hi: Node | None


@record
class FamilySingularity:
    """An expression at whose zeros the equations are singular, with a value for each index in
    `over`. `name` is the expression with the index i, or with i and j for a pair; `use` is as in
    Singularity."""

    name: str
    use: str
    over: Over
    node: Node


@record
class FamilySwitch:
    """An expression at whose zeros the equations have a kink or a jump, with a value for each index
    m in `ranges`. A range is (lo, hi), or () for a single value. See switches.py and
    equations.Switch."""

    name: str  # The expression as text, with the index i.
    node: Node
    ranges: tuple[tuple[Affine, ...], ...]
    held: bool


@record
class FamilyEquations:
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
    # Sample blocks: see the fields of the same names of Equations.
    sampled: tuple[Node, ...] = ()
    sample_times: tuple[Node, ...] = ()
    held_start: tuple[Node, ...] = ()
    # For each event that gives values, the assignments to single members.
    resets: tuple[tuple[Assigned, ...], ...] = ()
    # For each periodic family, the largest distance of an index beyond its ends.
    wraps: dict[str, int] = field(default_factory=dict)
    # `let` definitions that only outputs use. Each inner tuple is computed in one loop.
    along: tuple[tuple[Along, ...], ...] = ()
    # The number of sums in initial values and parameters.
    summed: int = 0
    facts: Structure | None = None
    singularities: tuple[FamilySingularity, ...] = ()
    switches: tuple[FamilySwitch, ...] = ()
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

    # Nothing here is written out: see Equations.
    dense = False
    acceleration = linear = constraints = None
    impulsive = momenta_names = ()

    @property
    def inertial(self) -> int:
        return len(self.model.coordinates)

    @property
    def mass_in_words(self) -> str:
        proved = self.facts
        shape = "diagonal" if proved.mass_diagonal else "banded"
        if self.carried:
            ways = ("eliminated from its last member to the first", "banded with what it carries")
            return f"of a chain, {ways[self.extended]}"
        if not (proved.mass_diagonal or self.scalars or len(self.families) > 1):
            ends = ((row[1], column[1]) for row, column in (x.to for x in self.mass))
            beside = max(abs((column - row).constant) for row, column in ends)
            shape += f", {beside} beside the diagonal"
        if not proved.mass_constant:
            return shape
        once = "a division a row" if proved.mass_diagonal else "factored once"
        once = "with rows of constraints factored at each acceleration" if self.bound else once
        return f"{shape}, constant: {once}"

    @property
    def forces_beyond(self) -> list[str]:
        if self.facts.variational:
            return []
        beyond = "force, dissipation or states" if self.states else "force or dissipation"
        return [f"of constraints, perhaps {beyond}" if self.bound else beyond]

    def listed(self, kind: str) -> list[Declared]:
        """Returns the quantities of a kind by declaration: see Equations.listed()."""
        if kind == "param":
            found = families(self.model, self.model.parameters)
            items = ((x, Quantity(x.name, x.unit, x.description)) for x in self.model.parameters)
            return [found[x.name].declared(quantity) for x, quantity in items]
        if kind != "observed":
            return moving(self.model, kind == "v")
        sizes, made, first = size_values(self.model), [], 0
        for quantity, x in zip(self.observed_names, self.outputs, strict=True):
            ends = (None, None) if x.lo is None else (x.lo.value(sizes), x.hi.value(sizes))
            made.append(Declared(quantity, first, *ends))
            first += made[-1].count
        return made

    @property
    def single_outputs(self) -> dict[str, Node]:
        return {x.item.name: x.node for x in self.outputs if x.lo is None}

    @property
    def has_energy(self) -> bool:
        return bool(self.model.coordinates or self.model.lagrangian)

    @property
    def n_switches(self) -> int:
        """The number of values of all switches for the sizes given in the model."""
        sizes, total = size_values(self.model), 0
        for x in self.switches:
            ends = [[at.value(sizes) for at in over] or [0, 0] for over in x.ranges]
            ends = [over for over in ends if over[0] <= over[1]]
            total += max(hi for _, hi in ends) - min(lo for lo, _ in ends) + 1 if ends else 0
        return total

    @property
    def is_chain(self) -> bool:
        return not self.has_pairs

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
    def told(self) -> list[Node]:
        """The values of outputs, of sample blocks and of events, which no kernel of the motion
        computes."""
        given = (x.node for assigned in self.resets for x in assigned)
        of_samples = (*self.sampled, *self.sample_times, *self.held_start)
        return [*self.observed, *self.conserved, *self.events, *of_samples, *given]

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
