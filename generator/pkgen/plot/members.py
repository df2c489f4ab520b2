"""Rows of many trajectories as lines: a bundle over time, or a cloud of points at one time."""

from __future__ import annotations

import numpy

from .names import amount, shown
from .picture import Line
from .table import Table

FEW = 7  # most members, or times, with a colour and a name each


def few_times(table: Table) -> int:
    """Returns the number of different times of rows if there are few, else 0."""
    count = len(numpy.unique(table.time[: 1 + len(table.data)]))
    rows = len(table.data) / max(1, int(table.member.max(initial=0)) + 1)
    return count if count <= FEW and rows <= FEW else 0


def joined(table: Table, *columns: numpy.ndarray) -> str:
    """Returns "line" if rows are close enough in time to be joined, else "points"."""
    sparse = table.sparse or (not table.several and any(map(table.rough, columns)))
    return "points" if sparse or table.event is not None else "line"


def bundle(
    table: Table,
    x: numpy.ndarray,
    y: numpy.ndarray,
    first: int,
    more: bool,
    z: numpy.ndarray | None = None,
) -> tuple[list[Line], tuple[float, float, str] | None]:
    """Returns lines of y over x: a single line, one per member if they are few, or one for all
    members with the range of their numbers. `first` is the first colour; `more`: there are other
    tables."""
    along = x is table.time or numpy.shares_memory(x, table.time)
    drawn = [column for column in (None if along else x, y, z) if column is not None]
    kind = "points" if table.several and few_times(table) else joined(table, *drawn)
    if not table.several:
        mark = kind == "line" and not along
        return [Line(table.label if more else "", x, y, first, kind, z, marked=mark)], None
    order = numpy.argsort(table.member, kind="stable")  # rows may be sorted by time
    member = table.member[order]
    begins = numpy.flatnonzero(numpy.diff(member, prepend=-1))
    numbers = table.data[order, 0][begins]
    x, y, z = x[order], y[order], None if z is None else z[order]
    word = table.columns[0].name
    if len(begins) <= FEW and not more:
        ends = [*begins[1:], len(member)]
        spans = [slice(a, b) for a, b in zip(begins, ends, strict=True)]
        return [
            Line(f"{word} {n:g}", x[s], y[s], first + k, kind, None if z is None else z[s])
            for k, (n, s) in enumerate(zip(numbers, spans, strict=True))
        ], None
    line = Line(table.label if more else "", x, y, first, kind, z, begins)
    if more or len(numbers) == len(member):  # a single time: one cloud
        return [line], None
    return [line], (float(numbers[0]), float(numbers[-1]), f"member {word}")


def clouds(
    table: Table, x: numpy.ndarray, y: numpy.ndarray, z: list[numpy.ndarray], first: int
) -> list[Line]:
    """Returns points, with a colour for each time."""
    time = table.columns[table.abscissa]
    found = []
    for k, t in enumerate(numpy.unique(table.time)):
        now = table.time == t
        said = f"{shown(time.name)} = {amount(f'{t:.6g}', time.unit)}"
        found.append(Line(said, x[now], y[now], first + k, "points", z[0][now] if z else None))
    return found
