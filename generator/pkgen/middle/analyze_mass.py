"""Where the mass matrix is positive definite, from the pivots of M = L D L^T."""

from __future__ import annotations

from ..equations import Equations
from .graph import Graph, Node
from .guards import COORDINATES, bounds_of
from .normal import Normal, squares_merged
from .ranges import Ranges

WORK = 500  # products of two terms


def definite(equations: Equations) -> bool:
    """Whether each pivot is proved positive, with the parameters within their bounds."""
    if equations.pivots is None:
        return False
    g = equations.graph
    normal = Normal(g, work=WORK)
    ranges = Ranges(g, [bounds_of(g, slot) for slot in equations.parameters])
    return all(_positive(g, ranges, normal, pivot) for pivot in equations.pivots)


def _positive(g: Graph, ranges: Ranges, normal: Normal, pivot: Node) -> bool:
    """m - m cos^2 is seen as m sin^2."""
    if ranges(pivot).positive:
        return True
    polynomial = normal(pivot)
    if polynomial is None:
        return False
    return ranges(normal.plain(squares_merged(g, polynomial))).positive


def singular(equations: Equations) -> tuple[str, ...]:
    """The expressions where whose zeros M may be singular; see `guards.py`."""
    return tuple(guard.quantity.name for guard in equations.guards if guard.use == COORDINATES)
