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
) -> tuple[Rows | None, list[Diagnostic]]:
    """Returns two results. The first has the constraint rows; its field `redundant` has the
    linearly dependent ones. The second is a list of errors about constraints that the initial state
    violates, and about constraint rows that are 0 at the initial state. `starts` has the initial
    values of coordinates, rates and states."""
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
        unknown = g.depends[own] & BIT[Kind.INPUT]  # inputs have no values before a run
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
    """Returns None if constraint k is satisfied at the start. Otherwise returns its error, and True
    if the rates cause the error, False if the coordinates do."""
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
    """Returns a row of J as a map from rates to entries, which are scaled with M. If all entries
    may be mere rounding errors of the initial values, all entries are returned as zeros."""
    by = gradient(g, residual, BIT[Kind.RATE])
    entries = evaluate(g, by.values(), start.values)
    row = {rate: x / start.unit.get(rate, 1.0) for rate, x in zip(by, entries, strict=True)}
    if any(abs(x) > SMALL * max(1.0, start.far) for x in row.values()):
        return row  # entries this large cannot be rounding errors
    for node, x in zip(by.values(), entries, strict=True):
        bends = gradient(g, node, BIT[Kind.COORDINATE])
        slopes = evaluate(g, bends.values(), start.values)
        ends = [abs(y * start.values[g.data[q]]) for q, y in zip(bends, slopes, strict=True)]
        if abs(x) > DEBRIS * math.fsum(ends):
            return row
    return dict.fromkeys(row, 0.0)


def _equilibrated(rows: list[dict[Node, float]]) -> list[dict[Node, float]]:
    """Returns the rows with their columns scaled to equal size, so that masses and units do not
    affect the numerical rank.

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
    """Returns the number of the first row that is a linear combination of earlier rows, and the
    numbers of the latter; None if all rows are independent. Uses Gram-Schmidt orthogonalization."""
    basis: list[tuple[list[float], dict[int, float]]] = []
    rates = sorted(set().union(*rows))
    for k, row in enumerate(rows):
        left, made = [row.get(rate, 0.0) for rate in rates], {k: 1.0}
        size = math.hypot(*left)
        if not math.isfinite(size):
            return None
        for _ in range(2):  # orthogonalizing twice is enough (Kahan and Parlett)
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
    """Returns the numbers of independent rows of which all rows are linear combinations. Chooses in
    each step the row with the largest component orthogonal to the chosen rows, relative to its
    length. Holonomic rows are chosen first, since they also constrain the positions."""
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
