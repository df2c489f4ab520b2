"""Evaluates nodes at given values of the symbols, in floats or, where possible, in fractions."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from contextlib import suppress
from fractions import Fraction

from ..functions import FUNCTIONS
from .differentiate import reachable, swept
from .graph import Graph, Kind, Node, Op, Symbol
from .written import Written

# Expressions with fewer nodes than this are compiled to a Python function.
COMPILED = 5_000
_UNDEFINED = ValueError, OverflowError, ZeroDivisionError
# The largest number of bits of a power that is evaluated exactly.
BITS = 100_000


def evaluate(g: Graph, nodes: Iterable[Node], values: Mapping[Symbol, float]) -> list[float]:
    """Returns the values of the nodes as floats; nan where a node is undefined, inf on overflow."""
    return swept(g, nodes, lambda node, args: value_of(g, node, args, values))


class Evaluator:
    """Evaluates nodes in floating point at many states. Fewer than COMPILED nodes are compiled once
    to a Python function; for more nodes compilation would take longer than it saves."""

    def __init__(self, g: Graph, nodes: Iterable[Node]):
        self.graph, self.nodes = g, list(nodes)
        self._written: Written | None = None
        if len(reachable(g, self.nodes)) < COMPILED:
            with suppress(*_UNDEFINED):
                self._written = Written(g, self.nodes, None, field="real")

    def __call__(self, values: Mapping[Symbol, float]) -> list[float]:
        """Returns the values of the nodes, as evaluate() does."""
        if self._written:
            with suppress(*_UNDEFINED):
                return self._written(None, values)
        return evaluate(self.graph, self.nodes, values)


def value_of(g: Graph, node: Node, args: list[float], values: Mapping[Symbol, float]) -> float:
    """Returns the value of a node as a float, given the values of its arguments."""
    op, data = g.op[node], g.data[node]
    try:
        if op is Op.NUMBER:
            return float(data)
        if op is Op.SYMBOL:
            return math.pi if data.kind is Kind.PI else float(values[data])
        if op is Op.ADD:
            return args[0] + args[1]
        if op is Op.MULTIPLY:
            return args[0] * args[1]
        if op is Op.POWER:
            return math.pow(args[0], float(data))
        return FUNCTIONS[data].real(*args)
    except ValueError:
        return math.nan
    except (OverflowError, ZeroDivisionError):
        return math.inf


def exact(
    g: Graph, nodes: Iterable[Node], values: Mapping[Symbol, Fraction]
) -> list[Fraction | None]:
    """Returns the values of the nodes as fractions; None for an irrational or undefined value."""
    return swept(g, nodes, lambda node, args: _fraction(g, node, args, values))


def _fraction(
    g: Graph, node: Node, args: list[Fraction | None], values: Mapping[Symbol, Fraction]
) -> Fraction | None:
    op, data = g.op[node], g.data[node]
    if None in args:
        return None
    if op is Op.NUMBER:
        return data
    if op is Op.SYMBOL:
        return values.get(data)
    if op is Op.ADD:
        return args[0] + args[1]
    if op is Op.MULTIPLY:
        return args[0] * args[1]
    if op is Op.POWER:
        size = args[0].numerator.bit_length() + args[0].denominator.bit_length()
        possible = data.denominator == 1 and (args[0] != 0 or data > 0)
        return args[0] ** int(data) if possible and size * abs(data) < BITS else None
    return FUNCTIONS[data].exact(*args)
