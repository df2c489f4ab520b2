"""The table row of a function of the language, with all that the compiler needs to know of it.

Most fields have defaults that are valid for any function: for example, the interval of all real
numbers, no ball, and no exact value, so that a call with constant arguments is not evaluated.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from ..record import record
from .interval import ANY, Range

# Values of `Singularity.use`: why an expression of the equations must not vanish.
COORDINATES, DIVISOR, ROOT, LOGARITHM, ARC = "COORDINATES", "DIVISOR", "ROOT", "LOGARITHM", "ARC"
CUT = "CUT"  # The Lagrangian jumps where the expression vanishes.


def at(point: int, value: int) -> Callable[[Fraction], Fraction | None]:
    """Returns a value of the field `exact`, for a function with one rational point: f(point) =
    value."""
    return lambda x: Fraction(value) if x == point else None


@record
class Kinked:
    """The two smooth branches of a function with a kink or a jump, as C expressions in the names of
    its arguments. The function changes branch where its argument x, or a - b, is zero."""

    below: str
    above: str


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
    # The function on arrays: its name in NumPy, if that differs from the name in the language, or
    # a callable (numpy module, arrays) -> array.
    array: str | Callable = ""
    # The function on Fractions. Returns None where the value is not rational.
    exact: Callable[..., Fraction | None] = lambda *_: None
    # Returns the reason why the function is undefined at the given numbers, or "".
    undefined: Callable[..., str] = lambda *_: ""

    # A callable (g, n, a, b) -> the partial derivatives by the arguments.
    derivative: Callable[..., tuple]
    # "odd", "even", or "" for neither.
    parity: str = ""

    # The function in interval arithmetic.
    interval: Callable[..., Range] = lambda *x: ANY
    # The function in ball arithmetic: a callable (Balls, a, b) -> Ball or None.
    ball: Callable = lambda *_: None
    # Rewrites a call in simpler functions, which reveals identities (graph/exact.py): a callable
    # (Exact, polynomials) -> polynomial.
    opened: Callable = lambda *_: None
    # A callable (domain, a, b) -> the value in a domain such as Floats of graph/written.py. Smooth
    # functions also accept power series. None: the function has no bounds in these domains.
    enclosed: Callable | None = None
    # Whether the function has several branches: it may jump though its derivative is zero.
    branched: bool = False
    # A text that describes the jump of the function, or "".
    jump: str = ""

    # The end points of the domain.
    ends: tuple[int, ...] = ()
    # A callable (g, a, b) -> (a node that must not vanish, the reason as in `Singularity.use`).
    singular: Callable | None = None
    # Whether the function vanishes exactly where its argument vanishes.
    like_argument: bool = False
    # If not 0: where |short x| > 36, the function is constant, 0 or huge, up to rounding
    # (middle/derive/marks.py).
    short: int = 0

    # The name in <math.h>, if it differs from the name in the language.
    c: str = ""
    # The body of a C helper function, which must propagate NaN; "" if <math.h> has the function.
    body: str = ""
    # A C comment on the line of `body`.
    remark: str = ""
    # A C comment above the helper function.
    note: str = ""
    # The branches of a function with a kink or a jump.
    kinked: Kinked | None = None
    # The branches of atan2(y, x) beside its branch cut, where y vanishes.
    cut: Kinked | None = None

    # The name in SymPy, if it differs, or a callable (sympy module, arguments) -> expression.
    sympy: Callable | str = ""

    @property
    def arity(self) -> int:
        return len(self.arguments)

    @property
    def smooth(self) -> bool:
        return self.kinked is None
