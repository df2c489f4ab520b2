"""The map of a sweep: an image of a quantity that the plan keeps (the colour) over two of the
sampled quantities (the axes).

A pixel has the mean of its members. If a sampled quantity has few values, as on a grid, each value
is a pixel. The data set is read by row groups, so that the memory used does not depend on the size
of the data set.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import numpy

from pkgen.plot.picture import Axis, Image, Panel, Picture
from pkgen.record import record
from pkgen.system.exits import UsageError
from pkgen.system.near import near

from .job import AT_START
from .parts import DRAWN, STATUS, STATUSES, arrow
from .shards import DATA
from .store import listed

if TYPE_CHECKING:
    import pyarrow

MOST = 800  # Most pixels along an axis.
# If members are drawn at random, pixels are so large that about this many members are in each.
PER_PIXEL = 8
FAILED = "failed"
GOOD = {name for code, name in STATUSES.items() if code >= 0}


@record(eq=False)
class Map:
    """An image. `values` has a row per value of y; it is NaN for a pixel without a member. `first`
    has the number of one member of each pixel, or 0 if there is none. `averaged` are the sampled
    quantities that are not axes of the image."""

    title: str
    x: Axis
    y: Axis
    value: str
    names: tuple[str, str]
    at_x: numpy.ndarray
    at_y: numpy.ndarray
    values: numpy.ndarray
    first: numpy.ndarray
    # for each pixel, the sampled quantities of the member in `first`
    drawn: dict[str, numpy.ndarray]
    members: int
    without: int
    averaged: tuple[str, ...]

    def picture(self) -> Picture:
        image = Image(self.values, self.at_x, self.at_y, self.value)
        notes = []
        if self.averaged:
            notes.append(f"pixels are means over {', '.join(self.averaged)} too")
        if self.without:
            what = self.value.rpartition(" [")[0] or self.value
            notes.append(f"{self.without:,} of {self.members:,} members have no {what}: left blank")
        panel = Panel(self.x, self.y, image=image)
        return Picture(self.title, (panel,), wide=False, notes=tuple(notes))


def read(path: Path, axes: Sequence[str] = (), value: str = "", most: int = MOST) -> Map:
    """Returns the map of the kept quantity `value` over `axes`, with at most `most` pixels per
    axis; by default the first kept quantity over the first two sampled ones. Raises UsageError."""
    with _opened(path) as reader:
        return reader.map(axes, value, most)


def member(path: Path, number: int) -> dict[str, float]:
    """Returns the values of the sampled quantities of member `number`, by column name. Raises
    UsageError."""
    with _opened(path) as reader:
        for first, *columns in reader.columns(["member", *reader.drawn]):
            if first[0] <= number <= first[-1]:
                row = number - first[0]
                values = (float(x[row]) for x in columns)
                return dict(zip(reader.drawn, values, strict=True))
    raise UsageError(f"{path}: its data set has no member {number}")


@contextmanager
def _opened(path: Path) -> Iterator[_Reader]:
    pa = arrow()
    files = listed(path / DATA, "*.parquet")
    if not files:
        raise UsageError(f"{path}: none of its data set is done: pkgen sweep --status {path}")
    try:
        yield _Reader(path, files, pa.parquet)
    except (pa.ArrowException, OSError) as error:
        raise UsageError(f"{path}/{DATA}: {error}") from None


class _Reader:
    def __init__(self, path: Path, files: list[Path], parquet: ModuleType):
        self.path, self.files, self.parquet = path, files, parquet
        with files[0].open("rb") as file:
            self.schema = parquet.read_schema(file)
        about = {f.name: (f.metadata or {}) for f in self.schema}
        self.units = {name: of.get(b"unit", b"").decode() for name, of in about.items()}
        self.drawn = [
            name for name, of in about.items() if of.get(b"description") == DRAWN.encode()
        ]
        self.kept = [n for n in about if n not in ("member", STATUS, *self.drawn)]

    def map(self, axes: Sequence[str], value: str, most: int) -> Map:
        names = [self._axis(name) for name in axes or self.drawn[:2]]
        if len(names) != 2:
            have = ", ".join(self.drawn) or "none"
            raise UsageError(f"{self.path}: a map has two axes that the plan draws; it has {have}")
        value = value or next((name for name in self.kept if name != "t"), "t")
        if value != FAILED and value not in self.kept:
            said = near(value, [*self.kept, FAILED], "column")
            raise UsageError(f"{self.path}: nothing is kept as {value}; {said}")
        places = self._pixels(names, most)
        shape = (len(places[1].at), len(places[0].at))
        size = shape[0] * shape[1]
        total, count, first = numpy.zeros(size), numpy.zeros(size), numpy.zeros(size, numpy.int64)
        members = without = 0
        drawn = {name: numpy.zeros(size) for name in self.drawn}
        for number, *columns, found in self.columns(["member", *self.drawn], value):
            of = dict(zip(self.drawn, columns, strict=True))
            x, y = (each.of(of[name]) for each, name in zip(places, names, strict=True))
            pixel = y * shape[1] + x
            good = numpy.isfinite(found)
            members += len(found)
            without += len(found) - int(good.sum())
            total += numpy.bincount(pixel[good], found[good], size)
            count += numpy.bincount(pixel[good], minlength=size)
            new, at = numpy.unique(pixel, return_index=True)
            at = at[first[new] == 0]
            first[pixel[at]] = number[at]
            for name, column in of.items():
                drawn[name][pixel[at]] = column[at]
        with numpy.errstate(invalid="ignore"):
            values = (total / count).reshape(shape)
        label = "part of members that failed" if value == FAILED else self._label(value)
        model = json.loads((self.schema.metadata or {}).get(b"pkgen", b"{}")).get("model", "")
        return Map(
            f"{model}: {members:,} members",
            Axis(self._label(names[0]), limits=places[0].ends),
            Axis(self._label(names[1]), limits=places[1].ends),
            label,
            (names[0], names[1]),
            places[0].at,
            places[1].at,
            values,
            first.reshape(shape),
            {name: x.reshape(shape) for name, x in drawn.items()},
            members,
            without,
            tuple(name for name in self.drawn if name not in names),
        )

    def _axis(self, name: str) -> str:
        found = next((n for n in (name, name + AT_START) if n in self.drawn), None)
        if found is None:
            said = near(name, [n.removesuffix(AT_START) for n in self.drawn], "axis")
            raise UsageError(f"{self.path}: the plan draws no {name}; {said}")
        return found

    def _label(self, name: str) -> str:
        unit = self.units[name]
        return f"{name} [{unit}]" if unit else name

    def _pixels(self, names: list[str], most: int) -> list[_Pixels]:
        found = [_Pixels(most), _Pixels(most)]
        members = 0
        for _, *columns in self.columns(["member", *names]):
            members += len(columns[0])
            for pixels, column in zip(found, columns, strict=True):
                pixels.add(column)
        return [pixels.done(members) for pixels in found]

    def columns(self, names: list[str], value: str = "") -> Iterator[list[numpy.ndarray]]:
        """Yields, for each row group of the data set, the columns `names` and the column `value`. A
        missing (null) number is NaN."""
        of = STATUS if value == FAILED else value
        for table in self._groups([*names, *([of] if of else [])]):
            columns = [table.column(name).to_numpy() for name in names]
            if value == FAILED:
                ended = table.column(STATUS).combine_chunks()
                failed = numpy.array([n not in GOOD for n in ended.dictionary.to_pylist()])
                columns.append(failed[ended.indices.to_numpy()].astype(float))
            elif value:
                columns.append(table.column(value).to_numpy(zero_copy_only=False).astype(float))
            yield columns

    def _groups(self, names: list[str]) -> Iterator[pyarrow.Table]:
        for path in self.files:
            with path.open("rb") as file:
                parquet = self.parquet.ParquetFile(file)
                for group in range(parquet.num_row_groups):
                    yield parquet.read_row_group(group, columns=names)


class _Pixels:
    """The pixels along an axis. If the sampled quantity has few values, each value is a pixel;
    otherwise pixels are intervals of equal width."""

    def __init__(self, most: int) -> None:
        self.most = most
        self.low, self.high = numpy.inf, -numpy.inf
        self.values: numpy.ndarray | None = numpy.empty(0)

    def add(self, column: numpy.ndarray) -> None:
        self.low, self.high = min(self.low, column.min()), max(self.high, column.max())
        if self.values is not None:
            self.values = numpy.union1d(self.values, column)
            if len(self.values) > self.most:
                self.values = None

    def done(self, members: int) -> _Pixels:
        if self.values is not None and 2 * len(self.values) > members:
            self.values = None  # nearly every member has its own value: use bins
        if self.values is None:
            bins = int(min(self.most, max(8, numpy.sqrt(members / PER_PIXEL))))
            edges = numpy.linspace(self.low, self.high, bins + 1)
            self.at = (edges[1:] + edges[:-1]) / 2
        else:
            self.at = self.values
        half = (self.at[-1] - self.at[0]) / max(1, len(self.at) - 1) / 2 or 0.5
        self.ends = (self.at[0] - half, self.at[-1] + half)
        return self

    def of(self, column: numpy.ndarray) -> numpy.ndarray:
        if self.values is not None:
            return numpy.searchsorted(self.values, column)
        width = (self.high - self.low) / len(self.at) or 1.0
        return numpy.clip((column - self.low) / width, 0, len(self.at) - 1).astype(numpy.int64)
