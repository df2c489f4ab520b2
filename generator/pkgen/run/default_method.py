"""The default method of a run."""

from __future__ import annotations

from ..equations import Equations, Facts
from ..middle.loops.loops import LoopEquations

# Measured over the models: above this rtol, dop853 reaches the same error faster than gauss.
GAUSS_RTOL = 1e-5
EXPONENTIAL_MOST = 64  # most coordinates: a step of it multiplies by a full matrix


def default_method(
    equations: Equations | LoopEquations, structure: Facts, rtol: float, exact: bool
) -> str:
    """Returns the method for all coordinates or a part. With `exact`, a small linear system with
    constant coefficients gets its exact flow, in steps short enough to detect events.

    gauss is the fastest method for smooth equations and tight tolerances; its error estimate is
    invalid across a kink. A long chain has fast oscillations of small amplitude: the iteration of
    gauss, not its error, would limit the step size, and its stages would not fit into the cache.
    Sums over all pairs have no such neighbours, so gauss pays off."""
    by_gauss = structure.smooth_in_pieces and rtol <= GAUSS_RTOL
    if isinstance(equations, LoopEquations):
        return "gauss" if equations.force.pairs and by_gauss else "dop853"
    few = len(equations.coordinates) + len(equations.states) <= EXPONENTIAL_MOST
    if exact and structure.affine and few:
        return "exponential"
    return "gauss" if by_gauss else "dop853"
