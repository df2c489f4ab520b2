"""The result of a run: rows as arrays, and the report."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html import escape
from typing import TYPE_CHECKING, Any

import numpy

from ..equations import Quantity
from ..system.exits import UsageError

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

    from ..analysis.sensitivity.forward import Sensitivities

SHOWN = 5  # number of first and of last rows that a notebook shows


class Result:
    """The rows of a run.

    `t` has their times, `r["theta1"]` is a column, `units` has the unit of each column, `report` is
    the run's report (docs/commands.md), `events` has the times of each event, `expects` has the
    verdicts on the scene's expectations, `messages` has the messages of the run,
    `sensitivity` has the derivatives that the run was asked for. In an ensemble,
    `member` has the member of each row, and `by_member("theta1")` has a row for each member.
    """

    def __init__(
        self,
        model: str,
        columns: list[Quantity],
        rows: numpy.ndarray,
        report: dict[str, Any],
        messages: str,
        expects: list[dict[str, Any]],
    ):
        self.model, self.report, self.messages, self.expects = model, report, messages, expects
        self.units = {c.name: c.unit for c in columns}
        self._index = {c.name: i for i, c in enumerate(columns)}
        self._rows = rows
        self._several = "members" in report
        self.sensitivity: Sensitivities | None = None

    @property
    def t(self) -> numpy.ndarray:
        """Times of the rows, of shape (rows,)."""
        return self._rows[:, self._index["t"]]

    @property
    def member(self) -> numpy.ndarray:
        """The member of each row, of shape (rows,). Raises KeyError for a single trajectory."""
        if not self._several:
            raise KeyError("member")
        return self._rows[:, 0].astype(int)

    @property
    def columns(self) -> tuple[str, ...]:
        return tuple(self._index)

    @property
    def events(self) -> dict[str, list[float]]:
        """The first thousand times of each event; in an ensemble, the first time in each member."""
        return {e["name"]: e.get("times", e.get("first", [])) for e in self.report["events"]}

    def __getitem__(self, name: str) -> numpy.ndarray:
        """A column, of shape (rows,). Raises KeyError."""
        if name not in self._index:
            raise KeyError(f"{name}: the rows have {', '.join(self._index)}")
        return self._rows[:, self._index[name]]

    def plot(self, *names: str, kind: str = "") -> Figure:
        """Draws columns (default: all) over time, or the `kind` "phase", "path", "spectrum" or
        "drift" of `pkgen plot`. Returns a matplotlib figure. Raises UsageError."""
        from ..plot import compose, draw
        from ..plot.table import Table
        from ..plot.view import KINDS, View

        if kind not in ("", *KINDS):
            raise UsageError(f"kind={kind!r}: {', '.join(KINDS)}")
        if kind in ("phase", "path", "spectrum") and not names:
            raise UsageError(f"kind={kind!r}: name columns")
        columns = tuple(Quantity(name, unit, "") for name, unit in self.units.items())
        table = Table(self.model, columns, self._rows, self._several, {"report": self.report})
        curves = (names,) if kind in ("phase", "path") else tuple((name,) for name in names)
        try:
            return draw.draw(compose.picture(View(kind, curves), [table]))
        except UsageError as error:
            raise UsageError(re.sub("^--[a-z]+ ", "names: ", str(error))) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._index)

    def __len__(self) -> int:
        """The number of rows."""
        return len(self._rows)

    def by_member(self, name: str) -> numpy.ndarray:
        """A column, of shape (members, rows of a member); NaN after the end of a member."""
        members, counts = numpy.unique(self.member, return_counts=True)
        found = numpy.full((len(members), counts.max(initial=0)), numpy.nan)
        for k, member in enumerate(members):
            found[k, : counts[k]] = self[name][self.member == member]
        return found

    def to_dataframe(self) -> pandas.DataFrame:
        """The rows with time as index; `attrs` has the units. Needs pandas."""
        import pandas

        frame = pandas.DataFrame({name: self[name] for name in self}).set_index("t")
        frame.attrs["units"] = self.units
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """The columns as variables of dimension `t`, with units. The dimensions of an ensemble are
        `member` and `t`, or `member` and `row` if members differ in times. Needs xarray."""
        import xarray

        of = {n: ("t", self[n], {"units": self.units[n]}) for n in self}
        if not self._several:
            return xarray.Dataset({n: x for n, x in of.items() if n != "t"}, {"t": of["t"]})
        times = self.by_member("t")
        alike = bool(numpy.all(times == times[:1]))
        dims = ("member", "t" if alike else "row")
        each: dict[str, Any] = {
            n: (dims, self.by_member(n), {"units": self.units[n]}) for n in self
        }
        del each[self.columns[0]]
        coordinates: dict[str, Any] = {"member": numpy.unique(self.member)}
        if alike:
            del each["t"]
            coordinates["t"] = ("t", times[0], {"units": self.units["t"]})
        return xarray.Dataset(each, coordinates)

    def __repr__(self) -> str:
        way = f"{self.report.get('method')}, {len(self)} rows of {', '.join(self)}"
        return f"<{self.model}: {way}>"

    def _repr_html_(self) -> str:
        def cells(values: Any, tag: str = "td") -> str:
            return "<tr>" + "".join(f"<{tag}>{escape(str(v))}</{tag}>" for v in values) + "</tr>"

        heads = [f"{n} [{u}]" if u else n for n, u in self.units.items()]
        count = len(self)
        some = range(count) if count <= 2 * SHOWN else [*range(SHOWN), *range(count - SHOWN, count)]
        body = [cells(f"{x:.6g}" for x in self._rows[k]) for k in some]
        if len(some) < count:
            body.insert(SHOWN, cells(["…"] * len(heads)))
        return f"<p>{escape(repr(self))}</p><table>{cells(heads, 'th')}{''.join(body)}</table>"
