"""Checks that a model's start satisfies its constraints, and that their rows are independent there.

The values are the model's starts and defaults. The runtime checks values from options by the same
rules (src/constraints/constraint.c). Constraints with an input cannot be checked before a run.
Rates in metres and in radians are scaled by their kinetic energies, with the diagonal of M.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import replace

from ...equations import Attitude, ParameterSlot, Row, Rows
from ...graph.differentiate import gradient
from ...graph.evaluate import evaluate
from ...graph.graph import BIT, ZERO, Graph, Kind, Node, Symbol
from ...graph.rounding import sizes
from ...record import record
from ...source import Diagnostic
from ..points.samples import started
from .nearest_start import nearest_start

EPS = sys.float_info.epsilon
WRITTEN = 1e-8  # tolerance relative to the terms: starts are written with a limited precision
DEBRIS = 64 * EPS  # rounding error of a zero, relative to the largest number of the start
SWEEPS = 3  # scaling sweeps over rows and columns
ROUNDING = 1e-12  # entries smaller in their row may be rounding errors: they scale no column
SMALL = 1e-9  # rows with smaller entries may be rounding errors
DEPENDENT = math.sqrt(16 * EPS)  # relative rest of a row orthogonal to others; squared, a pivot


@record
class Start:
    """Values at the start, and the length of a unit of each rate in the metric of M."""

    values: dict[Symbol, float]
    unit: dict[Node, float]
    far: float  # the largest coordinate in this metric; attitudes count as 1
    fast: float  # the largest rate


def at_the_start(
    g: Graph,
    c: Rows | None,
    parameters: tuple[ParameterSlot, ...],
    starts: tuple[Row, Row, Row],
    lagrangian: Node,
    attitudes: tuple[Attitude, ...],
    name: Callable[[Symbol], str],
) -> tuple[Rows | None, list[Diagnostic]]:
    """Returns the rows, redundant ones set apart, and errors: constraints that the start violates,
    or whose row is 0 there. `starts` are of coordinates, rates, and states."""
    if c is None or any(g.depends[node] & BIT[Kind.INPUT] for node in (*c.positions, *c.residual)):
        return c, []
    start = _start(g, started(g, parameters, starts), lagrangian, attitudes)
    rows = [_row(g, node, start) for node in c.residual]
    broken = [
        _broken(c, k, *found)
        for k, row in enumerate(rows)
        if (found := _residual(g, c, k, row, start)) is not None
    ]
    if broken:
        near = nearest_start(g, c, lagrangian, start.values, attitudes, name)
        if near:
            broken[0] = replace(broken[0], help=f"the nearest start that holds: {near}")
        elif contradiction := _contradiction(c, rows):
            broken.append(contradiction)
        return c, broken
    for k, row in enumerate(rows):
        if not any(row.values()):
            message = f"'{_name(c, k)}' has no force at the start: its row is 0 there"
            help = "start elsewhere, or write it another way"
            return c, [Diagnostic(f"the {_kind(c, k)} {message}", c.spans[k], help)]
    rows = _equilibrated(rows)
    if _dependent(rows) is None:
        return c, []
    own = _independent(rows, c.holonomic)
    redundant = c.picked([k for k in range(len(rows)) if k not in own])
    return replace(c.picked(own), redundant=redundant), []


def _contradiction(c: Rows, rows: list[dict[Node, float]]) -> Diagnostic | None:
    found = _dependent(_equilibrated(rows))
    if found is None:
        return None
    k, others = found
    names = " and ".join(f"'{_name(c, i)}'" for i in others) or "nothing"
    message = f"'{_name(c, k)}' contradicts {names}: they leave the same rates no freedom"
    return Diagnostic(f"the {_kind(c, k)} {message}", c.spans[k], "leave one out")


def _start(
    g: Graph, values: dict[Symbol, float], lagrangian: Node, attitudes: tuple[Attitude, ...]
) -> Start:
    turning = {i for a in attitudes for i in a.rates}
    unit, far, fast = {}, 0.0, 0.0
    for rate, slope in gradient(g, lagrangian, BIT[Kind.RATE]).items():
        own = gradient(g, slope, BIT[Kind.RATE]).get(rate, ZERO)
        unknown = g.depends[own] & BIT[Kind.INPUT]  # a run gives the value of an input
        (inertia,) = (0.0,) if unknown else evaluate(g, [own], values)
        unit[rate] = math.sqrt(inertia) if 0 < inertia < math.inf else 1.0
        i = g.data[rate].index
        place = 1.0 if i in turning else abs(values[Symbol(Kind.COORDINATE, i)])
        far = max(far, unit[rate] * place)
        fast = max(fast, unit[rate] * abs(values[g.data[rate]]))
    return Start(values, unit, far, fast)


def _residual(
    g: Graph, c: Rows, k: int, row: dict[Node, float], start: Start
) -> tuple[float, bool] | None:
    """Returns the violation of a row and whether it is one of rates; None if it holds."""
    slope = math.fsum(map(abs, row.values()))
    nodes = [(c.residual[k], slope * start.fast, True)]
    if k < c.holonomic:
        nodes.insert(0, (c.positions[k], slope * start.far, False))
    for node, largest, of_rates in nodes:
        found, terms = evaluate(g, [node, *sizes(g, [node])], start.values)
        if not abs(found) <= WRITTEN * terms + DEBRIS * largest:
            return found, of_rates
    return None


def _broken(c: Rows, k: int, found: float, of_rates: bool) -> Diagnostic:
    name, kind = _name(c, k), _kind(c, k)
    what = "its rate is" if of_rates and k < c.holonomic else "left minus right is"
    return Diagnostic(
        f"the start breaks the {kind} '{name}': {what} {found:.6g}, not 0",
        c.spans[k],
        "start rates along it" if of_rates else "start where it holds",
    )


def _row(g: Graph, residual: Node, start: Start) -> dict[Node, float]:
    """Returns the entries of J by rate, scaled by M; all 0 if they may be rounding errors of the
    start."""
    by = gradient(g, residual, BIT[Kind.RATE])
    entries = evaluate(g, by.values(), start.values)
    row = {rate: x / start.unit.get(rate, 1.0) for rate, x in zip(by, entries, strict=True)}
    if any(abs(x) > SMALL * max(1.0, start.far) for x in row.values()):
        return row  # without second derivatives, which are seldom needed
    for node, x in zip(by.values(), entries, strict=True):
        bends = gradient(g, node, BIT[Kind.COORDINATE])
        slopes = evaluate(g, bends.values(), start.values)
        ends = [abs(y * start.values[g.data[q]]) for q, y in zip(bends, slopes, strict=True)]
        if abs(x) > DEBRIS * math.fsum(ends):
            return row
    return dict.fromkeys(row, 0.0)


def _equilibrated(rows: list[dict[Node, float]]) -> list[dict[Node, float]]:
    """Returns the rows with columns scaled to one size: masses and units do not affect the rank.

    Reference: D. Ruiz, RAL-TR-2001-034.
    """
    rates = sorted(set().union(*rows))
    column = dict.fromkeys(rates, 1.0)
    for _ in range(SWEEPS):
        sizes = [max((abs(x) * column[r] for r, x in row.items()), default=0.0) for row in rows]
        for rate in rates:
            shares = [
                abs(row.get(rate, 0.0)) / size
                for row, size in zip(rows, sizes, strict=True)
                if size and abs(row.get(rate, 0.0)) * column[rate] > ROUNDING * size
            ]
            column[rate] = 1 / max(shares) if shares else column[rate]
    return [{rate: x * column[rate] for rate, x in row.items()} for row in rows]


def _dependent(rows: list[dict[Node, float]]) -> tuple[int, list[int]] | None:
    """Returns the first row that depends on rows before it, and these; or None. Gram-Schmidt
    orthogonalization records each vector as a combination of rows."""
    basis: list[tuple[list[float], dict[int, float]]] = []
    rates = sorted(set().union(*rows))
    for k, row in enumerate(rows):
        left, made = [row.get(rate, 0.0) for rate in rates], {k: 1.0}
        size = math.hypot(*left)
        if not math.isfinite(size):
            return None
        for _ in range(2):  # twice is enough: Kahan and Parlett
            for other, of in basis:
                along = math.fsum(a * b for a, b in zip(left, other, strict=True))
                left = [a - along * b for a, b in zip(left, other, strict=True)]
                for i, x in of.items():
                    made[i] = made.get(i, 0.0) - along * x
        rest = math.hypot(*left)
        if rest <= DEPENDENT * size:
            largest = max((abs(x) for i, x in made.items() if i != k), default=0.0)
            return k, [i for i in sorted(made) if i != k and abs(made[i]) > DEPENDENT * largest]
        basis.append(([a / rest for a in left], {i: x / rest for i, x in made.items()}))
    return None


def _independent(rows: list[dict[Node, float]], holonomic: int) -> list[int]:
    """Returns rows that imply the others, well conditioned: by pivoting, the row with the largest
    relative rest comes next. Holonomic rows come first, since they imply more."""
    rates = sorted(set().union(*rows))
    left = [[row.get(rate, 0.0) for rate in rates] for row in rows]
    sizes = [math.hypot(*row) or 1.0 for row in left]
    found: list[int] = []
    for among in (range(holonomic), range(holonomic, len(rows))):
        waiting = list(among)
        while waiting:
            k = max(waiting, key=lambda k: math.hypot(*left[k]) / sizes[k])
            rest = math.hypot(*left[k])
            if rest <= DEPENDENT * sizes[k]:
                break
            waiting.remove(k)
            found.append(k)
            unit = [x / rest for x in left[k]]
            for _ in range(2):
                for j in range(len(rows)):
                    along = math.fsum(a * b for a, b in zip(left[j], unit, strict=True))
                    left[j] = [a - along * b for a, b in zip(left[j], unit, strict=True)]
    return sorted(found)


def _name(c: Rows, k: int) -> str:
    return c.names[k].name.removeprefix("lambda_")


def _kind(c: Rows, k: int) -> str:
    return "constraint" if k < c.holonomic else "rolling"
