"""Draws rows of many trajectories: as lines over time, or as a cloud of points at one time."""

from __future__ import annotations

import numpy

from .names import amount, shown
from .picture import Line
from .table import Table

FEW = 7  # If there are at most this many members, or times, each has a colour and a name.


def few_times(table: Table) -> int:
    """Returns the number of distinct times of the rows if it is at most FEW, else 0."""
    count = len(numpy.unique(table.time[: 1 + len(table.data)]))
    rows = len(table.data) / max(1, int(table.member.max(initial=0)) + 1)
    return count if count <= FEW and rows <= FEW else 0


def joined(table: Table, *columns: numpy.ndarray) -> str:
    """Returns "line" if rows are so close in time that lines between them do not mislead, else
    "points"."""
    sparse = table.sparse or (not table.several and any(map(table.rough, columns)))
    return "points" if sparse or table.at_events else "line"


def bundle(
    table: Table,
    x: numpy.ndarray,
    y: numpy.ndarray,
    first: int,
    more: bool,
    z: numpy.ndarray | None = None,
) -> tuple[list[Line], tuple[float, float, str] | None]:
    """Returns lines of y over x, and the range of their colour bar or None. A single trajectory is
    one line. A few members are one line each. Many members are one Line with a strand for each.
    `first` is the index of the first colour; `more` says that other tables are drawn in the same
    panel."""
    along = x is table.time or numpy.shares_memory(x, table.time)
    drawn = [column for column in (None if along else x, y, z) if column is not None]
    kind = "points" if table.several and few_times(table) else joined(table, *drawn)
    if not table.several:
        mark = kind == "line" and not along
        return [Line(table.label if more else "", x, y, first, kind, z, marked=mark)], None
    order, begins = table.by_member()
    numbers = table.data[order, 0][begins]
    x, y, z = x[order], y[order], None if z is None else z[order]
    word = table.columns[0].name
    if len(begins) <= FEW and not more:
        parts = [
            numpy.split(v, begins[1:]) if v is not None else len(begins) * [v] for v in (x, y, z)
        ]
        return [
            Line(f"{word} {n:g}", x, y, first + k, kind, z)
            for k, (n, x, y, z) in enumerate(zip(numbers, *parts, strict=True))
        ], None
    line = Line(table.label if more else "", x, y, first, kind, z, begins)
    # No colour bar if there is one row per member (a cloud at a single time).
    if more or len(numbers) == len(order):
        return [line], None
    return [line], (float(numbers[0]), float(numbers[-1]), f"member {word}")


def clouds(
    table: Table, x: numpy.ndarray, y: numpy.ndarray, z: list[numpy.ndarray], first: int
) -> list[Line]:
    """Returns a cloud of points for each time, each in its own colour."""
    time = table.columns[table.abscissa]
    found = []
    for k, t in enumerate(numpy.unique(table.time)):
        now = table.time == t
        said = f"{shown(time.name)} = {amount(f'{t:.6g}', time.unit)}"
        found.append(Line(said, x[now], y[now], first + k, "points", z[0][now] if z else None))
    return found
