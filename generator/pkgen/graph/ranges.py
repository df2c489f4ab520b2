"""Where the values of an expression can lie, by interval arithmetic on the graph.

Coordinates, rates, time and inputs may be anything, parameters what their bounds say. An end may
be excluded: m > 0 makes m x^2 + m positive and not only not negative. A range is what is proved;
the values may fill less of it, since x - x is not seen to be 0 here.
Reference: R. E. Moore, Interval Analysis, Prentice-Hall 1966.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from .graph import Graph, Kind, Node, Op

INF = math.inf
ROUND = 1e-12  # of the ends, which are computed in floating point


@dataclass(frozen=True)
class Range:
    lo: float = -INF
    hi: float = INF
    above: bool = False  # lo itself is excluded, though it may be 0
    below: bool = False

    @property
    def positive(self) -> bool:
        return self.lo > ROUND or (self.lo == 0 and self.above)

    @property
    def not_negative(self) -> bool:
        return self.lo >= 0

    @property
    def never_zero(self) -> bool:
        return self.positive or (-self).positive

    def __neg__(self) -> Range:
        return Range(-self.hi, -self.lo, self.below, self.above)

    def __add__(self, other: Range) -> Range:
        return Range(
            self.lo + other.lo,
            self.hi + other.hi,
            self.above or other.above,
            self.below or other.below,
        )

    def __mul__(self, other: Range) -> Range:
        corners = [_corner(*x, *y) for x in self._ends() for y in other._ends()]
        lo, hi = min(x for x, _ in corners), max(x for x, _ in corners)
        return Range(
            lo,
            hi,
            all(excluded for x, excluded in corners if x == lo),
            all(excluded for x, excluded in corners if x == hi),
        )

    def _ends(self) -> tuple[tuple[float, bool], tuple[float, bool]]:
        return (self.lo, self.above), (self.hi, self.below)


def _corner(x: float, x_excluded: bool, y: float, y_excluded: bool) -> tuple[float, bool]:
    """A product of two ends, and whether it is not reached."""
    if x == 0 or y == 0:  # 0 times infinity too: the ends are limits
        return 0.0, (x != 0 or x_excluded) and (y != 0 or y_excluded)
    return x * y, x_excluded or y_excluded


ANY = Range()
UNIT = Range(-1, 1)
NOT_NEGATIVE = Range(0)
POSITIVE = Range(0, above=True)

_CALLS = {
    "sin": UNIT,
    "cos": UNIT,
    "tanh": UNIT,
    "sign": UNIT,
    "cosh": Range(1),
    "exp": POSITIVE,
    "step": Range(0, 1),
    "atan": Range(-math.pi / 2, math.pi / 2),
    "asin": Range(-math.pi / 2, math.pi / 2),
    "acos": Range(0, math.pi),
}


class Ranges:
    """The range of any node; `parameters` are those of the parameters."""

    def __init__(self, g: Graph, parameters: Sequence[Range]):
        self.graph = g
        self.parameters = parameters
        self.known: dict[Node, Range] = {}

    def __call__(self, output: Node) -> Range:
        new, found = set(), {output} - self.known.keys()
        while found:
            new |= found
            found = {a for node in found for a in self.graph.args[node]} - self.known.keys() - new
        for node in sorted(new):
            self.known[node] = self._range(node)
        return self.known[output]

    def _range(self, node: Node) -> Range:
        g = self.graph
        op, data = g.op[node], g.data[node]
        args = [self.known[a] for a in g.args[node]]
        if op is Op.NUMBER:
            return Range(float(data), float(data))
        if op is Op.SYMBOL:
            if data.kind is Kind.PI:
                return Range(3, 4)
            return self.parameters[data.index] if data.kind is Kind.PARAMETER else ANY
        if op is Op.ADD:
            return args[0] + args[1]
        if op is Op.MULTIPLY:
            same = g.args[node][0] == g.args[node][1]
            return _power(args[0], 2) if same else args[0] * args[1]
        if op is Op.POWER:
            return _power(args[0], data)
        return _call(data, args)


def _power(base: Range, exponent: float) -> Range:
    if exponent < 0:
        if base.positive:
            return POSITIVE
        odd = exponent == int(exponent) and int(exponent) % 2
        return Range(hi=0, below=True) if odd and (-base).positive else (ANY if odd else POSITIVE)
    if exponent != int(exponent):
        return Range(0, above=base.positive)
    if int(exponent) % 2 == 0:
        return Range(0, _end(max(abs(base.lo), abs(base.hi)), exponent), base.never_zero)
    return Range(_end(base.lo, exponent), _end(base.hi, exponent), base.above, base.below)


def _end(x: float, exponent: float) -> float:
    try:
        return x ** int(exponent)
    except OverflowError:
        return INF if x > 0 or int(exponent) % 2 == 0 else -INF


def _call(function: str, args: list[Range]) -> Range:
    first = args[0]
    if function in ("sqrt", "abs"):
        nonzero = first.positive if function == "sqrt" else first.never_zero
        return POSITIVE if nonzero else NOT_NEGATIVE
    if function == "pow":
        return POSITIVE if first.positive else ANY
    if function == "reciprocal":
        return POSITIVE if first.positive else NOT_NEGATIVE if first.not_negative else ANY
    if function in ("sinh", "tan", "atan2", "log"):
        return POSITIVE if function == "sinh" and first.positive else ANY
    if function in ("min", "max"):
        pick = min if function == "min" else max
        return Range(pick(x.lo for x in args), pick(x.hi for x in args))
    return _CALLS.get(function, ANY)
