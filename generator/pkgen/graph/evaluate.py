"""Values of nodes: floats at a state, exact fractions where there are only rational operations."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction

from ..functions import FUNCTIONS
from .constants import folded
from .differentiate import reachable
from .graph import Graph, Kind, Node, Op, Symbol

BITS = 100_000  # of an exact power

_MATH: dict[str, Callable[..., float]] = {
    name: getattr(math, row.c) for name, row in FUNCTIONS.items() if not row.c.startswith(":")
} | {
    "min": min,
    "max": max,
    "step": lambda x: float(x >= 0),
    "sign": lambda x: float((x > 0) - (x < 0)),
    "reciprocal": lambda x: 1 / x if x else 0.0,
}


def evaluate(g: Graph, nodes: Iterable[Node], values: Mapping[Symbol, float]) -> list[float]:
    """The nodes in floating point. Where one has no value it is nan (an overflow: inf)."""
    nodes = list(nodes)
    known: dict[Node, float] = {}
    for node in reachable(g, nodes):
        known[node] = value_of(g, node, [known[a] for a in g.args[node]], values)
    return [known[node] for node in nodes]


def value_of(g: Graph, node: Node, args: list[float], values: Mapping[Symbol, float]) -> float:
    """One node from the values of its arguments."""
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
        return _MATH[data](*args)
    except ValueError:
        return math.nan
    except (OverflowError, ZeroDivisionError):
        return math.inf


def exact(
    g: Graph, nodes: Iterable[Node], values: Mapping[Symbol, Fraction]
) -> list[Fraction | None]:
    """The nodes as fractions; None where one is not rational or has no value."""
    nodes = list(nodes)
    known: dict[Node, Fraction | None] = {}
    for node in reachable(g, nodes):
        args = [known[a] for a in g.args[node]]
        known[node] = None if None in args else _fraction(g, node, args, values)
    return [known[node] for node in nodes]


def _fraction(
    g: Graph, node: Node, args: list[Fraction], values: Mapping[Symbol, Fraction]
) -> Fraction | None:
    op, data = g.op[node], g.data[node]
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
    return folded(data, args)
