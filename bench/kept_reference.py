"""What a choice for an accuracy is judged by: the same scene in more digits than a double has, its
equations not reduced, by a method of another family than the one that was chosen, at tolerances
near the round-off of that precision. Another run, of the family chosen, tells its error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy

from pkgen.__main__ import parser_of
from pkgen.analysis.chart.wide import precise_tools
from pkgen.analysis.choose.trials import DENSE, LAND, Rows, Trial, Trials
from pkgen.compiler import Compilation, compile_model
from pkgen.front.read import read
from pkgen.run.build import build_library
from pkgen.run.settings import Settings
from pkgen.scenes import compile_plan as scene_use
from pkgen.scenes import lengths, scene
from pkgen.scenes import run_settings as parsing

SLOWEST = 12.0  # seconds of one run
STEPS = 3000  # at least, where the equations have the time in them
PLACES = 2000  # on the way, at which magnitudes are looked for
ENOUGH = 0.1  # of the accuracy: an error of the reference that leaves no doubt
CLOSE = 1e-14  # so that what vanishes is seen to
NOTHING = 1e-10  # of the largest magnitude: a smaller column may be nothing but errors
EXPLICIT = ("dop853", "dopri5", "rk4", "mclachlan4", "blanes_moan4", "blanes_moan6", "kahan_li8")
# Of a scalar: ways that are tight, and again looser where no other method arrives.
TIGHT = {
    "long double": {"gauss": 1e-18, "dop853": 1e-17, "radau": 1e-15, "dopri5": 1e-14},
    "__float128": {"gauss": 1e-24, "dop853": 1e-20, "radau": 1e-16, "dopri5": 1e-16},
}
LOOSER = 30.0


@dataclass(frozen=True)
class Known:
    """Rows, the largest magnitude of each column in the whole run, and the rows' own error: up to
    the time that is judged, and to the end."""

    rows: Rows
    scales: numpy.ndarray
    error: float
    to_the_end: float
    method: str

    def count(self, until: float | None) -> int:
        """Of rows up to a time."""
        if until is None:
            return len(self.rows.t)
        return int((self.rows.t <= until).sum()) * (until != 0)

    @property
    def nothing(self) -> numpy.ndarray:
        """The columns that may be nothing but errors."""
        return ~(self.scales >= NOTHING * self.scales.max(initial=0.0))

    def off(
        self, table: Sequence[Sequence[float]], until: float | None = None, low: object = 0.0
    ) -> numpy.ndarray:
        """Of each column (t last) the largest error of a run's rows up to a time, relative to that
        column's magnitude (the duration); infinite where rows are missing. `low`: what the table
        lacks of more digits."""
        found = numpy.array(table, ndmin=2)
        count = self.count(until)
        if len(found) < count or (until is None and len(found) != count):
            return numpy.full(len(self.scales) + 1, math.inf)
        found = found[:count]
        exact, rest = self.rows.x[:count], low - self.rows.low[:count]
        with numpy.errstate(divide="ignore", invalid="ignore"):
            off = abs(found[:, 1:] - exact + rest).max(axis=0, initial=0.0) / self.scales
        late = abs(found[:, 0] - self.rows.t[:count]).max(initial=0.0) / self.rows.t[-1]
        return numpy.nan_to_num([*off, late], nan=0.0, posinf=math.inf)


@dataclass(frozen=True)
class Scene:
    compilation: Compilation
    settings: Settings


def scene_of(path: str, name: str, *options: str) -> Scene:
    given = parser_of("run").parse_args([path, "--scene", name, *options])
    compilation = compile_model(read(path), unroll=lengths.UNROLL, use=scene_use.of_run(given))
    chosen = scene.chosen(compilation.declared, name)
    return Scene(compilation, parsing.settings(given, compilation, chosen=chosen))


def find(
    path: str,
    name: str,
    options: Sequence[str],
    method: str,
    accuracy: float,
    until: float | None,
) -> Known:
    """What is judged goes up to a time (None: the end). Raises RuntimeError where there is none."""
    one = scene_of(path, name, "--no-reduce", *options)
    usual = build_library(one.compilation.files, one.compilation.model.name)
    one = replace(one, settings=Trials(usual, one.settings).given())  # starts are taken as exact
    why = ""
    for scalar in TIGHT:
        try:
            found = _of(one, scalar, method, until)
        except RuntimeError as error:
            why = str(error)
            continue
        if found.error <= ENOUGH * accuracy:
            return found
        why = f"two runs in {scalar} differ by {found.error:.1e}"
    raise RuntimeError(f"no reference: {why}")


def _of(one: Scene, scalar: str, method: str, until: float | None) -> Known:
    compilation, structure = one.compilation, one.compilation.structure
    tools = precise_tools(scalar)
    trials = Trials(
        build_library(compilation.files, compilation.model.name, tools=tools), one.settings
    )
    smooth = structure.smooth_in_pieces
    names = ["gauss", "dop853", "radau"] if smooth else ["dop853", "dopri5"]
    if method not in EXPLICIT:
        names.remove("dop853")
        names.insert(0, "dop853")
    timed = not structure.autonomous
    longest = one.settings.until / STEPS if timed else None
    made: list[tuple[str, Rows]] = []
    why = ""
    for name in names:
        trial = _run(trials, name, TIGHT[scalar][name], longest)
        if trial.arrived:
            made.append((name, trials.last))
        else:
            why = trial.reason or "it takes too long"
        if len(made) == 2:
            break
        longest = longest and 0.7 * longest
    if not made:
        raise RuntimeError(why)
    name, rows = made[0]
    if len(made) < 2:
        trial = _run(trials, name, LOOSER * TIGHT[scalar][name], longest)
        made.append((name, trials.last))
    known = Known(rows, _scales(trials, rows), 0.0, 0.0, f"{name} {scalar}")
    other = made[1][1]

    def error(until: float | None) -> float:
        same = len(other.t) == len(rows.t)
        low = other.low[: known.count(until)] if same else 0.0
        off = known.off(numpy.column_stack([other.t, other.x]), until, low)
        return float(max([*off[:-1][~known.nothing], off[-1]]))

    return replace(known, error=error(until), to_the_end=error(None))


def _run(trials: Trials, name: str, setting: float, longest: float | None) -> Trial:
    until = trials.settings.until
    return trials.attempt(name, setting, LAND, until, cap=SLOWEST, max_step=longest)


def _scales(trials: Trials, rows: Rows) -> numpy.ndarray:
    """Rows close to each other, in the same run as rows of a scene would be, without its event."""
    settings = trials.settings
    until = float(rows.t[-1]) if len(rows.t) else settings.until
    trials.settings = replace(settings, at=None)
    try:
        every = settings.until / PLACES
        trial = trials.attempt("dop853", CLOSE, DENSE, until, cap=SLOWEST, every=every)
        if not trial.arrived:
            trial = trials.attempt("gauss", CLOSE, DENSE, until, cap=SLOWEST, every=every)
        return numpy.maximum(rows.scales, trials.last.scales)
    finally:
        trials.settings = settings
