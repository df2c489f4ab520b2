"""Ball arithmetic on the graph: each value is a midpoint and a radius that bounds its error.

Each operation adds its rounding error to the error propagated from its arguments, so the true
value lies in the ball. The value is None where no bound exists: for a division by a ball that
contains 0, a logarithm of such a ball, a step at its jump.
References: S. M. Rump, Fast and parallel interval arithmetic, BIT 39 (1999) 534-554; F. Johansson,
Arb, IEEE Trans. Comput. 66 (2017) 1281-1292.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import Any, NamedTuple

from ..functions import FUNCTIONS
from .differentiate import swept
from .graph import Graph, Kind, Node, Op, Symbol

BITS = 200
LARGE = 10_000  # the largest integer exponent of a power that is evaluated


class Ball(NamedTuple):
    mid: Any  # numbers of mpmath
    rad: Any

    @property
    def least(self) -> Any:
        """A lower bound of |x| for all x in the ball."""
        return max(abs(self.mid) - self.rad, 0)

    @property
    def most(self) -> Any:
        """An upper bound of |x| for all x in the ball."""
        return abs(self.mid) + self.rad


class Balls:
    """Ball arithmetic of a fixed precision. Operations return None where no bound exists."""

    def __init__(self, bits: int = BITS):
        from mpmath import MPContext

        self.mp = MPContext()
        self.mp.prec = bits
        self.tiny = self.mp.ldexp(1, 4 - bits)

    def number(self, value: Fraction | int) -> Ball:
        value = Fraction(value)
        return self._rounded(self.mp.mpf(value.numerator) / value.denominator, 0)

    def product(self, *factors: Ball) -> Ball:
        result = Ball(self.mp.mpf(1), self.mp.mpf(0))
        for factor in factors:
            result = self._times(result, factor)
        return result

    def total(self, terms: Iterable[Ball]) -> Ball:
        result = Ball(self.mp.mpf(0), self.mp.mpf(0))
        for term in terms:
            result = self._rounded(result.mid + term.mid, result.rad + term.rad)
        return result

    def values(
        self, g: Graph, nodes: Iterable[Node], symbols: Mapping[Symbol, Ball]
    ) -> list[Ball | None]:
        """Evaluates the nodes in ball arithmetic at the given values of the symbols."""
        return swept(g, nodes, lambda node, args: self._value(g, node, args, symbols))

    def _value(
        self, g: Graph, node: Node, args: list[Ball | None], symbols: Mapping[Symbol, Ball]
    ) -> Ball | None:
        op, data = g.op[node], g.data[node]
        if None in args:
            return None
        if op is Op.NUMBER:
            return self.number(data)
        if op is Op.SYMBOL:
            return self._rounded(self.mp.pi(), 0) if data.kind is Kind.PI else symbols[data]
        if op is Op.ADD:
            return self._rounded(args[0].mid + args[1].mid, args[0].rad + args[1].rad)
        if op is Op.MULTIPLY:
            return self._times(*args)
        if op is Op.POWER:
            if data.denominator == 1:
                return self._whole(args[0], int(data))
            return self.pow(args[0], self.number(data))
        return FUNCTIONS[data].ball(self, *args)

    def _rounded(self, mid: Any, rad: Any) -> Ball | None:
        if not self.mp.isfinite(mid):
            return None
        return Ball(mid, (rad + abs(mid) * self.tiny) * (1 + self.tiny))

    def _times(self, a: Ball, b: Ball) -> Ball | None:
        return self._rounded(a.mid * b.mid, a.most * b.rad + a.rad * abs(b.mid))

    def _whole(self, base: Ball, exponent: int) -> Ball | None:
        result: Ball | None = Ball(self.mp.mpf(1), self.mp.mpf(0))
        for _ in range(min(abs(exponent), LARGE)):
            result = result and self._times(result, base)
        if abs(exponent) > LARGE:
            return None
        return self.inverse(result) if exponent < 0 else result

    def inverse(self, x: Ball | None) -> Ball | None:
        if x is None or not x.least > 0:
            return None
        return self._rounded(1 / x.mid, x.rad / (x.least * abs(x.mid)))

    def quotient(self, a: Ball | None, b: Ball | None) -> Ball | None:
        inverse = self.inverse(b)
        return None if a is None or inverse is None else self._times(a, inverse)

    def slope(self, function: Callable, x: Ball, steepest: Any) -> Ball | None:
        return self._rounded(function(x.mid), x.rad * steepest)

    def turning(self, function: Callable, x: Ball) -> Ball | None:
        # For a radius of 1 or more, a sine or cosine has no useful bounds.
        return self.slope(function, x, 1) if x.rad < 1 else None

    def growing(self, function: Callable, slope: Callable, x: Ball) -> Ball | None:
        if x.rad > 1:
            return None
        end = x.mid + x.rad if function is self.mp.exp else x.most
        return self.slope(function, x, slope(end) * (1 + self.tiny))

    def arc(self, function: Callable, x: Ball) -> Ball | None:
        left = 1 - x.most
        return self.slope(function, x, 1 / self.mp.sqrt(left)) if left > 0 else None

    def exp(self, x: Ball) -> Ball | None:
        return self.growing(self.mp.exp, self.mp.exp, x)

    def log(self, x: Ball) -> Ball | None:
        return self.slope(self.mp.log, x, 1 / x.least) if x.mid > 0 and x.least > 0 else None

    def sqrt(self, x: Ball) -> Ball | None:
        if x == (0, 0):
            return x
        if not (x.mid > 0 and x.least > 0):
            return None
        return self.slope(self.mp.sqrt, x, 1 / self.mp.sqrt(x.least))

    def atan2(self, y: Ball, x: Ball) -> Ball | None:
        """Returns atan2(y, x); None if (x, y) may be the origin or lie on the branch cut."""
        from_origin = self.mp.hypot(y.mid, x.mid) - y.rad - x.rad
        if not from_origin > 0 or (x.mid <= x.rad and abs(y.mid) <= y.rad):
            return None
        return self._rounded(self.mp.atan2(y.mid, x.mid), (y.rad + x.rad) / from_origin)

    def pick(self, choose: Callable, x: Ball, y: Ball) -> Ball:
        return Ball(choose(x.mid, y.mid), max(x.rad, y.rad))

    def chosen(self, x: Ball, values: tuple[int, int, int]) -> Ball | None:
        if x.rad >= abs(x.mid) and x != (0, 0):
            return None
        return self.number(values[(x.mid > 0) - (x.mid < 0) + 1])

    def floor(self, x: Ball) -> Ball | None:
        lo, hi = self.mp.floor(x.mid - x.rad), self.mp.floor(x.mid + x.rad)
        return self.number(int(lo)) if lo == hi else None

    def pow(self, base: Ball, exponent: Ball) -> Ball | None:
        log = self.log(base)
        power = None if log is None else self._times(log, exponent)
        return None if power is None else self.exp(power)
