"""Checks that the initial state of a model satisfies the constraints, and that the constraint rows
are linearly independent there.

The check uses the initial values and parameter defaults in the model. The runtime checks values
from options by the same rules (src/constraints/constraint.c). Constraints with an input cannot be
checked before a run. To compare rates in different units, such as m/s and rad/s, each is scaled by
the square root of its diagonal entry of M.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from ...equations import Attitude, ParameterSlot, Row, Rows
from ...graph.differentiate import gradient
from ...graph.evaluate import evaluate
from ...graph.graph import BIT, ZERO, Graph, Kind, Node, Symbol
from ...graph.rounding import sizes
from ...record import record
from ...source import Diagnostic, Span
from ..points.samples import started
from .nearest_start import nearest_start

if TYPE_CHECKING:
    import numpy as np

RATE = BIT[Kind.RATE]
EPS = sys.float_info.epsilon
# The tolerance of a constraint, relative to its terms: models state initial values with few digits.
WRITTEN = 1e-8
# The rounding error of a number that should be 0, relative to the largest number of the initial
# state.
DEBRIS = 64 * EPS
# The number of sweeps over rows and columns when the matrix is scaled.
SWEEPS = 3
# Entries of a row whose ratio to its largest entry is smaller than this number may be rounding
# errors. They do not affect the scale of their column.
ROUNDING = 1e-12
# A row may consist of rounding errors if all its entries are smaller than this number.
SMALL = 1e-9
# Take the component of a row that is orthogonal to other rows, divided by the length of the row.
# The row is linearly dependent on the other rows if this ratio is at most the number here. The
# square of the ratio is about the pivot of S divided by the diagonal entry of S.
DEPENDENT = math.sqrt(16 * EPS)


@record
class Start:
    """The initial state. `unit` maps each rate to the square root of its diagonal entry of the mass
    matrix M. Rates and coordinates are multiplied by this number to compare them in one unit."""

    values: dict[Symbol, float]
    unit: dict[Node, float]
    far: float  # The largest scaled coordinate of the state; coordinates of rotations count as 1.
    fast: float  # The largest scaled rate of the state.


def at_the_start(
    g: Graph,
    c: Rows | None,
    parameters: tuple[ParameterSlot, ...],
    starts: tuple[Row, Row, Row],
    lagrangian: Node,
    attitudes: tuple[Attitude, ...],
    name: Callable[[Symbol], str],
    consistent: Span | None = None,
) -> tuple[Rows | None, list[Diagnostic]]:
    """Returns two results. The first has the constraint rows; its field `redundant` has the
    linearly dependent ones. The second is a list of errors about constraints that the initial state
    violates, and about constraint rows that are 0 at the initial state. `starts` has the initial
    values of coordinates, rates and states. `consistent` is the position of `start consistent`:
    then the state is the nearest one that satisfies the constraints."""
    if c is None and consistent is not None:
        message = "there is no constraint: every start is consistent"
        return c, [Diagnostic(message, consistent, "leave it out")]
    if c is None or any(g.depends[node] & BIT[Kind.INPUT] for node in (*c.positions, *c.residual)):
        return c, []
    import numpy as np

    values = started(g, parameters, starts)
    if consistent is not None:
        values = nearest_start(g, c, lagrangian, values, attitudes, name)[0] or values
    start = _start(g, values, lagrangian, attitudes)
    rates = sorted(start.unit.keys() | {r for x in c.residual for r in gradient(g, x, RATE)})
    rows = np.array([_row(g, node, start, rates) for node in c.residual])
    with np.errstate(all="ignore"):  # entries that are not finite stay so
        scaled = _equilibrated(rows)
    finite = np.isfinite(scaled).all()
    broken = [
        _broken(c, k, *found)
        for k, slope in enumerate(np.abs(rows).sum(axis=1).tolist())
        if (found := _residual(g, c, k, slope, start)) is not None
    ]
    if broken:
        near = nearest_start(g, c, lagrangian, start.values, attitudes, name)[1]
        if consistent is not None:
            message = "no start that satisfies the constraints is found near the given values"
            broken[:] = [Diagnostic(message, consistent, "start nearer to it")]
            broken += _contradiction(c, scaled) if finite else []
        elif near:
            near += "" if attitudes else "; or say: start consistent"
            broken[0] = replace(broken[0], help=f"the nearest start that holds: {near}")
        elif finite:
            broken += _contradiction(c, scaled)
        return c, broken
    for k, row in enumerate(rows):
        if not row.any():
            message = f"the {c.statement(k)} has no force at the start: its row is 0 there"
            help = "start elsewhere, or write it another way"
            return c, [Diagnostic(message, c.spans[k], help)]
    own = _independent(scaled, c.holonomic) if finite else range(len(rows))
    if len(own) == len(rows):
        return c, []
    redundant = c.picked([k for k in range(len(rows)) if k not in own])
    return replace(c.picked(own), redundant=redundant), []


def _start(
    g: Graph, values: dict[Symbol, float], lagrangian: Node, attitudes: tuple[Attitude, ...]
) -> Start:
    turning = {i for a in attitudes for i in a.rates}
    unit, far, fast = {}, 0.0, 0.0
    for rate, slope in gradient(g, lagrangian, RATE).items():
        own = gradient(g, slope, RATE).get(rate, ZERO)
        unknown = g.depends[own] & BIT[Kind.INPUT]  # inputs have no values before a run
        (inertia,) = (0.0,) if unknown else evaluate(g, [own], values)
        unit[rate] = math.sqrt(inertia) if 0 < inertia < math.inf else 1.0
        i = g.data[rate].index
        place = 1.0 if i in turning else abs(values[Symbol(Kind.COORDINATE, i)])
        far = max(far, unit[rate] * place)
        fast = max(fast, unit[rate] * abs(values[g.data[rate]]))
    return Start(values, unit, far, fast)


def _residual(g: Graph, c: Rows, k: int, slope: float, start: Start) -> tuple[float, bool] | None:
    """Returns None if constraint k is satisfied at the start. Otherwise returns its error, and True
    if the rates cause the error, False if the coordinates do. `slope` is the sum of the entries of
    its row."""
    nodes = [(c.residual[k], slope * start.fast, True)]
    if k < c.holonomic:
        nodes.insert(0, (c.positions[k], slope * start.far, False))
    for node, largest, of_rates in nodes:
        found, terms = evaluate(g, [node, *sizes(g, [node])], start.values)
        if not abs(found) <= WRITTEN * terms + DEBRIS * largest:
            return found, of_rates
    return None


def _broken(c: Rows, k: int, found: float, of_rates: bool) -> Diagnostic:
    what = "its rate is" if of_rates and k < c.holonomic else "left minus right is"
    return Diagnostic(
        f"the start breaks the {c.statement(k)}: {what} {found:.6g}, not 0",
        c.spans[k],
        "start rates along it" if of_rates else "start where it holds",
    )


def _row(g: Graph, residual: Node, start: Start, rates: list[Node]) -> list[float]:
    """Returns a row of J, one entry for each of the rates, which are scaled with M. If all entries
    may be mere rounding errors of the initial values, all entries are returned as zeros."""
    by = gradient(g, residual, RATE)
    entries = evaluate(g, [by.get(rate, ZERO) for rate in rates], start.values)
    row = [x / start.unit.get(rate, 1.0) for rate, x in zip(rates, entries, strict=True)]
    if any(abs(x) > SMALL * max(1.0, start.far) for x in row):
        return row  # entries this large cannot be rounding errors
    for rate, x in zip(rates, entries, strict=True):
        bends = gradient(g, by.get(rate, ZERO), BIT[Kind.COORDINATE])
        slopes = evaluate(g, bends.values(), start.values)
        ends = [abs(y * start.values[g.data[q]]) for q, y in zip(bends, slopes, strict=True)]
        if abs(x) > DEBRIS * math.fsum(ends):
            return row
    return [0.0] * len(row)


def _equilibrated(rows: np.ndarray) -> np.ndarray:
    """Returns the rows with their columns scaled to equal size, so that masses and units do not
    affect the numerical rank.

    Reference: D. Ruiz, RAL-TR-2001-034.
    """
    import numpy as np

    entries, columns = np.abs(rows), np.ones(rows.shape[1])
    for _ in range(SWEEPS):
        sizes = (entries * columns).max(axis=1, keepdims=True)
        seen = entries * columns > ROUNDING * sizes
        shares = np.where(seen, entries / np.where(sizes, sizes, 1), 0).max(axis=0)
        columns = np.where(shares, 1 / np.where(shares, shares, 1), columns)
    return rows * columns


def _contradiction(c: Rows, rows: np.ndarray) -> list[Diagnostic]:
    """Returns an error about the first row that is a linear combination of earlier rows, if any."""
    import numpy as np

    for k, row in enumerate(rows):
        x = np.linalg.lstsq(rows[:k].T, row, rcond=None)[0]
        if np.linalg.norm(row - x @ rows[:k]) <= DEPENDENT * np.linalg.norm(row):
            large = np.flatnonzero(np.abs(x) > DEPENDENT * np.abs(x).max(initial=0))
            names = " and ".join(c.statement(i).partition(" ")[2] for i in large) or "nothing"
            message = f"the {c.statement(k)} contradicts {names}"
            message += ": they leave the same rates no freedom"
            return [Diagnostic(message, c.spans[k], "leave one out")]
    return []


def _independent(rows: np.ndarray, holonomic: int) -> list[int]:
    """Returns the numbers of independent rows of which all rows are linear combinations. Chooses in
    each step the row with the largest component orthogonal to the chosen rows, relative to its
    length. Holonomic rows are chosen first, since they also constrain the positions."""
    import numpy as np

    left, sizes, found = rows.copy(), np.linalg.norm(rows, axis=1), []
    for among in (range(holonomic), range(holonomic, len(rows))):
        for _ in among:
            ratios = np.linalg.norm(left, axis=1) / sizes
            k = max(among, key=ratios.__getitem__)
            if ratios[k] <= DEPENDENT:
                break
            found.append(k)
            unit = left[k] / np.linalg.norm(left[k])
            for _ in range(2):  # orthogonalizing twice is enough (Kahan and Parlett)
                left -= np.outer(left @ unit, unit)
            left[k] = 0
    return sorted(found)
