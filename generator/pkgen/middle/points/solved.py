"""Solves M a = f at one state in ball arithmetic, with a rigorous bound of the error.

The entries of M and f are balls (midpoint, radius). Let R be an approximate inverse of M, and x an
approximate solution, both computed from the midpoints. Then, in the maximum norm,

    |x - a| <= |R| |f - M x| / (1 - |I - R M|)     if |I - R M| < 1.

Reference: S. M. Rump, Verification methods: rigorous results using floating-point arithmetic,
Acta Numerica 19 (2010) 287-449, section 10.
"""

from __future__ import annotations

from collections.abc import Mapping

from ...equations import Equations
from ...graph.balls import Ball, Balls
from ...graph.graph import Graph, Kind, Symbol


def accelerations(
    equations: Equations, g: Graph, balls: Balls, values: Mapping[Symbol, Ball]
) -> dict[Symbol, Ball] | None:
    """Returns the accelerations by symbol; None if an entry of M or f has no value, or if M may be
    nearly singular."""
    n = len(equations.force)
    entries = balls.values(g, [*sum(equations.mass, ()), *equations.force], values)
    if None in entries:
        return None
    mass = [entries[i * n : (i + 1) * n] for i in range(n)]
    force = entries[n * n :]
    mp = balls.mp
    matrix = mp.matrix([[entry.mid for entry in row] for row in mass])
    try:
        inverse = matrix**-1
    except ZeroDivisionError:
        return None
    x = [Ball(value, mp.mpf(0)) for value in inverse * mp.matrix([f.mid for f in force])]
    minus = balls.number(-1)
    residual = [
        balls.total([f, *(balls.product(minus, m, v) for m, v in zip(row, x, strict=True))])
        for row, f in zip(mass, force, strict=True)
    ]
    size = mp.mnorm(inverse, mp.inf)
    # A bound of the rounding errors of the product inverse * matrix, plus the radii of the entries
    # of M.
    blur = n * balls.tiny * mp.mnorm(matrix, mp.inf) + max(sum(m.rad for m in row) for row in mass)
    contraction = mp.mnorm(inverse * matrix - mp.eye(n), mp.inf) + size * blur
    if contraction >= mp.mpf(1) / 2:
        return None
    error = size * max(entry.most for entry in residual) / (1 - contraction) * (1 + balls.tiny)
    return {Symbol(Kind.ACCELERATION, i): Ball(x[i].mid, error) for i in range(n)}
