"""`python -m bench side_by_side [--docs]`: beside physicskit, at its published settings.

Its tests (physicskit/classical/tests/test_conservation.py) run each system at a step of their own
and ask |H - H(0)| <= 1e-6 |H(0)|. Each system that both have is run here three ways:

    theirs  its own integrate() with those steps, and the compiled loop inside it alone
    equal   our end of the same time, by gauss at 1e-13, beside theirs: what their steps miss it by
    ours    the cheapest of our methods and steps whose energy drifts no more than theirs did

Times are medians of turns taken in one run; theirs after a call that compiles.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from . import environment, machine, tables
from .chosen import chosen
from .side_by_side_cases import CASES, Case

ROOT = Path(__file__).resolve().parent.parent
PKGEN = ROOT / ".venv" / "bin" / "python"
PAGE = ROOT / "docs/dev/results/models.md"
MARK = "<!-- python -m bench side_by_side --docs -->\n"
END = "<!-- end of side_by_side -->\n"
TURNS = 5
HEAD = (
    "system",
    "time",
    "theirs",
    "drift",
    "off at the end",
    "ms, its loop",
    "ours",
    "drift",
    "off",
    "ms",
    "whole / ours",
    "loop / ours",
)
# Of ours: a method, and steps from long to short, or tolerances from loose to tight.
STEPS = tuple(2.0**-k for k in range(14))  # of the case's longest
TOLERANCES = tuple(10.0**-k for k in range(3, 15))


@dataclass(frozen=True)
class Theirs:
    whole: float  # seconds of integrate()
    loop: float
    drift: float  # max |H - H(0)| / |H(0)|
    energy: float  # H(0)
    end: list[float]  # q and q'


@dataclass(frozen=True)
class Ours:
    method: str
    setting: str
    seconds: float
    drift: float
    energy: float
    end: list[float]


@dataclass(frozen=True)
class Row:
    case: Case
    theirs: Theirs
    exact: Ours
    ours: Ours

    def off(self, end: list[float]) -> float:
        """Beside the largest of what there is."""
        size = max(map(abs, self.exact.end))
        return max(abs(a - b) for a, b in zip(end, self.exact.end, strict=True)) / size

    def cells(self) -> tuple[str, ...]:
        x, y = self.theirs, self.ours
        return (
            self.case.name,
            f"{self.case.time:g}",
            f"{self.case.method} {self.case.step:g}",
            f"{x.drift:.1e}",
            f"{self.off(x.end):.0e}",
            f"{1e3 * x.whole:.3g}, {1e3 * x.loop:.3g}",
            f"{y.method} {y.setting}",
            f"{y.drift:.1e}",
            f"{self.off(y.end):.0e}",
            f"{1e3 * y.seconds:.2g}",
            f"{x.whole / y.seconds:.2g}",
            f"{x.loop / y.seconds:.2g}",
        )


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench side_by_side", description=__doc__)
    parser.add_argument("--only", default="", help="systems whose name has this text")
    parser.add_argument("--docs", action="store_true", help="write docs/dev/results/models.md")
    arguments = parser.parse_args(words)
    if importlib.util.find_spec("physicskit") is None:
        if Path(sys.prefix) == environment.VENV:
            print("bench: physicskit cannot be had here", file=sys.stderr)
            return 1
        return environment.with_peers("side_by_side", words)
    rows = [row(case) for case in chosen(CASES, arguments.only, lambda case: case.name)]
    text = tables.table(HEAD, (row.cells() for row in rows)) + "\n"
    print(text)
    if arguments.docs:
        write(text)
    return 0


def row(case: Case) -> Row:
    theirs = measured(case)
    exact = run(case, "gauss", "--rtol", "1e-13")
    if abs(exact.energy - theirs.energy) > 1e-12 * abs(theirs.energy) * case.members:
        raise SystemExit(f"bench: {case.name}: energies {exact.energy!r} and {theirs.energy!r}")
    best = min(candidates(case, theirs.drift), key=lambda x: x.seconds)
    found = Row(case, theirs, exact, again(case, best))
    print(" | ".join(found.cells()), file=sys.stderr, flush=True)
    return found


def measured(case: Case) -> Theirs:
    """The median of some turns; the first, which compiles, does not count."""
    wholes, loops = [], []
    for turn in range(TURNS + 1):
        system = case.make()
        begin = time.perf_counter()
        result = system.integrate((0.0, case.time), dt=case.step, method=case.method)
        wholes.append(time.perf_counter() - begin)
        loops.append(case.loop_of(case.make()))
        if turn == 0:
            wholes, loops = [], []
    energy = result.energy
    drift = max(abs(energy - energy[0])) / abs(energy[0])
    end = case.end(result)
    return Theirs(statistics.median(wholes), statistics.median(loops), drift, energy[0], end)


def candidates(case: Case, drift: float) -> Iterator[Ours]:
    """Of each method the longest step, or loosest tolerance, that drifts no more."""
    for method in case.ours:
        adaptive = method in ("gauss", "dop853")
        for setting in TOLERANCES if adaptive else STEPS:
            option = ("--rtol", f"{setting:g}")
            if not adaptive:
                option = ("--step", repr(case.longest * setting))
            found = run(case, method, *option)
            if found is not None and found.drift <= drift:
                yield found
                break


def again(case: Case, best: Ours) -> Ours:
    """The same, its median time."""
    option, setting = best.setting.split()
    turns = [run(case, best.method, f"--{option}", setting) for _ in range(TURNS)]
    seconds = statistics.median(x.seconds for x in turns)
    return Ours(best.method, best.setting, seconds, best.drift, best.energy, best.end)


def run(case: Case, method: str, option: str, setting: str) -> Ours | None:
    """None where the numerics fail: the step is too long."""
    with tempfile.TemporaryDirectory() as directory:
        words = ["run", ROOT / case.model, *case.options(Path(directory)), "--json"]
        words += ["--until", repr(case.time), "--method", method, option, setting]
        command = [PKGEN, "-m", "pkgen", *map(str, words)]
        done = subprocess.run(command, capture_output=True, text=True, cwd=directory, check=False)
    if done.returncode == 4:
        return None
    if done.returncode:
        raise SystemExit(f"bench: {case.name}: {done.stdout}{done.stderr}")
    told = json.loads(done.stdout)
    drift, energy, end = case.found(told)
    shown = f"{option.removeprefix('--')} {setting}"
    return Ours(method, shown, told["report"]["seconds"], drift, energy, end)


def write(text: str) -> None:
    before, mark, rest = PAGE.read_text(encoding="utf-8").partition(MARK)
    if not mark:
        raise SystemExit(f"bench: {PAGE} has no line {MARK}")
    after = rest.partition(END)[2]
    here = "; ".join(machine.describe().lines())
    PAGE.write_text(f"{before}{MARK}\n{here}\n\n{text}\n{END}{after}", encoding="utf-8")
