"""Tables of rows to draw, with names and units of columns, from a run or a file.

Units of a CSV file are in its header (`x [m]`) or in FILE.csv.json, its metadata; else unknown.
Tables of other programs are accepted. The abscissa is the column t, or else the first column.
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import field, replace
from pathlib import Path

import numpy
from numpy.lib.recfunctions import structured_to_unstructured

from ..equations import Quantity
from ..record import record
from ..system.exits import UsageError
from ..system.files import PARTIAL, beside
from ..system.near import near
from .names import label
from .picture import Axis

# For a column with eight rows per period: RMS of the change between rows, relative to the standard
# deviation.
COARSE = 0.77
CONSTANT = 1e-7  # A column counts as constant if its relative variation is at most this.
# A variation below this, relative to the largest number of the table, is rounding noise.
NOISE = 1e-12
FEWEST = 8  # Fewest rows from which a period is estimated.
_HEAD = re.compile(r"\s*(.*?)\s*(?:\[([^\[\]]*)\])?\s*")
_INDEX = re.compile(r"\d+")


@record(eq=False)
class Table:
    """A table of rows. `data` has a row per time and a column per quantity. If there are many
    trajectories, the first column is the member number."""

    label: str  # name of the table in a legend
    columns: tuple[Quantity, ...]
    data: numpy.ndarray
    several: bool = False
    told: Mapping[str, object] = field(default_factory=dict)  # the run's FILE.csv.json
    notes: tuple[str, ...] = ()

    @property
    def names(self) -> list[str]:
        return [c.name for c in self.columns]

    @property
    def abscissa(self) -> int:
        """The index of the column that is drawn along the x axis."""
        return self.names.index("t") if "t" in self.names else int(self.several)

    @property
    def time(self) -> numpy.ndarray:
        return self.data[:, self.abscissa]

    @property
    def member(self) -> numpy.ndarray:
        """The trajectory of each row, numbered from 0."""
        if not self.several:
            return numpy.zeros(len(self.data), int)
        return numpy.unique(self.data[:, 0], return_inverse=True)[1]

    def by_member(self) -> tuple[numpy.ndarray, numpy.ndarray]:
        """Returns the order of rows by which each member's are together (they may be sorted by
        time), and where in this order each member begins."""
        order = numpy.argsort(self.member, kind="stable")
        return order, numpy.flatnonzero(numpy.diff(self.member[order], prepend=-1))

    @property
    def quantities(self) -> list[Quantity]:
        """The columns that can be drawn over the abscissa."""
        return [
            c for k, c in enumerate(self.columns) if k != self.abscissa and (k or not self.several)
        ]

    def __getitem__(self, name: str) -> numpy.ndarray:
        return self.data[:, self.names.index(name)]

    def quantity(self, name: str) -> Quantity:
        return self.columns[self.names.index(name)]

    def axis(self, name: str = "", log: bool = False) -> Axis:
        """Returns an axis with the name and unit of a column, by default of the abscissa."""
        quantity = self.quantity(name) if name else self.columns[self.abscissa]
        return Axis(label(quantity.name, quantity.unit), log)

    def found(self, option: str, name: str) -> list[str]:
        """Returns the columns that a name denotes: a column, members of a family, or components."""
        names = self.names
        if name in names:
            return [name]
        of = [n for n in names if part_of(n, name)]
        if not of:
            known = dict.fromkeys([*names, *(b for n in names if (b := base(n)) != n)])
            meant = near(name, list(known), "column")
            raise UsageError(f"{option} {name}: {self.label} has no such column; {meant}")
        return of

    def part(self, key: str) -> dict[str, object]:
        """Returns a dictionary in the run's metadata, "report" or "settings"; {} if it has none."""
        found = self.told.get(key)
        return found if isinstance(found, dict) else {}

    @property
    def drifts(self) -> dict[str, dict[str, object]]:
        """The drifts in the run's report, by name of the conserved quantity."""
        found = self.part("report").get("drifts")
        items = found if isinstance(found, list) else []
        return {d["name"]: d for d in items if isinstance(d, dict) and "name" in d}

    @property
    def sparse(self) -> bool:
        """Whether an adaptive method made more steps than there are rows."""
        report = self.part("report")
        steps = 0 if self.several or report.get("step") is not None else report.get("steps")
        return isinstance(steps, int) and steps > len(self.data)

    @property
    def at_events(self) -> bool:
        """Whether rows were recorded only when an event occurred."""
        settings = self.part("settings")
        return settings.get("at") is not None and settings.get("every") is None

    def rough(self, x: numpy.ndarray) -> bool:
        """Whether a column has fewer than eight rows per period, so that lines between rows would
        mislead. A column of rounding noise is not rough."""
        x, rest = finite(x), numpy.delete(self.data, self.abscissa, axis=1)
        if len(x) < FEWEST:
            return False
        noise = max(CONSTANT * numpy.abs(x).max(), NOISE * numpy.nanmax(numpy.abs(rest)))
        if numpy.ptp(x) <= noise:
            return False
        return bool(numpy.sqrt(numpy.mean(numpy.diff(x) ** 2)) > COARSE * x.std())


def finite(x: numpy.ndarray) -> numpy.ndarray:
    return x[numpy.isfinite(x)]


def ends(x: numpy.ndarray) -> tuple[float, float]:
    """Returns the smallest and the largest finite number; 0 and 1 if there is none."""
    x = finite(x)
    return (float(x.min()), float(x.max())) if len(x) else (0.0, 1.0)


def base(name: str) -> str:
    """Returns the family or vector of a name: q' of q[3]', omega(R) of omega(R).x."""
    family = re.fullmatch(r"(.*)\[\d+\]('*)", name)
    if family:
        return family[1] + family[2]
    return re.sub(r"\.[wxyz]('*)$", r"\1", name)


def part_of(name: str, whole: str) -> bool:
    return name != whole and base(name) == whole


def read(path: str) -> Table:
    """Reads a file of rows, of pkgen or of another program. Raises UsageError with the position of
    an error, or OSError."""
    file = Path(path)
    if file.is_dir():
        raise UsageError(f"{path}: this is a directory; give files of rows")
    plain = path.removesuffix(PARTIAL)
    columns, data = _npy(file) if plain.endswith(".npy") else _csv(file)
    if len(data) == 0:
        raise UsageError(f"{path}: no rows below its head")
    for column in columns:
        if sum(c.name == column.name for c in columns) > 1:
            raise UsageError(f"{path}: column {column.name} stands there twice")
    told, note = _told(file, [c.name for c in columns])
    return _table(file.name, columns, data, told, (note,) if note else ())


def rows(path: Path, label: str, told: dict[str, object]) -> Table | None:
    """Returns the rows that a run has just written, with its metadata `told`; None if the start is
    the only row."""
    columns, data = _npy(path) if path.name.endswith(".npy") else _csv(path)
    made = _table(label, columns, data, told)
    return made if made.several or len(data) > 1 else None


def _table(
    label: str,
    columns: list[Quantity],
    data: numpy.ndarray,
    told: dict[str, object],
    notes: tuple[str, ...] = (),
) -> Table:
    known = {c.name: c for c in quantities(told.get("columns", ()))}
    columns = [known.get(c.name, c) if not c.unit else c for c in columns]
    made = Table(label, tuple(columns), data, False, told, notes)
    several = "ensemble" in made.part("settings") or made.names[1:2] == ["t"]
    return replace(made, several=several)


def quantities(told: object) -> list[Quantity]:
    """Returns the columns listed in metadata; invalid items are ignored."""
    keys = ("name", "unit", "description")
    items = told if isinstance(told, list | tuple) else ()
    rows = [[item.get(key, "") for key in keys] for item in items if isinstance(item, dict)]
    return [Quantity(*row) for row in rows if all(isinstance(x, str) for x in row)]


def _told(path: Path, names: Iterable[str]) -> tuple[dict[str, object], str]:
    """Returns the metadata of a file ({} if there is none), and a note about an error or ""."""
    place = beside(path)
    try:
        told = json.loads(place.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}, ""
    except (OSError, ValueError, RecursionError) as error:
        return {}, f"{place}: not read: {str(error).splitlines()[0]}"
    if not isinstance(told, dict) or [c.name for c in quantities(told.get("columns"))] != names:
        return {}, f"{place}: not of these rows: its columns are others; passed over"
    return told, ""


def _npy(path: Path) -> tuple[list[Quantity], numpy.ndarray]:
    try:
        # A memory map allocates nothing if the header claims more rows than the file has.
        found = numpy.load(path, mmap_mode="r", allow_pickle=False)
    except Exception as error:  # NumPy's header parser raises exceptions of any type
        if isinstance(error, OSError) and error.errno is not None:
            raise
        said = str(error).partition("\n")[0]
        raise UsageError(f"{path}: no file of NumPy's: {said}") from None
    names = getattr(getattr(found, "dtype", None), "names", None)
    if not names or found.ndim != 1:
        raise UsageError(
            f"{path}: an array whose columns have names is needed, as pkgen run writes"
        )
    try:
        data = structured_to_unstructured(found).astype(float)
    except (TypeError, ValueError):
        data = numpy.zeros(0)
    if data.shape[1:] != (len(names),):
        raise UsageError(f"{path}: its columns are not all of numbers")
    return [Quantity(name, "", "") for name in names], data


def _csv(path: Path) -> tuple[list[Quantity], numpy.ndarray]:
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            head = next(csv.reader(file, strict=True), None)
            if not head or not any(cell.strip() for cell in head):
                raise UsageError(f"{path}: empty; its first line is to name its columns")
            if all(_number(cell) is not None for cell in head):
                raise UsageError(f"{path}:1: numbers where names of columns are to stand")
            columns = [_column(path, cell) for cell in head]
            rest = file.read()
    except UnicodeDecodeError:
        raise UsageError(f"{path}: not text in UTF-8") from None
    except csv.Error as error:
        raise UsageError(f"{path}: not CSV: {error}") from None
    if not rest.strip():
        return columns, numpy.zeros((0, len(columns)))
    try:
        data = numpy.loadtxt(rest.splitlines(), delimiter=",", ndmin=2, comments=None)
    except ValueError:
        data = None
    if data is None or data.shape[1] != len(columns):
        data = numpy.array([*_slowly(path, rest, columns)]).reshape(-1, len(columns))
    return columns, data


def _slowly(path: Path, rest: str, columns: list[Quantity]) -> Iterable[list[float]]:
    """Parses rows that NumPy could not read, for example with quoted cells. Raises UsageError with
    the position of an error."""
    for line, row in enumerate(csv.reader(rest.splitlines()), 2):
        if not any(cell.strip() for cell in row):
            continue
        if len(row) != len(columns):
            raise UsageError(
                f"{path}:{line}: {len(row)} values where its head has {len(columns)} columns"
            )
        numbers = [_number(cell) for cell in row]
        for cell, number, column in zip(row, numbers, columns, strict=True):
            if number is None:
                raise UsageError(f"{path}:{line}: column {column.name}: {cell[:40]!r} is no number")
        yield numbers  # type: ignore[misc]


def _column(path: Path, cell: str) -> Quantity:
    """Parses a header cell such as `theta [rad]`; in `q[3]` the brackets are no unit."""
    name, of = _HEAD.fullmatch(cell.replace("\n", " ")).groups()  # type: ignore[union-attr]
    if of is not None and (not name or _INDEX.fullmatch(of)):
        name, of = cell.strip(), None
    if not name:
        raise UsageError(f"{path}:1: a column has no name")
    return Quantity(name, of or "", "")


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
