"""The start on the constraints that is nearest to one that breaks them, in the metric of M.

Positions by Newton's method along M^-1 J^T, and then rates by one such correction, each of least
norm, so that rows may follow from others. Attitudes keep their place."""

from __future__ import annotations

import math

import numpy

from ...equations import Attitude, Row, Rows
from ...graph.differentiate import gradient
from ...graph.evaluate import evaluate
from ...graph.graph import BIT, ZERO, Graph, Kind, Node, Symbol

MOST = 40  # corrections
CLOSE = 1e-10  # beside the largest number: as good as 0


def nearest(
    g: Graph,
    rows: Rows,
    values: dict[Symbol, float],
    lagrangian: Node,
    attitudes: tuple[Attitude, ...],
) -> dict[Symbol, float] | None:
    """Its coordinates and rates that differ; None if none is found."""
    momenta = gradient(g, lagrangian, BIT[Kind.RATE])
    rates = list(momenta)
    turning = {i for a in attitudes for i in a.rates}
    mass = [gradient(g, p, BIT[Kind.RATE]) for p in momenta.values()]
    M = [row.get(rate, ZERO) for row in mass for rate in rates]
    J = [gradient(g, node, BIT[Kind.RATE]) for node in rows.residual]
    entries = [row.get(rate, ZERO) for row in J for rate in rates]
    n, c, h = len(rates), len(J), rows.holonomic
    free = [k for k, rate in enumerate(rates) if g.data[rate].index not in turning]
    places = [Symbol(Kind.COORDINATE, g.data[rates[k]].index) for k in free]
    found = dict(values)

    def step(residual: tuple[Node, ...], columns: list[int]) -> numpy.ndarray:
        here = evaluate(g, [*M, *entries, *residual], found)
        inertia = numpy.array(here[: n * n]).reshape(n, n)
        by = numpy.array(here[n * n : n * (n + c)]).reshape(c, n)[: len(residual), columns]
        root = numpy.linalg.inv(numpy.linalg.cholesky(inertia[numpy.ix_(columns, columns)])).T
        scaled = by @ root
        sizes = numpy.linalg.norm(scaled, axis=1)
        sizes[sizes == 0] = 1.0
        wanted = numpy.array(here[n * (n + c) :]) / sizes
        return root @ numpy.linalg.lstsq(scaled / sizes[:, None], wanted, rcond=1e-10)[0]

    try:
        for _ in range(MOST if h else 0):
            moved = step(rows.positions, free)
            for place, x in zip(places, moved, strict=True):
                found[place] -= float(x)
            if abs(moved).max() <= CLOSE * max(abs(found[place]) for place in places):
                break
        if not _fulfilled(g, rows.positions, found):
            return None
        for _ in range(3):
            for rate, x in zip(rates, step(rows.residual, list(range(n))), strict=True):
                found[g.data[rate]] -= float(x)
    except (numpy.linalg.LinAlgError, ValueError, OverflowError):
        return None
    if not _fulfilled(g, rows.residual, found):
        return None
    largest = {
        kind: max((abs(x) for s, x in found.items() if s.kind is kind), default=0.0)
        for kind in (Kind.COORDINATE, Kind.RATE)
    }
    changed = {}
    for s, x in found.items():
        if s.kind in largest and abs(x - values[s]) > 1e-14 * largest[s.kind]:
            changed[s] = 0.0 if abs(x) < 1e-15 * largest[s.kind] else x
    return changed


def _fulfilled(g: Graph, nodes: Row, values: dict[Symbol, float]) -> bool:
    from ...graph.rounding import sizes

    found = evaluate(g, nodes, values)
    terms = evaluate(g, sizes(g, nodes), values)
    return all(
        math.isfinite(x) and abs(x) <= CLOSE * term for x, term in zip(found, terms, strict=True)
    )
