"""Measures a chart: all data for the pictures, the tables and the page."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from typing import Any, Protocol

import numpy

from ...compiler import Compilation
from ...methods import Own
from ...record import record
from ...run import named
from ...run.build import build_library, own_methods, runtime_methods
from ...run.settings import Settings
from ...system import children
from ...system.exits import UsageError
from ...system.progress import Show
from . import answer, reference, spectrum, sweep
from .answer import Answer, Beside
from .errors import ENERGY, KINDS, ErrorKind
from .measure import Program
from .points import ChartedMethod, Track
from .reference import PRECISE, Reference
from .spectrum import Spectrum
from .sweep import Bench, Effort

TITLE_PARAMETERS = 12
BESIDE = 0.01
STEPWISE = "without dense output states on the way would cost steps of their own"


class Others(Protocol):
    """Solvers of other packages to compare with; an add-on implements this class."""

    names: tuple[str, ...]
    methods: list[str]  # methods of pkgen's runtime

    def measure(self, *given: Any) -> tuple[tuple[Beside, ...], list[Answer], list[Track]]: ...


@record
class Chart:
    model: str
    unit: str  # unit of time; "" if the model is dimensionless
    values: list[tuple[str, float, str]]  # name, value and unit of parameters and initial values
    until: float
    kind: ErrorKind
    starts: int
    reference: Reference  # the reference states of the first of the `starts` motions
    spectrum: Spectrum
    tracks: list[Track]  # the points of each method that applies to the model
    refused: dict[str, str]  # methods that do not apply to the model, with the reason
    answers: list[Answer]
    beside: tuple[Beside, ...] = ()  # answers of other packages
    unmeasured: tuple[str, ...] = ()  # methods and packages that an interrupt left unmeasured
    interrupted: bool = False

    @property
    def time(self) -> str:
        return f"{self.until:g} {self.unit}".rstrip()

    def times(self, answer: Answer) -> float | None:
        """Returns the CPU time of another package's answer, divided by the CPU time of pkgen's
        answer for the same accuracy. Returns None if one of them is missing."""
        mine = next(
            a.point for a in self.answers if (a.accuracy, a.axis) == (answer.accuracy, answer.axis)
        )
        if not (answer.point and mine and mine.seconds and answer.point.seconds):
            return None
        return answer.point.seconds / mine.seconds

    def subtitle(self) -> str:
        """Returns the subtitle of a picture: parameters and nonzero initial values."""
        said = [f"{name} = {value:.6g} {unit}".rstrip() for name, value, unit in self.values]
        if len(said) > TITLE_PARAMETERS:
            said = [*said[:TITLE_PARAMETERS], "…"]
        return ", ".join(said)


def methods(wanted: list[str] | None, own: tuple[Own, ...] = ()) -> list[ChartedMethod]:
    """Returns the methods named in `wanted`, or all if it is None. The methods are those of the
    runtime and `own`, which the user defines for the model. Raises KeyError for an unknown name."""
    known = {}
    for m in (*own_methods(own), *runtime_methods()):
        limits = m.get("limits") or {}
        ends = (_end(limits.get(axis)) for axis in ("imaginary", "real"))
        traits = tuple(m["flags"]), tuple(m["requires"])
        known[m["name"]] = ChartedMethod(m["name"], m["order"], *traits, *ends)
    return [known[name] for name in dict.fromkeys(known if wanted is None else wanted)]


def _end(limit: object) -> float | None:
    if limit is None:
        return None
    return math.inf if limit == "infinite" else float(limit)  # type: ignore[arg-type]


def measure(
    compilation: Compilation,
    settings: Settings,
    chosen: list[ChartedMethod],
    effort: Effort,
    on_progress: Show,
    kind: ErrorKind = KINDS["final"],
    starts: int = 1,
    others: Others | None = None,
) -> Chart:
    """Measures errors of one kind from several starts, also of methods of other packages
    (`others`). Raises NumericsFailed, BuildError, or UsageError."""
    name = compilation.model.name
    on_progress(0.0, "compiling")
    stepwise = {m.name: STEPWISE for m in chosen if kind.path and m.adaptive and not m.dense}
    chosen = [m for m in chosen if m.name not in stepwise]
    if not chosen:
        raise UsageError(f"--error {kind.name}: {STEPWISE}")
    path = build_library(
        compilation.files,
        name,
        *(m.name for m in chosen),
        able=PRECISE,
        own=compilation.model.methods,
    )
    program = Program(path, settings, compilation.model.methods)
    given = program.given()
    on_progress(0.02, "compiling and integrating the reference")
    exact = reference.find(compilation, given)
    motions = [(program, exact.measure(kind))]
    structure = compilation.structure
    for k in range(1, starts):
        state = exact.exact.x[k * reference.TIMES // starts]  # it fulfils constraints
        if not structure.autonomous:  # beside the start, by up to BESIDE of each scale
            chance = random.Random(k)
            moved = [chance.uniform(-BESIDE, BESIDE) for _ in state]
            state = exact.exact.x[0] + moved * exact.scales
        q, v = (tuple(enumerate(x.tolist())) for x in numpy.split(state, [exact.coordinates]))
        other = replace(given, start_q=q, start_v=v)
        motion = Program(path, other, compilation.model.methods)
        motions.append((motion, reference.find(compilation, other).measure(kind)))
    follower = reference.best(structure)
    found = spectrum.find(program, follower, settings.until, not structure.variational)
    floor = 0.0 if kind.name == ENERGY else exact.worst if kind.path else exact.error
    bench = Bench(motions, floor, settings.until, effort.rest())

    def show(text: str) -> None:
        on_progress(1 - effort.left() / effort.seconds, text)

    tracks = sweep.measure(bench, chosen, found, show)
    unmeasured = tuple(m.name for m in chosen if m not in [t.method for t in tracks])
    show("the answers")
    able = [t for t in tracks if not t.points[0].refused]
    refused = {t.method.name: t.points[0].reason for t in tracks if t.points[0].refused}
    told, able = answer.answers(bench, able)
    beside: tuple[Beside, ...] = ()
    try:
        if others and not children.ended():
            known = replace(bench, effort=effort), compilation, found, told, able
            beside, told, able = others.measure(*known, lambda _, text: show(text))
    except KeyboardInterrupt:
        unmeasured += others.names
    on_progress(1.0)
    return Chart(
        model=name,
        unit="" if compilation.model.dimensionless else "s",
        values=_values(compilation, given),
        until=settings.until,
        kind=kind,
        starts=starts,
        reference=exact,
        spectrum=found,
        tracks=able,
        refused={**stepwise, **refused},
        answers=told,
        beside=beside,
        unmeasured=unmeasured,
        interrupted=children.ended(),
    )


def _values(compilation: Compilation, given: Settings) -> list[tuple[str, float, str]]:
    found = []
    for start, quantities, values in (
        ("", named.parameters(compilation), given.parameters),
        ("(0)", named.coordinates(compilation), given.start_q),
        ("(0)", named.coordinates(compilation, rates=True), given.start_v),
    ):
        pairs = zip(quantities.columns(10**9), values, strict=True)
        found += [(f"{c.name}{start}", x, c.unit) for c, (_, x) in pairs if x or not start]
    return found
