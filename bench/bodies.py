"""`python -m bench bodies [--steps N] [--only TEXT] [--docs]`: rotations, constraints and rolling
over a million steps of one size.

A row a scene and method: its coordinates, rotations and rows, and the rates that these leave free;
the largest residuals of unit length, places and rates (the last two beside the sizes of their
terms: pk/constraint.h), and drifts of the energy and of momenta or claims, looked at LOOKS times
(c/long_run.c); and how many of the scene's own expectations are met, at its own settings. Exit
code 4 if one was missed, or a residual is above ROUND_OFF.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from dataclasses import dataclass

from pkgen import __main__ as command
from pkgen.compiler import compile_model
from pkgen.front.read import read
from pkgen.scenes import compile_plan as scene_use
from pkgen.scenes import lengths

from . import machine, systems, tables
from .builds import AS_RUN, OUTPUT, RUNTIME, SOURCES, compile_program, runtime_library
from .chosen import chosen
from .systems import PAGE, ROOT

BEGIN = "<!-- python -m bench bodies --docs -->\n"
END = "<!-- end of bodies -->\n"
STEPS, LOOKS = 1_000_000, 1000
ROUND_OFF = 1e-14
HEAD = (
    "scene",
    "q, R",
    "rows",
    "free",
    "method",
    "unit length",
    "places",
    "rates",
    "energy",
    "grows",
    "others",
    "µs a step",
    "met",
)
# Folder, model, scene, and methods with their steps. gauss4 projects; lie_midpoint and rattle are
# on the group and on the constraints, but of holonomic ones alone. A rattleback's steps are short
# for its fast pitching, and gauss4 takes a thousand times as long for one.
CASES = (
    ("bodies", "free_body", "tumbling", {"lie_midpoint4": 0.05, "gauss4": 0.05}),
    ("bodies", "heavy_top_rotation", "reference", {"lie_midpoint4": 0.01, "gauss4": 0.02}),
    ("bodies", "heavy_top_rotation", "through_upright", {"lie_midpoint4": 0.02, "gauss4": 0.05}),
    ("constrained", "pendulum_rod", "right_angle", {"rattle4": 0.02, "gauss4": 0.05}),
    ("constrained", "double_pendulum_rods", "reference", {"rattle4": 0.005, "gauss4": 0.01}),
    ("constrained", "dumbbell", "tumbles", {"rattle4": 0.02, "gauss4": 0.02}),
    ("constrained", "gimbals", "through_lock", {"rattle4": 0.005, "gauss4": 0.005}),
    ("constrained", "chaplygin_sleigh", "turns_round", {"gauss4": 0.01}),
    ("constrained", "skate", "cycloid", {"gauss4": 0.05}),
    ("constrained", "turntable", "circle", {"gauss4": 0.05}),
    ("constrained", "rolling_disk", "goes_round", {"gauss4": 0.01, "rkmk8": 0.005}),
    ("constrained", "rattleback", "undamped", {"rkmk8": 0.0005}),
)


@dataclass(frozen=True)
class Run:
    scene: str
    method: str
    steps: int
    coordinates: int
    rotations: int
    holonomic: int
    rolling: int
    norm: float
    place: float
    rate: float
    energy: float
    power: float
    others: float
    seconds: float
    growth: str
    met: int
    asked: int

    @property
    def well(self) -> bool:
        return self.met == self.asked and max(self.norm, self.place, self.rate) <= ROUND_OFF

    def cells(self) -> tuple[str, ...]:
        return (
            self.scene,
            f"{self.coordinates}, {self.rotations}",
            f"{self.holonomic} + {self.rolling}",
            str(self.coordinates + 3 * self.rotations - self.holonomic - self.rolling),
            self.method,
            _shown(self.norm if self.rotations else -1),
            _shown(self.place if self.holonomic else -1),
            _shown(self.rate if self.holonomic + self.rolling else -1),
            _shown(self.energy),
            f"{self.growth}" + (f" (t^{self.power:.2f})" if self.power else ""),
            _shown(self.others),
            f"{1e6 * self.seconds / self.steps:.2g}",
            f"{self.met} of {self.asked}",
        )


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench bodies", description=__doc__)
    parser.add_argument("--steps", type=int, default=STEPS)
    parser.add_argument("--only", default="", help="scenes whose 'model scene' has this text")
    parser.add_argument("--docs", action="store_true", help="write docs/dev/results/models.md")
    arguments = parser.parse_args(words)
    if arguments.docs and arguments.only:
        raise SystemExit("bench bodies: --docs wants all scenes")
    cases = chosen(CASES, arguments.only, lambda case: f"{case[1]} {case[2]}")
    OUTPUT.mkdir(parents=True, exist_ok=True)
    runs = []
    for folder, model, scene, methods in cases:
        path = ROOT / "models" / folder / f"{model}.lag"
        runs += of_scene(path, scene, methods, arguments.steps)
    text = f"{tables.table(HEAD, (run.cells() for run in runs))}\n"
    print(text)
    if arguments.docs:
        write(f"{arguments.steps:,} steps.\n\n{text}")
    return 0 if all(run.well for run in runs) else 4


def of_scene(path, scene: str, methods: dict[str, float], steps: int) -> list[Run]:
    row = systems.row(path, scene)
    found = []
    for method, h in methods.items():
        words = [compiled(path, scene, method, h), method, h, steps, max(1, steps // LOOKS)]
        done = subprocess.run([str(w) for w in words], capture_output=True, text=True, check=False)
        if done.returncode:
            raise SystemExit(f"bench bodies: {path.stem} {scene}, {method}: {done.stderr}")
        *numbers, growth = done.stdout.rstrip("\n").split(" ", 11)
        counts, figures = map(int, numbers[:4]), map(float, numbers[4:])
        name = f"{path.stem} {scene}"
        shown = f"{method} h = {h:g}"
        found.append(Run(name, shown, steps, *counts, *figures, growth, row.met, len(row.expects)))
        print(" | ".join(found[-1].cells()), file=sys.stderr, flush=True)
    return found


def compiled(path, scene: str, method: str, h: float):
    """The program of a scene, of no more than it needs by this method."""
    words = [str(path), "--scene", scene, "--method", method, "--step", str(h)]
    use = scene_use.of_run(command.parser_of("run").parse_args(words))
    folder = OUTPUT / "generated" / "bodies" / f"{path.stem}-{scene}-{method}"
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in compile_model(read(str(path)), unroll=lengths.UNROLL, use=use).files.items():
        (folder / name).write_text(text)
    sources = [SOURCES / "long_run.c", folder / f"{path.stem}.c"]
    defines = {"PK_RUNTIME": "", "BENCH_SYSTEM": f"{path.stem}_system"}
    flags = ("-std=c11", f"-I{RUNTIME / 'include'}", f"-I{folder}")
    build = AS_RUN[0]
    return compile_program(build, sources, defines, flags, (str(runtime_library(build)),))


def write(text: str) -> None:
    before, mark, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    if not mark:
        raise SystemExit(f"bench: {PAGE} has no line {BEGIN}")
    after = rest.partition(END)[2]
    here = "; ".join(machine.describe().lines())
    PAGE.write_text(f"{before}{BEGIN}\n{here}. {text}\n{END}{after}", encoding="utf-8")


def _shown(x: float) -> str:
    return "–" if x < 0 else f"{x:.1e}" if x else "0"
