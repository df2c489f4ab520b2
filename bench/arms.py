"""`python -m bench arms [--quick] [--docs]`: dynamics of serial arms, beside Pinocchio and MuJoCo.

Arms of N revolute joints in space: the accelerations by each, in turns in one run, with ratios
formed round by round. Before that a, M and f of the same states are compared. The peers are called
from C++ and C (c/arms), Pinocchio built by several compilers; what Python's calls take is said too.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from . import environment, machine, matching, report, tables
from .arm_models import lag, links, mjcf, rows
from .builds import (
    BUILDS,
    OUTPUT,
    QUICK_BUILDS,
    SOURCES,
    Broken,
    Build,
    Refused,
    Unavailable,
    compile_program,
    each_build,
    written,
)
from .peers import dynamics
from .peers.own import pkgen_python
from .turns import Runner, Timing, take_turns

FOLDER = SOURCES / "arms"
SIZES = (3, 6, 12, 20, 50, 100)
GOALS = {6: 0.3, 20: 0.5, 100: 1.0}  # of Pinocchio's time
WHAT = ("acceleration", "mass", "force")
WITH_MASS = 20  # joints: of more, C that writes M is long
AGREE = 1e-10  # of the largest number of a state
OWN, ABA, FORWARD = "pkgen", "Pinocchio's aba()", "MuJoCo's mj_forward()"
ABA_WORLD = f"{ABA}, world frames"
IN_PYTHON = ", called from Python"
HOW = """Written by `python -m bench arms --docs`. An arm of N revolute joints in space, each link
.3 m long, with a centre of mass and one moment of inertia: µs of its accelerations at given q, q'
and no torque, of 64 states in turn, medians of {rounds} rounds in which all take turns, each way's
fastest build. Ratios are formed round by round: median [quartiles]. In the same run the
accelerations of three states, and of up to {most} joints M (`crba()`, `mj_fullM()`) and f
(`rnea()`, `qfrc_bias`), agree within {agree} of the largest number of each.

All are called from C or C++ in the same loop. Pinocchio's templates are compiled here, from the
headers of its wheel `pin`, by g++ and clang++ with the flags that pkgen's C has and by g++ -O3
alone, without assertions. MuJoCo is its wheel's library, with contacts and constraints disabled:
`mj_forward()` is then what a step of its does, M and its factors included. pkgen has axes and
lengths compiled in, masses, moments of inertia and g not; the others have all as numbers at run
time, and a whole tensor of inertia. "called from Python" is the wheels' own build through its
binding, of one state over and over; of a model without joints that takes {empty}."""


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench arms", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="three sizes and rounds")
    parser.add_argument("--sizes", help="numbers of joints, separated by commas")
    parser.add_argument("--docs", action="store_true", help="write docs/benchmarks.md")
    options = parser.parse_args(words)
    if Path(sys.prefix) != environment.VENV:
        return environment.with_peers("arms", words)
    OUTPUT.mkdir(parents=True, exist_ok=True)
    here = machine.describe()
    sizes = tuple(map(int, options.sizes.split(","))) if options.sizes else SIZES
    sizes = SIZES[1::2] if options.quick and not options.sizes else sizes
    rounds, builds = (3, QUICK_BUILDS) if options.quick else (9, BUILDS)
    found, refused = {}, {}
    for n in sizes:
        found[n], missing = measured(n, builds, rounds, 0.05 if options.quick else 0.2)
        refused |= missing
    text = "\n\n".join([times(found), ratios(found), *missing_of(refused)])
    print(text)
    broken = [f"{name}: {why}" for name, why in refused.items() if isinstance(why, Broken)]
    if options.docs and not broken:
        how = HOW.format(rounds=rounds, agree=f"{AGREE:g}", most=WITH_MASS, empty=empty())
        said = "\n".join(here.lines())
        report.write_block("arms", f"## Serial arms\n\n{how}\n\n{said}\n\n{text}\n")
    for why in broken:
        _say(f"bench: failed: {why}")
    return 1 if broken else 0


def measured(
    n: int, builds: Sequence[Build], rounds: int, seconds: float
) -> tuple[dict[str, Timing], Refused]:
    """Timings of an arm of so many joints by title; and why who is missing."""
    runners: list[Runner] = []
    refused: Refused = {}
    for title, make in _ways(n).items():
        try:
            runners += make(title, builds, seconds)
        except Unavailable as reason:
            refused[title] = reason
    found = take_turns(runners, rounds, Agreement(n))
    _say(f"arm of {n}: " + ", ".join(f"{t} {1e-3 * x.median:.3g} µs" for t, x in found.items()))
    return found, refused


class Agreement:
    """All have the same accelerations, M and f, within AGREE of the largest of a state's."""

    def __init__(self, n: int):
        self.n = n
        self.first: list[list[float]] = []

    def __call__(self, runner: Runner, found: list[list[float]]) -> None:
        self.first = self.first or found
        for mine, others in zip(found, self.first, strict=bool(found)):
            count = len(mine) // 3
            for k in range(0, len(mine), count):
                pairs = [*zip(mine[k : k + count], others[k : k + count], strict=True)]
                far = max(abs(a - b) for a, b in pairs) / max(abs(b) for _, b in pairs)
                if not far < AGREE:
                    who = f"{runner.title}, {runner.flags}"
                    raise SystemExit(f"bench: arm of {self.n}: {who}: another result, by {far:.1e}")


# -- who takes part ------------------------------------------------------------------------------


def _ways(n: int) -> dict[str, Callable]:
    return {
        OWN: partial(_own, n),
        ABA: partial(_pinocchio, n, "local"),
        ABA_WORLD: partial(_pinocchio, n, "world"),
        FORWARD: partial(_mujoco, n),
        ABA + IN_PYTHON: partial(_in_python, lambda: dynamics.pinocchio_in_python(links(n))),
        FORWARD + IN_PYTHON: partial(_in_python, lambda: dynamics.mujoco_in_python(mjcf(links(n)))),
    }


def _what(n: int) -> tuple[str, ...]:
    """What is compared."""
    return WHAT if n <= WITH_MASS else WHAT[:1]


def _own(n: int, title: str, builds: Sequence[Build], seconds: float) -> list[Runner]:
    """The accelerations; M and f are of another build, with their kernels alone."""
    kernels = dict.fromkeys(_what(n), "mass,force") | {WHAT[0]: WHAT[0]}
    programs = {k: each_build(tuple(builds), partial(_compiled, n, k)) for k in kernels.values()}
    return [
        _runner(
            title, str(b), {w: programs[k][i] for w, k in kernels.items()}, n, "-", "-", seconds
        )
        for i, b in enumerate(builds)
    ]


def _compiled(n: int, kernels: str, build: Build) -> Path:
    folder = emitted(n, kernels)
    defines = {"ARM": f"arm{n}", "ARM_HEADER": f'"{folder / f"arm{n}.h"}"'}
    if kernels == "acceleration":
        defines["ARM_HAS_ACCELERATION"] = ""
    sources = [FOLDER / "main.c", FOLDER / "own.c", folder / f"arm{n}.c"]
    return compile_program(build, sources, defines, ("-std=c11",))


def emitted(n: int, kernels: str) -> Path:
    """The folder with pkgen's C."""
    folder = OUTPUT / "generated" / f"arms-{kernels.replace(',', '-')}"
    folder.mkdir(parents=True, exist_ok=True)
    model = written(f"arms/arm{n}.lag", lag(f"arm{n}", links(n)))
    command = [pkgen_python(), "-m", "pkgen", model, "--kernels", kernels, "-o", folder]
    done = subprocess.run([*command, "--max-seconds", "600"], capture_output=True, text=True)
    if done.returncode:
        raise Broken(f"pkgen refused {model.name}: {(done.stderr.splitlines() or ['?'])[-1]}")
    return folder


def operations(n: int) -> str:
    """Of pkgen's accelerations, as its header says."""
    text = (OUTPUT / "generated" / "arms-acceleration" / f"arm{n}.h").read_text()
    count = re.search(r"acceleration +(\d+) operations", text)
    return f"{int(count[1]):,}" if count else "?"


def _pinocchio(n: int, frames: str, title: str, _: object, seconds: float) -> list[Runner]:
    flags = dynamics.pinocchio_headers()
    main = _main_object()
    arm = written(f"arms/arm{n}.txt", rows(links(n)))

    def make(build: Build) -> Path:
        return compile_program(
            build, [FOLDER / "pinocchio.cpp"], dynamics.LIMITS, (*flags, f"-I{FOLDER}", main)
        )

    paths = each_build(dynamics.PINOCCHIO_BUILDS, make)
    return [
        _runner(title, str(build), dict.fromkeys(_what(n), path), n, str(arm), frames, seconds)
        for build, path in zip(dynamics.PINOCCHIO_BUILDS, paths, strict=True)
    ]


def _main_object() -> str:
    """The loop, by a C compiler."""
    return str(compile_program(QUICK_BUILDS[0], [FOLDER / "main.c"], {}, ("-std=c11", "-c")))


def _mujoco(n: int, title: str, builds: Sequence[Build], seconds: float) -> list[Runner]:
    headers, library = dynamics.mujoco_library()
    model = written(f"arms/arm{n}.xml", mjcf(links(n)))
    path = compile_program(
        builds[0],
        [FOLDER / "main.c", FOLDER / "mujoco.c"],
        {},
        ("-std=c11", "-isystem", str(headers)),
        (str(library), f"-Wl,-rpath,{library.parent}"),
    )
    return [_runner(title, "its wheel", dict.fromkeys(_what(n), path), n, str(model), "-", seconds)]


def _runner(
    title: str, flags: str, programs: dict[str, Path], n: int, file: str, word: str, seconds: float
) -> Runner:
    checked: list[list[float]] = []

    def run() -> tuple[float, list]:
        for what in _what(n)[1:] if not checked else ():
            checked.append(_said(programs[what], what, n, file, word, 0.0)[1])
        nanoseconds, numbers = _said(programs[WHAT[0]], WHAT[0], n, file, word, seconds)
        return nanoseconds, [numbers, *checked]

    return Runner(title, flags, run)


def _said(
    program: Path, what: str, n: int, file: str, word: str, seconds: float
) -> tuple[float, list[float]]:
    command = [program, what, str(n), file, word, repr(seconds)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise Broken(f"{program.name} {what} {n}: exit code {done.returncode} {done.stderr}")
    nanoseconds, *numbers = map(float, done.stdout.split())
    return nanoseconds, numbers


def _in_python(make: Callable, title: str, _: object, seconds: float) -> list[Runner]:
    call = make()
    return [Runner(title, "its wheel", lambda: (dynamics.nanoseconds(call, seconds), []))]


def empty() -> str:
    """What a call of the wheels takes from Python where there is nothing to do."""
    said = []
    for name, make in (
        ("Pinocchio", lambda: dynamics.pinocchio_in_python([])),
        ("MuJoCo", lambda: dynamics.mujoco_in_python(mjcf([]))),
    ):
        try:
            said.append(f"{1e-3 * dynamics.nanoseconds(make(), 0.2):.2f} µs ({name})")
        except Unavailable:
            continue
    return ", ".join(said) or "nothing known"


# -- what is said --------------------------------------------------------------------------------


def times(found: dict[int, dict[str, Timing]]) -> str:
    """µs, and in brackets pkgen's operations."""
    titles = dict.fromkeys(title for timings in found.values() for title in timings)
    largest = found[max(found)]
    body = [
        (title, *(_cell(timings.get(title)) for timings in found.values()), largest[title].flags)
        for title in titles
    ]
    body.insert(1, ("pkgen's operations", *map(operations, found), ""))
    heading = ("µs an evaluation, joints", *map(str, found), f"built with (of {max(found)})")
    return tables.table(heading, body)


def _cell(timing: Timing | None) -> str:
    return f"{1e-3 * timing.median:.3g}" if timing else "-"


def ratios(found: dict[int, dict[str, Timing]]) -> str:
    """pkgen's time to that of each peer from C, the faster of Pinocchio's two ways."""
    body = []
    for name, peers in (("Pinocchio", (ABA, ABA_WORLD)), ("MuJoCo", (FORWARD,))):
        cells = []
        for n, timings in found.items():
            there = [timings[title] for title in peers if title in timings]
            if not there or OWN not in timings:
                cells.append("-")
                continue
            best = min(there, key=lambda x: x.median)
            ratio = matching.ratio(timings[OWN].rounds, best.rounds)
            goal = GOALS.get(n) if name == "Pinocchio" else None
            verdict = f", goal {goal:g}" if goal else ""
            cells.append(f"{ratio.median:.2f} [{ratio.low:.2f}, {ratio.high:.2f}]{verdict}")
        body.append((f"pkgen / {name}", *cells))
    return tables.table(("of the time", *map(str, found)), body)


def missing_of(refused: Refused) -> list[str]:
    text = "\n".join(f"- {name}: {why}" for name, why in refused.items())
    return [text] if text else []


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
