"""A checked model: the output of `check`. Every name is known, every unit consistent.

Expressions are those of `tree.py`, all values in SI: units are multiplied in, and no `Quantity`
remains. Families (q[1..N]) and sums are still loops over index variables, which `derive` unrolls
with `indices.py`.
"""

from __future__ import annotations

import hashlib

from . import limits
from .functions.tables import Data
from .indices import hidden
from .methods import Own
from .record import record
from .source import Diagnostic, Source, Span
from .system.exits import UsageError
from .tree import Expr, Range


@record
class Size:
    """`size N = 31`; `value` is that of `--size` if it is given."""

    name: str
    value: int
    description: str
    span: Span


@record
class Bounds:
    """The interval of a parameter; an end None is infinite. `lo_open` excludes the lower end."""

    lo: Expr | None
    hi: Expr | None
    lo_open: bool
    hi_open: bool


@record
class Parameter:
    """A run-time parameter; with `range`, a family of parameters with indices lo..hi.

    `default` may use earlier parameters; then `follows` is true and the default is evaluated again
    when these change."""

    name: str
    range: Range | None
    default: Expr
    follows: bool
    bounds: Bounds
    unit: str  # SI, e.g. "kg*m/s^2"; "" if dimensionless
    description: str
    span: Span


@record
class Coordinate:
    """A generalized coordinate; with `range`, a family q[lo..hi]."""

    name: str
    range: Range | None
    unit: str
    rate_unit: str
    momentum_unit: str
    description: str
    span: Span
    rate: str = ""  # names of rate and momentum, if not x' and p_x
    momentum: str = ""


@record
class Rotation:
    """An attitude in SO(3); with `range`, a family R[lo..hi]. Its body rates are the rates of three
    coordinates `turns`, which follow all other coordinates. Its unit quaternion w, x, y, z is four
    states, which precede all other states; the unit of their rates is `per_time`."""

    name: str
    range: Range | None
    quaternion: tuple[str, ...]
    rates: tuple[str, ...]
    turns: tuple[str, ...]
    momenta: tuple[str, ...]
    rate_unit: str
    per_time: str
    momentum_unit: str
    description: str
    span: Span


@record
class Constraint:
    """`constraint` (holonomic) or `rolling` NAME: A = B; `value` is A - B, or a component of it if
    A and B are vectors. The multiplier is named lambda_NAME."""

    name: str
    index: Expr | None
    range: Range | None
    holonomic: bool
    value: Expr
    unit: str  # of the multiplier
    description: str
    span: Span


@record
class State:
    """A first-order variable with a `rate` statement; with `range`, a family."""

    name: str
    range: Range | None
    unit: str
    rate_unit: str
    description: str
    span: Span


@record
class Given:
    """A value given to NAME, NAME[index] or NAME[i = lo..hi]."""

    name: str
    index: Expr | None
    range: Range | None
    value: Expr
    span: Span


@record
class Rate(Given):
    """`rate NAME = EXPR`: the time derivative of a state, or of members of a family of states."""


@record
class End:
    """A boundary condition: the meaning of a family's coordinate outside its range.

    kind "fixed": NAME[index] is `value`, and its rate is the time derivative of `value` (None for
    body rates of a rotation, which follow from the quaternion's rate); "free": NAME[index] equals
    its neighbour in the range; "periodic": indices wrap around (`index` is None)."""

    kind: str
    name: str
    index: int | None
    value: Expr | None
    span: Span
    at: Expr | None = None  # the index as written, if the family's size is not known yet


@record
class Input:
    """An input, set by the embedding program; its derivatives up to `order` (0..2) are used. An
    input that is held between samples is set by the sample block `by`: this may be a memory cell,
    which begins at `start`, or a value NAME.k that the input NAME has k samples later."""

    name: str
    order: int
    units: tuple[str, ...]  # units of the input and of its derivatives up to `order`
    description: str
    span: Span
    by: str = ""
    start: Expr | None = None


@record
class Definition:
    """`let`, `const`, `observe` or `conserve`: NAME, NAME[index] or NAME[i = lo..hi].

    At most one of `index` and `range` is given.
    """

    name: str
    index: Expr | None
    range: Range | None
    value: Expr
    unit: str
    description: str
    span: Span


@record(eq=False)
class Table:
    """A table of data: the function `name` of one or two variables. `key` begins the names of its
    rows in FUNCTIONS, `units` are those of the variables and of the value."""

    name: str
    key: str
    data: Data
    file: str
    kind: str
    outside: str
    units: tuple[str, ...]
    description: str
    span: Span

    @property
    def long(self) -> bool:
        """Whether its numbers are not written in C, but given at run time."""
        return self.data.coefficients.size > limits.TABLE_NUMBERS


@record
class Force(Given):
    """`force COORD = EXPR`; several forces on one coordinate add up."""


@record
class Load(Given):
    """`force` at a point, or `torque` on a body or a rotation. Its power is dot(value, velocity),
    its generalized forces are the derivatives of `velocity` by the rates, times `value`. Both are
    vectors; for a torque, `velocity` is the angular velocity in space. Without `at`, `name` is
    ""."""

    velocity: Expr


@record
class Noise(Given):
    """`noise` along a coordinate, or at a point, whose rate is `velocity`. `value` is the two-sided
    intensity S of a random force F, with <F(t) F(s)> = S delta(t - s); at a point a vector of the
    intensities along x, y and z. Messages name it by `label` and its index."""

    velocity: Expr | None
    label: str


@record
class Sample:
    """`sample NAME every T offset T0 delay K`. `steps` are its definitions, which only later steps
    see, and its assignments to inputs and memory cells, in order."""

    name: str
    every: Expr
    offset: Expr | None
    delay: int
    steps: tuple[Given, ...]
    description: str
    head: Span  # position of the first line

    @property
    def kernel(self) -> str:
        """The name of its C function, without the model's in front."""
        return f"{self.name.replace('.', '_')}_sample"


@record
class Start:
    """An initial value of a coordinate (`order` 0) or its rate (1). The last one is valid."""

    name: str
    index: Expr | None
    range: Range | None
    order: int
    value: Expr
    span: Span


@record
class Event:
    """`event NAME: EXPR rising stop then a = EXPR`: a zero crossing of the event function EXPR. If
    `limit` (of a joint) is set, a run that starts beyond it stops at once. `then` are the values of
    the motion after it, and of memory cells, as functions of those before."""

    name: str
    value: Expr
    direction: int  # +1 rising, -1 falling, 0 either
    stop: bool
    unit: str
    description: str
    span: Span
    limit: bool = False
    then: tuple[Start, ...] = ()
    # A contact, friction or mode: it can happen while its row holds (`when` 1) or does not (0).
    mode: str = ""
    when: int = 0
    ends: bool = False  # whether it is where a mode ends

    @property
    def kernel(self) -> str:
        """The name of the C function of the values after it, without the model's in front."""
        return f"{self.name.replace('.', '_')}_reset"

    @property
    def acts(self) -> bool:
        """Whether the motion does not go on through it as if it were not there."""
        return self.stop or self.ends or bool(self.then or self.mode)


@record
class Contact:
    """`impact` or `contact` NAME: a gap that does not become negative. `restitution` is that of
    Newton's law, or of Poisson's; `mu` the coefficient of friction, and `along` the slip. Without
    `along` a place is searched for whose rate along the surface is the slip. `unit` is that of the
    multiplier."""

    name: str
    index: Expr | None
    range: Range | None
    gap: Expr
    restitution: Expr | None
    mu: Expr | None
    along: Expr | None
    poisson: bool
    unit: str
    description: str
    span: Span


@record
class Friction:
    """`friction NAME = FORCE static FORCE`: `value` and `static` bound the force along the slip,
    an expression of rates; while it sticks, the slip is 0. `unit` is that of the force."""

    name: str
    index: Expr | None
    range: Range | None
    slip: Expr | None
    value: Expr
    static: Expr | None
    unit: str
    description: str
    span: Span
    of: str = ""  # the contact that it belongs to; then a slip None is found from its gap


@record
class Mode:
    """`mode NAME: constraint a, b on at EVENT off at EVENT`. `begins`: whether it is on at the
    start."""

    name: str
    constraints: tuple[str, ...]
    on: str
    off: str
    span: Span
    begins: bool


@record
class Drawing:
    """`draw SHAPE …` or `view …`: its parts by name, each a number, the components of a position,
    or the columns of a rotation matrix. `form` is the shape of a body; `axes` are those of a
    ground, level or plane."""

    shape: str
    parts: tuple[tuple[str, tuple[Expr, ...]], ...]
    range: Range | None
    name: str  # name of the drawn position, "" if it is an expression
    description: str
    span: Span
    form: str = ""
    axes: tuple[str, ...] = ()


@record
class Assignment:
    """`set NAME = EXPR` in a scene, for a parameter or an input. `varies`: EXPR contains t."""

    name: str
    index: Expr | None
    range: Range | None
    value: Expr
    varies: bool
    span: Span


@record
class Record:
    """`record a, b every H at EVENT`; columns are named as in the CSV: "q[3]", "theta'"."""

    columns: tuple[Definition, ...]
    every: Expr | None
    at: str  # name of an event, or ""
    span: Span


@record
class Hold(Given):
    """`hold NAME = EXPR`: a prescribed motion, a function of parameters and t. Without an
    expression, `value` is None and the coordinate stays at its start."""


@record
class Exact(Given):
    """`exact NAME = EXPR within TOL`: a closed form of the motion, a function of t. With TOL, it
    holds for what the model approximates, and only its start is tried."""

    within: Expr | None


@record
class Expect:
    """`expect A = B within TOL at T`; T is a time or an event; without T, at all recorded times."""

    a: Expr
    relation: str  # "=", "<" or ">"
    b: Expr
    within: Expr | None
    at: Expr | None  # a time
    event: str  # name of an event, or ""
    span: Span
    component: str = ""  # ".x", ".y" or ".z" if this component of two vectors is compared


@record(kw_only=True)
class Scene:
    """A scene: one run of the model, with its settings."""

    name: str
    description: str = ""
    assignments: tuple[Assignment, ...] = ()
    starts: tuple[Start, ...] = ()
    until: Expr | None = None
    method: str = ""
    step: Expr | None = None
    rtol: Expr | None = None
    record: Record | None = None
    span: Span
    holds: tuple[Hold, ...] = ()
    accuracy: Expr | None = None
    swarm: Range | None = None
    expects: tuple[Expect, ...] = ()
    exacts: tuple[Exact, ...] = ()  # those of the model among them, where they are valid
    consistent: Span | None = None  # position of `start consistent`
    method_span: Span | None = None
    misfits: tuple[Diagnostic, ...] = ()  # errors that sizes from the command line cause

    @property
    def listed(self) -> bool:
        """Whether lists show it. Scenes of parts and one made of options are chosen by name."""
        return not (hidden(self.name) or "." in self.name)


@record
class Model:
    """A checked model; the fields are in declaration order."""

    source: Source
    name: str
    description: str
    dimensionless: bool  # the model, including its time, has no units
    sizes: tuple[Size, ...]
    parameters: tuple[Parameter, ...]
    coordinates: tuple[Coordinate, ...]
    ends: tuple[End, ...]
    inputs: tuple[Input, ...]
    definitions: tuple[Definition, ...]  # const and let, in declaration order
    kinetic: tuple[Expr, ...]
    potential: tuple[Expr, ...]
    lagrangian: tuple[Expr, ...]
    hamiltonian: tuple[Expr, ...]
    dissipation: tuple[Expr, ...]
    forces: tuple[Force, ...]
    observed: tuple[Definition, ...]
    conserved: tuple[Definition, ...]
    events: tuple[Event, ...]
    starts: tuple[Start, ...]
    scenes: tuple[Scene, ...]
    span: Span  # position of the `model` statement
    states: tuple[State, ...] = ()
    rates: tuple[Rate, ...] = ()
    rotations: tuple[Rotation, ...] = ()
    constraints: tuple[Constraint, ...] = ()
    drawings: tuple[Drawing, ...] = ()
    tables: tuple[Table, ...] = ()
    views: tuple[Drawing, ...] = ()
    fast: tuple[Expr, ...] = ()  # terms of the potential that the model names fast
    loads: tuple[Load, ...] = ()
    methods: tuple[Own, ...] = ()  # methods that the model defines
    exacts: tuple[Exact, ...] = ()
    consistent: Span | None = None  # position of `start consistent`
    samples: tuple[Sample, ...] = ()
    contacts: tuple[Contact, ...] = ()
    frictions: tuple[Friction, ...] = ()
    modes: tuple[Mode, ...] = ()
    noises: tuple[Noise, ...] = ()

    @property
    def meets(self) -> bool:
        """Whether constraint rows hold at times: contacts, friction, latches."""
        return bool(self.contacts or self.frictions or self.modes)

    @property
    def struck(self) -> bool:
        """Whether the motion changes besides its equations: by values after events, by contacts,
        or by noise."""
        return bool(self.resetting) or self.meets or bool(self.noises)

    @property
    def resetting(self) -> tuple[Event, ...]:
        return tuple(event for event in self.events if event.then)

    def refuse_long(self, what: str) -> None:
        """Raises UsageError for a table whose numbers are not written in C."""
        for table in self.tables:
            if table.long:
                count, most = table.data.coefficients.size, limits.TABLE_NUMBERS
                message = f"the table {table.name} has {count:,} numbers, of at most {most:,}"
                raise UsageError(f"{what}: {message}: leave out rows of the data")

    @property
    def sha256(self) -> str:
        """The digest of the model's text and of its tables."""
        keys = "".join(table.key for table in self.tables)
        text = self.source.sha256
        return hashlib.sha256((text + keys).encode()).hexdigest() if keys else text
