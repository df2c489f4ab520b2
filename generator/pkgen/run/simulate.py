"""`pkgen run`: integrates a compiled model; writes rows and the report."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from csv import writer
from dataclasses import asdict, replace
from pathlib import Path
from typing import IO

from ..back.c.render import is_portable
from ..compiler import Compilation
from ..equations import Quantity
from ..record import record
from ..system import children
from ..version import __version__
from . import not_finite
from .build import build_library
from .ensemble import Ensemble
from .library import Run, load
from .named import LISTED, columns
from .settings import Settings


@record
class Outcome:
    """The result of a run: its code, report and messages."""

    code: int
    report: dict[str, object]
    messages: str

    @property
    def whole(self) -> bool:
        """Whether the run wrote all its rows. This is also true if a later diagnostic failed."""
        return bool(self.report.get("whole"))


def build(compilation: Compilation, settings: Settings, ensemble: Ensemble | None) -> Path:
    """Builds the library of the model. Raises BuildError if C cannot be compiled."""
    return build_library(
        compilation.files,
        compilation.model.name,
        *settings.methods,
        ensemble=ensemble is not None,
        diagnose=bool(settings.diagnose),
        parts=compilation.blocks,
        own=compilation.model.methods,
    )


@record
class Runnable:
    """A compiled model, the settings of a run, and the members of an ensemble or None."""

    compilation: Compilation
    settings: Settings
    ensemble: Ensemble | None = None
    threads: int | None = None  # None: one per processor
    library: Path | None = None  # None: the library is not built yet
    complete: Callable[[Runnable, Outcome], Outcome] | None = None  # adds to the report

    def columns(self, listed: int = sys.maxsize) -> list[Quantity]:
        member = [self.ensemble.member] if self.ensemble else []
        return [*member, *columns(self.compilation, self.settings.show, listed)]


def simulate(
    run: Runnable,
    output: IO[bytes] | int,
    on_progress: Callable[[float], None] | None = None,
    npy: bool = False,
    **more: object,
) -> Outcome:
    """Runs the model and writes its rows to `output`, as CSV or (`npy`) as an array of float64 with
    named columns: numpy.load(file)["theta1"]. SIGINT ends the run and keeps its rows. `more` sets
    fields of pk_run_settings directly."""
    if npy:
        import numpy

        done, told = followed(run, on_progress, **more)
        if len(rows := done.rows()):
            numpy.save(output, rows.view([(c.name, float) for c in run.columns()])[:, 0])
        return told
    fd = output if isinstance(output, int) else output.fileno()
    units = run.settings.units
    if units and not more.get("resume"):  # the runtime's header has no units of time and energy
        with open(fd, "w", newline="", encoding="utf-8", closefd=False) as file:
            names = [f"{c.name} [{c.unit}]" if c.unit else c.name for c in run.columns()]
            writer(file, lineterminator="\n").writerow(names)
    return followed(run, on_progress, csv=fd, header=not units, **more)[1]


def followed(
    run: Runnable, on_progress: Callable[[float], None] | None = None, **more: object
) -> tuple[Run, Outcome]:
    """Runs the model. Returns the Run object and the outcome. The rows stay in memory, unless
    `more` contains `csv`, the file to which they are written."""
    with children.stopping() as stopped:

        def poll(part: float) -> bool:
            if on_progress:
                on_progress(part)
            return stopped()

        more |= {"threads": run.threads or 0}
        done = load(run.library).run(run.settings, poll, run.ensemble, **more)
    told = outcome(run.compilation, run.settings, done, run.ensemble)
    asked = run.complete and "modes" in told.report.get("diagnostics", {})
    return done, run.complete(run, told) if asked else told


def outcome(
    compilation: Compilation, settings: Settings, done: Run, ensemble: Ensemble | None = None
) -> Outcome:
    """Returns the outcome of a finished run, with quantities in messages as the user names them."""
    messages = "".join(f"run: {line}\n" for line in done.messages.splitlines())
    if done.not_finite and compilation.equations.dense:
        constant = not_finite.constant(compilation, dict(settings.parameters))
        messages = f"run: {constant}\n" if constant else messages
    strict = ", ".join(x.name for x in compilation.model.tables if x.outside == "error")
    if strict and done.report["status"] == "PK_NOT_FINITE":
        messages += (
            f"run: there are no values outside of the data of {strict}; 'outside hold' goes on\n"
        )
    if compilation.model.consistent and done.report:
        e, given = compilation.equations, done.given()
        values = [*given["q"][: e.own], *given["v"]]
        names = (x.name for x in (*e.coordinates[: e.own], *e.rates, *e.states))
        done.report["start"] = start = dict(zip(names, values, strict=True))
        messages = (
            f"run: start: {', '.join(f'{k} = {x:.12g}' for k, x in start.items())}\n{messages}"
        )
    return Outcome(done.code, done.report, ensemble.placed(messages) if ensemble else messages)


def sidecar(run: Runnable, outcome: Outcome, data: str) -> dict[str, object]:
    """Returns the content of the JSON file beside an output file: units, settings, the report."""
    compilation, settings, ensemble = run.compilation, run.settings, run.ensemble
    of = {"ensemble": ensemble.title} if ensemble else {}
    return {
        "pkgen": __version__,
        "model": compilation.model.name,
        "source": os.path.basename(compilation.model.source.path),
        "source_sha256": compilation.model.sha256,
        "data": data,
        "partial": not outcome.whole,
        "columns": [asdict(c) for c in run.columns(LISTED)],
        "portable": is_portable(compilation.files),
        "settings": {**asdict(replace(settings, tables=())), **of},
        "tables": {x.name: os.path.basename(x.file) for x in compilation.model.tables},
        "report": outcome.report,
    }
