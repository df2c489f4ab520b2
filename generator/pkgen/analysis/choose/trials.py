"""Runs one scene with different methods, and compares the rows with those of an exact run."""

from __future__ import annotations

import math
from dataclasses import field, replace
from pathlib import Path

import numpy

from ...record import record
from ...run.library import Run
from ...run.settings import Settings
from ..chart.measure import Program
from ..chart.rows import Rows, rows_of

LAND, DENSE = "land", "dense"
MANY = 256  # the peaks between rows are computed only for runs of at most so many rows


@record
class Trial:
    """A run of one method at one setting. `error` is the largest error of any column, relative to
    the largest magnitude of the column; it is infinite if the run fails."""

    method: str
    rows: str  # LAND or DENSE
    setting: float
    refused: bool  # whether the method does not apply
    reason: str
    arrived: bool
    slow: bool  # whether the run was stopped at its limit of CPU seconds
    t: float  # last time reached
    seconds: float
    took: float
    steps: int
    compared: int  # number of rows that were compared with the exact rows
    error: float
    holds: float  # time until which the accuracy was kept
    max_step: float | None = None  # upper limit of adaptive steps; None: no limit
    columns: tuple[float, ...] = field(default=(), repr=False)


class Trials(Program):
    """Makes runs of one scene by different methods, and compares their output rows with the rows
    `exact`."""

    def __init__(self, path: Path, settings: Settings):
        super().__init__(path, settings)
        self.spent = 0.0  # CPU seconds of all runs so far
        self.exact: Rows | None = None
        self.ignored: set[int] = set()  # indices of columns
        self.last: Rows | None = None
        self.between: numpy.ndarray | None = None  # the value of Rows.between for the exact rows

    @property
    def without(self) -> bool:
        """Whether rows are written at an event that did not occur in the exact run, so that the
        exact rows are only the start and the end."""
        return self.exact is not None and self.exact.without

    def attempt(
        self,
        method: str,
        setting: float,
        rows: str,
        span: float,
        *,
        accuracy: float = 1.0,
        laps: float = 0.0,
        cap: float = 0.0,
        every: float = 0.0,
        max_step: float | None = None,
    ) -> Trial:
        """Makes one run up to the time `span`. To measure its time, repeats the run until all runs
        together took `laps` seconds. The first run is stopped after `cap` seconds (0: never).
        `every` is the time between rows (0: that of the scene)."""
        bounds = [x for x in (max_step, self.settings.max_step) if x]
        but = {"until": span, "rows": rows, "diagnose": (), "max_step": min(bounds, default=None)}
        but["every"] = every or self.settings.every

        def once(cap: float = 0.0) -> Run:
            return self.run(method, setting, but=but, compared=1, cap=cap)

        done = once(cap)
        found = done.report
        able = bool(found.get("begun"))
        arrived = able and found["code"] >= 0 and not found["slow"]
        fastest = took = found.get("processor", 0.0)
        self.last = self._rows(done)
        columns, error, holds = (), math.inf, 0.0
        if self.exact is not None and able:
            columns, error, holds = self.exact.compare(self.last, accuracy, self.ignored)
        elif self.exact is not None:
            columns = (math.inf,) * self.exact.x.shape[1]
        while arrived and took < laps:
            again = once().report["processor"]
            took += again
            fastest = min(fastest, again)
        self.spent += took
        failed = found.get("reason", "") if found.get("code", 0) < 0 else ""
        return Trial(
            method=method,
            rows=rows,
            setting=found.get("step") or found.get("rtol", setting),
            refused=not able,
            reason=failed or ("" if able else "does not apply"),
            arrived=arrived,
            slow=bool(found.get("slow")),
            t=math.inf if found.get("t", 0.0) is None else float(found.get("t", 0.0)),
            seconds=fastest if arrived else math.inf,
            took=took,
            steps=found.get("steps", 0),
            compared=0 if self.exact is None else len(self.exact.t),
            error=error if arrived else math.inf,
            holds=holds,
            max_step=max_step,
            columns=columns,
        )

    def _rows(self, done: Run) -> Rows:
        at = self.settings.at is not None
        return replace(rows_of(done), by_number=at, without=at and done.report.get("rows") == 0)

    def keep_as_exact(self) -> tuple[float, ...]:
        """Stores the rows of the last run as exact. Returns each column's largest magnitude."""
        self.exact = replace(self.last, between=self.between)
        return tuple(map(float, self.exact.scales))

    def look_between(self, method: str, setting: float, rows: str, span: float) -> None:
        """Measures the largest magnitudes between rows, since a column may be small in all rows,
        such as after each period of an orbit, or at events."""
        if self.settings.at is None and len(self.last.t) > MANY:
            return
        but = {"until": span, "rows": rows, "diagnose": (), "at": None, "every": span / MANY}
        done = self.run(method, setting, but=but, compared=1)
        self.spent += done.report.get("processor", 0.0)
        found = abs(self._rows(done).x)
        if done.report.get("begun") and len(found) and numpy.isfinite(found).all():
            self.between = found.max(axis=0)
