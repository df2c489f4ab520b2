"""Computes a motion within rigorous bounds, row by row; repeats it if too many digits are lost.

The truncation error of a step is 10^-D of the change in that step, where D is the number of
requested digits plus SPARE. The number of digits that the motion itself loses is known only after a
run; then the run is repeated with that many additional digits.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from math import ceil, floor, log, log10
from typing import Any

from pkgen.indices import multiplied
from pkgen.record import record
from pkgen.system.exits import UsageError

from .domains import ball, flint
from .flow import REAL, Flow, Given
from .step import Step, begun, step

SPARE = 9  # digits computed in addition to those requested
ATTEMPTS = 5
BITS_A_DIGIT = log(10) / log(2)
GUARD = 40  # Bits of precision in addition to those of the digits.
SHORTEST = 1e-9  # Shortest step, relative to the duration of the run.
# The first time radius that is tried for a step is that of the last step times this factor.
GROWTH = 1.2


@record
class Row:
    t: Fraction
    values: list[Any]  # balls


@record
class Enclosure:
    names: tuple[str, ...]
    rows: list[Row]
    until: Fraction  # Requested end time.
    reached: Fraction  # Time of the last row.
    wanted: int  # Requested digits.
    # Certified digits of the value with the fewest, relative to the largest value of its column.
    digits: int
    worst: str  # Column of the value with the fewest certified digits.
    width: float  # Largest width of bounds.
    widest: str
    steps: int
    order: int
    bits: int
    seconds: float  # CPU seconds of all attempts
    attempts: int
    # Whether the bounds hold for many motions, since a parameter or start is an interval.
    several: bool
    interrupted: bool = False

    @property
    def whole(self) -> bool:
        return self.reached == self.until


def enclose(
    given: Given,
    digits: int,
    told: Callable[[float], None] = lambda _: None,
    stopped: Callable[[], bool] = lambda: False,
) -> Enclosure:
    """Returns rows from t = 0 to the end of the run. Rows end earlier if a step has no finite
    bounds, or if the run is interrupted. Raises UsageError if the start violates the
    constraints."""
    begin = time.process_time()
    spare, best = SPARE, None
    attempt = 0
    while attempt < ATTEMPTS:
        attempt += 1
        found = _attempt(given, digits, spare, told, stopped)
        if best is None or (found.reached, found.digits) > (best.reached, best.digits):
            best = found
        if (found.whole and found.digits >= digits) or given.several or stopped():
            break
        # The last attempt, with more digits, was no better than the one before.
        if best is not found:
            break
        spare += max(digits - found.digits, 0) + SPARE if found.whole else 2 * digits
    seconds = time.process_time() - begin
    return replace(best, seconds=seconds, attempts=attempt, interrupted=stopped())


def _attempt(
    given: Given,
    digits: int,
    spare: int,
    told: Callable[[float], None],
    stopped: Callable[[], bool],
) -> Enclosure:
    sought = digits + spare
    # The order K that minimises the work per unit of time, K^2/10^(-D/K).
    order = max(ceil(sought * log(10) / 2), 8)
    bits = ceil(sought * BITS_A_DIGIT) + GUARD
    with flint().ctx.workprec(bits):
        rows, steps, reached = _rows(given, order, sought, told, stopped)
        return _judged(given, rows, digits, steps, order, bits, reached)


def _rows(
    given: Given,
    order: int,
    sought: int,
    told: Callable[[float], None],
    stopped: Callable[[], bool],
) -> tuple[list[Row], int, Fraction]:
    library = flint()
    library.ctx.cap = order + 2
    flow = Flow(given)
    ratio = library.arb(10 ** (-sought / (order + 1))).mid()
    now = begun(ball(0), flow.start)
    _refuse_off(given, flow)
    rows = [Row(Fraction(0), flow.shown(now.t, now.hull()))]
    tried, steps, shortest = ball(given.until), 0, float(given.until) * SHORTEST
    while rows[-1].t < given.until and all(x.is_finite() for x in rows[-1].values):
        if stopped():
            break
        made = step(flow, now, order, ratio, tried)
        if made is None or made.length < shortest or not _narrow(made):
            break
        more = _between(given, flow, made, rows[-1].t)
        if more is None:
            break
        rows += more
        try:
            now = made.last()
        except ZeroDivisionError:
            break
        steps += 1
        tried = (made.around.radius * GROWTH).mid()
        told(float(rows[-1].t / given.until))
    return rows, steps, rows[-1].t


def _refuse_off(given: Given, flow: Flow) -> None:
    """Raises UsageError if the start violates the constraints: the equations only preserve them."""
    residuals = flow.residuals(REAL, flow.values(ball(0), flow.start))
    for k, x in enumerate(residuals):
        if x.contains(0):
            continue
        rows = given.equations.constraints
        of = k if k < rows.holonomic else k - rows.holonomic
        what = "itself" if k < rows.holonomic else "in its rate"
        raise UsageError(
            f"--enclose: the start is off the constraint "
            f"'{multiplied(rows.names[of].name)}' {what}, by {float(x.mid()):.3g}, and "
            "bounds are of the numbers as they are written: give a start that meets it exactly, "
            "by a formula in the model's 'start'"
        )


def _narrow(made: Step) -> bool:
    """Whether all bounds are finite, and the bounds of some variable are narrower than its change
    in the step."""
    hull = made.first.hull()
    pairs = zip(hull, made.around.moved, strict=True)
    return all(x.is_finite() for x in hull) and any(x.rad() < m or x.rad() == 0 for x, m in pairs)


def _between(given: Given, flow: Flow, made: Step, last: Fraction) -> list[Row] | None:
    """Returns the rows at times within a step; None if a row has no finite bounds."""
    found = []
    while last < given.until:
        t = min((last // given.every + 1) * given.every, given.until)
        after = ball(t) - made.first.t
        if not after <= made.length:
            break
        values = flow.shown(ball(t), made.hull(after))
        if not all(x.is_finite() for x in values):
            return None
        found.append(Row(t, values))
        last = t
    return found


def _size(column: tuple[Any, ...]) -> float:
    """Returns the largest magnitude in a column, relative to which its digits count. If all values
    of the column may be 0, returns 1: then digits count from the decimal point."""
    if all(x.contains(0) for x in column):
        return 1.0
    return max(float(x.abs_upper()) for x in column)


def _judged(
    given: Given,
    rows: list[Row],
    digits: int,
    steps: int,
    order: int,
    bits: int,
    reached: Fraction,
) -> Enclosure:
    columns = list(zip(*(row.values for row in rows), strict=True))
    radii = [max(float(x.rad().upper()) for x in column) for column in columns]
    sizes = [_size(column) for column in columns]
    kept = [
        floor(-log10(r / size)) if 0 < r < size else 0 if r > 0 else bits
        for r, size in zip(radii, sizes, strict=True)
    ]
    worst = min(range(len(kept)), key=lambda i: (kept[i], i))
    widest = max(range(len(kept)), key=lambda i: (radii[i], -i))
    return Enclosure(
        names=given.names,
        rows=rows,
        until=given.until,
        reached=reached,
        wanted=digits,
        digits=kept[worst],
        worst=given.names[worst],
        width=2 * radii[widest],
        widest=given.names[widest],
        steps=steps,
        order=order,
        bits=bits,
        seconds=0.0,
        attempts=1,
        several=given.several,
    )
