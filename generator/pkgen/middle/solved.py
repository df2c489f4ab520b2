"""M a = f at one state, with a bound of the error.

An approximate inverse R of M and a solution x, both from the midpoints, give

    |x - a| <= |R (f - M x)| / (1 - |I - R M|)     in the maximum norm, where |I - R M| < 1,

with M and f as the balls that they are. Reference: S. M. Rump, Verification methods: rigorous
results using floating-point arithmetic, Acta Numerica 19 (2010) 287-449, section 10.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..equations import Equations
from .balls import Ball, Balls
from .graph import Graph, Kind, Symbol


def accelerations(
    equations: Equations, g: Graph, balls: Balls, values: Mapping[Symbol, Ball]
) -> dict[Symbol, Ball] | None:
    """By symbol; None where M has no value or is too near to a singular matrix."""
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
    r = [[Ball(inverse[i, j], mp.mpf(0)) for j in range(n)] for i in range(n)]
    minus = balls.number(-1)
    residual = [
        balls.total(
            [force[i], *(balls.product(minus, m, v) for m, v in zip(mass[i], x, strict=True))]
        )
        for i in range(n)
    ]
    away = [
        [
            balls.total(
                [
                    balls.number(-1 if i == j else 0),
                    *(balls.product(r[i][k], mass[k][j]) for k in range(n)),
                ]
            )
            for j in range(n)
        ]
        for i in range(n)
    ]
    contraction = max(sum(entry.most for entry in row) for row in away)
    if contraction >= mp.mpf(1) / 2:
        return None
    corrections = (
        balls.total([balls.product(r[i][k], residual[k]) for k in range(n)]) for i in range(n)
    )
    error = max(entry.most for entry in corrections) / (1 - contraction) * (1 + balls.tiny)
    return {Symbol(Kind.ACCELERATION, i): Ball(x[i].mid, error) for i in range(n)}
