"""The table row of a function of the language, with all that the compiler needs to know of it.

Most fields have defaults that are valid for any function. For example, by default the values of a
function may be any real numbers, and the compiler does not evaluate calls with constant arguments.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from ..record import record
from .interval import ANY, Range

# Values of `Singularity.use`. Each is a reason why an expression in the equations must not vanish.
COORDINATES, DIVISOR, ROOT, LOGARITHM, ARC = "COORDINATES", "DIVISOR", "ROOT", "LOGARITHM", "ARC"
CUT = "CUT"  # The Lagrangian jumps where the expression vanishes.


def at(point: int, value: int) -> Callable[[Fraction], Fraction | None]:
    """Returns a callable for the field `exact` of a function that has a rational value at one
    rational argument only: f(point) = value."""
    return lambda x: Fraction(value) if x == point else None


@record
class Kinked:
    """The two smooth branches of a function with a kink or a jump, as C expressions in the names of
    its arguments. The function changes branch where its only argument x, or the difference a - b of
    its two arguments, is zero."""

    below: str
    above: str
    # For a function that jumps at every integer of a function u, in place of `below` and `above`:
    # `place` is the name of u in the table, `held` the C expression on the piece n <= u <= n + 1.
    # There `side` is 2 n + 1.
    place: str = ""
    held: str = ""


@record(kw_only=True)
class Function:
    """One row of the table. In the signatures below, `g` is the graph, `n` the node of the call,
    `a` and `b` the nodes of its arguments."""

    # The names of the arguments.
    arguments: tuple[str, ...] = ("x",)
    # "none": arguments and value are dimensionless. "same": arguments and value have the same
    # dimension. "any": the arguments have the same dimension, the value is dimensionless. "root":
    # the value has the square root of the argument's dimension.
    units: str = "none"
    # Whether only the compiler calls the function, in derivatives. Models cannot use its name.
    internal: bool = False

    # The function on floats.
    real: Callable[..., float]
    # The function on arrays: its name in NumPy, if that differs from the name in the language, or a
    # callable that takes the numpy module and arrays, and returns an array.
    array: str | Callable = ""
    # The function on Fractions. Returns None where the value is not rational.
    exact: Callable[..., Fraction | None] = lambda *_: None
    # Returns the reason why the function is undefined at the given numbers, or "".
    undefined: Callable[..., str] = lambda *_: ""

    # A callable (g, n, a, b) that returns the partial derivatives with respect to the arguments.
    derivative: Callable[..., tuple]
    # "odd", "even", or "" for neither.
    parity: str = ""

    # The function in interval arithmetic.
    interval: Callable[..., Range] = lambda *x: ANY
    # The function in ball arithmetic: a callable (Balls, a, b) -> Ball or None.
    ball: Callable = lambda *_: None
    # A callable (Exact, polynomials) -> polynomial, which rewrites a call in terms of simpler
    # functions. This lets graph/exact.py recognize more expressions as equal.
    opened: Callable = lambda *_: None
    # A callable (domain, a, b) -> the value of the function. The domain has the arithmetic of a
    # kind of numbers, such as Floats of graph/written.py. Smooth functions also accept power
    # series. None if the function cannot be evaluated in domains.
    enclosed: Callable | None = None
    # A callable (series, name, a) that adds the function's Taylor series, by the given name, to a
    # back.c.jets.Series, and returns its name; `a` is the name of the argument's series. None if no
    # recurrence is known.
    series: Callable[..., str] | None = None
    # Whether the function has several branches: it may jump though its derivative is zero.
    branched: bool = False
    # A text that describes the jump of the function, or "".
    jump: str = ""

    # The end points of the domain.
    ends: tuple[int, ...] = ()
    # A callable (g, a, b) -> (a node that must not vanish, the reason as a `Singularity.use`).
    singular: Callable | None = None
    # The argument that must not move, since the derivative by it is not known; "" for none.
    still: str = ""
    # Whether the function vanishes exactly where its argument vanishes.
    like_argument: bool = False
    # If not 0, the function varies in a range of short width. Where |short x| > 36, it is constant,
    # 0 or huge, up to rounding errors (middle/derive/marks.py).
    short: int = 0

    # The name in <math.h>, if it differs from the name in the language.
    c: str = ""
    # The body of a C helper function, which must propagate NaN; "" if <math.h> has the function.
    body: str = ""
    # C statements before the `return` of `body`.
    steps: str = ""
    # A C comment on the line of `body`.
    remark: str = ""
    # A C comment above the helper function.
    note: str = ""
    # The branches of a function with a kink or a jump.
    kinked: Kinked | None = None
    # The branches of atan2(y, x) beside its branch cut, where y vanishes.
    cut: Kinked | None = None

    # Whether the function is such a u (Kinked.place), at whose integers another one jumps.
    counted: bool = False
    # The name of the table of the model that the function reads, or "" (functions/tables.py): its
    # value and derivatives, of these `orders` by the arguments, or the place on the `axis`.
    table: str = ""
    orders: tuple[int, ...] = ()
    axis: int = 0
    # The name in SymPy, if it differs, or a callable (sympy module, arguments) -> expression.
    sympy: Callable | str = ""

    @property
    def arity(self) -> int:
        return len(self.arguments)

    @property
    def smooth(self) -> bool:
        return self.kinked is None
