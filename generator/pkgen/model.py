"""A checked model: what `check` hands to `derive`. Every name is known, every unit consistent.

Expressions are those of `tree.py` with units already folded in: all values are SI and there
is no `Quantity` left. Families and sums are still loops over index variables; `derive` unrolls
them with `indices.py`.
"""

from __future__ import annotations

from .methods import Own
from .record import record
from .source import Diagnostic, Source, Span
from .tree import Expr, Range


@record
class Size:
    """`size N = 31`; `value` already holds what `--size` set."""

    name: str
    value: int
    description: str
    span: Span


@record
class Bounds:
    """Where a parameter may lie; None is infinite. `lo_open` excludes the end itself."""

    lo: Expr | None
    hi: Expr | None
    lo_open: bool
    hi_open: bool


@record
class Parameter:
    """A run-time parameter, or with `range` a family of them (indices lo..hi).

    `default` may use earlier parameters; then `follows` is true and the default is evaluated
    again whenever they change.
    """

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
    rate: str = ""  # what its rate and momentum are called, where not x' and p_x
    momentum: str = ""


@record
class Rotation:
    """An attitude in SO(3); with `range`, a family R[lo..hi]. Its body rates are the rates of
    coordinates of their own, `turns`, which stand behind all others; its unit quaternion w, x, y, z
    are states, before all others, whose own rates have `per_time`."""

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


def multipliers(name: str) -> tuple[str, str]:
    """The names of what keeps it: of a unique multiplier, and of the one of least norm."""
    return f"lambda_{name}", f"least_lambda_{name}"


@record
class Constraint:
    """`constraint` (holonomic) or `rolling` NAME: A = B; `value` is A - B, of a vector a component.
    `name` is that of its multiplier without the lambda_ in front."""

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
    """A first-order variable, whose rate the model states; with `range`, a family."""

    name: str
    range: Range | None
    unit: str
    rate_unit: str
    description: str
    span: Span


@record
class Given:
    """What NAME, NAME[index] or NAME[i = lo..hi] is given."""

    name: str
    index: Expr | None
    range: Range | None
    value: Expr
    span: Span


@record
class Rate(Given):
    """`rate NAME = EXPR`: each state, and each member of a family of states, has one."""


@record
class End:
    """What a family's coordinate outside its range means.

    kind "fixed": NAME[index] has the value `value` (its rate is the value's time derivative; of the
    body rates of a rotation, which have None, the rate is that of its quaternion);
    "free": NAME[index] is its neighbour inside; "periodic": any index wraps around (index None).
    """

    kind: str
    name: str
    index: int | None
    value: Expr | None
    span: Span
    at: Expr | None = None  # the index as written, for a family whose size is not known yet


@record
class Input:
    """Set by the embedding program; `order` derivatives of it occur (0, 1 or 2)."""

    name: str
    order: int
    units: tuple[str, ...]  # of the input and its derivatives up to order
    description: str
    span: Span


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


@record
class Force(Given):
    """`force COORD = EXPR`; several for one coordinate add up."""


@record
class Start:
    """An initial value; `order` 0 for a coordinate, 1 for its rate. Later ones override."""

    name: str
    index: Expr | None
    range: Range | None
    order: int
    value: Expr
    span: Span


@record
class Event:
    """`event NAME: EXPR rising stop`: where EXPR crosses zero. Of a `limit` a run stops at once if
    it starts beyond it."""

    name: str
    value: Expr
    direction: int  # +1 rising, -1 falling, 0 either
    stop: bool
    unit: str
    description: str
    span: Span
    limit: bool = False


@record
class Drawing:
    """`draw SHAPE …` or `view …`: its parts by name, each a number or as many as a place has
    components (9 of a turn: columns). `form` is of a body, `axes` of a ground, level or plane."""

    shape: str
    parts: tuple[tuple[str, tuple[Expr, ...]], ...]
    range: Range | None
    name: str  # of the place that is drawn, "" of an expression
    description: str
    span: Span
    form: str = ""
    axes: tuple[str, ...] = ()


@record
class Assignment:
    """`set NAME = EXPR` in a scene: a parameter, or an input. `varies`: EXPR contains t."""

    name: str
    index: Expr | None
    range: Range | None
    value: Expr
    varies: bool
    span: Span


@record
class Record:
    """`record a, b every H at EVENT`; the columns are named as in the CSV: "q[3]", "theta'"."""

    columns: tuple[Definition, ...]
    every: Expr | None
    at: str  # "" without
    span: Span


@record
class Hold(Given):
    """`hold NAME = EXPR`: a prescribed motion, of parameters and t; without a value (None) it stays
    at its start."""


@record
class Expect:
    """`expect A = B within TOL at T`: a time or an event; with neither, at every recorded time."""

    a: Expr
    relation: str  # "=", "<" or ">"
    b: Expr
    within: Expr | None
    at: Expr | None  # a time
    event: str  # "" without
    span: Span
    component: str = ""  # ".x" where vectors are compared


@record(kw_only=True)
class Scene:
    """One use of the model."""

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
    method_span: Span | None = None
    misfits: tuple[Diagnostic, ...] = ()  # errors that other sizes than the file's have made


@record
class Model:
    """Everything in declaration order."""

    source: Source
    name: str
    description: str
    dimensionless: bool  # no unit in the whole model: time has none either
    sizes: tuple[Size, ...]
    parameters: tuple[Parameter, ...]
    coordinates: tuple[Coordinate, ...]
    ends: tuple[End, ...]
    inputs: tuple[Input, ...]
    definitions: tuple[Definition, ...]  # const and let, in the order written
    kinetic: tuple[Expr, ...]
    potential: tuple[Expr, ...]
    lagrangian: tuple[Expr, ...]
    dissipation: tuple[Expr, ...]
    forces: tuple[Force, ...]
    observed: tuple[Definition, ...]
    conserved: tuple[Definition, ...]
    events: tuple[Event, ...]
    starts: tuple[Start, ...]
    scenes: tuple[Scene, ...]
    span: Span  # of the `model` statement
    states: tuple[State, ...] = ()
    rates: tuple[Rate, ...] = ()
    rotations: tuple[Rotation, ...] = ()
    constraints: tuple[Constraint, ...] = ()
    drawings: tuple[Drawing, ...] = ()
    views: tuple[Drawing, ...] = ()
    fast: tuple[Expr, ...] = ()  # what of the potential is
    methods: tuple[Own, ...] = ()  # that it brings beside the runtime's
