"""`pkgen run --ensemble FILE`: each row is a trajectory, each column a quantity that varies.

Columns are named as in --set and --start: parameters and inputs (`m1`, `k[2]`), coordinates
(`theta1`, `q[1]`) and their rates (`theta1'`). All other quantities have the value of the model, or
of --set or --start, in all members. A value in CSV is written as in these options, with or without
a unit. A Parquet column may have a unit, as `unit` in the metadata of its field.
"""

from __future__ import annotations

import array
import csv
import math
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from typing import TYPE_CHECKING, TextIO

import numpy

from .. import limits
from ..compiler import Compilation
from ..front.check import options_text
from ..front.check.options_text import OptionError
from ..system.exits import UsageError
from ..system.near import near
from .ensemble import Column, Ensemble, Settable

if TYPE_CHECKING:
    import pyarrow

# A line with another character than those of plain numbers, with a number like .5 or 1., or blank.
ODD = re.compile(r"[^-+0-9.eE,\n]|(?<!\d)\.|\.(?!\d)|^\n")
PLAIN = re.compile(r"[-+]?[0-9]+(\.[0-9]+)?([eE][-+]?[0-9]+)?")


def read(path: str, compilation: Compilation) -> Ensemble:
    """Reads the members of a file. Raises UsageError with the place of an error."""
    if path.endswith(".parquet"):
        return _Reader(path, compilation).parquet()
    try:
        if os.path.isfile(path):  # plain() may fail: a file, unlike a pipe, can be read again
            found = _Reader(path, compilation).plain()
            if found is not None:
                return found
        with open(path, encoding="utf-8-sig", newline="") as file:
            return _Reader(path, compilation).read(file)
    except UnicodeDecodeError:
        raise UsageError(f"{path}: not text in UTF-8; save it as CSV in UTF-8") from None
    except csv.Error as error:
        raise UsageError(f"{path}: not CSV: {error}") from None


def of_columns(path: str, columns: Sequence[Column], values: Sequence[numpy.ndarray]) -> Ensemble:
    """Makes an ensemble of arrays in SI units, one per column; members are numbered by row from 1.
    Raises UsageError."""
    if not values or any(x.shape != values[0].shape or x.ndim != 1 for x in values):
        raise UsageError(f"{path}: members are columns of one length, named as what they set")
    if not len(values[0]):
        raise UsageError(f"{path}: it has no rows; give one a trajectory")
    for column, x in zip(columns, values, strict=True):
        wrong = numpy.flatnonzero(~numpy.isfinite(x))
        if len(wrong):
            row = f"{path}:{wrong[0] + 1}: column {column.name}"
            raise UsageError(f"{row}: a value is missing or not finite")
    members = range(1, len(values[0]) + 1)
    return Ensemble(path, tuple(columns), members, numpy.stack(values, axis=1))


def _plain(lines: Iterable[str]) -> Iterator[str]:
    """Yields lines of plain numbers; raises ValueError at any other line."""
    for line in lines:
        if ODD.search(line):
            raise ValueError
        yield line


class _Reader:
    def __init__(self, path: str, compilation: Compilation):
        self.path = path
        self.model = compilation.model
        self.sizes = {size.name: size.value for size in self.model.sizes}
        self.known = Settable(compilation)

    def read(self, file: TextIO) -> Ensemble:
        rows = self._rows(file)
        line, header = next(rows, (1, None))
        if header is None:
            some = ",".join(list(self.known)[-2:])
            raise UsageError(
                f"{self.path}: the file is empty; its first line names columns, e.g. {some}"
            )
        columns = self._columns(f"{self.path}:{line}", header)
        values = array.array("d")
        lines = array.array("q")
        for line, row in rows:
            if len(row) != len(columns):
                wrong = f"{len(row)} values where the header has {len(columns)} columns"
                raise UsageError(f"{self.path}:{line}: {wrong}")
            values.extend(self._value(line, c, cell) for c, cell in zip(columns, row, strict=True))
            lines.append(line)
            self._bounded(line, len(lines), len(columns))
        if not lines:
            raise UsageError(f"{self.path}: no rows below the header; give one a trajectory")
        return Ensemble(self.path, columns, lines, values)

    def plain(self) -> Ensemble | None:
        """Reads CSV whose cells are all plain numbers; returns None for any other CSV."""
        with open(self.path, encoding="utf-8-sig") as file:
            lines = self._lines(file)
            header, first = next(lines, ""), next(lines, "")
            if not (header.strip() and first) or '"' in header:
                return None
            columns = self._columns(f"{self.path}:1", [cell.strip() for cell in header.split(",")])
            most = min(limits.SWARM, limits.SWARM_VALUES // len(columns)) + 1
            rows, how = _plain(chain((first,), lines)), {"delimiter": ",", "comments": None}
            try:
                values = numpy.loadtxt(rows, max_rows=most, ndmin=2, **how)
            except ValueError:
                return None
        if values.shape[1] != len(columns) or not numpy.isfinite(values).all():
            return None
        members = len(values)
        self._bounded(members + 1, members, len(columns))
        return Ensemble(self.path, columns, range(2, members + 2), values)

    def parquet(self) -> Ensemble:
        """Reads Parquet; members are numbered by row from 1."""
        try:
            import pyarrow.parquet
        except ImportError:
            raise UsageError(
                f"{self.path}: Parquet is read by pyarrow, which is missing: pip install pyarrow"
            ) from None
        try:
            file = pyarrow.parquet.ParquetFile(self.path)
            members, schema = file.metadata.num_rows, file.schema_arrow
            columns = self._columns(self.path, schema.names)
            self._bounded(members, members, len(columns))
            found = [self._of_parquet(file, *one) for one in zip(columns, schema, strict=True)]
        except (pyarrow.ArrowException, OSError, MemoryError, ValueError) as error:
            if isinstance(error, OSError) and error.errno is not None:
                raise
            why = " ".join(str(error).split()) or "more than fits in memory"
            raise UsageError(f"{self.path}: not Parquet that can be read: {why[:200]}") from None
        return of_columns(self.path, columns, found)

    def _of_parquet(self, file: pyarrow.parquet.ParquetFile, column: Column, one: pyarrow.Field):
        """Returns the numbers of one column of a Parquet file, converted to SI units."""
        import pyarrow

        if not (pyarrow.types.is_floating(one.type) or pyarrow.types.is_integer(one.type)):
            raise UsageError(f"{self.path}: column {column.name}: {one.type} is no number")
        read = file.read([one.name]).column(0)
        unit = ((one.metadata or {}).get(b"unit") or b"").decode(errors="replace")
        factor = self._quantity(0, column, f"1 [{unit}]") if unit else 1.0
        return read.to_numpy().astype(float, copy=False) * factor

    def _bounded(self, line: int, members: int, columns: int) -> None:
        if members > limits.SWARM or members * columns > limits.SWARM_VALUES:
            raise UsageError(
                f"{self.path}:{line}: the limit is {limits.SWARM:,} members, and "
                f"{limits.SWARM_VALUES:,} values in all"
            )

    def _lines(self, file: TextIO) -> Iterator[str]:
        """Yields lines; raises UsageError at one that is too long, or endless as in /dev/zero."""
        number = 0
        while text := file.readline(limits.ENSEMBLE_LINE):
            number += 1
            if len(text) == limits.ENSEMBLE_LINE:
                most = f"{limits.ENSEMBLE_LINE:,}"
                raise UsageError(f"{self.path}:{number}: a line of more than {most} characters")
            yield text

    def _rows(self, file: TextIO) -> Iterator[tuple[int, list[str]]]:
        """Yields (line number, cells) of rows that are not blank."""
        reader = csv.reader(self._lines(file), strict=True)
        for row in reader:
            if any(cell.strip() for cell in row):
                yield reader.line_num, [cell.strip() for cell in row]

    def _columns(self, place: str, header: Sequence[str]) -> tuple[Column, ...]:
        columns = tuple(self._column(place, cell) for cell in header)
        for column in columns:
            if columns.count(column) > 1:
                raise UsageError(f"{place}: column {column.name} stands there twice")
        return columns

    def _column(self, place: str, text: str) -> Column:
        if not text:
            raise UsageError(f"{place}: a column has no name; give that of what it sets")
        try:
            side = options_text.left_side(text, self.sizes)
        except OptionError as error:
            raise UsageError(f"{place}: column {text}: {error.text()}") from None
        name = side.text()
        if name not in self.known:
            what = "the model has no such parameter, input, coordinate or rate"
            hint = near(name, list(self.known), "quantity")
            raise UsageError(f"{place}: column {text}: {what}; {hint}")
        return self.known[name]

    def _value(self, line: int, column: Column, text: str) -> float:
        # A plain number is in SI units; long files need this fast case.
        found = float(text) if PLAIN.fullmatch(text) else self._quantity(line, column, text)
        if not math.isfinite(found):
            raise UsageError(f"{self.path}:{line}: column {column.name}: {text} is not finite")
        return found

    def _quantity(self, line: int, column: Column, text: str) -> float:
        """Parses a value with a unit; `line` is its line number for messages, or 0."""
        place = f"{self.path}{f':{line}' if line else ''}: column {column.name}"
        if not text:
            raise UsageError(f"{place}: a value is missing; give one, or drop the column")
        try:
            how = {"dimensionless": self.model.dimensionless, "values": self.sizes}
            return float(options_text.quantity(text, column.unit, **how, name=column.name))
        except OptionError as error:
            raise UsageError(f"{place}: {text}: {error.text()}") from None
        except OverflowError:
            raise UsageError(f"{place}: {text} is not finite") from None
