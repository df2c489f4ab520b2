"""Evaluates nodes of the expression graph in ball arithmetic: on real balls, on power series of
real balls, and on complex balls.

If a result is undefined, the returned ball is not finite; callers check that. A complex function is
holomorphic on each ball for which its result is finite. The result for a ball that touches a branch
cut is not finite. The arithmetic is Arb's. Reference: F. Johansson, Arb, IEEE Trans. Comput. 66
(2017) 1281-1292.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from operator import methodcaller
from typing import Any

from pkgen.graph.graph import Graph, Node, Symbol
from pkgen.graph.written import Written
from pkgen.system.exits import UsageError

MISSING = (
    "--enclose needs balls of arbitrary precision, which python-flint has and which is not "
    "installed: pip install python-flint"
)


def flint() -> Any:
    """Returns python-flint. Raises UsageError if it is not installed."""
    try:
        import flint as library
    except ImportError:
        raise UsageError(MISSING) from None
    return library


def ball(value: Fraction | int, upper: Fraction | None = None) -> Any:
    """Returns a ball that contains `value`, or all numbers from `value` to `upper`."""
    if upper is not None and upper != value:
        return ball(value).union(ball(upper))
    value = Fraction(value)
    library = flint()
    return library.arb(library.fmpq(value.numerator, value.denominator))


class Reals:
    """Functions of real balls (arb). The functions `enclosed` in functions/row.py call them by
    these names."""

    number = staticmethod(ball)

    @property
    def pi(self) -> Any:
        return flint().arb.pi()

    sin, cos, exp, log, sqrt = map(methodcaller, ("sin", "cos", "exp", "log", "sqrt"))
    asin, acos, atan = map(methodcaller, ("asin", "acos", "atan"))

    def atan2(self, y: Any, x: Any) -> Any:
        return x.nan() if on_cut(y, x) else flint().arb.atan2(y, x)

    def min(self, x: Any, y: Any) -> Any:
        return x.min(y)

    def max(self, x: Any, y: Any) -> Any:
        return x.max(y)

    # For constants only:

    def step(self, x: Any) -> Any:
        return ball(int(x >= 0)) if x >= 0 or x < 0 else x.nan()

    def sign(self, x: Any) -> Any:
        return ball((x > 0) - (x < 0)) if x > 0 or x < 0 or x == 0 else x.nan()


class Series(Reals):
    """Functions of power series (arb_series). A constant may be a real ball (arb)."""

    def atan2(self, y: Any, x: Any) -> Any:
        """Computes atan2 as the integral of its derivative (x y' - y x')/(x^2 + y^2)."""
        library = flint()
        y, x = (a if isinstance(a, library.arb_series) else a + _constant(y, x) for a in (y, x))
        first = super().atan2(y[0], x[0])
        slope = (x * y.derivative() - y * x.derivative()) / (x * x + y * y)
        return first + slope.integral()


def _constant(y: Any, x: Any) -> Any:
    library = flint()
    lengths = [a.prec for a in (y, x) if isinstance(a, library.arb_series)]
    return library.arb_series([0], min(lengths, default=library.ctx.cap))


class Complexes(Reals):
    """Functions of complex balls (acb), not finite if a ball touches the branch cut."""

    def log(self, x: Any) -> Any:
        return _complex(x).log(analytic=True)

    def sqrt(self, x: Any) -> Any:
        return _complex(x).sqrt(analytic=True)

    def _inside(self, value: Any, what: Any) -> Any:
        """Returns `value` if the ball `what` does not touch the branch cut, the nonpositive real
        axis; otherwise returns a nonfinite ball."""
        off = _complex(what).log(analytic=True)
        return value if off.is_finite() else off

    def asin(self, x: Any) -> Any:
        return self._inside(_complex(x).asin(), 1 - x * x)

    def acos(self, x: Any) -> Any:
        return self._inside(_complex(x).acos(), 1 - x * x)

    def atan(self, x: Any) -> Any:
        return self._inside(_complex(x).atan(), 1 + x * x)

    def atan2(self, y: Any, x: Any) -> Any:
        """Returns c + atan(w/u). Here c is the angle of the midpoint of (x, y), and (u, w) is
        (x, y) rotated by -c."""
        y, x = _complex(y), _complex(x)
        if on_cut(y.real, x.real):
            return x * flint().arb.nan()
        c = flint().arb.atan2(y.real.mid(), x.real.mid()).mid()
        u, w = x * c.cos() + y * c.sin(), y * c.cos() - x * c.sin()
        # If the real part of u is positive, then u is not 0 and the ball w/u is on one branch of
        # atan.
        return c + self.atan(w / u) if u.real > 0 else x * flint().arb.nan()


def _complex(x: Any) -> Any:
    library = flint()
    return x if isinstance(x, library.acb) else library.acb(x)


def on_cut(y: Any, x: Any) -> bool:
    """Whether some (y, x) in these real balls is on the branch cut of atan2, or is the origin."""
    return bool(y.contains(0)) and not x > 0


def written(g: Graph, nodes: Iterable[Node], constants: Mapping[Symbol, Any]) -> Written:
    """Returns the nodes as a function that evaluates them in any of these domains."""
    return Written(g, nodes, constants, Reals())
