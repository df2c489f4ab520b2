"""What the compiler knows about a function of the language: a field for each use.

A field that a row leaves out has a default that is right, if weaker: no interval is every real
number, no ball proves nothing, no exact value leaves the call as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from ..record import record
from .interval import ANY, Range

# How the equations use what must not vanish, `Singularity.use`.
COORDINATES, DIVISOR, ROOT, LOGARITHM, ARC = "COORDINATES", "DIVISOR", "ROOT", "LOGARITHM", "ARC"
CUT = "CUT"  # L jumps there


def at(point: int, value: int) -> Callable[[Fraction], Fraction | None]:
    """The exact value of a function that has a rational one at one point."""
    return lambda x: Fraction(value) if x == point else None


@record
class Kinked:
    """A function that is a smooth one on either side of the zero of what decides it: its argument,
    or the first less the second."""

    below: str  # C, of the arguments' names
    above: str


@record(kw_only=True)
class Function:
    """One row. `g` is the graph, `n` the call's node, `a` and `b` its arguments' nodes."""

    # The language. `units`: "none" takes and gives dimensionless; "same" takes one dimension and
    # gives it back; "any" takes one and gives none; "root" halves it.
    arguments: tuple[str, ...] = ("x",)
    units: str = "none"
    internal: bool = False  # made by differentiation, not available in a model

    # Values. `real` of floats; `array` of arrays: a name of NumPy's, if it is not
    # this one, or (numpy module, arrays) -> array.
    real: Callable[..., float]
    array: str | Callable = ""
    exact: Callable[..., Fraction | None] = lambda *_: None  # of rational numbers; None: no such
    undefined: Callable[..., str] = lambda *_: ""  # what is wrong with these numbers

    # Calculus: (g, n, a, b) -> the partial derivatives.
    derivative: Callable[..., tuple]
    parity: str = ""  # "odd" or "even"

    # Proofs. `interval` of Ranges; `ball` (arithmetic of Balls, a, b) or None; `opened` writes a
    # call of polynomials by other functions (see graph/exact.py), so that identities are seen.
    interval: Callable[..., Range] = lambda *x: ANY
    ball: Callable = lambda *_: None
    opened: Callable = lambda *_: None
    # (a domain as Floats of graph/written.py is one, a, b) -> the value there, in bounds of smooth
    # ones a power series too; None: no bounds.
    enclosed: Callable | None = None
    branched: bool = False  # one of several values, so its derivative does not say where it jumps
    jump: str = ""  # how it jumps

    # Where it ends: the arguments at which it ceases to have a value, the (g, a, b) -> (node that
    # must not vanish, its use), and whether it vanishes where its argument does and nowhere else.
    ends: tuple[int, ...] = ()
    singular: Callable | None = None
    like_argument: bool = False
    # It is constant, 0 or huge where this times its argument is beyond 36; 0: it fades slowly.
    short: int = 0

    # C: a name of <math.h>, if it is not this one; or the body of a helper, which hands a NaN on.
    c: str = ""
    body: str = ""
    remark: str = ""  # a comment beside the body
    note: str = ""  # a comment above the helper
    kinked: Kinked | None = None
    cut: Kinked | None = None  # the function is smooth but for a branch cut, where y vanishes

    sympy: Callable | str = (
        ""  # a name of SymPy's, if it is not this one; or (sympy module, arguments) -> expression
    )

    @property
    def arity(self) -> int:
        return len(self.arguments)

    @property
    def smooth(self) -> bool:
        return self.kinked is None
