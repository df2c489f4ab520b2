"""Checks tables of data: `table road = "road.csv" x [m], y [m] spline`."""

from __future__ import annotations

import hashlib
import math
from pathlib import Path

from ... import model as m
from ...functions import add_table
from ...functions.tables import SMOOTH, Data
from ...system.exits import UsageError
from .. import data
from .. import statements as st
from ..data import KINDS, OF_GRIDS, OUTSIDE, WrongData
from ..read import ALLOW, READ, refusal
from ..units import ONE, Unit
from .names import SPECIAL, Entry, Facts, callable_names
from .shared import Checks


class Tables(Checks):
    def declare(self, statement: st.Table) -> None:
        if statement.name in callable_names() | SPECIAL:
            message = f"'{statement.name}' is a function of the language"
            self.error(message, statement.name_span, "choose another name")
        kind, outside = self._words(statement)
        units = [
            ONE if c.unit is None else self.expressions.unit(c.unit.text, c.unit.span)
            for c in statement.columns
        ]
        good = self._fits(statement) and kind and None not in units
        found = self._read(statement, units, kind, outside) if good else None
        if found is None:
            self.poison(st.Left(statement.name, None, None, statement.name_span))
            return
        *given, value = units
        facts = Facts(value.dimension, united=True)
        if not self.names.declare(Entry(statement.name, "table", facts, statement.name_span)):
            return
        path, table = found
        digest = hashlib.sha256()
        for array in (*(a.knots for a in table.axes), table.coefficients):
            digest.update(array.tobytes())
        key = f"{statement.name}#{digest.hexdigest()[:16]}{kind}{outside}"
        table = add_table(statement.name, key, table)
        bends = SMOOTH[OF_GRIDS.get(kind, kind)] < 1
        self.expressions.tables[statement.name] = (key, bends, tuple(u.dimension for u in given))
        texts = tuple(u.shown for u in units)
        said = kind, outside, texts, statement.description, statement.span
        self.parts["tables"].append(m.Table(statement.name, key, table, str(path), *said))

    def finish(self, broken: set[str]) -> None:
        """Refuses data for a table that the model does not have."""
        names = [table.name for table in self.parts["tables"]]
        unknown = [name for name in data.brought() if name not in names]
        if unknown and not self.report.errors and "table" not in broken:
            has = ", ".join(names) or "none"
            raise UsageError(f"--table {unknown[0]}: the model has no such table; it has: {has}")

    def _fits(self, statement: st.Table) -> bool:
        count = len(statement.columns)
        if (count, statement.grid) in ((2, False), (3, True)):
            return True
        help = "one variable: x [m], y [m]; two: x [m], y [m] -> z [N]"
        self.error("a table has one or two variables and a value", statement.columns[0], help)
        return False

    def _words(self, statement: st.Table) -> tuple[str, str]:
        """Returns the kind of a table and what is outside of it; "" after an error."""
        kinds = (*OF_GRIDS,) if statement.grid else KINDS
        words = [*statement.words]
        kind, outside = kinds[0], "error"
        if words and words[0][0] != "outside":
            kind, span = words.pop(0)
            if kind not in kinds:
                help = f"write one of: {' '.join(kinds)}"
                self.error(f"'{kind}' is no way to interpolate here", span, help)
                return "", ""
        if words and words[0][0] == "outside" and len(words) > 1:
            words.pop(0)
        if words:
            outside, span = words.pop(0)
            if outside not in OUTSIDE:
                help = f"write one of: {' '.join(OUTSIDE)}"
                self.error(f"'{outside}' does not say what is outside of the data", span, help)
                return "", ""
        if words:
            self.error("a table has a kind and what is outside of it, no more", words[0][1])
            return "", ""
        return kind, outside

    def _read(
        self, statement: st.Table, units: list[Unit], kind: str, outside: str
    ) -> tuple[Path, Data] | None:
        folder = Path(self.source.piece(statement.span.start).path).parent
        path = data.brought().get(statement.name)
        if path is None:
            path = folder / statement.file
            if wrong := refusal(statement.file, path, folder):
                self.error(wrong, statement.file_span, ALLOW)
                return None
        texts = ["" if c.unit is None else c.unit.text for c in statement.columns]
        wanted = [(c.name, unit) for c, unit in zip(statement.columns, texts, strict=True)]
        factors = [float(u.factor) * math.pi**u.pi for u in units]
        make = data.grid if statement.grid else data.curve
        try:
            if isinstance(path, tuple):
                *axes, values = path
                return Path("arrays"), data.of_arrays(axes, values, kind, outside, statement.name)
            made = make(data.read(path), wanted, factors, kind, outside)
        except WrongData as wrong:
            self.error(str(wrong), statement.file_span, wrong.help)
            return None
        READ[str(path)] = None
        return path, made
