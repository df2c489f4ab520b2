"""Proves that M is positive definite, by writing the kinetic energy T as a sum of nonnegative terms
that all vanish only if all rates are 0.

This is simpler than the test of the pivots of M for a chain of links: the pivots are long
expressions, but the terms of T for each link have only a few rates in addition to those of the
links before."""

from __future__ import annotations

from collections.abc import Iterable

from ...equations import ParameterSlot
from ...functions.interval import INF, Range
from ...graph.differentiate import Forward, reachable
from ...graph.graph import BIT, ONE, ZERO, Graph, Kind, Node, Op, Symbol
from ...graph.normal import Normal, squares_merged
from ...graph.ranges import Ranges

RATES = BIT[Kind.RATE]
# The largest number of products of two terms that are computed for one normal form.
WORK = 500
# The largest number of rates that one term may prove to be 0.
SEVERAL = 3

Matrix = list[list[Node]]


def definite_by_squares(
    g: Graph, parameters: tuple[ParameterSlot, ...], lagrangian: Node, count: int
) -> bool:
    """Returns whether the kinetic energy T is proved positive definite in the rates. If no term of
    T is negative and T = 0, all terms are 0. If a term is positive definite in those of its rates
    that are not yet known to be 0, these rates are 0 too. This step is repeated until all rates are
    known to be 0, or no term gives a further rate."""
    g = g.copy()
    positive = Positive(g, parameters)
    degree, rates = _degrees_and_rates(g, lagrangian)
    terms = [node for node in summands(g, lagrangian) if node in degree]
    if any(degree[node] > 2 for node in terms):
        return False
    if not all(positive.ranges(node).not_negative for node in terms):
        return False
    found, waiting = 0, True
    while waiting:
        waiting = False
        for node in terms:
            rest = rates[node] & ~found
            if not 0 < rest.bit_count() <= SEVERAL:
                continue
            left = [i for i in range(rest.bit_length()) if rest >> i & 1]
            if positive(determinant(g, _hessian(g, node, left))):
                found |= rest
                waiting = True
    return found == (1 << count) - 1


class Positive:
    """Tests whether a node is proved positive at all states. Before interval arithmetic is used,
    m - m cos^2 is rewritten as m sin^2."""

    def __init__(self, g: Graph, parameters: Iterable[ParameterSlot]):
        self.graph = g
        self.ranges = Ranges(g, [bounds_of(g, slot) for slot in parameters])

    def __call__(self, node: Node) -> bool:
        if self.ranges(node).positive:
            return True
        normal = Normal(self.graph, work=WORK)
        polynomial = normal(node)
        if polynomial is None:
            return False
        merged = squares_merged(self.graph, polynomial)
        return self.ranges(normal.plain(merged)).positive


def _degrees_and_rates(g: Graph, output: Node) -> tuple[dict[Node, float], dict[Node, int]]:
    """Returns two maps from the nodes with rates: to their degree in the rates (inf if a node, as
    written, is no polynomial in the rates), and to their rates as a bit mask."""
    degree: dict[Node, float] = {}
    rates: dict[Node, int] = {}
    for node in reachable(g, [output], RATES):
        of = [degree.get(a, 0) for a in g.args[node]]
        rates[node] = 0
        for a in g.args[node]:
            rates[node] |= rates.get(a, 0)
        if g.op[node] is Op.SYMBOL:
            degree[node], rates[node] = 1, 1 << g.data[node].index
        elif g.op[node] is Op.ADD:
            degree[node] = max(of)
        elif g.op[node] is Op.MULTIPLY:
            degree[node] = sum(of)
        elif g.op[node] is Op.POWER and g.data[node] == 2:
            degree[node] = 2 * of[0]
        else:
            degree[node] = INF
    return degree, rates


def _hessian(g: Graph, term: Node, rates: list[int]) -> Matrix:
    """Returns the matrix of second derivatives of a term by the given rates."""
    by = [g.symbol(Symbol(Kind.RATE, i)) for i in rates]
    along = [Forward(g, RATES, lambda n, own=v: ONE if n == own else ZERO) for v in by]
    return [[second(first(term)) for second in along] for first in along]


def bounds_of(g: Graph, slot: ParameterSlot) -> Range:
    lo = -INF if slot.lo is None or g.value(slot.lo) is None else float(g.value(slot.lo))
    hi = INF if slot.hi is None or g.value(slot.hi) is None else float(g.value(slot.hi))
    return Range(lo, hi, slot.lo_open, slot.hi_open)


def summands(g: Graph, node: Node) -> list[Node]:
    """Returns the terms of a sum. A term that is a sum itself is replaced by its terms."""
    terms, stack = [], [node]
    while stack:
        part = stack.pop()
        if g.op[part] is Op.ADD:
            stack.extend(g.args[part])
        else:
            terms.append(part)
    return terms


def determinant(g: Graph, rows: Matrix) -> Node:
    """Returns the determinant of a matrix, by expansion along the first row."""
    if not rows:
        return ONE
    total = ZERO
    for j, entry in enumerate(rows[0]):
        if entry != ZERO:
            minor = determinant(g, [[*row[:j], *row[j + 1 :]] for row in rows[1:]])
            term = g.multiply(entry, minor)
            total = g.subtract(total, term) if j % 2 else g.add(total, term)
    return total
