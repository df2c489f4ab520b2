"""Ranges of expressions by interval arithmetic on the graph.

Coordinates, rates, time and inputs are unbounded; parameters have their declared bounds. An end
point may be excluded: with m > 0, m x^2 + m is positive, not only nonnegative. A range contains all
values, but may be too wide: interval arithmetic does not detect that x - x is 0.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..functions import FUNCTIONS
from ..functions.interval import ANY, INF, POSITIVE, Range
from .differentiate import unknown
from .graph import Graph, Kind, Node, Op


class Ranges:
    """Computes the ranges of nodes. `parameters` holds the ranges of the parameters, by index."""

    def __init__(self, g: Graph, parameters: Sequence[Range]):
        self.graph = g
        self.parameters = parameters
        self.known: dict[Node, Range] = {}

    def __call__(self, output: Node) -> Range:
        for node in unknown(self.graph.args.__getitem__, [output], self.known):
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
        return FUNCTIONS[data].interval(*args)


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
