"""Finds a neighbourhood that no motion leaves in a step, by the theorem of Picard and Lindelof in
complex time.

The equations are y' = F(t, y). Let |F| <= M over the polydisk of radii r around the start, with
R M <= r. Then each motion is holomorphic in the disk |t| < R, and in this disk differs from its
start by at most R M. By Cauchy's estimate the Taylor coefficients of the motion are at most
R M/R^k. The Taylor coefficients of the derivative of the motion with respect to the start are at
most (exp(R L) - 1)/R^k, where L bounds the entries of the Jacobian of F (Gronwall). Reference:
W. Walter, Ordinary Differential Equations, Springer 1998, sections 6, 8 and 9.
"""

from __future__ import annotations

from typing import Any

from pkgen.record import record

from .domains import flint
from .flow import COMPLEX, Flow

ROUNDS = 6
INFLATION = 1.1
SHRINK = 0.8
TRIES = 300


@record
class Neighbourhood:
    radius: Any  # R, the radius of the disk of complex times.
    moved: list[Any]  # R M of each variable, a bound of its distance from the start.
    turned: Any  # The matrix exp(R L) - 1, which bounds derivatives with respect to the start.


def neighbourhood(flow: Flow, t: Any, y: list[Any], tried: Any) -> Neighbourhood | None:
    """Returns a neighbourhood that no motion leaves within a time radius; tries decreasing time
    radii from `tried` on. Returns None if all fail."""
    library = flint()
    for _ in range(TRIES):
        moved = _moved(flow, t, y, tried)
        if moved is not None:
            within = [_around(*x) for x in zip(y, moved, strict=True)]
            bounds = flow.jacobian_bound(_around(t, tried), within)
            turned = (bounds * tried).exp()
            if all(x.is_finite() for x in turned.entries()):
                ones = [[int(i == j) for j in range(flow.size)] for i in range(flow.size)]
                return Neighbourhood(tried, moved, turned - library.arb_mat(ones))
        tried = (tried * SHRINK).mid()
    return None


def _moved(flow: Flow, t: Any, y: list[Any], radius: Any) -> list[Any] | None:
    """Returns R M for the time radius R = `radius`. The radii r of the polydisk are enlarged until
    r >= R M; returns None if that fails."""
    library = flint()
    now = _around(t, radius)
    tried = [library.arb(0) for _ in y]
    for _ in range(ROUNDS):
        around = [_around(*x) for x in zip(y, tried, strict=True)]
        slopes = flow.slopes(COMPLEX, flow.values(now, around))
        moved = [(library.acb(f).abs_upper() * radius).upper() for f in slopes]
        if not all(x.is_finite() for x in moved):
            return None
        if all(a <= b for a, b in zip(moved, tried, strict=True)):
            return moved
        tried = [(x * INFLATION).upper() for x in moved]
    return None


def _around(x: Any, radius: Any) -> Any:
    """Returns the real ball, enlarged by `radius` in real and imaginary direction."""
    library = flint()
    both = library.arb(0, radius)
    return library.acb(x + both, both)
