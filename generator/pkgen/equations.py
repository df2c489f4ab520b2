"""The output of `derive`: the equations of motion as nodes of one expression graph.

With L(q, v, t), Q the generalized forces and D the Rayleigh function:

    p    = dL/dv                    M    = dp/dv
    pdot = dL/dq + Q - dD/dv        f    = pdot - (dp/dq) v - dp/dt,   M a = f
    h    = v.p - L

States are first-order variables x' = g(t, q, v, x). They may occur in L, Q and D as t does: dp/dt
includes (dp/dx) g.

Families (q[1..N]) are unrolled: everything here is flat, in declaration order.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from .graph.graph import Graph, Node
from .graph.solve import Pivots
from .model import Definition, Event, Model
from .record import record
from .source import Diagnostic, Span

Row = tuple[Node, ...]
Matrix = tuple[Row, ...]


@record
class Quantity:
    """A named scalar, as it appears in the C introspection tables and in CSV headings."""

    name: str  # "theta1", "q[3]", "theta1'", "p_theta1"
    unit: str
    description: str

    @staticmethod
    def each(items: Iterable[Definition | Event]) -> tuple[Quantity, ...]:
        """Returns a quantity for each item, in order."""
        return tuple(Quantity(x.name, x.unit, x.description) for x in items)


@record
class Singularity:
    """An expression at whose zeros the equations end. `use` is a pk_singularity_kind without its
    PK_SINGULARITY_; at "COORDINATES" M is singular, and only the coordinates end."""

    quantity: Quantity  # its name is the expression
    node: Node
    use: str


@record
class Switch:
    """An expression at whose zeros the equations have a kink or a jump (middle/derive/switches.py).
    If L or a constraint row may jump, `impulse` is not 0 and the slopes are set (impulses.py)."""

    quantity: Quantity  # its name is the expression
    node: Node
    impulse: int = 0  # flags OF_ENERGY, OF_ROLLING of impulses.py
    slope: Row = ()  # derivatives by the coordinates; for rotations along body axes
    slope_t: Node = 0  # derivative by t, also through inputs, at fixed coordinates
    held: bool = True  # its calls are held on one side during a step


@record
class ParameterSlot:
    """One scalar parameter. `family` and `position` give its element of a C array."""

    quantity: Quantity
    family: str  # the declared name: "k" for k[2]
    position: int  # 0 for the first member of a family
    length: int  # members of the family; 0 for a plain parameter
    default: Node
    follows: bool
    lo: Node | None
    hi: Node | None
    lo_open: bool
    hi_open: bool


@record
class Linear:
    """Derivatives of r = f - M a, with a held: M (da/dq) = r_q, and so on."""

    r_q: Matrix
    r_v: Matrix
    r_t: Row


@record
class Hamiltonian:
    """The canonical form in (q, p): q' = dH/dp, p' = -dH/dq + applied."""

    energy: Node
    by_p: Row
    by_q: Row
    applied: Row  # Q - dD/dv in (q, p)
    pivots: Pivots  # of M, from solving p for v


@record
class Particles:
    """Masses and places r with T = sum of m/2 |r'|^2 (z = 0 in a plane). In `accelerations` (r'')
    the coordinates' accelerations are symbols. `beyond` names in words the other terms of L,
    which have degree 0 or 1 in the rates. Empty, with `why` and `span`, if T is no such sum."""

    masses: Row
    places: Matrix
    rates: Matrix
    accelerations: Matrix
    names: tuple[str, ...] = ()  # names of the positions: "(x, y)"
    beyond: str = ""
    why: str = ""
    span: Span | None = None


@record
class Attitude:
    """Indices of a rotation: of the first of its three body rates, and of the first of the four
    states of its quaternion w, x, y, z (-1 if a reduction dropped the quaternion)."""

    rate: int
    state: int

    @property
    def rates(self) -> range:
        return range(self.rate, self.rate + 3)

    @property
    def numbers(self) -> range:
        """The indices of its quaternion among the states."""
        return range(self.state, self.state + 4) if self.state >= 0 else range(0)


@record
class Rows:
    """The constraint rows of a model. The first `holonomic` rows have phi(t, q); all have J v + j0,
    for a holonomic row the time derivative of phi."""

    names: tuple[Quantity, ...]  # of the multipliers; unit: generalized force / entry of J
    holonomic: int
    positions: Row  # phi of the holonomic rows, in the unit of the equation's sides
    residual: Row  # J v + j0, in that unit per time; for a rolling in that unit
    spans: tuple[Span, ...]  # of the constraint statements
    redundant: Rows | None = None  # rows that depend on these at the start

    def picked(self, which: Sequence[int]) -> Rows:
        holonomic = sum(k < self.holonomic for k in which)
        return Rows(
            tuple(self.names[k] for k in which),
            holonomic,
            tuple(self.positions[k] for k in which[:holonomic]),
            tuple(self.residual[k] for k in which),
            tuple(self.spans[k] for k in which),
        )


@record
class Constraints:
    """Rows J v + j0 = 0, the first `holonomic` of them the time derivatives of phi = 0. Equations'
    applied, pdot and force include the constraint force J^T lambda; the `free_` fields exclude it.
    `redundant` rows depend on these and have no force; a run ends where they cease to depend."""

    names: tuple[Quantity, ...]  # of the multipliers
    holonomic: int
    positions: Row  # phi
    rows: Matrix  # J
    residual: Row  # J v + j0
    multipliers: Row
    pivots: Pivots  # of S = J M^-1 J^T, each with the diagonal entry of S
    free_applied: Row
    free_pdot: Row
    free_force: Row
    spans: tuple[Span, ...]
    workless: bool  # j0 = 0, and nothing depends on t or inputs: no work is done
    redundant: Rows | None = None
    redundant_rows: Matrix = ()  # J of the redundant rows
    least: Row = ()  # multipliers of least norm, of these rows and then of redundant ones
    shared: frozenset[int] = frozenset()  # rows without a unique multiplier, indexed as `least`

    @property
    def stated(self) -> Rows:
        """Returns the rows from which constrain() made these."""
        return Rows(
            self.names, self.holonomic, self.positions, self.residual, self.spans, self.redundant
        )


@record
class Named:
    """The quantities of a model, families unrolled; fields as in Equations."""

    parameters: tuple[ParameterSlot, ...]
    coordinates: tuple[Quantity, ...]
    rates: tuple[Quantity, ...]
    momenta_names: tuple[Quantity, ...]
    inputs: tuple[Quantity, ...]
    states: tuple[Quantity, ...]


@record
class Equations:
    model: Model
    graph: Graph
    parameters: tuple[ParameterSlot, ...]
    coordinates: tuple[Quantity, ...]
    rates: tuple[Quantity, ...]
    momenta_names: tuple[Quantity, ...]
    inputs: tuple[Quantity, ...]  # each input, followed by its derivatives that occur
    observed_names: tuple[Quantity, ...]
    conserved_names: tuple[Quantity, ...]
    event_names: tuple[Quantity, ...]

    lagrangian: Node
    kinetic: Node | None  # None, like `potential`, if the model has a `lagrangian`
    potential: Node | None
    written: Node  # L as in the model, before simplification
    energy: Node
    momenta: Row
    gradient: Row  # dL/dq
    applied: Row  # Q - dD/dv
    pdot: Row
    mass: Matrix
    force: Row  # f
    acceleration: Row | None  # None: not requested, or too large: a loop solves M a = f
    pivots: Pivots | None  # D of M = L D L^T, by coordinate, whatever the elimination order
    p_q: Matrix | None  # None, like the next two, if the kernel is not requested
    pdot_q: Matrix | None
    pdot_v: Matrix | None
    linear: Linear | None  # None: not requested
    singularities: tuple[Singularity, ...]
    observed: Row
    conserved: Row
    events: Row  # event functions; model.events has the directions
    start_q: Row
    start_v: Row
    left_out: tuple[Diagnostic, ...] = ()  # warnings: dropped constraints, identically 0 = 0
    unrolled: str = ""  # the reason why families are not kept as loops
    hamiltonian: Hamiltonian | None = None  # None: not requested
    switches: tuple[Switch, ...] = ()
    marks: tuple[
        Switch, ...
    ] = ()  # arguments of exp, tanh, ...: no switches, see middle/derive/marks.py
    # First-order variables x' = state_rates; states.as_rates() turns them into coordinates.
    states: tuple[Quantity, ...] = ()
    state_rates: Row = ()
    state_start: Row = ()
    # The last n_first_order coordinates are dummies whose rates are the states.
    n_first_order: int = 0
    n_unread: int = 0  # of these, the number of last ones that no rate depends on
    attitudes: tuple[Attitude, ...] = ()  # rotations; their body rates follow all other rates
    constraints: Constraints | None = None
    # The mass matrix if `mass` is the unit matrix (solved form), or if `unconstrained` is set.
    inertia: Matrix | None = None
    unconstrained: tuple[Row, Row] | None = None  # in C: p, and pdot without constraint forces
    terms: tuple[Row, Row] | None = None  # in C: magnitudes of the terms of phi, J v + j0
    redundant_terms: Row = ()  # in C: the same for redundant rows, phi and then J v + j0
    particles: Particles | None = None  # None: not requested
    fast: Row | None = None  # the acceleration from the `fast` terms of V; None: there are none

    @property
    def moving(self) -> tuple[str, ...]:
        """The names of the rows of M: of coordinates, or for rotations of body rates."""
        return tuple(
            (self.rates if i in self.turning else self.coordinates)[i].name
            for i in range(len(self.coordinates))
        )

    @property
    def impulsive(self) -> tuple[Switch, ...]:
        """The switches at which rates may jump."""
        return tuple(x for x in self.switches if x.impulse)

    @property
    def turning(self) -> frozenset[int]:
        """The coordinates whose rates are body rates."""
        return frozenset(i for a in self.attitudes for i in a.rates)

    @property
    def quaternions(self) -> int:
        """The number of states that are quaternion components; they come first."""
        return sum(len(a.numbers) for a in self.attitudes)

    @property
    def own(self) -> int:
        """The number of coordinates before those whose rates are first-order variables."""
        return len(self.coordinates) - self.n_first_order

    @property
    def inertial(self) -> int:
        """The number of rows of M that come from the Lagrangian: of coordinates and body rates (the
        C counts body rates among the states)."""
        return len(self.coordinates) - max(self.n_first_order - len(self.turning), 0)

    @property
    def seen(self) -> tuple[Quantity, ...]:
        """The coordinates without the hidden ones, whose rates are body rates."""
        return self.coordinates[: len(self.coordinates) - len(self.turning)]


Indices = tuple[tuple[int, ...], ...]


@record
class Claim:
    """The outcome of a `conserve`: proved, refuted, or open, with the reason in words."""

    name: str
    outcome: str  # PROVED, REFUTED or OPEN of middle/analyze/proofs.py
    says: str


@record
class Invariant:
    """A constant of the motion: a sum of terms, each a coefficient (a node of parameters) times
    names: "t", coordinates, momenta and "energy"."""

    name: str  # "energy", "p_phi", or its formula
    reason: str  # the symmetry, in words
    generator: str  # of the symmetry: "x d/dy - y d/dx"
    terms: tuple[tuple[Node, tuple[str, ...]], ...]
    node: Node
    when: str = ""  # the sizes for which it is proved, if families are loops


@record
class Symmetries:
    """A basis of the invariants by Noether's theorem; nodes are of `graph`."""

    graph: Graph
    parameters: tuple[str, ...]  # names of the parameters in coefficients
    searched: str  # the generators searched, in words; "" if the model was too large
    invariants: tuple[Invariant, ...]


@record
class Facts:
    """Proved facts about a system; False means not proved. See enum pk_fact."""

    mass_constant: bool
    mass_diagonal: bool
    quadratic: bool
    separable: bool
    autonomous: bool
    conservative: bool
    variational: bool
    smooth: bool
    affine: bool = False  # the acceleration is affine in q and v, with constant coefficients
    switched: bool = False  # smooth except at switches, which a run locates
    linear_drag: bool = False  # separable except for forces C v with constant C
    affine_rates: bool = False  # the same with any C(q, t)
    fast: bool = False  # separable, and terms of V are named fast
    claims: tuple[Claim, ...] = ()
    symmetries: Symmetries | None = None  # None: not requested

    @property
    def smooth_in_pieces(self) -> bool:
        return self.smooth or self.switched


@record
class Structure(Facts):
    """Facts, with those about single coordinates. `influences` may have too many entries: a missing
    one is proved to have no influence."""

    cyclic: tuple[bool, ...] = ()  # p_i is constant
    definite: bool = False  # M is positive definite wherever it has a value
    singular: tuple[str, ...] = ()  # expressions at whose zeros M may be singular
    mass_blocks: Indices = ()  # the blocks of coordinates that M couples, the finest partition
    mass_band: int = 0  # the largest |i - j| of an entry of M that is not zero
    influences: Indices = ()  # for each i all j with q_j or v_j in a_i
    blocks: Indices = ()  # a partition of coordinates; blocks do not influence each other
