"""`pkgen run --ensemble FILE.csv`: a row a trajectory, what differs from the others in its columns.

The header names columns as --set and --start do: parameters and inputs (`m1`, `k[2]`), coordinates
(`theta1`, `q[1]`) and their rates (`theta1'`). A value is written as there, its unit with it or
left out. What no column names is the same for all: the model's value, or that of --set, --start.
"""

from __future__ import annotations

import array
import csv
import difflib
import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from itertools import chain
from typing import TYPE_CHECKING, TextIO

from .. import limits
from ..compiler import Compilation
from ..equations import Quantity
from ..front.check import options_text
from ..front.check.options_text import OptionError
from ..record import record
from ..system.exits import UsageError
from . import named

if TYPE_CHECKING:
    import numpy

PLAIN = re.compile(r"[-+]?[0-9]+(\.[0-9]+)?([eE][-+]?[0-9]+)?")


@record
class Column:
    """What a column sets: the driver's word for its kind, the index there, its SI unit; `member`
    is of a family of parameters that C has as such."""

    name: str
    kind: str
    index: int
    unit: str
    member: int = 0


@record
class Ensemble:
    """Members of a file or of a scene's swarm, all values in SI."""

    path: str
    columns: tuple[Column, ...]
    lines: Sequence[int]  # where each member stands in the file, or its number in the swarm
    values: array.array | numpy.ndarray = field(repr=False)  # of doubles, member by member
    counted: str = ""  # the variable of a swarm

    @property
    def member(self) -> Quantity:
        """The column that says which member a row is of."""
        if self.counted:
            return Quantity(self.counted, "", "member of the swarm")
        return Quantity("member", "", "row of the ensemble's file, from 1")

    @property
    def title(self) -> str:
        """What its members are from, for the file beside the rows."""
        return f"swarm {self.counted}" if self.counted else os.path.basename(self.path)

    def placed(self, messages: str) -> str:
        """Messages of the run, with the line of the file that a member stands on, or with its
        number in the swarm."""
        if self.counted:
            return re.sub(r"\bmember (-?\d+)", rf"{self.counted} = \1", messages)

        def place(found: re.Match[str]) -> str:
            return f"{self.path}:{self.lines[int(found[1]) - 1]}: "

        return re.sub(r"^run: member (\d+): ", place, messages, flags=re.M)

    def named(self, member: int) -> str:
        """A member, by its number."""
        return f"{self.counted} = {member}" if self.counted else f"member {member}"


def read(path: str, compilation: Compilation) -> Ensemble:
    """The members of a file. Raises UsageError with the place of what is wrong."""
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            return _Reader(path, compilation).read(file)
    except UnicodeDecodeError:
        raise UsageError(f"{path}: not text in UTF-8; save it as CSV in UTF-8") from None
    except csv.Error as error:
        raise UsageError(f"{path}: not CSV: {error}") from None


class Settable(Mapping[str, Column]):
    """What may differ from member to member, by name; families are not written out."""

    def __init__(self, compilation: Compilation):
        self._kinds = {
            "param": named.parameters(compilation),
            "input": named.inputs(compilation),
            "q": named.coordinates(compilation),
            "v": named.coordinates(compilation, rates=True),
        }
        self._looped = compilation.looped
        starts = compilation.report.starts  # now parameters, of which momenta follow
        self._starts = {name + "'" * order: x for (name, order), x in starts.items()}

    def __getitem__(self, name: str) -> Column:
        of = self._starts.get(name, name)
        for kind, known in self._kinds.items():
            if of in known:
                flat, quantity = known[of]
                member = 0
                if kind == "param" and self._looped:
                    flat, member = known.place(flat)
                return Column(name, kind, flat, quantity.unit, member)
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        return chain(*self._kinds.values(), self._starts)

    def __len__(self) -> int:
        return sum(known.count for known in self._kinds.values()) + len(self._starts)


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
            raise UsageError(
                f"{self.path}: the file is empty; its first line names columns, e.g. "
                f"{','.join(list(self.known)[-2:])}"
            )
        columns = tuple(self._column(line, cell) for cell in header)
        for column in columns:
            if columns.count(column) > 1:
                raise UsageError(f"{self.path}:{line}: column {column.name} stands there twice")
        values = array.array("d")
        lines = array.array("q")
        for line, row in rows:
            if len(row) != len(columns):
                raise UsageError(
                    f"{self.path}:{line}: {len(row)} values where the header has "
                    f"{len(columns)} columns"
                )
            values.extend(self._value(line, c, cell) for c, cell in zip(columns, row, strict=True))
            lines.append(line)
            if len(lines) > limits.SWARM or len(values) > limits.SWARM_VALUES:
                raise UsageError(
                    f"{self.path}:{line}: the limit is {limits.SWARM:,} members, and "
                    f"{limits.SWARM_VALUES:,} values in all"
                )
        if not lines:
            raise UsageError(f"{self.path}: no rows below the header; give one a trajectory")
        return Ensemble(self.path, columns, lines, values)

    def _lines(self, file: TextIO) -> Iterator[str]:
        """What never ends, /dev/zero say, is not read to its end."""
        number = 0
        while text := file.readline(limits.ENSEMBLE_LINE):
            number += 1
            if len(text) == limits.ENSEMBLE_LINE:
                most = f"{limits.ENSEMBLE_LINE:,}"
                raise UsageError(f"{self.path}:{number}: a line of more than {most} characters")
            yield text

    def _rows(self, file: TextIO) -> Iterator[tuple[int, list[str]]]:
        """Rows that are not blank, with their lines."""
        reader = csv.reader(self._lines(file), strict=True)
        for row in reader:
            if any(cell.strip() for cell in row):
                yield reader.line_num, [cell.strip() for cell in row]

    def _column(self, line: int, text: str) -> Column:
        place = f"{self.path}:{line}"
        if not text:
            raise UsageError(f"{place}: a column has no name; give that of what it sets")
        try:
            side = options_text.left_side(text, self.sizes)
        except OptionError as error:
            raise UsageError(f"{place}: column {text}: {error.text()}") from None
        name = side.text()
        if name not in self.known:
            near = difflib.get_close_matches(name, self.known, n=1)
            names = list(self.known)
            hint = (
                f"did you mean '{near[0]}'?"
                if near
                else f"it has: {', '.join(names[:12])}{', ...' if len(names) > 12 else ''}"
            )
            raise UsageError(
                f"{place}: column {text}: the model has no such parameter, input, coordinate or "
                f"rate; {hint}"
            )
        return self.known[name]

    def _value(self, line: int, column: Column, text: str) -> float:
        # A bare number is in the SI unit of what it sets: the fast way, as files are long.
        found = float(text) if PLAIN.fullmatch(text) else self._quantity(line, column, text)
        if not math.isfinite(found):
            raise UsageError(f"{self.path}:{line}: column {column.name}: {text} is not finite")
        return found

    def _quantity(self, line: int, column: Column, text: str) -> float:
        place = f"{self.path}:{line}: column {column.name}"
        if not text:
            raise UsageError(f"{place}: a value is missing; give one, or drop the column")
        try:
            return float(
                options_text.quantity(
                    text,
                    column.unit,
                    dimensionless=self.model.dimensionless,
                    values=self.sizes,
                    name=column.name,
                )
            )
        except OptionError as error:
            raise UsageError(f"{place}: {text}: {error.text()}") from None
        except OverflowError:
            raise UsageError(f"{place}: {text} is not finite") from None
