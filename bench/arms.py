"""`python -m bench arms [--quick] [--docs]`: arms and robots beside Pinocchio and MuJoCo.

Arms of N revolute joints in space, and robots of others from their URDF: the accelerations by each,
in turns in one run, with ratios formed round by round. Before that a, M and f of the same states
are compared. The peers are called from C++ and C (c/arms), Pinocchio built by several compilers;
what Python's calls take is said too.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path

from . import environment, machine, matching, report, robots, tables
from .arm_models import Link, lag, links, mjcf, rows
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
AGREE, AGREE_ROBOTS = 1e-10, 1e-12  # of the largest number of a state
OWN, ABA, FORWARD = "pkgen", "Pinocchio's aba()", "MuJoCo's mj_forward()"
ABA_WORLD = f"{ABA}, world frames"
IN_PYTHON = ", called from Python"
HOW = """Written by `python -m bench arms --docs`. An arm of N revolute joints in space, each link
.3 m long, with a centre of mass and one moment of inertia: µs of its accelerations at given q, q'
and no torque, of 64 states in turn, medians of {rounds} rounds in which all take turns, each way's
fastest build. Ratios are formed round by round: median [quartiles]. In the same run the
accelerations of three states, and of up to {most} joints M (`crba()`, `mj_fullM()`) and f
(`rnea()`, `qfrc_bias`), agree within {agree} of the largest number of each.

Robots are URDF files of the wheel `example-robot-data`: pkgen has what `pkgen import` writes of
them, all numbers compiled in, the others what Pinocchio reads of them; both without damping.
Accelerations, M and f agree with Pinocchio's within {robots} of the largest number of each.

All are called from C or C++ in the same loop. Pinocchio's templates are compiled here, from the
headers of its wheel `pin`, by g++ and clang++ with the flags that pkgen's C has and by g++ -O3
alone, without assertions. MuJoCo is its wheel's library, with contacts and constraints disabled:
`mj_forward()` is then what a step of its does, M and its factors included. Of arms pkgen has axes
and lengths compiled in, masses, moments of inertia and g not; the others have all as numbers at run
time, and a whole tensor of inertia. "called from Python" is the wheels' own build through its
binding, of one state over and over; of a model without joints that takes {empty}."""


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench arms", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="three sizes and rounds")
    parser.add_argument("--sizes", help="numbers of joints, separated by commas")
    parser.add_argument("--robots", help=f"of {', '.join(robots.ROBOTS)}, separated by commas")
    parser.add_argument("--docs", action="store_true", help="write docs/dev/results/benchmarks.md")
    options = parser.parse_args(words)
    if Path(sys.prefix) != environment.VENV:
        return environment.with_peers("arms", words)
    OUTPUT.mkdir(parents=True, exist_ok=True)
    here = machine.describe()
    sizes = tuple(map(int, options.sizes.split(","))) if options.sizes else SIZES
    sizes = SIZES[1::2] if options.quick and not options.sizes else sizes
    named = options.robots.split(",") if options.robots else [*robots.ROBOTS]
    rounds, builds = (3, QUICK_BUILDS) if options.quick else (9, BUILDS)
    arms, others, refused = {}, {}, {}
    for found, subjects in ((arms, map(arm, sizes)), (others, map(robot, named))):
        for subject in subjects:
            try:
                timings, missing = measured(subject, builds, rounds, 0.05 if options.quick else 0.2)
            except Unavailable as reason:
                refused[subject.name] = reason
                continue
            found[subject] = timings
            refused |= {f"{subject.name}, {title}": why for title, why in missing.items()}
    parts = [part for found in (arms, others) if found for part in (times(found), ratios(found))]
    if others:
        parts.append(differences(others))
    text = "\n\n".join([*parts, *missing_of(refused)])
    print(text)
    broken = [f"{name}: {why}" for name, why in refused.items() if isinstance(why, Broken)]
    if options.docs and not broken:
        within = dict(agree=f"{AGREE:g}", robots=f"{AGREE_ROBOTS:g}", most=WITH_MASS)
        how = HOW.format(rounds=rounds, empty=empty(), **within)
        said = "\n".join(here.lines())
        report.write_block("arms", f"## Arms and robots\n\n{how}\n\n{said}\n\n{text}\n")
    for why in broken:
        _say(f"bench: failed: {why}")
    return 1 if broken else 0


@dataclass(eq=False)
class Subject:
    """What is measured: `text` is its model, named `model`, `tree` the same for the others."""

    name: str
    model: str
    text: str
    tree: list[Link]
    agree: float
    what: tuple[str, ...]  # is compared
    goal: float | None = None
    far: dict[str, float] = field(default_factory=dict)  # the largest differences, by what

    @property
    def count(self) -> int:
        return len(self.tree)

    @cached_property
    def rows(self) -> Path:
        return written(f"arms/{self.model}.txt", rows(self.tree))

    @cached_property
    def mjcf(self) -> Path:
        return written(f"arms/{self.model}.xml", mjcf(self.tree))


def arm(n: int) -> Subject:
    what = WHAT if n <= WITH_MASS else WHAT[:1]  # C that writes M of more joints is long
    name, tree = f"arm{n}", links(n)
    return Subject(str(n), name, lag(name, tree), tree, AGREE, what, GOALS.get(n))


def robot(name: str) -> Subject:
    text = robots.lag(name)
    tree = robots.tree(name, text)
    return Subject(f"{name}, {len(tree)}", f"robot_{name.lower()}", text, tree, AGREE_ROBOTS, WHAT)


Found = dict[Subject, dict[str, Timing]]


def measured(
    subject: Subject, builds: Sequence[Build], rounds: int, seconds: float
) -> tuple[dict[str, Timing], Refused]:
    """Timings by title; and why who is missing."""
    runners: list[Runner] = []
    refused: Refused = {}
    for title, make in _ways(subject).items():
        try:
            runners += make(title, builds, seconds)
        except Unavailable as reason:
            refused[title] = reason
    found = take_turns(runners, rounds, Agreement(subject))
    shown = ", ".join(f"{t} {1e-3 * x.median:.3g} µs" for t, x in found.items())
    _say(f"{subject.model}: {shown}")
    return found, refused


class Agreement:
    """All have the same accelerations, M and f, within `agree` of the largest of a state's."""

    def __init__(self, subject: Subject):
        self.subject = subject
        self.first: list[list[float]] = []

    def __call__(self, runner: Runner, found: list[list[float]]) -> None:
        self.first = self.first or found
        of = self.subject
        for what, mine, others in zip(of.what, found, self.first, strict=True) if found else ():
            count = len(mine) // 3
            for k in range(0, len(mine), count):
                pairs = [*zip(mine[k : k + count], others[k : k + count], strict=True)]
                far = max(abs(a - b) for a, b in pairs) / max(abs(b) for _, b in pairs)
                if runner.title in (ABA, ABA_WORLD):
                    of.far[what] = max(far, of.far.get(what, 0.0))
                if not far < of.agree:
                    who = f"{runner.title}, {runner.flags}"
                    raise SystemExit(f"bench: {of.model}: {who}: another {what}, by {far:.1e}")


# -- who takes part ------------------------------------------------------------------------------


def _ways(of: Subject) -> dict[str, Callable]:
    return {
        OWN: partial(_own, of),
        ABA: partial(_pinocchio, of, "local"),
        ABA_WORLD: partial(_pinocchio, of, "world"),
        FORWARD: partial(_mujoco, of),
        ABA + IN_PYTHON: partial(_in_python, lambda: dynamics.pinocchio_in_python(of.tree)),
        FORWARD + IN_PYTHON: partial(_in_python, lambda: dynamics.mujoco_in_python(mjcf(of.tree))),
    }


def _own(of: Subject, title: str, builds: Sequence[Build], seconds: float) -> list[Runner]:
    """The accelerations; M and f are of another build, with their kernels alone."""
    kernels = dict.fromkeys(of.what, "mass,force") | {WHAT[0]: WHAT[0]}
    programs = {k: each_build(tuple(builds), partial(_compiled, of, k)) for k in kernels.values()}
    return [
        _runner(
            title, str(b), {w: programs[k][i] for w, k in kernels.items()}, of, "-", "-", seconds
        )
        for i, b in enumerate(builds)
    ]


def _compiled(of: Subject, kernels: str, build: Build) -> Path:
    folder = emitted(of, kernels)
    defines = {"ARM": of.model, "ARM_HEADER": f'"{folder / f"{of.model}.h"}"'}
    if kernels == "acceleration":
        defines["ARM_HAS_ACCELERATION"] = ""
    sources = [FOLDER / "main.c", FOLDER / "own.c", folder / f"{of.model}.c"]
    return compile_program(build, sources, defines, ("-std=c11",))


def emitted(of: Subject, kernels: str) -> Path:
    """The folder with pkgen's C."""
    folder = OUTPUT / "generated" / f"arms-{kernels.replace(',', '-')}"
    folder.mkdir(parents=True, exist_ok=True)
    model = written(f"arms/{of.model}.lag", of.text)
    command = [pkgen_python(), "-m", "pkgen", model, "--kernels", kernels, "-o", folder]
    done = subprocess.run([*command, "--max-seconds", "600"], capture_output=True, text=True)
    if done.returncode:
        raise Broken(f"pkgen refused {model.name}: {(done.stderr.splitlines() or ['?'])[-1]}")
    return folder


def operations(of: Subject) -> str:
    """Of pkgen's accelerations, as its header says."""
    text = (OUTPUT / "generated" / "arms-acceleration" / f"{of.model}.h").read_text()
    count = re.search(r"acceleration +(\d+) operations", text)
    return f"{int(count[1]):,}" if count else "?"


def _pinocchio(of: Subject, frames: str, title: str, _: object, seconds: float) -> list[Runner]:
    flags = dynamics.pinocchio_headers()
    main = _main_object()

    def make(build: Build) -> Path:
        return compile_program(
            build, [FOLDER / "pinocchio.cpp"], dynamics.LIMITS, (*flags, f"-I{FOLDER}", main)
        )

    paths = each_build(dynamics.PINOCCHIO_BUILDS, make)
    return [
        _runner(title, str(build), dict.fromkeys(of.what, path), of, str(of.rows), frames, seconds)
        for build, path in zip(dynamics.PINOCCHIO_BUILDS, paths, strict=True)
    ]


def _main_object() -> str:
    """The loop, by a C compiler."""
    return str(compile_program(QUICK_BUILDS[0], [FOLDER / "main.c"], {}, ("-std=c11", "-c")))


def _mujoco(of: Subject, title: str, builds: Sequence[Build], seconds: float) -> list[Runner]:
    headers, library = dynamics.mujoco_library()
    path = compile_program(
        builds[0],
        [FOLDER / "main.c", FOLDER / "mujoco.c"],
        {},
        ("-std=c11", "-isystem", str(headers)),
        (str(library), f"-Wl,-rpath,{library.parent}"),
    )
    programs = dict.fromkeys(of.what, path)
    return [_runner(title, "its wheel", programs, of, str(of.mjcf), "-", seconds)]


def _runner(
    title: str,
    flags: str,
    programs: dict[str, Path],
    of: Subject,
    file: str,
    word: str,
    seconds: float,
) -> Runner:
    checked: list[list[float]] = []

    def run() -> tuple[float, list]:
        for what in of.what[1:] if not checked else ():
            checked.append(_said(programs[what], what, of.count, file, word, 0.0)[1])
        nanoseconds, numbers = _said(programs[WHAT[0]], WHAT[0], of.count, file, word, seconds)
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


def times(found: Found) -> str:
    """µs, and in brackets pkgen's operations."""
    titles = dict.fromkeys(title for timings in found.values() for title in timings)
    last = [*found][-1]
    body = [
        (
            title,
            *(_cell(timings.get(title)) for timings in found.values()),
            found[last][title].flags if title in found[last] else "",
        )
        for title in titles
    ]
    body.insert(1, ("pkgen's operations", *map(operations, found), ""))
    built = f"built with (of {last.name.partition(',')[0]})"
    return tables.table(("µs an evaluation, joints", *(of.name for of in found), built), body)


def _cell(timing: Timing | None) -> str:
    return f"{1e-3 * timing.median:.3g}" if timing else "-"


def ratios(found: Found) -> str:
    """pkgen's time to that of each peer from C, the faster of Pinocchio's two ways."""
    body = []
    for name, peers in (("Pinocchio", (ABA, ABA_WORLD)), ("MuJoCo", (FORWARD,))):
        cells = []
        for of, timings in found.items():
            there = [timings[title] for title in peers if title in timings]
            if not there or OWN not in timings:
                cells.append("-")
                continue
            best = min(there, key=lambda x: x.median)
            ratio = matching.ratio(timings[OWN].rounds, best.rounds)
            verdict = f", goal {of.goal:g}" if of.goal and name == "Pinocchio" else ""
            cells.append(f"{ratio.median:.2f} [{ratio.low:.2f}, {ratio.high:.2f}]{verdict}")
        body.append((f"pkgen / {name}", *cells))
    return tables.table(("of the time", *(of.name for of in found)), body)


def differences(found: Found) -> str:
    """From Pinocchio's, of the largest number of each."""
    with_ = {"acceleration": "aba()", "mass": "crba()", "force": "rnea()"}
    body = [
        (f"{what}, by {with_[what]}", *(f"{of.far[what]:.1e}" if of.far else "-" for of in found))
        for what in WHAT
    ]
    return tables.table(("largest difference", *(of.name for of in found)), body)


def missing_of(refused: Refused) -> list[str]:
    text = "\n".join(f"- {name}: {why}" for name, why in refused.items())
    return [text] if text else []


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
