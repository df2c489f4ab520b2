"""Reads the CSV files of tables, and makes piecewise polynomials of their columns."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from .. import limits
from ..functions.tables import AT_ENDS, SMOOTH, Axis, Data
from ..record import record
from ..system.exits import UsageError

if TYPE_CHECKING:
    import numpy

KINDS = ("linear", "spline", "pchip", "hold")
OF_GRIDS = {"bilinear": "linear", "bicubic": "spline"}
OUTSIDE = ("error", "hold", "linear", "periodic")
_TITLE = re.compile(r"\s*(.*?)\s*(?:\[([^\[\]]*)\]\s*)?")


Brought = Path | tuple["numpy.ndarray", ...]  # a file, or the arrays of the columns in SI units
_NONE: Mapping[str, Brought] = MappingProxyType({})
_BROUGHT: ContextVar[Mapping[str, Brought]] = ContextVar("brought", default=_NONE)


@contextmanager
def bringing(tables: Mapping[str, Brought]) -> Iterator[None]:
    """Within the context, models read the tables with these names from other files or arrays."""
    token = _BROUGHT.set(tables)
    try:
        yield
    finally:
        _BROUGHT.reset(token)


def brought() -> Mapping[str, Brought]:
    return _BROUGHT.get()


def of_options(texts: Sequence[str]) -> dict[str, Brought]:
    """Returns the files of the options `--table NAME=FILE`. Raises UsageError."""
    found: dict[str, Brought] = {}
    for text in texts:
        name, equal, path = text.partition("=")
        if not (name and equal and path) or name in found:
            raise UsageError(f"--table {text}: give a table once, e.g. --table road=other.csv")
        found[name] = Path(path)
    return found


class WrongData(Exception):
    """A file that is no table; the message begins with the place in it, and `help` is a hint."""

    def __init__(self, message: str, help: str = ""):
        super().__init__(message)
        self.help = help


@record
class Cells:
    """The cells of a file: the line and the texts of each row, and the titles of the columns."""

    path: str
    titles: tuple[tuple[str, str], ...]  # name and unit, "" if there is none
    lines: tuple[int, ...]
    rows: tuple[list[str], ...]

    def wrong(self, row: int, column: int, why: str, help: str = "") -> WrongData:
        """Returns an error at a cell. The column counts characters, as in a text editor."""
        at = 1 + sum(len(cell) + 1 for cell in self.rows[row][:column])
        return WrongData(f"{self.path}:{self.lines[row]}:{at}: {why}", help)


def read(path: Path) -> Cells:
    """Returns the cells of a file. Raises WrongData."""
    try:
        found = path.stat()
        if not path.is_file():
            raise WrongData(f"{path}: this is no file of data")
        if found.st_size > limits.TABLE_BYTES:
            raise WrongData(f"{path}: the file has more than {limits.TABLE_BYTES:,} bytes")
        return _cells(path, found.st_mtime_ns, found.st_size)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise WrongData(f"{path}: cannot read it: {reason}") from None


@lru_cache(maxsize=4)
def _cells(path: Path, *_: int) -> Cells:
    with open(path, encoding="utf-8-sig") as file:
        kept = [(k + 1, x) for k, x in enumerate(file) if x.strip() and x.lstrip()[0] != "#"]
    comma = next((c for c in ";\t" if kept and c in kept[0][1]), ",")
    rows = []
    for line, text in kept:
        try:
            rows += csv.reader([text], delimiter=comma, strict=True)
        except csv.Error as error:
            raise WrongData(f"{path}:{line}:1: {error}") from None
    cells = Cells(str(path), (), tuple(line for line, _ in kept), tuple(rows))
    for k, row in enumerate(rows):
        if len(row) > len(rows[0]) and any(map(str.strip, row[len(rows[0]) :])):
            help = "a number has a point, not a comma"
            raise cells.wrong(k, len(rows[0]), "the first row has fewer cells", help)
    names = [
        k for k, cell in enumerate(rows[0] if rows else ()) if cell.strip() and not _float(cell)
    ]
    if not names:
        return cells
    if len(names) < sum(bool(cell.strip()) for cell in rows[0]):
        shown = rows[0][names[0]].strip()[:40]
        raise cells.wrong(0, names[0], f"'{shown}' is no number, though others of its row are")
    titles = tuple(_TITLE.fullmatch(cell).groups("") for cell in rows[0])
    return replace(cells, titles=titles, lines=cells.lines[1:], rows=cells.rows[1:])


def _float(cell: str) -> list[float]:
    """Returns the number in a cell, which may be infinite or NaN; [] for another text."""
    try:
        return [] if "_" in cell else [float(cell)]
    except ValueError:
        return []


def columns(
    cells: Cells, wanted: Sequence[tuple[str, str]]
) -> tuple[list[numpy.ndarray], list[int]]:
    """Returns the columns with the wanted (name, unit), and their numbers. If the file has none of
    these names, returns its first columns. Raises WrongData."""
    import numpy

    names = [name for name, _ in cells.titles]
    places = [names.index(name) if name in names else -1 for name, _ in wanted]
    if twice := [name for name, _ in wanted if names.count(name) > 1]:
        raise WrongData(f"{cells.path}: there are two columns '{twice[0]}'", "rename one of them")
    if max(places) < 0:
        places = [*range(len(wanted))]
    for (name, unit), k in zip(wanted, places, strict=True):
        if k < 0:
            has = ", ".join(names)
            raise WrongData(f"{cells.path}: there is no column '{name}'", f"it has: {has}")
        given = cells.titles[k][1] if k < len(cells.titles) else ""
        if given and given.replace(" ", "") != unit.replace(" ", ""):
            message = f"{cells.path}: the column '{names[k]}' is in [{given}], not in [{unit}]"
            raise WrongData(message, "give the unit that the file has")
    if len(cells.rows) < 2:
        raise WrongData(f"{cells.path}: a table has two rows of numbers at least")
    return [
        numpy.array([_cell(cells, i, k) for i in range(len(cells.rows))]) for k in places
    ], places


def _cell(cells: Cells, row: int, column: int) -> float:
    found = cells.rows[row]
    if column >= len(found) or not found[column].strip():
        at = min(column, len(found))
        raise cells.wrong(row, at, f"column {column + 1} has no number here", "remove the row")
    value = _float(found[column])
    if not value or not math.isfinite(value[0]):
        shown = found[column].strip()[:40]
        help = "a number has a point, not a comma" if "," in shown else ""
        raise cells.wrong(row, column, f"'{shown}' is no finite number", help)
    return value[0]


def curve(cells: Cells, wanted, factors: Sequence[float], kind: str, outside: str) -> Data:
    """Returns the table of one variable. Raises WrongData."""
    (x, y), places = columns(cells, wanted)
    for k in (x[1:] <= x[:-1]).nonzero()[0][:1]:
        why = f"{x[k + 1]:g} is not above {x[k]:g}, the value before it"
        raise cells.wrong(int(k) + 1, places[0], why, "put the rows in rising order")
    return of_arrays([x * factors[0]], y * factors[1], kind, outside, cells.path)


def grid(cells: Cells, wanted, factors: Sequence[float], kind: str, outside: str) -> Data:
    """Returns the table of two variables; each pair of values has one row. Raises WrongData."""
    import numpy

    (x, y, z), places = columns(cells, wanted)
    (knots_x, i), (knots_y, j) = (numpy.unique(v, return_inverse=True) for v in (x, y))
    found = numpy.full((len(knots_x), len(knots_y)), -1)
    for row, at in enumerate(zip(i, j, strict=True)):
        if found[at] >= 0:
            message = f"these values are in line {cells.lines[found[at]]} too"
            raise cells.wrong(row, places[0], message, "a grid has each pair of values once")
        found[at] = row
    if (found < 0).any():
        a, b = numpy.argwhere(found < 0)[0]
        message = (
            f"there is no row of {wanted[0][0]} = {knots_x[a]:g}, {wanted[1][0]} = {knots_y[b]:g}"
        )
        raise WrongData(f"{cells.path}: {message}", "a grid has a row of each pair of values")
    if min(found.shape) < 2:
        raise WrongData(f"{cells.path}: a grid has two values of each variable at least")
    axes = [knots_x * factors[0], knots_y * factors[1]]
    return of_arrays(axes, z[found] * factors[2], kind, outside, cells.path)


def of_arrays(
    axes: Sequence[numpy.ndarray], values: numpy.ndarray, kind: str, outside: str, name: str
) -> Data:
    """Returns the table with these knots and values, of shape (knots, knots) in a grid. `name` says
    in messages where the data are from. Raises WrongData."""
    import numpy

    kind = OF_GRIDS.get(kind, kind)
    axes, values = [numpy.array(x, dtype=float) for x in axes], numpy.array(values, dtype=float)
    for x in axes:
        if x.ndim != 1 or len(x) < 2 or not (numpy.diff(x) > 0).all():
            raise WrongData(f"{name}: a variable has two values at least, in rising order")
    if values.shape != tuple(map(len, axes)):
        raise WrongData(f"{name}: the values have another shape than the variables")
    if not all(numpy.isfinite(x).all() for x in (*axes, values)):
        raise WrongData(f"{name}: a number is not finite")
    if outside == "periodic" and kind != "hold":
        for k in range(len(axes)):
            if (values.take(0, k) != values.take(-1, k)).any():
                help = "a period ends with its first value"
                raise WrongData(f"{name}: the last value is not the first one", help)
    made, c = [], values
    smooth = min(SMOOTH[kind], AT_ENDS[outside])
    for number, x in enumerate(axes):
        try:
            with numpy.errstate(all="ignore"):
                c = _coefficients(x, c, kind, outside, axis=2 * number)
        except ValueError:  # of SciPy, for slopes that are not finite
            c = numpy.full(1, numpy.nan)
        if not numpy.isfinite(c).all():
            raise WrongData(f"{name}: the rows are too close for their values")
        x.flags.writeable = False
        period = float(x[-1] - x[0]) if outside == "periodic" else 0.0
        made.append(Axis(x, period, outside == "error", smooth))
    if len(axes) == 2:
        c = c.swapaxes(1, 2)
    c = numpy.ascontiguousarray(c)
    c.flags.writeable = False
    return Data(tuple(made), c, {"hold": 0, "linear": 1}.get(kind, 3))


def _coefficients(
    x: numpy.ndarray, y: numpy.ndarray, kind: str, outside: str, axis: int
) -> numpy.ndarray:
    """Replaces an axis of values by two: the pieces, with one below and one above the knots, and
    the coefficients by rising powers."""
    import numpy

    y = numpy.moveaxis(y, axis, 0)
    width = (slice(None), *[None] * (y.ndim - 1))
    c = numpy.zeros((len(x) + 1, 4, *y.shape[1:]))
    c[1:-1, 0] = y[:-1]
    if kind == "linear":
        c[1:-1, 1] = numpy.diff(y, axis=0) / numpy.diff(x)[width]
    elif kind != "hold":
        c[1:-1] = _cubics(x, y, kind, outside == "periodic")
    h, last = x[-1] - x[-2], c[-2]
    if kind == "hold":
        c[0, 0], c[-1, 0] = y[0], y[-1]
    else:  # The polynomials at the ends go on outside, as far as `outside` lets them.
        c[0] = c[1]
        for k in range(4):
            c[-1, k] = sum(math.comb(i, k) * last[i] * h ** (i - k) for i in range(k, 4))
        c[-1, 0] = y[-1]
        beyond = {"hold": 1, "linear": 2}.get(outside, 4)
        c[0, beyond:] = c[-1, beyond:] = 0
    return numpy.moveaxis(c, (0, 1), (axis, axis + 1))


def _cubics(x: numpy.ndarray, y: numpy.ndarray, kind: str, periodic: bool) -> numpy.ndarray:
    import numpy
    from scipy.interpolate import CubicSpline, PchipInterpolator

    if kind == "spline":
        found = CubicSpline(x, y, bc_type="periodic" if periodic else "not-a-knot")
        return numpy.moveaxis(found.c[::-1], 1, 0)
    if not periodic:
        return numpy.moveaxis(PchipInterpolator(x, y).c[::-1], 1, 0)
    # A slope depends on the two neighbours: three periods have the same slopes at both ends.
    p, n = x[-1] - x[0], len(x) - 1
    three = PchipInterpolator([*(x[:-1] - p), *x, *(x[1:] + p)], [*y[:-1], *y, *y[1:]])
    return numpy.moveaxis(three.c[::-1, n : 2 * n], 1, 0)
