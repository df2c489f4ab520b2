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

LAND, DENSE = "land", "dense"
MANY = 256  # a run with more rows is not searched for larger magnitudes between rows


@record
class Trial:
    """A run of one method at one setting. `error` is the largest error of any column, relative to
    the largest magnitude of the column; it is infinite if the run fails."""

    method: str
    rows: str  # LAND or DENSE
    setting: float
    able: bool  # whether the method applies
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

    @property
    def refused(self) -> bool:
        return not self.able


@record
class Rows:
    """The rows of a run at the times t. `x` has the values as doubles. If the scalar type is wider
    than double, x + low has all digits of the values."""

    t: numpy.ndarray
    x: numpy.ndarray  # shape (times, columns)
    low: numpy.ndarray
    by_number: bool  # rows are at events: row i of a run is compared with row i of another
    without: bool = False  # rows are at events, but none occurred: only start and end
    between: numpy.ndarray | None = None  # largest magnitude of each column between rows

    @property
    def scales(self) -> numpy.ndarray:
        """Returns the largest magnitude of each column in the whole run."""
        largest = abs(self.x).max(axis=0, initial=0.0)
        return largest if self.between is None else numpy.maximum(largest, self.between)

    def found_in(self, tried: Rows) -> numpy.ndarray:
        """Returns, for each of these rows, the index of the row of `tried` at the same time, or -1
        if there is none. Rows at the same time have equal doubles as times. An exception is the
        last row, which may be at the time of an event."""
        count, theirs = len(self.t), len(tried.t)
        if self.by_number:
            at = numpy.arange(count)
            at[at >= theirs] = -1
            if count and theirs != count:
                at[-1] = -1
            return at
        at = numpy.searchsorted(tried.t, self.t)
        missing = at >= theirs
        missing[~missing] = tried.t[at[~missing]] != self.t[~missing]
        if count and missing[-1] and theirs and at[-1] >= theirs - 1:
            at[-1], missing[-1] = theirs - 1, False
        return numpy.where(missing, -1, at)

    def compare(
        self, tried: Rows, accuracy: float, ignored: set[int]
    ) -> tuple[tuple[float, ...], float, float]:
        """Compares the rows `tried` with these rows. Returns the largest error of each column,
        relative to the scale of the column in these rows; the largest of all errors; and the time
        until which errors are within the accuracy. The last two results leave out the columns
        `ignored`."""
        at = self.found_in(tried)
        there = at >= 0
        errors = numpy.full(self.x.shape, math.inf)
        off = abs(tried.x[at[there]] - self.x[there] + (tried.low[at[there]] - self.low[there]))
        with numpy.errstate(divide="ignore", invalid="ignore"):
            relative = numpy.where(off == 0, 0.0, off / self.scales)
        errors[there] = numpy.where(relative < math.inf, relative, math.inf)
        kept = [i for i in range(self.x.shape[1]) if i not in ignored]
        row = errors[:, kept].max(axis=1, initial=0.0)
        row[~there] = math.inf
        if len(self.t) and self.t[-1] > 0:  # the error of a row's time, at an event, counts too
            row[there] = numpy.maximum(
                row[there], abs(tried.t[at[there]] - self.t[there]) / self.t[-1]
            )
        beyond = numpy.flatnonzero(~(row <= accuracy))
        held = len(row) if not len(beyond) else beyond[0]
        holds = float(self.t[held - 1]) if held else 0.0
        return (
            tuple(map(float, errors.max(axis=0, initial=0.0))),
            float(row.max(initial=0.0)),
            holds,
        )


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
            able=able,
            reason=failed or ("" if able else "does not apply"),
            arrived=arrived,
            slow=bool(found.get("slow")),
            t=_number(found.get("t", 0.0)),
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
        high, low = done.rows(), done.rows(low=True)
        at = self.settings.at is not None
        without = at and done.report.get("rows") == 0
        return Rows(high[:, 0], high[:, 1:], low[:, 1:], at, without)

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

    def ignore(self, column: int) -> None:
        self.ignored.add(column)


def _number(x: float | None) -> float:
    return math.inf if x is None else float(x)
