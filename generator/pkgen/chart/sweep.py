"""Which points are measured: each method at steps or tolerances from loose to tight, until its
error is round-off, or the next point would take more than its share of the time."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

from .measure import Exact, Program
from .points import Method, Point, Track
from .spectrum import Spectrum

LOOSEST, TIGHTEST = 1e-2, 1e-14  # tolerances
DECADES = 14.0  # of error that the steps of a method are to go through
FINER = (1.12, 4.0)  # a step over the next one, at least and at most
PAST_LIMIT = 1.5  # the first step, in limits
ROUND_OFF = 3e-16
EASED = 1e-8  # below it an error that no longer falls has met round-off


@dataclass(frozen=True)
class Effort:
    """How long to measure."""

    points: int  # of a method, at most
    lap_seconds: float  # of laps of a point
    seconds: float  # of everything

    @staticmethod
    def usual(points: int | None, seconds: float | None, quick: bool) -> Effort:
        return Effort(
            points or (9 if quick else 16),
            0.004 if quick else 0.03,
            seconds or (15.0 if quick else 60.0),
        )


@dataclass(frozen=True)
class Bench:
    """What points are measured against."""

    program: Program
    exact: Exact
    scales: list[float]
    floor: float  # the reference's own error
    until: float
    effort: Effort

    def point(self, method: Method, setting: float, cap: float) -> Point:
        lap = self.effort.lap_seconds
        return self.program.point(method, setting, lap, cap, self.exact, self.scales)


def tolerances(count: int) -> list[float]:
    ratio = (TIGHTEST / LOOSEST) ** (1 / max(1, count - 1))
    return [LOOSEST * ratio**k for k in range(count)]


def steps(method: Method, spectrum: Spectrum, count: int) -> list[float]:
    """Whole parts of the time to go, from one past the limit (or, without a limit, so long that
    an oscillation has few steps) on, finer the higher the order."""
    order = max(1, method.order)
    limit = spectrum.limit(method)
    first = PAST_LIMIT * limit if limit else max(1.0, order / 2) / spectrum.fastest
    ratio = min(max(10 ** (DECADES / (order * count)), FINER[0]), FINER[1])
    made: list[int] = []
    whole = max(1, math.ceil(spectrum.until / first))
    while len(made) < count:
        made.append(whole)
        whole = max(whole + 1, round(whole * ratio))
    return [spectrum.until / k for k in made]


def measure(
    bench: Bench,
    methods: list[Method],
    spectrum: Spectrum,
    on_progress: Callable[[str, float], None],
) -> list[Track]:
    """All points of all methods that the system admits, refused ones with one point each."""
    began, tracks = time.monotonic(), []
    for k, method in enumerate(methods):
        left = bench.effort.seconds - (time.monotonic() - began)
        share = max(left, 0.0) / (len(methods) - k)
        on_progress(method.name, k / len(methods))
        tracks.append(Track(method, tuple(_sweep(bench, method, spectrum, share))))
    on_progress("", 1.0)
    return tracks


def _sweep(bench: Bench, method: Method, spectrum: Spectrum, share: float) -> list[Point]:
    count = bench.effort.points
    settings = steps(method, spectrum, count) if method.fixed else tolerances(count)
    began, points, before = time.monotonic(), [], 0.0
    for setting in settings:
        left = share - (time.monotonic() - began)
        # A point is integrated twice at least, and a tighter one takes longer.
        if points and 4 * before > left:
            break
        started = time.monotonic()
        point = bench.point(method, setting, cap=max(left / 2, bench.effort.lap_seconds))
        points.append(point)
        before = time.monotonic() - started
        before = point.seconds or before
        if point.refused or point.slow or _at_round_off(points, bench.floor):
            break
    return points


def _at_round_off(points: list[Point], floor: float) -> bool:
    """The reference cannot tell the last error from none, or two points no longer improve."""
    errors = [p.error for p in points if p.good]
    if errors and errors[-1] < max(ROUND_OFF, 2 * floor):
        return True
    best = min(errors[:-2], default=math.inf)
    return best < EASED and len(errors) > 3 and min(errors[-2:]) > 0.5 * best
