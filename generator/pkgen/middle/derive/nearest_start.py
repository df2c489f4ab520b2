"""Finds initial values that satisfy the constraints, close to given values that do not, and writes
them as text for the model. Distances are measured in the metric of M."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ...equations import Attitude, Rows
from ...graph.differentiate import gradient
from ...graph.evaluate import evaluate
from ...graph.graph import BIT, ZERO, Graph, Kind, Node, Symbol
from ..quantities import symbols

CORRECTIONS = 50
CLOSE = 1e-13  # tolerance of Newton's method, relative to the largest number of the start


def nearest_start(
    g: Graph,
    c: Rows,
    lagrangian: Node,
    values: dict[Symbol, float],
    attitudes: tuple[Attitude, ...],
    name: Callable[[Symbol], str],
) -> tuple[dict[Symbol, float], str]:
    """Returns initial values of all symbols, and a `start` statement with those of all coordinates
    and rates; ({}, "") if Newton's method fails.

    Attitudes are not changed. Each correction is the shortest one in the metric of M at the start.
    """
    import numpy as np

    values = dict(values)
    count = 1 + max(s.index for s in values if s.kind is Kind.RATE)
    rates = symbols(g, Kind.RATE, count)
    turning = {i for a in attitudes for i in a.rates}
    fixed = [i in turning for i in range(count)]

    def rows(nodes: Sequence[Node]) -> np.ndarray:
        slopes = [gradient(g, node, BIT[Kind.RATE]) for node in nodes]
        entries = [row.get(rate, ZERO) for row in slopes for rate in rates]
        return np.array(evaluate(g, entries, values)).reshape(len(nodes), count)

    by_rate = gradient(g, lagrangian, BIT[Kind.RATE])
    M = rows([by_rate.get(rate, ZERO) for rate in rates])
    J = rows(c.residual)
    if not (np.isfinite(M).all() and np.isfinite(J).all()):
        return {}, ""
    sizes, turns = np.linalg.eigh((M + M.T) / 2)
    if not sizes[0] > 0:
        return {}, ""
    root = turns / np.sqrt(sizes)  # root root^T is the inverse of M

    def corrected(
        residual: Sequence[Node], nodes: Sequence[Node], kind: Kind, kept: Sequence[bool]
    ) -> bool:
        symbols = [Symbol(kind, i) for i in range(count)]
        for _ in range(CORRECTIONS):
            J = np.where(kept, 0.0, rows(nodes))
            off = np.array(evaluate(g, residual, values))
            if not (np.isfinite(J).all() and np.isfinite(off).all()):
                return False
            step = root @ np.linalg.lstsq(J @ root, -off, rcond=1e-10)[0]
            step = np.where(kept, 0.0, step)
            for symbol, x in zip(symbols, step, strict=True):
                values[symbol] = values.get(symbol, 0.0) + x
            largest = max(1e-300, *(abs(values[s]) for s in symbols))
            if np.abs(step).max() <= CLOSE * largest:
                return bool(np.abs(off).max() <= 1e-9 * max(1e-300, np.abs(J).max()) * largest)
        return False

    held = c.holonomic
    if held and not corrected(c.positions[:held], c.residual[:held], Kind.COORDINATE, fixed):
        return {}, ""
    if not corrected(c.residual, c.residual, Kind.RATE, [False] * count):
        return {}, ""
    energy = np.sqrt(M.diagonal())

    def written(kind: Kind, i: int) -> str:
        """Returns the value of coordinate or rate i as text. Compares it to the largest value of
        all coordinates or rates, after scaling all values with M. A value so small that it may be a
        rounding error becomes 0."""
        far = max(energy[k] * abs(values.get(Symbol(kind, k), 0.0)) for k in range(count))
        x = values.get(Symbol(kind, i), 0.0)
        return f"{x if energy[i] * abs(x) > CLOSE * far else 0.0:.15g}"

    items = []
    for i in range(count):
        of_place, of_rate = Symbol(Kind.COORDINATE, i), Symbol(Kind.RATE, i)
        if not fixed[i]:
            items.append(f"{name(of_place)} = {written(Kind.COORDINATE, i)}")
            items.append(f"{name(of_rate)} = {written(Kind.RATE, i)}")
    for a in attitudes:
        rotation = name(Symbol(Kind.RATE, a.rate)).removesuffix(".x")
        numbers = ", ".join(written(Kind.RATE, i) for i in a.rates)
        items.append(f"{rotation} = [{numbers}]")
    return values, "start " + ", ".join(items)
