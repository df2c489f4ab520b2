"""The cheapest way to an accuracy, by going through every method that applies.

A method of fixed steps makes whole numbers of them between rows, so those are gone through: ever
more until the accuracy is kept, and then between the last that missed and the first that kept it.
Likewise tolerances, by their logarithm. Whatever takes several times as long as the cheapest so
far is given up, for a tighter setting takes longer still.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator
from dataclasses import dataclass

from pkgen.analysis.chart.points import ChartedMethod
from pkgen.analysis.choose.trials import DENSE, LAND, Trial, Trials

FIRST = ("radau", "gauss", "dop853", "gauss8", "gauss4", "rk4")  # so that there is a cheapest soon
GIVEN_UP = 2.5  # times the cheapest
PATIENCE = 0.02  # seconds; what takes less is never given up
LONGEST = 30.0  # times the run that is judged, while nothing has kept the accuracy yet
LEAST = 0.1  # seconds, of that
LOOSEST, TIGHTEST = 1.0, 2.0**-52
LAPS = 0.01
ROUNDS = 5
NEAR = 1.6  # times the cheapest: timed with care


@dataclass(frozen=True)
class Way:
    """A method with how it makes rows, at the loosest setting that keeps the accuracy."""

    method: str
    rows: str
    setting: float
    error: float
    seconds: float


@dataclass
class Chart:
    trials: Trials
    accuracy: float
    until: float
    every: float
    judged: float  # seconds of the run that is judged
    best: float = math.inf

    def ways(self, methods: list[ChartedMethod]) -> list[Way]:
        """Those that keep the accuracy, the cheapest first."""
        ordered = sorted(
            methods,
            key=lambda m: (m.name not in FIRST, FIRST.index(m.name) if m.name in FIRST else 0),
        )
        found = [w for m in ordered for rows in _rows(m) if (w := self._way(m, rows)) is not None]
        cheapest = min((w.seconds for w in found), default=math.inf)
        near = [w for w in found if w.seconds <= NEAR * cheapest]
        timed = self.timed(near)
        rest = [w for w in found if w.seconds > NEAR * cheapest]
        return sorted([*timed, *rest], key=lambda w: w.seconds)

    def timed(self, ways: list[Way]) -> list[Way]:
        """Of rounds in turns, so that what else the machine does is shared, each one's median."""
        seconds: list[list[float]] = [[] for _ in ways]
        for _ in range(ROUNDS):
            for way, found in zip(ways, seconds, strict=True):
                found.append(self._try(way.method, way.setting, way.rows, LAPS).seconds)
        return [
            Way(w.method, w.rows, w.setting, w.error, statistics.median(s))
            for w, s in zip(ways, seconds, strict=True)
        ]

    def _try(self, method: str, setting: float, rows: str, laps: float = 0.0) -> Trial:
        cap = max(PATIENCE, GIVEN_UP * self.best)
        if self.best == math.inf:
            cap = max(LEAST, LONGEST * self.judged)
        return self.trials.attempt(
            method,
            setting,
            rows,
            self.until,
            accuracy=self.accuracy,
            laps=laps,
            cap=0.0 if laps else cap,
        )

    def _way(self, method: ChartedMethod, rows: str) -> Way | None:
        last: Trial | None = None
        for setting in self._settings(method):
            tried = self._try(method.name, setting, rows)
            if tried.refused or tried.slow:
                return None
            if tried.error <= self.accuracy:
                tried = self._loosest(method, rows, last, tried)
                again = self._try(method.name, tried.setting, rows, min(LAPS, 20 * tried.seconds))
                self.best = min(self.best, again.seconds)
                return Way(method.name, rows, tried.setting, tried.error, again.seconds)
            last = tried
        return None

    def _settings(self, method: ChartedMethod) -> Iterator[float]:
        if method.fixed:
            count = 1
            while self.every / count > 1e-13 * self.until:
                yield self.every / count
                count = max(count + 1, math.ceil(1.3 * count))
        else:
            tolerance = LOOSEST
            while tolerance > TIGHTEST:
                yield tolerance
                tolerance /= 4

    def _loosest(
        self, method: ChartedMethod, rows: str, missed: Trial | None, kept: Trial
    ) -> Trial:
        """Between a setting that missed and a tighter one that kept it."""
        if missed is None:
            return kept
        low = missed.setting
        while True:
            if method.fixed:
                a, b = round(self.every / low), round(self.every / kept.setting)
                if b - a <= max(1, b // 40):
                    return kept
                setting = self.every / ((a + b) // 2)
            else:
                if low / kept.setting < 1.15:
                    return kept
                setting = math.sqrt(low * kept.setting)
            tried = self._try(method.name, setting, rows)
            if tried.error <= self.accuracy:
                kept = tried
            else:
                low = setting


def _rows(method: ChartedMethod) -> tuple[str, ...]:
    """Where rows may be made by an interpolant, both ways count."""
    return (LAND, DENSE) if "dense" in method.flags else (LAND,)
