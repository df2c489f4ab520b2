"""`python -m bench published [--docs] [--exact] [--only TEXT]`: published problems of mechanics.

Each is a model of bench/lag/published with a scene that asks for an accuracy; pkgen chooses the
method. What comes out is compared with the exact end, and with the reference that was published.
The exact end is a closed form, or of __float128 and kept in exact.json (`--exact` makes it again);
published_by_hand.py has some of them again by nothing of pkgen. OTHERS is what the codes that
publish theirs reached.
"""

from __future__ import annotations

import argparse
import csv
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import mpmath

from pkgen import __main__ as command
from pkgen.analysis.choose.trials import Trials
from pkgen.compiler import compile_model
from pkgen.front.read import read
from pkgen.run.build import build_library
from pkgen.scenes import compile_plan as scene_use
from pkgen.scenes import lengths, scene
from pkgen.scenes import run_settings as parsing

from . import accuracy_reference, machine, tables
from .chosen import chosen

ROOT = Path(__file__).resolve().parent.parent
MODELS = ROOT / "bench/lag/published"
EXACT = MODELS / "exact.json"
PAGE = ROOT / "docs/dev/results/published.md"
MARK = "<!-- python -m bench published --docs -->\n"
RUNS = 5  # of which the shortest is told

Row = Sequence[float]


@dataclass(frozen=True)
class Problem:
    """`claim` bounds the error of the last row, or of `rows` of them, beside the exact ones: of
    each number relative to itself where `each`, else to the largest, of the reference."""

    name: str
    model: str
    scene: str
    claim: float
    closed: Callable[[float], Row] | None = None
    published: Row | None = None
    each: bool = False
    rows: int = 1
    same: str = ""  # another scene, with the same end

    @property
    def exact(self) -> str:
        """Its name in exact.json."""
        return f"{self.model} {self.same or self.scene}"

    @property
    def path(self) -> Path:
        return MODELS / f"{self.model}.lag"


@dataclass(frozen=True)
class Run:
    problem: Problem
    report: dict
    asked: float | None  # None: the scene says by which method
    warned: bool
    ms: float
    error: float
    off: float | None  # from the published reference

    def cells(self) -> tuple[str, ...]:
        report = self.report
        setting = report["rtol"] if report["step"] is None else report["step"]
        return (
            self.problem.name,
            f"{self.asked:.0e}{', warned' * self.warned}" if self.asked else "–",
            f"{report['method']} {setting:.1e}",
            str(report["steps"]),
            str(report["evaluations"]),
            f"{self.ms:.2g}",
            f"{self.error:.1e}",
            "–" if self.off is None else f"{self.off:.1e}",
        )


HEAD = ("problem", "asked", "method", "steps", "evaluations", "ms", "error", "off the reference")


def kepler(e: float) -> Callable[[float], Row]:
    """x, y, x', y' of the ellipse of half axis 1 from its pericentre on, by Kepler's equation."""

    def at(t: float) -> Row:
        with mpmath.workdps(30):
            # The scenes' decimals, not the doubles nearest to them.
            ecc, b = mpmath.mpf(str(e)), mpmath.sqrt(1 - mpmath.mpf(str(e)) ** 2)
            angle = mpmath.findroot(lambda x: x - ecc * mpmath.sin(x) - t, t, tol=1e-25)
            c, s = mpmath.cos(angle), mpmath.sin(angle)
            speed = 1 / (1 - ecc * c)
            return [float(x) for x in (c - ecc, b * s, -s * speed, b * c * speed)]

    return at


def pendulum(t: float) -> Row:
    """x, y of a pendulum let go when horizontal: sin(theta/2) = k cd(t sqrt(g/l)), k^2 = 1/2."""
    with mpmath.workdps(30):
        m, u = mpmath.mpf(1) / 2, mpmath.mpf(t) * mpmath.sqrt(mpmath.mpf("9.81"))
        half = mpmath.sqrt(m) * mpmath.ellipfun("cd", u, m=m)
        sign = mpmath.sqrt(1 - half**2)
        return [float(2 * half * sign), float(2 * half**2 - 1)]


def four_bars(t: float) -> Row:
    """x, y of the first joint of ten windows whose cranks turn alike: a pendulum that goes round.
    Half its angle from upright, phi, has sin(phi) = k' sd(E t), cos(phi) = cd(E t)."""
    n = 10
    with mpmath.workdps(30):
        speed = mpmath.mpf("9.81") * (mpmath.mpf(n + 1) / 2 + n) / (mpmath.mpf(n + 1) / 3 + n)
        square = mpmath.mpf(1) / 4 + speed
        m, u = speed / square, mpmath.mpf(t) * mpmath.sqrt(square)
        sine = mpmath.sqrt(1 - m) * mpmath.ellipfun("sd", u, m=m)
        return [float(2 * sine * mpmath.ellipfun("cd", u, m=m)), float(1 - 2 * sine**2)]


PLEIADES = (
    0.3706139143970502, 3.237284092057233, -3.222559032418324, 0.6597091455775310,
    0.3425581707156584, 1.562172101400631, -0.7003092922212495, -3.943437585517392,
    -3.271380973972550, 5.225081843456543, -2.590612434977470, 1.198213693392275,
    -0.2429682344935824, 1.091449240428980, 3.417003806314313, 1.354584501625501,
    -2.590065597810775, 2.025053734714242, -1.155815100160448, -0.8072988170223021,
    0.5952396354208710, -3.741244961234010, 0.3773459685750630, 0.9386858869551073,
    0.3667922227200571, -0.3474046353808490, 2.344915448180937, -1.947020434263292,
)  # fmt: skip
ANDREWS = (
    15.81077119629904, -15.75637105984298, 0.04082224013073101, -0.5347301163226948,
    0.5244099658805304, 0.5347301163226948, 1.048080741042263,
)  # fmt: skip
CRANK = (
    15, -0.3311734987910881, 0.1697373326718410, 1.893192460247178e-4, 2.375751865617931e-5,
    -5.323907988763734e-6, -8.363283141616840e-6,
)  # fmt: skip

PROBLEMS = (
    # Relative to themselves these numbers are off by 3.8 times what they are to their largest.
    Problem("Pleiades", "pleiades", "published", 4e-12, published=PLEIADES, each=True),
    Problem("Andrews' squeezer", "andrews", "published", 2e-11, published=ANDREWS, each=True),
    Problem("Andrews' squeezer, A03", "andrews", "a03", 1e-9),
    Problem("slider crank", "crank", "published", 1e-8, published=CRANK, each=True),
    Problem("pendulum, A01", "pendulum", "published", 1e-8, closed=pendulum, rows=400),
    Problem("N-four-bar, A02", "four_bars", "published", 1e-7, closed=four_bars, rows=10),
    Problem("Bricard's mechanism, A04", "bricard", "published", 1e-7, rows=10),
    Problem("flyball governor, A05", "governor", "published", 1e-8, rows=10),
    *(
        Problem(f"DETEST D{k}", "orbits", f"D{k}", 2e-12, closed=kepler(e))
        for k, e in enumerate((0.1, 0.3, 0.5, 0.7, 0.9), start=1)
    ),
    Problem("Arenstorf's orbit", "arenstorf", "published", 2e-9, closed=lambda t: (0.994, 0)),
    Problem("Arenstorf's orbit, loose", "arenstorf", "loose", 2e-5, closed=lambda t: (0.994, 0)),
    Problem("outer planets, 548 years", "outer_planets", "book", 1e-10),
    Problem("outer planets, 1e5 years", "outer_planets", "long", 1e-5),
    Problem("the same, fixed steps", "outer_planets", "long_fixed", 2e-9, same="long"),
    Problem("stiff spring pendulum", "stiff_pendulum", "published", 1e-8),
    Problem("Fermi-Pasta-Ulam, stiff springs", "fpu_stiff", "published", 1e-6),
)

OTHERS_HEAD = ("problem", "code", "tolerance", "steps", "evaluations", "error", "time", "source")
OTHERS = (
    ("Andrews' squeezer", "MEBDFI", "1e-8.5", "466", "1859", "4.8e-06", "0.62 s", "a"),
    ("Andrews' squeezer", "MEBDFI", "1e-9.5", "569", "2225", "5.8e-07", "0.79 s", "a"),
    ("Andrews' squeezer", "MEBDFI", "1e-10", "645", "2564", "1.6e-06", "0.88 s", "a"),
    ("Andrews' squeezer", "PSIDE", "1e-14", "1112", "26000", "the reference", "56.7 s", "b"),
    ("Andrews' squeezer, A03", "OpenSim 3.2", "–", "–", "–", "–", "0.384 s", "c"),
    ("slider crank", "MEBDFI", "1e-8.5", "7009", "26539", "4.6e-06", "11 s", "a"),
    ("slider crank", "MEBDFI", "1e-9", "8316", "37327", "3.8e-06", "13 s", "a"),
    ("slider crank", "MEBDFI", "1e-10", "fails", "–", "–", "–", "a"),
    ("pendulum, A01, 10 s of it", "OpenSim 3.2", "–", "–", "–", "–", "0.637 s", "c"),
    ("Arenstorf's orbit", "DOPRI5", "1e-7", "240", "1442", "9.0e-06", "–", "d"),
    ("Arenstorf's orbit", "DOPRI5", "1e-17", "21139", "126836", "2.0e-12", "–", "d"),
)


def exact(problem: Problem) -> list[Row]:
    """Of what has no closed form the rows that are compared, from the last one backwards."""
    return json.loads(EXACT.read_text(encoding="utf-8"))[problem.exact]


def difference(row: Row, reference: Row, each: bool) -> float:
    """The largest; columns that the reference has not are left out."""
    size = max(abs(x) for x in reference)
    pairs = zip(row, reference)  # noqa: B905
    return max(abs(x - r) / (abs(r) if each else size) for x, r in pairs)


def run(problem: Problem, runs: int = RUNS) -> Run:
    with tempfile.TemporaryDirectory() as directory:
        rows = Path(directory, "rows.csv")
        words = ["run", problem.path, "--scene", problem.scene, "-o", rows, "--json"]
        command = [sys.executable, "-m", "pkgen", *map(str, words)]
        told, seconds = {}, []
        for _ in range(runs):
            done = subprocess.run(command, capture_output=True, text=True)
            if done.returncode:
                raise SystemExit(f"bench published: {problem.name}: {done.stderr}")
            told = json.loads(done.stdout)
            seconds.append(told["report"]["seconds"])
        with rows.open(encoding="utf-8") as file:
            table = [[float(x) for x in line] for line in list(csv.reader(file))[1:]]
    every = max(1, (len(table) - 1) // problem.rows)
    found = table[::-every][: problem.rows]
    closed = problem.closed
    references = [closed(row[0]) for row in found] if closed else exact(problem)
    errors = [difference(f[1:], r, problem.each) for f, r in zip(found, references, strict=True)]
    off = problem.published and difference(found[0][1:], problem.published, problem.each)
    asked = told.get("accuracy", {}).get("asked")
    warned = "not kept" in done.stderr
    return Run(problem, told["report"], asked, warned, 1e3 * min(seconds), max(errors), off)


def make_exact(problems: Sequence[Problem]) -> None:
    """exact.json, of all that has no closed form, in __float128."""
    kept = json.loads(EXACT.read_text(encoding="utf-8")) if EXACT.exists() else {}
    for problem in (p for p in problems if p.closed is None and not p.same):
        words = [str(problem.path), "--scene", problem.scene]
        given = command.parser_of("run").parse_args(words)
        use = scene_use.of_run(given)
        compilation = compile_model(read(words[0]), unroll=lengths.UNROLL, use=use)
        of_scene = scene.chosen(compilation.declared, problem.scene)
        settings = parsing.settings(given, compilation, chosen=of_scene)
        program = build_library(compilation.files, compilation.model.name)
        found = accuracy_reference.find(compilation, Trials(program, settings).given())
        rows = (found.rows.x + found.rows.low)[::-1][: problem.rows]
        kept[problem.exact] = rows.tolist()
        print(f"{problem.name}: to {found.error:.1e}", file=sys.stderr, flush=True)
    lines = ",\n".join(f"{json.dumps(name)}: {json.dumps(kept[name])}" for name in sorted(kept))
    EXACT.write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench published", description=__doc__)
    parser.add_argument("--only", default="", help="problems whose name has this text")
    parser.add_argument("--exact", action="store_true", help="make exact.json again, some minutes")
    parser.add_argument("--docs", action="store_true", help="write docs/dev/results/published.md")
    arguments = parser.parse_args(words)
    problems = chosen(PROBLEMS, arguments.only, lambda problem: problem.name)
    if arguments.exact:
        make_exact(problems)
    found = []
    for problem in problems:
        found.append(run(problem))
        print(" | ".join(found[-1].cells()), file=sys.stderr, flush=True)
    kept = sum(x.error <= x.problem.claim for x in found)
    text = f"{tables.table(HEAD, (x.cells() for x in found))}\n"
    print(f"{text}\nWithin what is claimed: {kept} of {len(found)}")
    if arguments.docs:
        if arguments.only:
            raise SystemExit("bench published: --docs wants all problems")
        before, _, _ = PAGE.read_text(encoding="utf-8").partition(MARK)
        here = "; ".join(machine.describe().lines())
        others = tables.table(OTHERS_HEAD, OTHERS)
        after = f"\n{here}\n\n{text}\nWhat others publish:\n\n{others}\n"
        PAGE.write_text(f"{before}{MARK}{after}", encoding="utf-8")
    return 0 if kept == len(found) else 4
