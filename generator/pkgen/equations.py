"""What `derive` hands on: the equations of motion as nodes of one expression graph.

With L(q, v, t), Q the generalized forces and D the Rayleigh function:

    p    = dL/dv                    M    = dp/dv
    pdot = dL/dq + Q - dD/dv        f    = pdot - (dp/dq) v - dp/dt,   M a = f
    h    = v.p - L

First-order variables x' = g(t, q, v, x), the states, may occur in L, Q and D as t does: dp/dt has
(dp/dx) g in it.

Families are unrolled: everything here is flat, in declaration order.
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
        """As they are declared."""
        return tuple(Quantity(x.name, x.unit, x.description) for x in items)


@record
class Singularity:
    """The equations end where it vanishes: what they use it for, a kind of pk/system.h without its
    PK_SINGULARITY_. As "COORDINATES" these alone end, M being singular there."""

    quantity: Quantity  # its name is the expression
    node: Node
    use: str


@record
class Switch:
    """The equations are smooth on either side of its zero (middle/derive/switches.py). Where L or
    a row may jump, `impulse` is not 0, and the slopes are there (middle/derive/impulses.py)."""

    quantity: Quantity  # its name is the expression
    node: Node
    impulse: int = 0  # of OF_ENERGY and OF_ROLLING
    slope: Row = ()  # by the coordinates, along body rates
    slope_t: Node = 0  # by t, all coordinates held
    held: bool = True  # each of its calls on one side throughout a step


@record
class ParameterSlot:
    """One scalar parameter. `family` and `position` say which element of a C array it is."""

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
    """The canonical form, of q and of p instead of v: q' = dH/dp, p' = -dH/dq + applied."""

    energy: Node
    by_p: Row
    by_q: Row
    applied: Row  # Q - dD/dv there
    pivots: Pivots  # of M, which is solved for v


@record
class Particles:
    """Masses and places with T = sum of m/2 |r'|^2, z 0 in a plane; in r'' the accelerations of the
    coordinates are given. `beyond` names the other terms of L in words; none is quadratic in the
    rates. Empty, with `why` and `span`, if T was not seen to be such a sum."""

    masses: Row
    places: Matrix
    rates: Matrix
    accelerations: Matrix
    names: tuple[str, ...] = ()  # of the places: "(x, y)"
    beyond: str = ""
    why: str = ""
    span: Span | None = None


@record
class Attitude:
    """Where a rotation stands: the first of its three rates, and of the four states that are its
    quaternion w, x, y, z; -1 where nothing asks for that."""

    rate: int
    state: int

    @property
    def rates(self) -> range:
        return range(self.rate, self.rate + 3)

    @property
    def numbers(self) -> range:
        """Of its quaternion, among the states."""
        return range(self.state, self.state + 4) if self.state >= 0 else range(0)


@record
class Rows:
    """What a model states, a row each constraint: the `holonomic` ones, which come first, as
    phi(t, q), and all as J v + j0, which of those is the rate of phi."""

    names: tuple[Quantity, ...]  # of the multipliers, in the unit of a force along q over J's
    holonomic: int
    positions: Row  # phi, in the unit of a side; as many as are holonomic
    residual: Row  # J v + j0, in that unit over time, of a rolling in that of a side
    spans: tuple[Span, ...]  # of the statements
    redundant: Rows | None = None  # those that follow from these, where the motion starts

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
    """Rows J v + j0 = 0, the first `holonomic` of them the rates of phi = 0; the force J^T lambda
    of d'Alembert is in `applied`, in pdot and f. What is `free` is without it. Rows that follow
    from these are `redundant`: they have no force, and a run ends where they cease to follow."""

    names: tuple[Quantity, ...]  # of the multipliers
    holonomic: int
    positions: Row  # phi
    rows: Matrix  # J
    residual: Row  # J v + j0
    multipliers: Row
    pivots: Pivots  # of S = J M^-1 J^T, each beside its diagonal entry
    free_applied: Row
    free_pdot: Row
    free_force: Row
    spans: tuple[Span, ...]
    workless: bool  # J v = 0 at any time: no constraint moves by itself
    redundant: Rows | None = None
    redundant_rows: Matrix = ()  # J of these
    least: Row = ()  # the multipliers of least norm, of these rows and then of the redundant ones
    shared: frozenset[int] = frozenset()  # rows whose multiplier is not unique, counted so

    @property
    def stated(self) -> Rows:
        """As what constrain() made these of."""
        return Rows(
            self.names, self.holonomic, self.positions, self.residual, self.spans, self.redundant
        )


@record
class Named:
    """The quantities of a model, families unrolled; the fields are those of Equations."""

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
    inputs: tuple[Quantity, ...]  # an input, then those of its derivatives that occur
    observed_names: tuple[Quantity, ...]
    conserved_names: tuple[Quantity, ...]
    event_names: tuple[Quantity, ...]

    lagrangian: Node
    kinetic: Node | None  # None, like potential, where the model states L itself
    potential: Node | None
    written: Node  # L as the model states it, before its operations are made fewer
    energy: Node
    momenta: Row
    gradient: Row  # dL/dq
    applied: Row  # Q - dD/dv, zero where there is none
    pdot: Row
    mass: Matrix
    force: Row  # f
    acceleration: Row | None  # None: not asked for, or too large: solve M a = f in a loop
    pivots: Pivots | None  # D of M = L D L^T by coordinate, in whatever order eliminated
    p_q: Matrix | None  # None, like the next two, where the kernel is not asked for
    pdot_q: Matrix | None
    pdot_v: Matrix | None
    linear: Linear | None  # None: not asked for
    singularities: tuple[Singularity, ...]
    observed: Row
    conserved: Row
    events: Row  # what crosses zero; model.events has the directions
    start_q: Row
    start_v: Row
    unrolled: str = ""  # why the families of coordinates are not loops
    hamiltonian: Hamiltonian | None = None  # None: not asked for
    switches: tuple[Switch, ...] = ()
    marks: tuple[
        Switch, ...
    ] = ()  # arguments of exp, tanh, ...: no switches, see middle/derive/marks.py
    # First-order variables x' = state_rates, which are no coordinates: states.py makes them so.
    states: tuple[Quantity, ...] = ()
    state_rates: Row = ()
    state_start: Row = ()
    # The last n_first_order coordinates are dummies: their rates are the states.
    n_first_order: int = 0
    n_unread: int = 0  # of these the last ones, which no rate depends on
    attitudes: tuple[Attitude, ...] = ()  # rotations: their rates stand behind all coordinates
    constraints: Constraints | None = None
    # M before M a = f was solved, where `mass` is the unit matrix; and beside `unconstrained`.
    inertia: Matrix | None = None
    unconstrained: tuple[Row, Row] | None = (
        None  # in C: p and pdot without the forces of constraints
    )
    terms: tuple[Row, Row] | None = None  # in C: sizes of the terms of phi and of J v + j0
    redundant_terms: Row = ()  # in C: the same of redundant rows, positions and then rates
    particles: Particles | None = None  # None: not asked for
    warnings: tuple[Diagnostic, ...] = ()
    fast: Row | None = None  # the acceleration by the part of V that is named so; None: none is

    @property
    def moving(self) -> tuple[str, ...]:
        """What the rows of M are of: coordinates, and body rates by their own names."""
        return tuple(
            (self.rates if i in self.turning else self.coordinates)[i].name
            for i in range(len(self.coordinates))
        )

    @property
    def jolted(self) -> tuple[Switch, ...]:
        """The switches at which rates may jump."""
        return tuple(x for x in self.switches if x.impulse)

    @property
    def turning(self) -> frozenset[int]:
        """The coordinates whose rates are body rates."""
        return frozenset(i for a in self.attitudes for i in a.rates)

    @property
    def quaternions(self) -> int:
        """How many of the states are numbers of attitudes; they come first."""
        return sum(len(a.numbers) for a in self.attitudes)

    @property
    def own(self) -> int:
        """How many coordinates come before those whose rates are first-order variables."""
        return len(self.coordinates) - self.n_first_order

    @property
    def inertial(self) -> int:
        """How many rows of M are of a Lagrangian: coordinates and body rates, of which those of
        rotations are counted among the states in C."""
        return len(self.coordinates) - max(self.n_first_order - len(self.turning), 0)

    @property
    def seen(self) -> tuple[Quantity, ...]:
        """The coordinates but those whose rates are body rates, which nobody sees."""
        return self.coordinates[: len(self.coordinates) - len(self.turning)]


Indices = tuple[tuple[int, ...], ...]


@record
class Claim:
    """What became of a `conserve`: proved, refuted, or not proved, and how or how far."""

    name: str
    outcome: str  # PROVED, REFUTED or OPEN of middle/analyze/proofs.py
    says: str


@record
class Invariant:
    """A constant of the motion that was found: a sum of terms, each a coefficient of parameters
    times names: "t", coordinates, momenta and "energy"."""

    name: str  # "energy", "p_phi"; of any other its formula
    reason: str  # what the motion does not notice
    generator: str  # in derivatives: "x d/dy - y d/dx"
    terms: tuple[tuple[Node, tuple[str, ...]], ...]
    node: Node
    when: str = ""  # for which sizes it is proved, where families are loops


@record
class Symmetries:
    """What Noether's theorem gives, in a basis; nodes of a graph of their own."""

    graph: Graph
    parameters: tuple[str, ...]  # the names of those in coefficients
    searched: str  # among which generators; "" where the model was too large for a search
    invariants: tuple[Invariant, ...]


@record
class Facts:
    """Each proved (never a guess): false means not proved. See enum pk_fact."""

    mass_constant: bool
    mass_diagonal: bool
    quadratic: bool
    separable: bool
    autonomous: bool
    conservative: bool
    variational: bool
    smooth: bool
    affine: bool = False  # the acceleration is so in q and v, with constant coefficients
    switched: bool = False  # smooth but for switches, which a run locates
    linear_drag: bool = False  # separable but for forces C v with constant C
    affine_rates: bool = False  # ... with any C(q, t)
    fast: bool = False  # of forces of q and t alone, a part is named
    claims: tuple[Claim, ...] = ()
    symmetries: Symmetries | None = None  # None: not asked for

    @property
    def smooth_in_pieces(self) -> bool:
        return self.smooth or self.switched


@record
class Structure(Facts):
    """With what is known of single coordinates. `influences` errs on the side of too many: what is
    not there is proved to have no influence."""

    cyclic: tuple[bool, ...] = ()  # p_i is constant
    definite: bool = False  # M is positive definite wherever it has a value
    singular: tuple[str, ...] = ()  # expressions; where one vanishes, M may be singular
    mass_blocks: Indices = ()  # coordinates that M couples, the finest partition
    mass_band: int = 0  # the largest |i - j| of an entry of M that is not zero
    influences: Indices = ()  # by i: each j whose q_j or v_j occurs in a_i
    blocks: Indices = ()  # coordinates that do not influence those of another block
