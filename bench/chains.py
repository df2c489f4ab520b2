"""A chain of masses: nanoseconds of a mass-step of velocity Verlet, own and others', against what
memory allows.
"""

from __future__ import annotations

import shutil
import subprocess
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from .builds import (
    OUTPUT,
    RUNTIME,
    SOURCES,
    Build,
    Refused,
    Unavailable,
    compile_program,
    each_build,
)
from .measure import Effort
from .peers.own import emit
from .turns import Runner, Timing, take_turns

FOLDER = SOURCES / "chains"
SIZES = (1_000, 10_000, 100_000, 1_000_000)
BEYOND = 8_000_000  # 128 MB of q and v, more than caches hold: there memory is the limit
MASS_STEPS = 40_000_000  # a turn, and
FEWEST_STEPS = 100  # what a call costs once is to be spread over many
FEWEST_BEYOND = 33
H = 0.05
# All but the roofline make the same steps, up to rounding.
AGREE = 1e-9


def measure(effort: Effort, say) -> tuple[dict[int, dict[str, Timing]], Refused]:
    """Timings by size and title; and why who is missing."""
    quick = effort.starts < 5
    found, refused = {}, {}
    for n in (SIZES[0], SIZES[-1]) if quick else (*SIZES, BEYOND):
        fewest = FEWEST_BEYOND if n == BEYOND else FEWEST_STEPS
        steps = max(fewest, MASS_STEPS // n // (4 if quick else 1))
        runners = []
        for title, make in _ways().items():
            try:
                runners += make(title, effort.builds, n, steps)
            except Unavailable as reason:
                refused[title] = reason
        found[n] = take_turns(runners, 3 if quick or n == BEYOND else 7, _Agreement())
    say(f"chains: {len(runners)} builds at {len(found)} sizes")
    return found, refused


class _Agreement:
    """All runners' places agree with the first's."""

    def __init__(self):
        self.first = None

    def __call__(self, runner: Runner, places: list[float]) -> None:
        if not places:
            return
        self.first = self.first or places
        far = max(abs(a - b) for a, b in zip(places, self.first, strict=True))
        if not far < AGREE:
            raise SystemExit(f"bench: {runner.title}, {runner.flags}: {places}, not {self.first}")


def _ways() -> dict[str, Callable]:
    return {
        "roofline, one pass": partial(_c, ("roofline.c",), False),
        "force callback": partial(_c, ("callback.c", "force.c"), True),
        "pkgen": _own,
        "numpy": partial(_python, _numpy),
        "numba": partial(_python, _numba),
    }


def _programs(title, builds, make, n: int, steps: int, counts: bool) -> list[Runner]:
    def run(program: Path):
        command = [program, str(n), str(steps), repr(H)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"bench: {title}: {done.stderr.strip()}")
        nanoseconds, *places = (float(x) for x in done.stdout.split())
        return nanoseconds, places if counts else []

    paths = each_build(builds, make)
    return [
        Runner(title, str(b), partial(run, path)) for b, path in zip(builds, paths, strict=True)
    ]


def _c(files, counts: bool, title: str, builds: tuple[Build, ...], n: int, steps: int):
    sources = [FOLDER / name for name in (*files, "main.c")]
    make = partial(compile_program, sources=sources, defines={}, extra=("-std=c11",))
    return _programs(title, builds, make, n, steps, counts)


def _own(title: str, builds: tuple[Build, ...], n: int, steps: int) -> list[Runner]:
    folder = OUTPUT / "generated" / "chain"
    emit(FOLDER / "fput.lag", folder)
    if "fput_sizes(" not in (folder / "fput.h").read_text():
        shutil.rmtree(folder)
        raise Unavailable("this pkgen unrolls families")
    sources = [FOLDER / "own.c", FOLDER / "main.c", folder / "fput.c"]
    sources += sorted((RUNTIME / "src").rglob("*.c"))
    defines = {"PK_RUNTIME": "", "PK_INLINE_SPLITTING": ""}
    extra = ("-std=c11", f"-I{RUNTIME / 'include'}", f"-I{folder}")
    make = partial(compile_program, sources=sources, defines=defines, extra=extra)
    return _programs(title, builds, make, n, steps, True)


def _python(make, title: str, _: tuple[Build, ...], n: int, steps: int) -> list[Runner]:
    """In this process, a tenth of the steps; agreement is checked with as many."""
    advance, flags = make()
    few = max(10, steps // 10)

    def run():
        import numpy

        q = numpy.sin(numpy.pi * numpy.arange(1, n + 1) / (n + 1))
        v = numpy.zeros(n)
        advance(q, v, 2)
        begin = time.perf_counter()
        advance(q, v, few)
        return 1e9 * (time.perf_counter() - begin) / (n * few), []

    return [Runner(title, flags, run)]


def _numpy() -> tuple[Callable, str]:
    try:
        import numpy
    except ImportError:
        raise Unavailable("NumPy is not installed") from None

    def force(q):
        d = numpy.diff(q, prepend=0.0, append=0.0)
        f = d * (1 + 0.25 * d * d)
        return numpy.diff(f)

    def advance(q, v, steps):
        a = force(q)
        for _ in range(steps):
            v += H / 2 * a
            q += H * v
            a = force(q)
            v += H / 2 * a

    return advance, f"NumPy {numpy.__version__}"


def _numba() -> tuple[Callable, str]:
    try:
        import numba
    except ImportError:
        raise Unavailable("numba is not installed") from None

    @numba.njit
    def advance(q, v, steps):
        n = len(q)
        for _ in range(steps):
            left = q[0] * (1 + 0.25 * q[0] * q[0])
            for i in range(n):
                d = (q[i + 1] if i + 1 < n else 0.0) - q[i]
                right = d * (1 + 0.25 * d * d)
                v[i] += H * (right - left)
                left = right
            for i in range(n):
                q[i] += H * v[i]

    return advance, f"numba {numba.__version__}, njit, leapfrog in two passes"
