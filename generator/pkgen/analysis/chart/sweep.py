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

# A full and a quick chart: the largest number of points of a method, the seconds in which a point
# is timed by repetitions, the seconds for everything except drawing.
FULL, QUICK = (16, 0.03, 55.0), (9, 0.004, 10.0)
SWEPT = 2 / 3  # fraction of the time for the sweep; the rest is for search.py
LEAST = 0.25  # fraction of the time that measurements get even if the reference took it all
LOOSEST, TIGHTEST = 1e-2, 1e-14  # range of tolerances
DECADES = 14.0  # the points of a method should reduce its error by this many powers of ten
FINER = (1.12, 4.0)  # bounds on the ratio of a step size to the next shorter one
UNKNOWN = 1.4  # this ratio if the run with the longer step failed, so that its error is unknown
PAST_LIMIT = 1.5  # the first step size, in units of the method's stability limit, if it has one
# Else the first step is so long that the fastest oscillation advances by this angle in radians, or
# by the order of the method if that is larger.
LONGEST = 3.0
ANSWER = 1e-3  # if the first step has a smaller error, it may be an answer: longer steps are tried
LONGER = 3  # factor from a step size to the next longer one in this case
ROUND_OFF = 3e-16
EASED = 1e-8  # an error below this that no longer falls with the step is round-off


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
        """Returns the effort that remains after the reference was computed: the seconds left, but
        at least the fraction LEAST of all seconds, since a reference may take long."""
        return Effort(self.points, self.lap_seconds, max(self.left(), LEAST * self.seconds))

    def left(self, part: float = 1.0) -> float:
        """Returns the seconds until the fraction `part` of the time is used, or 0 after Ctrl-C."""
        if children.ended():
            return 0.0
        return max(0.0, part * self.seconds - (processor() - self.began))

    @staticmethod
    def usual(points: int | None, seconds: float | None, quick: bool) -> Effort:
        most, lap, within = QUICK if quick else FULL
        return Effort(points or most, lap, seconds or within)


@record
class Bench:
    """The setup of measurements: a program and a measure of errors for each start of the motion.
    The error of a point is the median of its errors from all starts. The time of a point is that of
    the run from the first start."""

    starts: list[tuple[Program, Measure]]
    floor: float  # error of the reference; smaller errors cannot be measured
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
        if any(p.slow for p in points):  # a run without an error: no median is known
            return replace(first, slow=True, error=None, took=sum(p.took for p in points))
        errors = sorted(math.inf if p.error is None else p.error for p in points)
        median = statistics.median(errors)
        worst = next((p for p in points if not p.arrived), first) if median == math.inf else first
        error = None if median == math.inf else median
        of = {"status": worst.status, "reason": worst.reason, "took": sum(p.took for p in points)}
        return replace(first, error=error, least=errors[0], most=errors[-1], **of)


class Steps:
    """The step sizes of a sweep, which divide the duration into equal steps. The first step size is
    beyond the stability limit or, without a limit, so long that an oscillation has few steps. Each
    further step size is extrapolated from the last two errors, such that every point reduces the
    error by the same number of decades (DECADES in all)."""

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
    """Returns the points of all methods. A method that the runtime refuses has one point, which
    says why. After an interrupt, the points measured so far are returned."""
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
    lap = share / (3 * count)  # limits repetitions of loose points, to leave time for tight points
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
    """Inserts points with longer steps before the first point, as long as the first point is so
    accurate that it may be an answer. For example, an exact method takes any step on a linear
    system."""
    whole = plan.whole
    while whole > 1 and points[0].good and (points[0].error or 0) < ANSWER:
        whole = max(1, whole // LONGER)
        points.insert(0, bench.point(method, plan.until / whole, cap, lap))


def _at_round_off(points: list[Point], floor: float) -> bool:
    """Whether the last error is near the error of the reference, or the last two errors are no
    longer smaller than earlier ones."""
    errors = [p.error for p in points if p.good]
    if errors and errors[-1] < max(ROUND_OFF, 2 * floor):
        return True
    best = min(errors[:-2], default=math.inf)
    return best < EASED and len(errors) > 3 and min(errors[-2:]) > 0.5 * best
