"""The output of `derive`: the equations of motion as nodes of one expression graph.

With L(q, v, t), Q the generalized forces and D the Rayleigh function:

    p    = dL/dv                    M    = dp/dv
    pdot = dL/dq + Q - dD/dv        f    = pdot - (dp/dq) v - dp/dt,   M a = f
    h    = v.p - L

States are first-order variables x' = g(t, q, v, x). They may occur in L, Q and D like t: dp/dt
includes (dp/dx) g.

Families (q[1..N]) are unrolled: each member is a separate quantity, in declaration order.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Protocol

from .graph.graph import ZERO, Graph, Node
from .graph.solve import Pivots
from .indices import indexed, multiplied
from .model import Definition, Event, Model
from .record import record
from .source import Diagnostic, Span

Row = tuple[Node, ...]
Matrix = tuple[Row, ...]


@record
class Quantity:
    """A named scalar, as in the introspection tables of the C and in CSV headings."""

    name: str  # "theta1", "q[3]", "theta1'", "p_theta1"
    unit: str
    description: str

    @staticmethod
    def each(items: Iterable[Definition | Event]) -> tuple[Quantity, ...]:
        """Returns a quantity for each item, in order."""
        return tuple(Quantity(x.name, x.unit, x.description) for x in items)


@record
class Declared:
    """A declaration of a quantity, or of a family of quantities with the indices lo..hi. A flat
    index counts single quantities over all declarations; `first` is that of the first one here."""

    quantity: Quantity
    first: int
    lo: int | None
    hi: int | None

    @staticmethod
    def each(quantities: Iterable[Quantity]) -> list[Declared]:
        """Returns a separate declaration for each quantity, also for each member of a family."""
        return [Declared(q, i, None, None) for i, q in enumerate(quantities)]

    def member(self, index: int | None) -> Quantity:
        name, primes = self.quantity.name.rstrip("'"), self.quantity.name.count("'")
        shown = indexed(name, index) + "'" * primes
        return Quantity(shown, self.quantity.unit, self.quantity.description)

    def members(self, most: int = sys.maxsize) -> list[Quantity]:
        """Returns the first `most` members of the family, or the single quantity."""
        if self.lo is None:
            return [self.quantity]
        return [self.member(index) for index in range(self.lo, self.lo + min(self.count, most))]

    @property
    def count(self) -> int:
        return 1 if self.lo is None else self.hi - self.lo + 1


@record
class Singularity:
    """An expression at whose zeros the equations become singular. `use` is a pk_singularity_kind
    without its PK_SINGULARITY_; at "COORDINATES" M is singular, but only because of the
    coordinates."""

    quantity: Quantity  # named by the text of the expression
    node: Node
    use: str


@record
class Switch:
    """An expression at whose zeros the equations have a kink or a jump (middle/derive/switches.py).
    If L or a constraint may jump there, `impulse` is not 0 and the slopes are set (impulses.py)."""

    quantity: Quantity  # named by the text of the expression
    node: Node
    impulse: int = 0  # flags OF_ENERGY, OF_ROLLING of impulses.py
    slope: Row = ()  # derivatives by the coordinates; for rotations by angles about body axes
    slope_t: Node = 0  # derivative by t, also through inputs, at constant coordinates
    counted: bool = False  # whether it counts pieces (functions/row.py, Kinked.place)
    held: bool = True  # whether a step keeps its branch, even beyond the zero

    @property
    def name(self) -> str:
        return self.quantity.name


@record
class ParameterSlot:
    """One scalar parameter. `family` and `position` locate it in an array in C."""

    quantity: Quantity
    family: str  # declared name: "k" for k[2]
    position: int  # 0 for the first member of a family
    length: int  # number of members of the family; 0 for a single parameter
    default: Node
    follows: bool
    lo: Node | None
    hi: Node | None
    lo_open: bool
    hi_open: bool


@record
class Linear:
    """Derivatives of r = f - M a at constant a; for example, M (da/dq) = r_q."""

    r_q: Matrix
    r_v: Matrix
    r_t: Row


@record
class Noise:
    """Independent white noises: for each its name, its intensity S, and the accelerations M^-1 d by
    a unit force along its direction d."""

    names: tuple[str, ...]
    intensities: Row
    accelerations: Matrix


@record
class Hamiltonian:
    """The canonical form in (q, p): q' = dH/dp, p' = -dH/dq + applied."""

    energy: Node
    by_p: Row
    by_q: Row
    applied: Row  # Q - dD/dv in (q, p)
    pivots: Pivots  # pivots of M, from solving p for v


@record
class Particles:
    """Masses m and positions r with T = sum of m/2 |r'|^2 (in a plane z = 0). In `accelerations`
    (r'') the accelerations of the coordinates are symbols. `beyond` describes the other terms of L,
    which have degree 0 or 1 in the rates. If T is no such sum, only `why` (the reason) and `span`
    are set."""

    masses: Row
    places: Matrix
    rates: Matrix
    accelerations: Matrix
    names: tuple[str, ...] = ()  # names of the positions, such as "(x, y)"
    beyond: str = ""
    why: str = ""
    span: Span | None = None


@record
class Attitude:
    """The indices of a rotation: those of the first of its three body rates, and of the first of
    its four quaternion states w, x, y, z (-1 if a reduction dropped the quaternion)."""

    rate: int
    state: int

    @property
    def rates(self) -> range:
        return range(self.rate, self.rate + 3)

    @property
    def numbers(self) -> range:
        """The indices of the quaternion's components among the states."""
        return range(self.state, self.state + 4) if self.state >= 0 else range(0)


@record
class Meeting:
    """A row that holds at times, of a contact, a friction or a latch; see struct pk_contact. A row
    of friction has the force -side F while it slips. `bounds` of a contact begin with its
    coefficient of restitution; those of a friction are F_0 and f of F = F_0 + f lambda, and the
    same while it sticks, where lambda is the multiplier of the contact `of`. `flag`: a
    contact has Poisson's law; a latch holds at the start."""

    name: str
    kind: str  # of enum pk_contact_kind, without PK_
    row: int
    mode: Node  # 1 while the row holds
    events: tuple[str, str]
    bounds: Row
    flag: bool = False
    side: Node | None = None
    of: str = ""


@record
class Rows:
    """The constraint rows of a model. Each row has J v + j0; the first `holonomic` rows also have
    phi(t, q), and their J v + j0 is its time derivative."""

    names: tuple[Quantity, ...]  # multipliers; unit: generalized force / entry of J
    holonomic: int
    positions: Row  # phi of the holonomic rows, in the unit of the constraint equation
    residual: Row  # J v + j0; unit: that of phi per time, or that of the rolling equation
    spans: tuple[Span, ...]  # positions of the constraint statements
    redundant: Rows | None = None  # rows that at the start depend on these rows
    meetings: tuple[Meeting, ...] = ()

    def picked(self, which: Sequence[int]) -> Rows:
        """Returns these rows alone."""
        holonomic = sum(k < self.holonomic for k in which)
        return replace(
            self,
            names=tuple(self.names[k] for k in which),
            holonomic=holonomic,
            positions=tuple(self.positions[k] for k in which[:holonomic]),
            residual=tuple(self.residual[k] for k in which),
            spans=tuple(self.spans[k] for k in which),
        )

    def statement(self, k: int) -> str:
        """Returns the kind and the name of the statement of row k: constraint 'rod'."""
        kind = "constraint" if k < self.holonomic else "rolling"
        return f"{kind} '{multiplied(self.names[k].name)}'"


@record(kw_only=True)
class Constraints(Rows):
    """Rows J v + j0 = 0 with their multipliers. The fields applied, pdot and force of Equations
    include the constraint force J^T lambda; the `free_` fields exclude it. `redundant` rows depend
    on these rows and have no force; a run ends where they become independent."""

    rows: Matrix  # J
    multipliers: Row
    pivots: Pivots  # pivots of S = J M^-1 J^T, each with the diagonal entry of S
    free_applied: Row
    free_pdot: Row
    free_force: Row
    workless: bool  # j0 = 0, and nothing depends on t or inputs: the constraints do no work
    redundant_rows: Matrix = ()  # J of the redundant rows
    least: Row = ()  # multipliers of least norm: for these rows, then for redundant rows
    values: Row = ()  # for each meeting the acceleration of its row if none holds, then its bounds
    shared: frozenset[int] = frozenset()  # indices in `least` of rows without a unique multiplier


@record
class Named:
    """The quantities of a model with families unrolled; the fields are as in Equations."""

    parameters: tuple[ParameterSlot, ...]
    coordinates: tuple[Quantity, ...]
    rates: tuple[Quantity, ...]
    momenta_names: tuple[Quantity, ...]
    inputs: tuple[Quantity, ...]
    states: tuple[Quantity, ...]


class AnyEquations(Protocol):
    """The fields that runs and reports read, both of equations that are written out (Equations)
    and of equations of families of any length (middle/families)."""

    model: Model
    graph: Graph
    switches: tuple
    coordinates: tuple
    states: tuple
    inputs: tuple[Quantity, ...]
    momenta_names: tuple[Quantity, ...]
    event_names: tuple[Quantity, ...]
    acceleration: Row | None
    linear: Linear | None
    constraints: Constraints | None
    # Whether C has kernels of dense matrices, and every quantity a name of its own.
    dense: bool
    # Whether members of long families feel only those near them.
    is_chain: bool
    # The shape of M in words, where it is not read from the facts.
    mass_in_words: str
    # The kinds of forces that do not come from L, in words.
    forces_beyond: list[str]
    # The number of rows of M that come from L.
    inertial: int
    # The outputs with one value each, by name.
    single_outputs: dict[str, Node]
    has_energy: bool
    # The number of values that switches have.
    n_switches: int

    def listed(self, kind: str) -> list[Declared]:
        """Returns the quantities of a kind as a run numbers them: "q", "v" (rates, then states),
        "param" or "observed"."""
        ...


@record
class Equations:
    model: Model
    graph: Graph
    parameters: tuple[ParameterSlot, ...]
    coordinates: tuple[Quantity, ...]
    rates: tuple[Quantity, ...]
    momenta_names: tuple[Quantity, ...]
    inputs: tuple[Quantity, ...]  # each input, followed by those of its derivatives that occur
    observed_names: tuple[Quantity, ...]
    conserved_names: tuple[Quantity, ...]
    event_names: tuple[Quantity, ...]

    lagrangian: Node
    kinetic: Node | None  # None if the model has a `lagrangian`, as is `potential`
    potential: Node | None
    written: Node  # L as in the model, before simplification
    energy: Node
    momenta: Row
    gradient: Row  # dL/dq
    applied: Row  # Q - dD/dv
    pdot: Row
    mass: Matrix
    force: Row  # f
    acceleration: Row | None  # None: not requested, or so large that C solves M a = f in a loop
    pivots: Pivots | None  # D of M = L D L^T, indexed by coordinate
    p_q: Matrix | None  # None if the kernel is not requested, as are pdot_q and pdot_v
    pdot_q: Matrix | None
    pdot_v: Matrix | None
    linear: Linear | None  # None: not requested
    singularities: tuple[Singularity, ...]
    observed: Row
    conserved: Row
    events: Row  # event functions; model.events has their directions
    # For each sample block, the next values of all inputs; then, of constants and parameters: the
    # period and the offset of each block; the initial values of all inputs.
    sampled: Row
    sample_times: Row
    held_start: Row
    start_q: Row
    start_v: Row
    # For each event with values after it (model.resetting), the coordinates, rates, states and
    # inputs after it.
    resets: tuple[Row, ...] = ()
    left_out: tuple[Diagnostic, ...] = ()  # warnings: constraints dropped as 0 = 0
    unrolled: str = ""  # the reason why families are not kept as loops
    hamiltonian: Hamiltonian | None = None  # None: not requested
    switches: tuple[Switch, ...] = ()
    marks: tuple[
        Switch, ...
    ] = ()  # arguments of exp, tanh, ..., not switches (middle/derive/marks.py)
    # First-order variables x' = state_rates; states.as_rates() makes coordinates of them.
    states: tuple[Quantity, ...] = ()
    state_rates: Row = ()
    state_start: Row = ()
    # The last n_first_order coordinates are dummies: their rates are the states.
    n_first_order: int = 0
    n_unread: int = 0  # number of the last dummies on which no rate depends
    attitudes: tuple[Attitude, ...] = ()  # rotations; their body rates follow all other rates
    constraints: Constraints | None = None
    # The mass matrix, if `mass` is the unit matrix (solved form) or `unconstrained` is set.
    inertia: Matrix | None = None
    unconstrained: tuple[Row, Row] | None = None  # for C: p, and pdot without constraint forces
    terms: tuple[Row, Row] | None = None  # for C: magnitudes of the terms of phi and of J v + j0
    redundant_terms: Row = ()  # for C: these magnitudes for redundant rows, phi then J v + j0
    particles: Particles | None = None  # None: not requested
    flight: Equations | None = None  # for C: these while no contact, friction or latch holds
    fast: Row | None = None  # acceleration by the `fast` terms of V; None if no term is fast
    noise: Noise | None = None
    # For C: the requested Jacobians by name (middle/derive/sensitivity.py).
    sensitivity: Mapping[str, Matrix] | None = None

    # See AnyEquations.
    dense = True
    is_chain = False
    mass_in_words = ""

    @property
    def forces_beyond(self) -> list[str]:
        bound = self.constraints
        applied = bound.free_applied if bound else self.applied[: self.inertial]
        found = ["of constraints"] if bound else []
        return found + ["force or dissipation"] * any(node != ZERO for node in applied)

    def listed(self, kind: str) -> list[Declared]:
        found = {"q": self.seen, "v": (*self.rates, *self.states), "observed": self.observed_names}
        named = (slot.quantity for slot in self.parameters)
        return Declared.each(named if kind == "param" else found[kind])

    @property
    def single_outputs(self) -> dict[str, Node]:
        return {q.name: x for q, x in zip(self.observed_names, self.observed, strict=True)}

    @property
    def has_energy(self) -> bool:
        """A model with states only has none, unless they come from an L of first degree in the
        rates."""
        return bool(self.coordinates or self.model.lagrangian)

    @property
    def n_switches(self) -> int:
        return len(self.switches)

    @property
    def moving(self) -> tuple[str, ...]:
        """The names of the rows of M: coordinates, or for rotations body rates."""
        return tuple(
            (self.rates if i in self.turning else self.coordinates)[i].name
            for i in range(len(self.coordinates))
        )

    @property
    def impulsive(self) -> tuple[Switch, ...]:
        """The switches at which rates may jump."""
        return tuple(x for x in self.switches if x.impulse)

    @property
    def counted(self) -> tuple[int, ...]:
        """For each switch 1 if it counts pieces, else 0; () if none does."""
        flags = tuple(int(x.counted) for x in self.switches)
        return flags if any(flags) else ()

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
        """The number of coordinates that are not dummies of first-order variables."""
        return len(self.coordinates) - self.n_first_order

    @property
    def inertial(self) -> int:
        """The number of rows of M that come from the Lagrangian, those of coordinates and body
        rates (in C, body rates are states)."""
        return len(self.coordinates) - max(self.n_first_order - len(self.turning), 0)

    @property
    def seen(self) -> tuple[Quantity, ...]:
        """The coordinates without hidden ones, which are dummies of body rates."""
        return self.coordinates[: len(self.coordinates) - len(self.turning)]
