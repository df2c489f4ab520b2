"""The row of a function of the language: a field for each use by the compiler.

Defaults of fields are correct but weak: the default interval is all real numbers, the default ball
proves nothing, and without an exact value the call stays as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from ..record import record
from .interval import ANY, Range

# How the equations use an expression that must not vanish, `Singularity.use`.
COORDINATES, DIVISOR, ROOT, LOGARITHM, ARC = "COORDINATES", "DIVISOR", "ROOT", "LOGARITHM", "ARC"
CUT = "CUT"  # L jumps there


def at(point: int, value: int) -> Callable[[Fraction], Fraction | None]:
    """Returns the field `exact` of a function with a rational value at one point only."""
    return lambda x: Fraction(value) if x == point else None


@record
class Kinked:
    """A function with a smooth branch on either side of its switch, the zero of its argument or of
    the first argument minus the second."""

    below: str  # C of the branches, in the names of the arguments
    above: str


@record(kw_only=True)
class Function:
    """One row. `g` is the graph, `n` the call's node, `a` and `b` its arguments' nodes."""

    # The language. `units`: "none": arguments and value are dimensionless; "same": all have one
    # dimension; "any": the arguments have one, the value none; "root": halves the dimension.
    arguments: tuple[str, ...] = ("x",)
    units: str = "none"
    internal: bool = False  # made by differentiation, not available in a model

    # Values. `real`: of floats. `array`: of arrays, a NumPy name if it differs from the function's,
    # or (numpy module, arrays) -> array.
    real: Callable[..., float]
    array: str | Callable = ""
    exact: Callable[..., Fraction | None] = lambda *_: None  # of Fractions; None: no rational value
    undefined: Callable[..., str] = lambda *_: ""  # reason why there is no value at these numbers

    # Calculus: (g, n, a, b) -> the partial derivatives.
    derivative: Callable[..., tuple]
    parity: str = ""  # "odd" or "even"

    # Proofs. `interval`: of Ranges. `ball`: (Balls, a, b) -> Ball or None. `opened`: (Exact,
    # polynomials) -> polynomial in other functions (graph/exact.py), which reveals identities.
    interval: Callable[..., Range] = lambda *x: ANY
    ball: Callable = lambda *_: None
    opened: Callable = lambda *_: None
    # (a domain such as Floats of graph/written.py, a, b) -> the value in that domain; smooth
    # functions also take power series. None: no bounds.
    enclosed: Callable | None = None
    branched: bool = False  # has branches: a zero derivative does not exclude jumps
    jump: str = ""  # text: how it jumps

    # The domain. `ends`: end points of the domain. `singular`: (g, a, b) -> (node that must not
    # vanish, its use). `like_argument`: it vanishes exactly where its argument does.
    ends: tuple[int, ...] = ()
    singular: Callable | None = None
    like_argument: bool = False
    # Constant, 0 or huge up to rounding where |short x| > 36 (middle/derive/marks.py); 0: not so.
    short: int = 0

    # C: a name of <math.h>, if it differs; or the body of a helper, which must propagate NaN.
    c: str = ""
    body: str = ""
    remark: str = ""  # a comment on the line of the body
    note: str = ""  # a comment above the helper
    kinked: Kinked | None = None
    cut: Kinked | None = None  # smooth except at a branch cut, where y vanishes

    sympy: Callable | str = (
        ""  # a SymPy name, if it differs; or (sympy module, arguments) -> expression
    )

    @property
    def arity(self) -> int:
        return len(self.arguments)

    @property
    def smooth(self) -> bool:
        return self.kinked is None
