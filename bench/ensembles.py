"""Many double pendulums at once: nanoseconds of a member's RK4 step, own and peers'.

And heyoka's batch mode on the same work: as many members to the same end, at the final error that
RK4 has there.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import time
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path

from . import codegen, matching, reference
from .builds import (
    RUNTIME,
    SOURCES,
    Build,
    Refused,
    Unavailable,
    compile_program,
    each_build,
    written,
)
from .measure import Effort
from .models import error, model
from .peers.own import generated, kernel_header
from .peers.vectors import heyoka_batch, numba_step, numpy_step
from .turns import Runner, Timing, take_turns

FOLDER = SOURCES / "ensembles"
Builds = tuple[Build, ...]
STEPS, H = 100, 0.01
SHOWN = 8  # members whose final state a program prints
MOST_ERROR = {"double": 2e-6, "float": 1e-4}


def measure(effort: Effort, say) -> tuple[dict[str, Timing], list[Timing], Refused]:
    """Times by title, heyoka's batch mode by tolerance (nanoseconds a member), and refusals."""
    quick = effort.starts < 5
    members, rounds = (10240, 3) if quick else (102400, 7)
    runners, refused = [], {}
    for title, make in _ways().items():
        try:
            runners += make(title, effort.builds, members)
        except Unavailable as reason:
            refused[title] = reason
    exact = _exact(STEPS * H)
    best = take_turns(runners, rounds, partial(_must_agree, exact))
    batch = []
    try:
        batch = _batch(members, exact, rounds)
    except Unavailable as reason:
        refused["heyoka, batch mode"] = reason
    say(f"ensembles: {len(best)} ways, {len(runners)} builds, {members} members")
    return best, batch, refused


def rk4_error(timing: Timing) -> float:
    """Median final error of the shown members."""
    return statistics.median(map(error, timing.result, _exact(STEPS * H)))


def heyoka_seconds(batch: list[Timing], wanted: float) -> matching.Match | None:
    """Seconds a member of the batch mode at the error `wanted`."""
    points = matching.curve(
        [float(t.title) for t in batch],
        [t.result for t in batch],
        [[1e-9 * t.median] for t in batch],
    )
    return matching.seconds_at(points, wanted)


def _must_agree(exact: list[list[float]], runner: Runner, states: list[list[float]]) -> None:
    """All made the same steps: what RK4 leaves at this step, and rounding on top."""
    if not states:
        return
    found = statistics.median(map(error, states, exact))
    if not found < MOST_ERROR[runner.kind]:
        raise SystemExit(f"bench: {runner.title}, {runner.flags}: final error {found}")


@cache
def _exact(t_end: float) -> list[list[float]]:
    starts = [
        (1.3 + 0.002 * i, -0.9 + 0.003 * i, 0.2 + 0.004 * i, 0.4 - 0.005 * i) for i in range(SHOWN)
    ]
    return reference.finals_at(model("double_pendulum"), starts, t_end)


def _batch(members: int, exact, rounds: int) -> list[Timing]:
    """Of heyoka, on a share of the members, which is enough for a mean."""
    run = heyoka_batch(model("double_pendulum"), min(members, 4096), STEPS * H)
    tolerances = [10.0**-k for k in range(4, 12)]
    times: dict[float, list[float]] = {t: [] for t in tolerances}
    errors = {}
    for _ in range(rounds):
        for tolerance in tolerances:
            seconds, states = run(tolerance)
            times[tolerance].append(1e9 * seconds)
            errors[tolerance] = statistics.median(map(error, states[:SHOWN], exact))
    return [Timing(str(t), "", times[t], [errors[t]]) for t in tolerances]


def _ways() -> dict[str, Callable]:
    return {
        "scalar libm": partial(_scalar, "double", "sympy"),
        "scalar libm, pkgen --libm": partial(_scalar, "double", "pkgen"),
        "libmvec": _libmvec,
        "numpy": partial(_python, numpy_step),
        "numba": partial(_python, numba_step),
        "pkgen": partial(_own, "double", 1),
        "pkgen, two threads": partial(_own, "double", 2),
        "float: scalar libm": partial(_scalar, "float", "sympy"),
        "float: scalar libm, pkgen --libm": partial(_scalar, "float", "pkgen"),
        "float: pkgen": partial(_own, "float", 1),
    }


def _programs(title, builds, make, members, scalar="double", threads=1) -> list[Runner]:
    def run(program: Path):
        command = [program, str(members), str(STEPS), repr(H), str(threads)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"bench: {title}: {done.stderr.strip()}")
        nanoseconds, *numbers = (float(x) for x in done.stdout.split())
        return nanoseconds, [numbers[4 * i : 4 * i + 4] for i in range(SHOWN)]

    paths = each_build(builds, make)
    return [
        Runner(title, str(build), partial(run, path), scalar)
        for build, path in zip(builds, paths, strict=True)
    ]


def _defines(scalar: str) -> dict[str, str]:
    return {"BENCH_FLOAT": "", "PK_FLOAT": ""} if scalar == "float" else {}


def _scalar(
    scalar: str, source: str, title: str, builds: tuple[Build, ...], members: int
) -> list[Runner]:
    pendulum = model("double_pendulum")
    if source == "pkgen":
        header = kernel_header(pendulum, "--libm", scalar=scalar)
    else:
        text = "#include <tgmath.h>\n" + codegen.acceleration(pendulum, scalar)
        header = f'"{written(f"ensembles/{scalar}.h", text)}"'

    def make(build: Build) -> Path:
        defines = {"BENCH_EQUATIONS": header, **_defines(scalar)}
        flags = ("-std=gnu11", f"-I{RUNTIME / 'include'}")
        return compile_program(build, [FOLDER / "scalar.c", FOLDER / "main.c"], defines, flags)

    return _programs(title, builds, make, members, scalar)


def _libmvec(title: str, builds: Builds, members: int) -> list[Runner]:
    wide = tuple(b for b in builds if "-march=native" in b.flags)
    sources = [FOLDER / "libmvec.c", FOLDER / "main.c"]

    def make(build: Build) -> Path:
        return compile_program(build, sources, {}, ("-std=gnu11",), ("-lmvec",))

    return _programs(title, wide, make, members)


def _own(
    scalar: str, threads: int, title: str, builds: tuple[Build, ...], members: int
) -> list[Runner]:
    if not (RUNTIME / "include/pk/ensemble.h").exists():
        raise Unavailable("this pkgen has no ensembles")
    if threads > (os.cpu_count() or 1):
        raise Unavailable(f"the machine has fewer than {threads} cores")
    folder = generated("double_pendulum")
    sources = [FOLDER / "own.c", FOLDER / "main.c", folder / "double_pendulum.c"]
    sources += sorted((RUNTIME / "src").rglob("*.c")) + sorted((RUNTIME / "omp").glob("*.c"))
    defines = {"PK_RUNTIME": "", "PK_INLINE_ERK": "", "PK_INLINE_ENSEMBLE": "", **_defines(scalar)}
    include = ("-std=c11", f"-I{RUNTIME / 'include'}", f"-I{folder}")
    # clang's OpenMP library is not part of clang; its builds take part with one thread.
    able = tuple(b for b in builds if b.cc == "gcc" or threads == 1)

    def make(build: Build) -> Path:
        openmp = ("-fopenmp",) if threads > 1 else ()
        return compile_program(build, sources, defines, (*include, *openmp))

    return _programs(title, able, make, members, scalar, threads)


def _python(maker, title: str, _: Builds, members: int) -> list[Runner]:
    """In this process; fewer steps, since they are slow and all alike."""
    step, flags = maker(model("double_pendulum"))
    steps = STEPS // 10

    def run():
        step(members, 1, H)
        begin = time.perf_counter()
        step(members, steps, H)
        return 1e9 * (time.perf_counter() - begin) / (members * steps), []

    states = [list(row) for row in step(SHOWN, STEPS, H)]
    _must_agree(_exact(STEPS * H), Runner(title, flags, run, "double"), states)
    return [Runner(title, flags, run, "double")]
