"""Where the mass matrix is positive definite: from the pivots of M = L D L^T, or from T as a sum
of squares. Of a chain of links the pivots are long, but each link's term of T has one rate more.
"""

from __future__ import annotations

from ...equations import Equations
from ...graph.differentiate import Columns, reachable, symbols_in
from ...graph.graph import BIT, ZERO, Graph, Kind, Node, Op, Symbol
from ...graph.normal import Normal, squares_merged
from ...graph.ranges import Ranges
from ..points.singularities import COORDINATES, bounds_of, summands
from .along import determinant

RATES = BIT[Kind.RATE]
WORK = 500  # products of two terms
SEVERAL = 3  # rates that one term adds


def definite(equations: Equations) -> bool:
    """Whether that is proved everywhere, with the parameters within their bounds."""
    g = equations.graph.copy()
    ranges = Ranges(g, [bounds_of(g, slot) for slot in equations.parameters])
    pivots = equations.pivots
    if pivots is not None:
        normal = Normal(g, work=WORK)
        if all(_positive(g, ranges, normal, pivot) for pivot, _ in pivots):
            return True
    return _by_squares(g, ranges, equations)


def _by_squares(g: Graph, ranges: Ranges, e: Equations) -> bool:
    """Where no term of T is negative, v.M v = 0 makes each of them 0. If all rates of a term but
    some are known to be 0 then, and it is definite in these, so are they: go on until all are."""
    terms = [node for node in summands(g, e.written) if g.depends[node] & RATES]
    if not all(ranges(node).not_negative for node in terms) or not _quadratic(g, terms):
        return False
    left = [{s.index for s in symbols_in(g, [node], RATES)} for node in terms]
    waiting, found = True, set()
    while waiting:
        waiting = False
        for node, rates in zip(terms, left, strict=True):
            rest = sorted(rates - found)
            if rest and len(rest) <= SEVERAL and _definite_in(g, ranges, node, rest):
                found |= rates
                waiting = True
    return len(found) == len(e.coordinates)


def _quadratic(g: Graph, nodes: list[Node]) -> bool:
    """Whether nodes are polynomials of the second degree in the rates, as they stand."""
    degree: dict[Node, float] = {}
    for node in reachable(g, nodes, RATES):
        of = [degree.get(a, 0) for a in g.args[node]]
        if g.op[node] is Op.SYMBOL:
            degree[node] = 1
        elif g.op[node] is Op.ADD:
            degree[node] = max(of)
        elif g.op[node] is Op.MULTIPLY:
            degree[node] = sum(of)
        elif g.op[node] is Op.POWER and g.data[node] == 2:
            degree[node] = 2 * of[0]
        else:
            return False
    return all(degree[node] <= 2 for node in nodes)


def _definite_in(g: Graph, ranges: Ranges, term: Node, rates: list[int]) -> bool:
    """By the second derivatives of a term that is nowhere negative: their determinant decides."""
    v = [g.symbol(Symbol(Kind.RATE, i)) for i in rates]
    slopes = [Columns(g, [term], RATES).column(x)[term] for x in v]
    again = Columns(g, slopes, RATES)
    matrix = [[again.column(x).get(slope, ZERO) for x in v] for slope in slopes]
    return _positive(g, ranges, Normal(g, work=WORK), determinant(g, matrix))


def _positive(g: Graph, ranges: Ranges, normal: Normal, node: Node) -> bool:
    """m - m cos^2 is seen as m sin^2."""
    if ranges(node).positive:
        return True
    polynomial = normal(node)
    if polynomial is None:
        return False
    return ranges(normal.plain(squares_merged(g, polynomial))).positive


def singular(equations: Equations) -> tuple[str, ...]:
    """The expressions where whose zeros M may be singular; see `singularities.py`."""
    return tuple(
        singularity.quantity.name
        for singularity in equations.singularities
        if singularity.use == COORDINATES
    )
