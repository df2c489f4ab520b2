"""The rows of a scene in __float128, by a tolerance far below what a double tells, checked against
a looser one; kept under build/accuracy, for the long ones take a while."""

from __future__ import annotations

import hashlib
import math
import struct
from dataclasses import dataclass
from pathlib import Path

from pkgen.analysis.chart.reference import precise_tools
from pkgen.analysis.choose.trials import LAND, Trials
from pkgen.compiler import Compilation
from pkgen.run.build import build_program
from pkgen.run.settings import Settings

from .builds import OUTPUT

FOLDER = OUTPUT.parent / "accuracy"
SCALAR = "__float128"
Way = tuple[str, float, float, float]  # a method, its setting, one to check it with, seconds
NOTHING = 1e-18  # a column of no larger numbers is zero


@dataclass(frozen=True)
class Rows:
    """Times, and at each the columns as sums of two doubles; `error` is their own."""

    path: Path
    times: list[float]
    columns: list[list[tuple[float, float]]]
    error: float

    @property
    def scales(self) -> list[float]:
        return [max(abs(high) for high, _ in column) for column in self.columns]

    def difference(self, table: list[list[float]], until: float | None) -> float:
        """The largest of the table's rows (t, then columns) up to a time, relative to each column's
        largest magnitude; infinite where a row is missing. The time of an event's row is known to
        errors."""
        if len(table) != len(self.times):
            return math.inf
        worst = max(
            abs(row[0] - t) / self.times[-1] for row, t in zip(table, self.times, strict=True)
        )
        for i, (column, scale) in enumerate(zip(self.columns, self.scales, strict=True)):
            if scale < NOTHING:
                continue
            for row, (high, low) in zip(table, column, strict=True):
                if until is not None and row[0] > until:
                    break
                error = abs((row[i + 1] - high) - low) / scale
                worst = max(worst, error if error >= 0 else math.inf)
        return worst


def find(compilation: Compilation, settings: Settings, columns: int) -> Rows:
    """`settings` have every parameter and start written out as doubles."""
    ways = _ways(settings.every or settings.until, compilation.structure.smooth_in_pieces)
    said = repr((sorted(compilation.files.items()), settings.lines(), ways))
    path = FOLDER / f"{hashlib.sha256(said.encode()).hexdigest()[:24]}.rows"
    note = path.with_suffix(".error")
    if not note.exists():
        FOLDER.mkdir(parents=True, exist_ok=True)
        tools = precise_tools(SCALAR)[0]
        program = build_program(compilation.files, compilation.model.name, tools=tools)
        with Trials(program, settings) as trials:
            note.write_text(repr(_make(trials, ways, settings.until, path)))
    return _read(path, columns, float(note.read_text()))


def _ways(every: float, smooth: bool) -> list[Way]:
    """In turns, the next where one takes too long. dop853 needs h ~ tolerance^(1/8); the last two
    are for what is stiff, the one where its iteration converges with so long steps."""
    ways = [
        ("gauss", 1e-22, 1e-19, 20.0),
        ("dop853", 1e-18, 1e-16, 20.0),
        ("gauss8", every / 64, every / 32, 300.0),
        ("gauss", 1e-20, 1e-18, 300.0),
    ]
    return [way for way in ways if smooth or way[0] != "gauss"]


def _make(trials: Trials, ways: list[Way], until: float, path: Path) -> float:
    why = ""
    for method, tight, loose, slowest in ways:
        exact = trials.attempt(method, tight, LAND, until, cap=slowest)
        if exact.arrived:
            trials.keep_as_exact()
            trials.save(path)
            return trials.attempt(method, loose, LAND, until).error
        why = exact.reason or "it takes too long"
    raise RuntimeError(f"no reference: {why}")


def _read(path: Path, columns: int, error: float) -> Rows:
    numbers = [x for (x,) in struct.iter_unpack("d", path.read_bytes())]
    pairs = list(zip(numbers[::2], numbers[1::2], strict=True))
    width = columns + 1
    return Rows(
        path,
        [pair[0] for pair in pairs[::width]],
        [pairs[i::width] for i in range(1, width)],
        error,
    )
