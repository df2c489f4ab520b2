"""Proves that the mass matrix M is positive definite, either by its pivots (the entries of D in M =
L D L^T), or by writing the kinetic energy as a sum of squares."""

from __future__ import annotations

from ...equations import Equations
from ..points.singularities import COORDINATES
from ..points.squares import Positive, definite_by_squares


def definite(equations: Equations) -> bool:
    """Returns whether M is proved positive definite at all states, for all parameters within their
    bounds."""
    e = equations
    if definite_by_squares(e.graph, e.parameters, e.written, len(e.coordinates)):
        return True
    positive = Positive(e.graph.copy(), e.parameters)
    return e.pivots is not None and all(positive(pivot) for pivot, _ in e.pivots)


def singular(equations: Equations) -> tuple[str, ...]:
    """Returns the names of expressions. Where one of these vanishes, the mass matrix M may be
    singular; see points/singularities.py."""
    return tuple(
        singularity.quantity.name
        for singularity in equations.singularities
        if singularity.use == COORDINATES
    )
