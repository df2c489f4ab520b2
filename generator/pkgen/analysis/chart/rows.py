"""The output rows of runs, and their differences."""

from __future__ import annotations

import math

import numpy

from ...record import record
from ...run.library import Run

Selection = slice | numpy.ndarray


@record
class Rows:
    """The rows of a run at the times t. `x` has the values as doubles. If the scalar type is wider
    than double, x + low has all digits of the values."""

    t: numpy.ndarray
    x: numpy.ndarray  # shape (times, columns)
    low: numpy.ndarray
    by_number: bool = False  # rows are at events: row i of a run is compared with row i of another
    without: bool = False  # rows are at events, but none occurred: only start and end
    between: numpy.ndarray | None = None  # largest magnitude of each column between rows

    @property
    def scales(self) -> numpy.ndarray:
        """Returns the largest magnitude of each column in the whole run."""
        largest = abs(self.x).max(axis=0, initial=0.0)
        return largest if self.between is None else numpy.maximum(largest, self.between)

    def apart(
        self, tried: Rows, mine: Selection = slice(None), its: Selection = slice(None)
    ) -> numpy.ndarray:
        """Returns `tried`, minus these rows, for the selected rows of both."""
        return tried.x[its] - self.x[mine] + (tried.low[its] - self.low[mine])

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
        off = abs(self.apart(tried, there, at[there]))
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


def rows_of(done: Run) -> Rows:
    high, low = done.rows(), done.rows(low=True)
    return Rows(high[:, 0], high[:, 1:], low[:, 1:])
