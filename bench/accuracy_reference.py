"""The rows of a scene in __float128, by a tolerance far below what a double tells, checked against
a looser one; kept under build/accuracy, for the long ones take a while."""

from __future__ import annotations

import hashlib
import math
from dataclasses import asdict, dataclass

import numpy

from pkgen.analysis.chart.wide import precise_tools
from pkgen.analysis.choose.trials import LAND, Rows, Trials
from pkgen.compiler import Compilation
from pkgen.run.build import build_library
from pkgen.run.settings import Settings

from .builds import OUTPUT

FOLDER = OUTPUT.parent / "accuracy"
SCALAR = "__float128"
Way = tuple[str, float, float, float]  # a method, its setting, one to check it with, seconds
NOTHING = 1e-18  # a column of no larger numbers is zero


@dataclass(frozen=True)
class Reference:
    """Rows as sums of two doubles; `error` is their own."""

    rows: Rows
    error: float

    def difference(self, table: list[list[float]], until: float | None) -> float:
        """The largest of the table's rows (t, then columns) up to a time, relative to each column's
        largest magnitude; infinite where a row is missing. The time of an event's row is known to
        errors."""
        exact, found = self.rows, numpy.array(table, ndmin=2)
        if len(found) != len(exact.t):
            return math.inf
        counted = exact.scales >= NOTHING
        early = slice(None) if until is None else found[:, 0] <= until
        off = abs(found[:, 1:] - exact.x - exact.low)[early][:, counted] / exact.scales[counted]
        late = abs(found[:, 0] - exact.t).max() / exact.t[-1]
        worst = float(max(late, off.max(initial=0.0)))
        return worst if worst >= 0 else math.inf


def find(compilation: Compilation, settings: Settings) -> Reference:
    """`settings` have every parameter and start written out as doubles."""
    ways = _ways(settings.every or settings.until, compilation.structure.smooth_in_pieces)
    said = repr((sorted(compilation.files.items()), settings, ways, "between"))
    path = FOLDER / f"{hashlib.sha256(said.encode()).hexdigest()[:24]}.npz"
    if not path.exists():
        FOLDER.mkdir(parents=True, exist_ok=True)
        tools = precise_tools(SCALAR)
        program = build_library(compilation.files, compilation.model.name, tools=tools)
        trials = Trials(program, settings)
        error = _make(trials, ways, settings.until)
        rows = asdict(trials.exact)
        numpy.savez(
            path, error=error, **{k: numpy.nan if x is None else x for k, x in rows.items()}
        )
    with numpy.load(path) as kept:
        flags = {name: bool(kept[name]) for name in ("by_number", "without")}
        between = kept["between"] if kept["between"].shape else None
        rows = Rows(kept["t"], kept["x"], kept["low"], **flags, between=between)
        return Reference(rows, float(kept["error"]))


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


def _make(trials: Trials, ways: list[Way], until: float) -> float:
    """Keeps the rows; their error."""
    why = ""
    for method, tight, loose, slowest in ways:
        exact = trials.attempt(method, tight, LAND, until, cap=slowest)
        if exact.arrived:
            trials.look_between(method, loose, LAND, until)
            trials.keep_as_exact()
            return trials.attempt(method, loose, LAND, until).error
        why = exact.reason or "it takes too long"
    raise RuntimeError(f"no reference: {why}")
