"""Whether a model starts where its constraints hold, and whether there they say more than one
another.

The numbers are those of the model's own starts and defaults; what options give is checked by the
runtime by the same rules (src/constraints/constraint.c). With an input nobody knows what holds
before it is given. Rates of metres and of radians compare as their kinetic energies do, by M: its
diagonal is enough of it.
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
WRITTEN = 1e-8  # of its terms: starts are written with as many digits as their author has
DEBRIS = 64 * EPS  # beside the largest number of the start: what rounding leaves of a zero
SWEEPS = 3  # of rows and columns
ROUNDING = 1e-12  # an entry so small in its row may be rounding of 0: no column is scaled by it
SMALL = 1e-9  # a row that may be rounding
DEPENDENT = math.sqrt(16 * EPS)  # left of a row without its parts along others; squared, a pivot


@record
class Start:
    """Numbers of the start, and by each rate what one unit of it is in the metric of M."""

    values: dict[Symbol, float]
    unit: dict[Node, float]
    far: float  # the largest coordinate there, with attitudes 1
    fast: float


def at_the_start(
    g: Graph,
    c: Rows | None,
    parameters: tuple[ParameterSlot, ...],
    starts: tuple[Row, Row, Row],
    lagrangian: Node,
    attitudes: tuple[Attitude, ...],
    name: Callable[[Symbol], str],
) -> tuple[Rows | None, list[Diagnostic]]:
    """The rows, those that follow from others apart; or what is wrong: each constraint that the
    start breaks, or that has no force there. `starts` are of coordinates, their rates, and
    states."""
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
        unknown = g.depends[own] & BIT[Kind.INPUT]  # what an input is, a run says
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
    """What is not 0, and whether it is of rates; `row` is in units of M."""
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
    """The entries of J by the rate, in units of M; 0 where all are what rounding of the start
    leaves of it."""
    by = gradient(g, residual, BIT[Kind.RATE])
    entries = evaluate(g, by.values(), start.values)
    row = {rate: x / start.unit.get(rate, 1.0) for rate, x in zip(by, entries, strict=True)}
    if any(abs(x) > SMALL * max(1.0, start.far) for x in row.values()):
        return row  # second derivatives are seldom asked for
    for node, x in zip(by.values(), entries, strict=True):
        bends = gradient(g, node, BIT[Kind.COORDINATE])
        slopes = evaluate(g, bends.values(), start.values)
        ends = [abs(y * start.values[g.data[q]]) for q, y in zip(bends, slopes, strict=True)]
        if abs(x) > DEBRIS * math.fsum(ends):
            return row
    return dict.fromkeys(row, 0.0)


def _equilibrated(rows: list[dict[Node, float]]) -> list[dict[Node, float]]:
    """The rows with columns of one size, so that masses and units say nothing of their rank.

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
    """The first row that others before it make, and which; by Gram-Schmidt with each row's own
    combination of those before."""
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
    """Rows that the others follow from, as far apart as can be: of those left always the one that
    most is left of, those of positions first, since they say more."""
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
