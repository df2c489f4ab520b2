"""`python -m bench reductions [--quick] [--docs]`: what a scene of each model saves.

The scenes of each model run as `pkgen run` makes them and with `--no-reduce`, in turns: degrees of
freedom, operations a step, bytes of the C (gcc -O2, text), time of the run with its rows, and the
largest difference of a recorded quantity, relative to its largest magnitude. Methods with a
tolerance take TIGHT for that: what is compared are the equations, not the errors of a method.

Operations a step are those of the kernels that it evaluates, as pkgen counts them, and those of the
method for each number of the state, as FLOPS says.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import re
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pkgen import __main__ as command
from pkgen.analysis.choose.trials import DENSE, LAND, Trials
from pkgen.compiler import Compilation, compile_model
from pkgen.front.read import read
from pkgen.run import named
from pkgen.run.build import build_library
from pkgen.run.library import load
from pkgen.run.settings import Settings
from pkgen.scenes import compile_plan as scene_use
from pkgen.scenes import lengths, scene
from pkgen.scenes import run_settings as parsing

from . import machine, tables

ROOT = Path(__file__).resolve().parent.parent
MARK = "<!-- python -m bench reductions --docs -->\n"
ROUNDS, QUICK_ROUNDS = 15, 3
LAPS = 0.02  # seconds
TIGHT = "3e-15"
# Of a step, for each number of the state: a product and a sum for each coefficient of the tableau
# that is not 0. For gauss, of an iteration: its two 8 x 8 matrices, for positions and rates.
FLOPS = {
    "gauss": 2 * 64,
    "dop853": 2 * (50 + 8 + 8 + 3),
    "rk4": 2 * (3 + 4),
    "yoshida4": 2 * 4,
    "exponential": 0,  # its matrix is as large as the state
}
# Evaluations that come together: the stages of an iteration of gauss, or a step.
TOGETHER = {"gauss": 8, "dop853": 12, "rk4": 4, "yoshida4": 3, "exponential": 0}


@dataclass(frozen=True)
class Way:
    """One scene, reduced or not."""

    compilation: Compilation
    settings: Settings
    program: Path
    bytes: int

    @property
    def coordinates(self) -> int:
        return named.coordinates(self.compilation).count

    @property
    def numbers(self) -> int:
        """Of the state."""
        return 2 * self.coordinates + len(named.states(self.compilation))

    @property
    def operations(self) -> int | None:
        """A step, of gauss an iteration; of parts the sum of theirs."""
        parts = self.compilation.parts
        if not self.compilation.equations.dense:
            return None
        methods = [p.method for p in self.settings.parts] or [self.settings.method] * max(
            1, len(parts)
        )
        programs = [p.program for p in parts] or [self.compilation.program]
        sizes = [2 * len(p.coordinates) for p in parts] or [self.numbers]
        if any(method not in FLOPS for method in methods):
            return None
        total = 0
        for method, program, size in zip(methods, programs, sizes, strict=True):
            kernels = {k.name: sum(k.operations.values()) for k in program.kernels}
            each = kernels["acceleration"]
            if method == "exponential":
                total += 2 * size * (size + 1)
                continue
            total += TOGETHER[method] * each + FLOPS[method] * size
        return total


@dataclass(frozen=True)
class Row:
    name: str
    way: Way
    whole: Way
    times: tuple[float, float]
    ratio: float
    difference: float


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench reductions", description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--docs", action="store_true", help="write its page")
    arguments = parser.parse_args(words)
    rounds = QUICK_ROUNDS if arguments.quick else ROUNDS
    rows = []
    for path in sorted((ROOT / "models").rglob("*.lag")):
        for name in _scenes(path):
            rows.append(_row(path, name, rounds))
            print(_line(rows[-1]), file=sys.stderr)
    text = tables.table(HEAD, map(_cells, rows)) + "\n"
    print(text)
    if arguments.docs:
        _write(text)
    worst = max(row.difference for row in rows)
    print(f"largest difference {worst:.2g}")
    return 0


def _scenes(path: Path) -> list[str]:
    """Of single motions."""
    found = re.findall(r"^scene (\w+)(.*?)^end$", path.read_text(), re.M | re.S)
    return [name for name, body in found if not re.search(r"^\s*swarm\b", body, re.M)]


def _way(path: Path, name: str, *options: str) -> Way:
    words = [str(path), "--scene", name, *options]
    parsed = command.parser_of("run").parse_args(words)
    source = read(str(path))
    compilation = compile_model(source, unroll=lengths.UNROLL, use=scene_use.of_run(parsed))
    chosen = scene.chosen(compilation.declared, name)
    settings = parsing.settings(parsed, compilation, None, chosen)
    methods = [settings.method, *(part.method for part in settings.parts)]
    program = build_library(
        compilation.files,
        compilation.model.name,
        *methods,
        parts=[(part.name, part.coordinates) for part in compilation.parts],
    )
    of_scene = [] if options else ["--scene", name]
    return Way(compilation, settings, program, _bytes(path, *of_scene))


def _bytes(path: Path, *options: str) -> int:
    """Of the C that is for embedding: of a scene alone, or of the whole model."""
    with tempfile.TemporaryDirectory() as directory:
        with contextlib.redirect_stdout(io.StringIO()):
            if command.main([str(path), "-o", directory, *options]):
                raise SystemExit(f"bench: {path} {' '.join(options)} does not compile")
        total = 0
        for file in Path(directory).glob("*.c"):
            object_ = file.with_suffix(".o")
            subprocess.run(["gcc", "-std=c99", "-O2", "-c", file, "-o", object_], check=True)
            size = subprocess.run(["size", object_], capture_output=True, text=True, check=True)
            total += int(size.stdout.splitlines()[1].split()[0])
        return total


def _row(path: Path, name: str, rounds: int) -> Row:
    ways = _way(path, name), _way(path, name, "--no-reduce")
    if ways[0].settings.method == "exponential" != ways[1].settings.method:
        ways = ways[0], _way(path, name, "--no-reduce", "--rtol", "1e-13")  # as near as can be
    times: tuple[list[float], list[float]] = ([], [])
    for _ in range(rounds):
        for k, way in enumerate(ways):
            times[k].append(_time(way))
    one, other = _tight_rows(path, name, ways[0]), _tight_rows(path, name, ways[1], "--no-reduce")
    if one.shape != other.shape:
        raise SystemExit(f"bench: {path.stem} {name}: {one.shape} rows and {other.shape}")
    scale = np.abs(other[:, 1:]).max(axis=0)
    off = np.abs(one[:, 1:] - other[:, 1:]).max(axis=0) / np.where(scale > 0, scale, 1)
    ratio = statistics.median(a / b for a, b in zip(*times, strict=True))
    fastest = min(times[0]), min(times[1])
    return Row(f"{path.stem} {name}", ways[0], ways[1], fastest, ratio, float(off.max()))


def _tight_rows(path: Path, name: str, way: Way, *options: str) -> np.ndarray:
    if way.settings.step is None and way.settings.method != "exponential":
        way = _way(path, name, *options, "--rtol", TIGHT)
    return _rows(way)


def _rows(way: Way) -> np.ndarray:
    return load(way.program).run(way.settings).rows()


def _time(way: Way) -> float:
    """Of the fastest lap, rows made but not written."""
    s = way.settings
    setting = s.step or (s.every if s.method == "exponential" else s.rtol)
    # As a run has them: the one whose interpolant is as good as its steps does not land.
    dense = s.method == "gauss" and not way.compilation.parts
    rows = s.rows or (DENSE if dense else LAND)
    tried = Trials(way.program, s).attempt(s.method, setting, rows, s.until, laps=LAPS)
    if not tried.arrived:
        raise SystemExit(f"bench: {way.compilation.model.name}: {tried.reason}")
    return tried.seconds


def _cells(row: Row) -> list[str]:
    def both(a, b) -> str:
        return "–" if a is None or b is None else f"{b} → {a}"

    one, whole = row.way, row.whole
    ops = one.operations, whole.operations
    if one.settings.method != whole.settings.method:
        method = f"{whole.settings.method} → {one.settings.method}"
        less = "–"
    else:
        method = one.settings.method
        less = f"{ops[0] / ops[1]:.2f}" if None not in ops and ops[1] else "–"
    return [
        row.name,
        method,
        both(one.coordinates, whole.coordinates),
        both(one.numbers, whole.numbers),
        both(*ops),
        less,
        both(one.bytes, whole.bytes),
        f"{1e6 * row.times[1]:.0f} → {1e6 * row.times[0]:.0f}",
        f"{row.ratio:.2f}",
        f"{row.difference:.1e}",
    ]


HEAD = (
    "model, scene",
    "method",
    "degrees of freedom",
    "numbers of the state",
    "operations",
    "ratio",
    "bytes of C",
    "µs",
    "ratio",
    "difference",
)


def _line(row: Row) -> str:
    return " | ".join(_cells(row))


def _write(text: str) -> None:
    """Between the marks of its page."""
    path = ROOT / "docs/dev/results/reductions.md"
    said = "; ".join(machine.describe().lines())
    before, _, _ = path.read_text().partition(MARK)
    path.write_text(f"{before}{MARK}\n{said}\n\n{text}")
