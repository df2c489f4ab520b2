"""Finds the loosest settings that keep an accuracy, between the points of a sweep.

A point is a run of a method at one setting. It keeps an accuracy by luck if a slightly finer run
does not: the error may change its sign near the setting, or may be round-off that happens to be
small. Therefore the method of each possible answer is also run at FINER times its setting. Other
measured points in this range of settings count too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

from .points import AXES, ChartedMethod, Point, Track
from .scale import ROUNDING, divided, two_digits
from .sweep import TIGHTEST, Bench

# Factors on the setting of a point: True: on a fixed step size, False: on a tolerance.
FINER = {True: (0.97, 0.92, 0.87), False: (0.8, 0.5, 0.3)}
LOOSER = {True: (1.06, 1.12, 1.18, 1.25), False: (1.8, 3.2, 6.0, 10.0)}
TRIALS = 12  # largest number of trials to find the loosest setting of a method for an accuracy
NEAR = 1.03  # a trial must promise to be cheaper than the best point by this factor
AIM = 0.8  # intended error of a trial, relative to the accuracy
# Bounds on the setting of a trial, between those of the looser point (0) and the tighter point (1).
INNER = (0.25, 0.75)
# Errors of a method still fall if a setting finer by COARSER multiplies them by less than FALLING.
COARSER, FALLING = 1.5, 0.7
FOREMOST = 3  # largest number of methods that are measured in one round of _go_on()
UNSEEN = 1e-2  # if the error of a method is unknown: intended ratio of the next to the last error
ROUNDS, TIMED = 3, 1.5  # rounds of timing; points within TIMED times the fastest take part


class Search:
    """The points of every method, including those that the search measures."""

    def __init__(self, bench: Bench, tracks: list[Track]):
        self.bench = bench
        self.methods = {track.method.name: track.method for track in tracks}
        self.points = {t.method.name: sorted(t.points, key=lambda p: -p.setting) for t in tracks}
        self.measured = 0

    @property
    def left(self) -> float:
        return self.bench.effort.left()

    def good(self) -> list[Point]:
        return [p for points in self.points.values() for p in points if p.good]

    def tracks(self, accuracies: list[float]) -> list[Track]:
        """Returns the points of every method (a Track each). A point that keeps an accuracy, but is
        cheaper than the answer for it, was rejected as an answer and is marked as lucky."""
        best = {(a, x): self.cheapest(a, x) for a in accuracies for x in AXES}

        def lucky(p: Point) -> bool:
            return any(
                _met(p, a) and (b is None or _cost(p, x) < _cost(b, x))
                for (a, x), b in best.items()
            )

        return [
            Track(m, tuple(replace(p, lucky=lucky(p)) for p in self.points[m.name]))
            for m in self.methods.values()
        ]

    def cheapest(self, accuracy: float, axis: str) -> Point | None:
        able = sorted((p for p in self.good() if _met(p, accuracy)), key=lambda p: _cost(p, axis))
        return next((p for p in able if self.keeps(p, accuracy)), None)

    def keeps(self, point: Point, accuracy: float) -> bool:
        """Whether the point keeps the accuracy, and slightly finer points too."""
        if not _met(point, accuracy):
            return False
        method = self.methods[point.method]
        bounds = [point.setting, *self._finer(method, point.setting)]
        between = [self._within(method, low, high) for high, low in pairwise(bounds)]
        if any(not _met(p, accuracy) for near in between for p in near):
            return False
        for near, setting in zip(between, bounds[1:], strict=True):
            if not near and (p := self._measure(method, setting)) and not _met(p, accuracy):
                return False
        if any(self._within(method, bounds[-1], point.setting)):
            return True
        tighter = self._within(method, 0.0, point.setting)  # for want of finer runs
        return not tighter or _met(tighter[0], accuracy)

    def refine(self, accuracy: float) -> None:
        """Measures the methods that may be cheapest at their loosest setting for the accuracy."""
        for axis in AXES:
            for _ in range(TRIALS):
                if not self._go_on(accuracy, axis):
                    break
            foreseen = ((self._bracket(m, accuracy, False), m) for m in self.methods.values())
            able = [(_least(m, b, axis) * _cost(b[1], axis), m) for b, m in foreseen if b]
            for _, method in sorted(able, key=lambda pair: pair[0]):
                self._close_in(method, accuracy, axis)

    def unmeasured(self, accuracy: float, axis: str) -> tuple[str, ...]:
        """Returns the methods that may be cheaper than the answer, but were not measured since the
        time is up: the methods of _ahead(), and methods with an untried setting between a point
        that keeps the accuracy and a looser point that misses it."""
        if self.left > 0:
            return ()
        best = _cost(self.cheapest(accuracy, axis), axis)
        found = [method.name for _, method, _ in self._ahead(accuracy, axis)]
        for name, method in self.methods.items():
            bracket = self._bracket(method, accuracy, True)
            if bracket and bracket[0] is not bracket[1]:
                gap = NEAR * _least(method, bracket, axis) < min(best, _cost(bracket[1], axis))
                between = self._between(method, *bracket, accuracy)
                found += [name] if gap and not self._known(name, between) else []
        return tuple(found)

    def time_again(self, accuracy: float) -> None:
        """Repeats the timing of each nearly fastest method in turns, at its loosest and its fastest
        point."""
        least = _cost(self.cheapest(accuracy, "seconds"), "seconds")
        able = []
        for points in self.points.values():
            soon = [p for p in points if _met(p, accuracy) and self._soonest(p) <= TIMED * least]
            kept = [p for p in soon if self.keeps(p, accuracy)]
            able += kept[:1]
            able += sorted(kept[1:], key=self._soonest)[:1]
        for _ in range(ROUNDS):
            for p in able:
                self._measure(self.methods[p.method], p.setting, again=True)

    def _soonest(self, point: Point) -> float:
        """Returns the seconds that a point takes at its method's fastest rate of evaluations, since
        other load on the machine may have slowed this run."""
        paces = [p.seconds / p.work for p in self.points[point.method] if p.seconds and p.work]
        return min(_cost(point, "seconds"), (point.work or math.inf) * min(paces, default=math.inf))

    def _close_in(self, method: ChartedMethod, accuracy: float, axis: str) -> None:
        for _ in range(TRIALS):
            found = self._bracket(method, accuracy, True)
            best = self.cheapest(accuracy, axis)
            if not found or found[0] is found[1]:
                return
            loose, tight = found
            if _least(method, found, axis) * NEAR > min(_cost(tight, axis), _cost(best, axis)):
                if not self._looser(method, tight, accuracy, _cost(best, axis), axis):
                    return
            elif self._measure(method, self._between(method, loose, tight, accuracy)) is None:
                return

    def _looser(
        self, method: ChartedMethod, tight: Point, accuracy: float, best: float, axis: str
    ) -> bool:
        """Measures points at LOOSER times the setting of `tight`. Errors of long steps need not be
        monotonic, so a looser point may keep the accuracy although a point between the two misses
        it. Returns whether one of the measured points keeps the accuracy."""
        found = False
        for part in LOOSER[method.fixed] if _cost(tight, axis) < LOOSER[True][-1] * best else ():
            setting = tight.setting * part
            setting = divided(self.bench.until, setting) if method.fixed else two_digits(setting)
            point = self._measure(method, setting)
            found |= point is not None and self.keeps(point, accuracy)
        return found

    def _go_on(self, accuracy: float, axis: str) -> bool:
        """Measures the next point of the first methods of _ahead(). Returns whether there was such
        a method."""
        able = self._ahead(accuracy, axis)[:FOREMOST]
        return any([self._measure(method, setting) for _, method, setting in able])

    def _ahead(self, accuracy: float, axis: str) -> list[tuple[float, ChartedMethod, float]]:
        """Returns methods that may be cheaper than the cheapest one for this accuracy. Their sweep
        ended before it reached the accuracy, while errors still fell. Each element has the forecast
        cost, the method, and the setting to try next."""
        best = _cost(self.cheapest(accuracy, axis), axis)
        ahead = []
        for name, method in self.methods.items():
            points = self.points[name]
            good = [p for p in points if p.good]
            last = good[-1] if good else points[-1]
            met = best < math.inf and any(_met(p, accuracy) for p in good)
            if last.refused or met or (not good and len(points) >= self.bench.effort.points):
                continue
            before = [p for p in good if p.setting > COARSER * last.setting]
            if len(good) > 1 and not (
                before and (last.error or 0.0) < FALLING * (before[-1].error or 0.0)
            ):
                continue
            order = max(1, method.order)
            share = min(AIM * accuracy / (last.error or 1.0), 1 / COARSER) if good else UNSEEN
            finer = share ** (1 / order)  # factor from the last step size to the next one
            setting = divided(self.bench.until, last.setting * finer)
            if not method.fixed:
                setting = max(two_digits(last.setting * share), TIGHTEST)
            cost = (_cost(last, axis) if good else last.took * (axis == "seconds")) / finer
            late = any(p.slow and p.setting < last.setting for p in points)
            if setting < last.setting and NEAR * cost < best and not late:
                ahead.append((cost, method, setting))
        return sorted(ahead, key=lambda x: x[0])

    def _bracket(
        self, method: ChartedMethod, accuracy: float, judged: bool
    ) -> tuple[Point, Point] | None:
        """Returns the loosest point that keeps the accuracy, preceded by the next looser point, or
        by itself if there is none."""
        points = [p for p in self.points[method.name] if not p.slow]
        for k, p in enumerate(points):
            if self.keeps(p, accuracy) if judged else _met(p, accuracy):
                return points[max(k - 1, 0)], p
        return None

    def _between(self, method: ChartedMethod, loose: Point, tight: Point, accuracy: float) -> float:
        share = 0.5
        if loose.good and loose.error and tight.error and loose.error > accuracy > tight.error:
            aim = max(AIM * accuracy, math.sqrt(accuracy * tight.error))
            share = math.log(loose.error / aim) / math.log(loose.error / tight.error)
        share = min(max(share, INNER[0]), INNER[1])
        setting = loose.setting * (tight.setting / loose.setting) ** share
        return divided(self.bench.until, setting) if method.fixed else two_digits(setting)

    def _finer(self, method: ChartedMethod, setting: float) -> Iterator[float]:
        until = self.bench.until
        for k, part in enumerate(FINER[method.fixed], 1):
            if not method.fixed:
                yield two_digits(setting * part)
            else:
                whole = round(until / setting)
                yield until / max(whole + k, round(whole / part))

    def _within(self, method: ChartedMethod, low: float, high: float) -> list[Point]:
        """Returns the points with low <= setting < high, from loose to tight, without refused runs
        and runs stopped at the time limit."""
        return [
            p
            for p in self.points[method.name]
            if low * (1 - ROUNDING) <= p.setting < high * (1 - ROUNDING)
            and not (p.slow or p.refused)
        ]

    def _known(self, name: str, setting: float) -> Point | None:
        points = self.points[name]
        return next((p for p in points if math.isclose(p.setting, setting, rel_tol=ROUNDING)), None)

    def _measure(self, method: ChartedMethod, setting: float, again: bool = False) -> Point | None:
        """Measures a method at a setting and returns the point. Returns None if the point is
        already known, if it cannot be used, or if the time is up."""
        known, old = self.points[method.name], self._known(method.name, setting)
        if self.left <= 0 or (old is not None and not again):
            return None
        # Only points that may be the fastest are timed by repetitions.
        lap = self.bench.effort.lap_seconds if again else 0.0
        point = self.bench.point(method, setting, cap=self.bench.effort.seconds / 4, lap=lap)
        if old is not None:
            if old.seconds and point.seconds and point.seconds < old.seconds:
                known[known.index(old)] = replace(old, seconds=point.seconds)
            return None
        self.measured += 1
        known.append(point)
        known.sort(key=lambda p: -p.setting)
        return None if point.slow or point.refused else point


def _met(point: Point, accuracy: float) -> bool:
    return point.good and point.error is not None and point.error <= accuracy


def _cost(point: Point | None, axis: str) -> float:
    cost = point.cost(axis) if point else None
    return math.inf if cost is None else cost


def _least(method: ChartedMethod, bracket: tuple[Point, Point], axis: str) -> float:
    """Returns the least cost that a setting between the two points may have."""
    loose, tight = bracket
    foreseen = _cost(tight, axis) * tight.setting / loose.setting if method.fixed else 0.0
    return _cost(loose, axis) if loose.arrived else foreseen
