"""`pkgen run`: integrate a compiled model with the C driver, and keep what came out.

The driver (runtime/run) is a program linked with the model. It reads its settings as lines on
standard input, writes CSV to standard output and a report in JSON to a file.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from csv import reader, writer
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO

from .. import __version__
from ..back.c.render import is_portable
from ..compiler import Compilation
from ..equations import Quantity
from ..indices import hidden
from ..system import children
from ..system.exits import INTERRUPTED, NUMERICS_FAILED
from ..system.files import scratch
from . import named, not_finite
from .build import build_program
from .ensemble import Ensemble
from .reasons import with_options
from .settings import Settings, Shown

LISTED = 10_000  # members of a family that are described one by one


@dataclass(frozen=True)
class Outcome:
    """How a run ended: the driver's exit code, its report, and what it said."""

    code: int
    report: dict[str, object]
    messages: str

    @property
    def whole(self) -> bool:
        """Whether all rows are written; a diagnostic, made after them, may fail."""
        return bool(self.report.get("whole"))


def columns(
    compilation: Compilation,
    ensemble: Ensemble | None = None,
    show: tuple[Shown, ...] = (),
    listed: int = LISTED,
) -> list[Quantity]:
    """The columns of the CSV, in order; of a family of more than `listed` members one for all."""
    time = Quantity("t", "" if compilation.model.dimensionless else "s", "time")
    energy = Quantity("energy", "" if compilation.model.dimensionless else "J", "q'.dL/dq' - L")
    member = [ensemble.member] if ensemble else []
    if show:
        coordinates, rates = (named.coordinates(compilation, rates=r) for r in (False, True))
        return [*member, time, *(_column(compilation, c, coordinates, rates, energy) for c in show)]
    return [
        *member,
        time,
        *named.coordinates(compilation).columns(listed),
        *named.coordinates(compilation, rates=True).columns(listed),
        *(q for q in named.observed(compilation) if not hidden(q.name)),
        *named.quadratures(compilation),
        *([energy] if named.has_energy(compilation) else []),
    ]


def _column(
    compilation: Compilation,
    shown: Shown,
    coordinates: named.Named,
    rates: named.Named,
    energy: Quantity,
) -> Quantity:
    match shown.kind:
        case "q":
            return coordinates[shown.name][1]
        case "v":
            return rates[shown.name][1]
        case "observed":
            return named.observed(compilation)[shown.index]
        case "z":
            return named.quadratures(compilation)[shown.index]
    return energy


def build(compilation: Compilation, settings: Settings, ensemble: Ensemble | None) -> Path:
    """The program that runs the model. Raises BuildError if C cannot be compiled."""
    return build_program(
        compilation.files,
        compilation.model.name,
        *(settings.compiled_for or (settings.method, *(part.method for part in settings.parts))),
        ensemble=ensemble is not None,
        parts=[(part.name, part.coordinates) for part in compilation.parts],
    )


def simulate(
    compilation: Compilation,
    program: Path,
    settings: Settings,
    output: IO[bytes] | int,
    on_progress: Callable[[float], None] | None = None,
    ensemble: Ensemble | None = None,
    threads: int | None = None,
) -> Outcome:
    """Run the model, its CSV going to `output`."""
    with scratch() as folder:
        report_path = folder / "report.json"
        lines = [*settings.lines(), f"report {report_path}"]
        lines.append(f"progress {1 if on_progress else 0}")
        if settings.units:
            lines.append("header 0")
            _write_header(columns(compilation, ensemble, settings.show, sys.maxsize), output)
        if ensemble:
            lines += ensemble.settings(folder / "members", threads)
        child = subprocess.Popen(
            [program],
            stdin=subprocess.PIPE,
            stdout=output,
            stderr=subprocess.PIPE,
            text=True,
            **children.group(),
        )
        messages = with_options(_converse(child, "\n".join(lines) + "\n", on_progress))
        messages = not_finite.named(messages, compilation, settings.parameters)
        report = {}
        with contextlib.suppress(FileNotFoundError, ValueError):  # where the driver was killed
            report = json.loads(report_path.read_text())
    if child.returncode == -signal.SIGINT:  # in the diagnostics, which keep nothing
        return Outcome(INTERRUPTED, report, messages + "run: interrupted in --diagnose\n")
    if child.returncode < 0:
        messages += f"run: ended by signal {-child.returncode}\n"
        return Outcome(NUMERICS_FAILED, report, messages)
    return Outcome(child.returncode, report, ensemble.placed(messages) if ensemble else messages)


def _write_header(columns: list[Quantity], output: IO[bytes] | int) -> None:
    """In place of the driver's, which knows no units of time and energy."""
    fd = output if isinstance(output, int) else output.fileno()
    with open(fd, "w", newline="", encoding="utf-8", closefd=False) as file:
        names = [f"{c.name} [{c.unit}]" if c.unit else c.name for c in columns]
        writer(file, lineterminator="\n").writerow(names)


def _converse(
    child: subprocess.Popen[str], settings: str, on_progress: Callable[[float], None] | None
) -> str:
    """Give the driver its settings, follow its progress, return what else it said."""
    assert child.stdin is not None and child.stderr is not None
    messages = []
    with children.forwarding(child):
        # A driver that has ended already says why by its exit code and its messages.
        with contextlib.suppress(BrokenPipeError):
            child.stdin.write(settings)
            child.stdin.close()
        for line in child.stderr:
            if line.startswith("progress "):
                if on_progress:
                    on_progress(float(line.split()[1]))
            else:
                messages.append(line)
        child.wait()
    return "".join(messages)


def sidecar(
    compilation: Compilation,
    settings: Settings,
    outcome: Outcome,
    data: str,
    ensemble: Ensemble | None = None,
) -> dict[str, object]:
    """What stands beside an output file: units, settings and the report."""
    of = {"ensemble": ensemble.title} if ensemble else {}
    return {
        "pkgen": __version__,
        "model": compilation.model.name,
        "source": os.path.basename(compilation.model.source.path),
        "source_sha256": compilation.model.source.sha256,
        "data": data,
        "partial": not outcome.whole,
        "columns": [asdict(c) for c in columns(compilation, ensemble, settings.show)],
        "portable": is_portable(compilation.files),
        "settings": {**asdict(settings), **of},
        "report": outcome.report,
    }


def csv_to_npy(csv: Path, npy: IO[bytes]) -> None:
    """The rows of a CSV as an array of float64 with named columns: numpy.load(npy)["theta1"]."""
    import numpy

    with open(csv, newline="", encoding="utf-8") as file:
        names = [re.sub(r" \[[^\]]*\]$", "", name) for name in next(reader(file))]
        rows = numpy.loadtxt(file, delimiter=",", ndmin=2).reshape(-1, len(names))
    numpy.save(npy, rows.view([(name, float) for name in names])[:, 0])
