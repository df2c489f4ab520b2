"""`python -m bench accuracy [--quick] [--only TEXT] [--docs]`: is what `accuracy` promises kept,
and what does it cost beside the cheapest way that there is?

Of each scene of tests/accuracy `pkgen run` makes the rows. They are compared with rows in
__float128 (accuracy_reference.py), and the run's time with that of the cheapest of all methods at
all settings that keep the same accuracy (accuracy_chart.py): both in one program, in turns, rows
made but not written.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import io
import json
import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from pkgen import __main__ as command
from pkgen.analysis.chart.chart import methods
from pkgen.analysis.choose.trials import Trials
from pkgen.compiler import compile_model
from pkgen.front.read import read
from pkgen.run.build import build_library
from pkgen.scenes import compile_plan as scene_use
from pkgen.scenes import lengths, scene
from pkgen.scenes import run_settings as parsing

from . import accuracy_reference, machine
from .accuracy_chart import Chart, Way
from .chosen import chosen

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from accuracy.cases import CASES, SCENE, Case  # noqa: E402

RATIO = 1.5  # times the cheapest: to be reached
MARK = "<!-- python -m bench accuracy --docs -->\n"


@dataclass(frozen=True)
class Judged:
    """`best` is None where no method keeps it."""

    case: Case
    asked: float
    reached: float
    horizon: float | None
    chosen: Way
    best: Way | None
    expected: float
    trials: float  # seconds of the processor
    reference: float  # its own error
    ways: int

    @property
    def kept(self) -> bool:
        """To the end, or to the horizon that was warned of."""
        return self.reached <= self.asked

    @property
    def ratio(self) -> float:
        return self.chosen.seconds / self.best.seconds if self.best else math.nan


def judge(case: Case, folder: Path) -> Judged:
    path = folder / f"{case.name.replace(' ', '_')}.lag"
    path.write_text(case.text(), encoding="utf-8")
    said, table = _run(path)
    given = command.parser_of("run").parse_args([str(path), "--scene", SCENE])
    compilation = compile_model(read(str(path)), unroll=lengths.UNROLL, use=scene_use.of_run(given))
    settings = parsing.settings(
        given, compilation, chosen=scene.chosen(compilation.declared, SCENE)
    )
    able = methods(None)
    program = build_library(compilation.files, compilation.model.name, *(m.name for m in able))
    trials = Trials(program, settings)
    exact = accuracy_reference.find(compilation, trials.given())
    trials.exact = exact.rows
    for column, scale in enumerate(exact.rows.scales):
        if scale < accuracy_reference.NOTHING:
            trials.ignore(column)
    every = settings.every or settings.until
    chart = Chart(trials, said["asked"], settings.until, every, said["run_seconds"])
    ways = chart.ways(able)
    setting = said.get("step") or said.get("rtol")
    own = Way(said["method"], said["rows"], setting, 0.0, 0.0)
    own, *near = chart.timed([own, *ways[:3]])
    return Judged(
        case,
        asked=said["asked"],
        reached=exact.difference(table, said["horizon"]),
        horizon=said["horizon"],
        chosen=own,
        best=min(near, key=lambda w: w.seconds, default=None),
        expected=said["expected"],
        trials=said["trial_seconds"],
        reference=exact.error,
        ways=len(ways),
    )


def _run(path: Path) -> tuple[dict, list[list[float]]]:
    """What `pkgen run` says of its choice, and its rows."""
    rows = path.with_suffix(".csv")
    with contextlib.redirect_stdout(io.StringIO()) as out:
        code = command.main(["run", str(path), "--scene", SCENE, "--json", "-o", str(rows)])
    if code != 0:
        raise RuntimeError(f"{path}: pkgen run ended with {code}")
    with open(rows, newline="", encoding="utf-8") as file:
        table = [[float(x) for x in row] for row in list(csv.reader(file))[1:]]
    return json.loads(out.getvalue())["accuracy"], table


def table(found: list[Judged]) -> str:
    head = ("scene", "asked", "reached", "chosen", "µs", "cheapest", "µs", "ratio", "trials, ms")
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(_cells(j)) + " |" for j in found]
    return "\n".join(lines)


def _cells(j: Judged) -> list[str]:
    warned = "" if j.horizon is None else f", warned from t = {j.horizon:.4g}"
    missed = "" if j.kept else " **missed**"
    return [
        j.case.name,
        f"{j.asked:.0e}",
        f"{j.reached:.1e}{missed}{warned}",
        _way(j.chosen),
        f"{1e6 * j.chosen.seconds:.3g}",
        _way(j.best) if j.best else "none",
        f"{1e6 * j.best.seconds:.3g}" if j.best else "",
        f"{j.ratio:.2f}" if j.best else "",
        f"{1e3 * j.trials:.3g}",
    ]


def _way(way: Way) -> str:
    return f"{way.method} {way.rows} {way.setting:.2g}"


def verdict(found: list[Judged]) -> str:
    """Scenes that no method keeps do not count; they are to be warned of."""
    able = [j for j in found if j.best]
    kept = [j for j in able if j.kept]
    cheap = [j for j in able if j.ratio <= RATIO]
    warned = [j for j in found if not j.best and j.horizon is not None]
    return (
        f"{len(able)} scenes: kept in {len(kept)} ({len(kept) / max(1, len(able)):.0%}), at most "
        f"{RATIO:g} times the cheapest in {len(cheap)}, at worst "
        f"{max((j.ratio for j in able), default=math.nan):.2f} times; "
        f"{len(found) - len(able)} that no method keeps, warned of in {len(warned)}"
    )


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench accuracy")
    parser.add_argument("--quick", action="store_true", help="the quick scenes alone")
    parser.add_argument("--only", default="", help="scenes whose name has this")
    parser.add_argument("--docs", action="store_true", help="write its page")
    arguments = parser.parse_args(words)
    began = time.monotonic()
    folder = accuracy_reference.FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    found, failed = [], []
    cases = [case for case in CASES if case.quick or not arguments.quick]
    for case in chosen(cases, arguments.only, lambda case: case.name):
        try:
            found.append(judge(case, folder))
        except RuntimeError as error:
            failed.append(f"{case.name}: {error}")
            print(f"bench: failed: {failed[-1]}", file=sys.stderr)
            continue
        print(" | ".join(_cells(found[-1])), file=sys.stderr, flush=True)
    said = f"{verdict(found)}; judged in {time.monotonic() - began:.0f} s"
    print(f"{table(found)}\n\n{said}")
    if arguments.docs:
        here = "; ".join(machine.describe().lines())
        _into(ROOT / "docs/dev/results/accuracy.md", f"{said}.\n\n{here}\n\n{table(found)}\n")
    for why in failed:
        print(f"bench: failed: {why}", file=sys.stderr)
    return 1 if failed else 0


def _into(path: Path, text: str) -> None:
    """Behind the mark; what is before it is written by hand."""
    before, mark, _ = path.read_text(encoding="utf-8").partition(MARK)
    path.write_text(f"{before}{mark}\n{text}", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
