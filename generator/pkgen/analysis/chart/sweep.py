"""Measures the points: each method at steps or tolerances from loose to tight, until its error is
round-off, or the next point would take more than the method's share of the time.
"""

from __future__ import annotations

import math
import os
import statistics
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import field, replace

from ...record import record
from ...system import children
from .errors import Measure
from .measure import Program
from .points import ChartedMethod, Point, Track
from .scale import pieces, slope
from .spectrum import Spectrum

# Most points of a method, seconds to time a point, seconds for all except drawing.
FULL, QUICK = (16, 0.03, 55.0), (9, 0.004, 10.0)
SWEPT = 2 / 3  # fraction of the time for the sweep; the rest is for search.py
LEAST = 0.25  # least fraction of the time that remains after the reference
LOOSEST, TIGHTEST = 1e-2, 1e-14  # range of tolerances
DECADES = 14.0  # ratio of the first to the last error, in decades, if a method has all points
FINER = (1.12, 4.0)  # bounds on the ratio of successive steps
UNKNOWN = 1.4  # ratio of steps after a failed step
PAST_LIMIT = 1.5  # first step in units of the stability limit; if none, see LONGEST
LONGEST = 3.0  # first step in radians of the fastest oscillation, or the order if larger
ANSWER = 1e-3  # largest error of a first step that may already be an answer
LONGER = 3  # factor to longer steps than the first, if it may be an answer
ROUND_OFF = 3e-16
EASED = 1e-8  # errors below this that no longer fall are round-off


def processor() -> float:
    """Returns the CPU seconds of this process and its finished child processes."""
    return time.process_time() + sum(os.times()[2:4])


@record
class Effort:
    """The time for measurements, in CPU seconds, so that load on the machine has no effect."""

    points: int  # most points of a method
    lap_seconds: float  # seconds to time a point
    seconds: float  # seconds of everything except drawing
    began: float = field(default_factory=lambda: processor())

    def rest(self) -> Effort:
        """Returns the remaining effort, but at least LEAST of it all: references may take long."""
        return Effort(self.points, self.lap_seconds, max(self.left(), LEAST * self.seconds))

    def left(self, part: float = 1.0) -> float:
        """Returns the seconds left of the fraction `part` of the time; 0 after an interrupt."""
        if children.ended():
            return 0.0
        return max(0.0, part * self.seconds - (processor() - self.began))

    @staticmethod
    def usual(points: int | None, seconds: float | None, quick: bool) -> Effort:
        most, lap, within = QUICK if quick else FULL
        return Effort(points or most, lap, seconds or within)


@record
class Bench:
    """The setup of a measurement: a program and a measure for each start. The error of a point is
    the median over the starts, its time that from the first start."""

    starts: list[tuple[Program, Measure]]
    floor: float  # error of the reference
    until: float
    effort: Effort

    def point(
        self, method: ChartedMethod, setting: float, cap: float, lap: float = math.inf
    ) -> Point:
        (program, measure), *others = self.starts
        lap = min(lap, self.effort.lap_seconds)
        first = program.point(method, setting, lap, cap, measure)
        if not others or first.refused or first.slow:
            return first
        points = [first, *(p.point(method, setting, 0.0, cap, m) for p, m in others)]
        if any(p.slow for p in points):  # the median is unknown in this case
            return replace(first, slow=True, error=None, took=sum(p.took for p in points))
        errors = sorted(math.inf if p.error is None else p.error for p in points)
        median = statistics.median(errors)
        worst = next((p for p in points if not p.arrived), first) if median == math.inf else first
        return replace(
            first,
            error=None if median == math.inf else median,
            least=errors[0],
            most=errors[-1],
            status=worst.status,
            reason=worst.reason,
            took=sum(p.took for p in points),
        )


class Steps:
    """Steps that divide the duration. The first is beyond the stability limit or, without a limit,
    so long that an oscillation has few steps. Each further step is chosen to reduce the error by an
    equal share of DECADES, by extrapolation of the last two errors."""

    def __init__(self, method: ChartedMethod, spectrum: Spectrum, count: int):
        limit = spectrum.limit(method)
        self.order = max(1, method.order)
        first = PAST_LIMIT * limit if limit else max(LONGEST, self.order) / spectrum.fastest
        self.until = spectrum.until
        self.whole = pieces(self.until, first)
        self.decades = DECADES / count

    @property
    def first(self) -> float:
        return self.until / self.whole

    def after(self, points: list[Point]) -> float:
        power = float(self.order)
        if not points[-1].good:
            power = self.decades / math.log10(UNKNOWN)
        elif len(points) > 1 and points[-2].good and points[-2].error and points[-1].error:
            power = slope(points[-2], points[-1])
        power = min(max(power, 0.1), self.order)
        ratio = min(max(10 ** (self.decades / power), FINER[0]), FINER[1])
        self.whole = max(self.whole + 1, round(self.whole * ratio))
        return self.until / self.whole


class Tolerances:
    def __init__(self, count: int):
        self.first = LOOSEST
        self.ratio = (TIGHTEST / LOOSEST) ** (1 / max(1, count - 1))

    def after(self, points: list[Point]) -> float:
        return points[-1].setting * self.ratio


def measure(
    bench: Bench,
    methods: list[ChartedMethod],
    spectrum: Spectrum,
    on_progress: Callable[[str], None],
) -> list[Track]:
    """Returns the points of all methods; of a refused method, one point. After an interrupt it
    returns the points measured so far."""
    kept: dict[str, list[Point]] = {}
    with suppress(KeyboardInterrupt):
        for k, method in enumerate(methods):
            on_progress(method.name)
            share = bench.effort.left(SWEPT) / (len(methods) - k)
            _sweep(bench, method, spectrum, share, kept.setdefault(method.name, []))
    return [Track(m, tuple(kept[m.name])) for m in methods if kept.get(m.name)]


def _sweep(
    bench: Bench, method: ChartedMethod, spectrum: Spectrum, share: float, points: list[Point]
) -> None:
    """Measures the points of one method, in time `share`, and appends them to `points`."""
    count = bench.effort.points
    plan = Steps(method, spectrum, count) if method.fixed else Tolerances(count)
    end = processor() + share
    lap = share / (3 * count)  # limits the timing of loose points, so that tight ones have time
    while len(points) < count:
        left = end - processor()
        # A point takes at least two integrations, and a tighter one takes longer.
        if points and 4 * (points[-1].seconds or points[-1].took) > left:
            break
        cap = max(left / 2, bench.effort.lap_seconds)
        setting = plan.after(points) if points else plan.first
        points.append(bench.point(method, setting, cap, lap))
        if len(points) == 1 and isinstance(plan, Steps):
            _longer(bench, method, plan, cap, lap, points)
        if points[-1].refused or points[-1].slow or _at_round_off(points, bench.floor):
            break


def _longer(
    bench: Bench, method: ChartedMethod, plan: Steps, cap: float, lap: float, points: list[Point]
) -> None:
    """While the first step may already be an answer, inserts longer steps before it: an exact
    method allows any step on a linear system."""
    whole = plan.whole
    while whole > 1 and points[0].good and (points[0].error or 0) < ANSWER:
        whole = max(1, whole // LONGER)
        points.insert(0, bench.point(method, plan.until / whole, cap, lap))


def _at_round_off(points: list[Point], floor: float) -> bool:
    """Whether the last error is near the reference's, or the last two no longer fall."""
    errors = [p.error for p in points if p.good]
    if errors and errors[-1] < max(ROUND_OFF, 2 * floor):
        return True
    best = min(errors[:-2], default=math.inf)
    return best < EASED and len(errors) > 3 and min(errors[-2:]) > 0.5 * best
