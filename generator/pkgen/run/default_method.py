"""The method of a run that names none."""

from __future__ import annotations

from ..equations import Equations, Facts
from ..middle.loops.loops import LoopEquations

# Measured over the models: above it dop853 takes less time to the same error than gauss.
GAUSS_RTOL = 1e-5
EXPONENTIAL_MOST = 64  # coordinates: a step of it is a product with a full matrix


def default_method(
    equations: Equations | LoopEquations, structure: Facts, rtol: float, exact: bool
) -> str:
    """For all coordinates or those of a part. A linear system with constant coefficients has an
    exact flow, unless it is large. Events are found on it, by steps short enough to see them.

    gauss is the fastest where the equations are smooth and the tolerance is not loose; across a
    kink its error estimate means nothing. A long chain oscillates faster than it visibly moves, so
    that the iteration of gauss, not its error, limits its steps, and all its stages do not fit a
    cache; pair sums have no such neighbours and repay it."""
    by_gauss = structure.smooth_in_pieces and rtol <= GAUSS_RTOL
    if isinstance(equations, LoopEquations):
        return "gauss" if equations.force.pairs and by_gauss else "dop853"
    few = len(equations.coordinates) + len(equations.states) <= EXPONENTIAL_MOST
    if exact and structure.affine and few:
        return "exponential"
    return "gauss" if by_gauss else "dop853"
