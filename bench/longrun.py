"""Energy over many periods: gauss8 at a fixed step on a Kepler orbit of eccentricity 0.6.

Starts turned by different angles have the same motion and different rounding: the root mean square
over them is the size of the drift, its slope against time in a log-log plot the exponent (0.5 for a
random walk, 1 for a bias).
"""

from __future__ import annotations

import math
import os
import statistics
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from .builds import AS_RUN, OUTPUT, RUNTIME, SOURCES, Broken, Unavailable, compile_program
from .measure import Effort
from .peers.own import emit

FOLDER = SOURCES / "kepler"
ANGLES = (0.3, 1.1, 1.9, 2.7, 3.5, 4.3)
STEPS_A_PERIOD = 64  # truncation stays below rounding
FROM = 100  # periods; before, rounding of the output is most of what is seen


@dataclass(frozen=True)
class LongRun:
    periods: float
    rms: float
    exponent: float
    starts: int
    flags: str


def measure(effort: Effort, say) -> LongRun:
    periods = 10_000 if effort.starts < 5 else 1_000_000
    folder = OUTPUT / "generated" / "kepler"
    emit(FOLDER / "kepler.lag", folder)
    sources = [FOLDER / "kepler.c", folder / "kepler.c", *sorted((RUNTIME / "src").rglob("*.c"))]
    build = AS_RUN[0]
    include = ("-std=c11", f"-I{RUNTIME / 'include'}", f"-I{folder}")
    defines = {"PK_RUNTIME": "", "PK_INLINE_GAUSS": ""}
    program = compile_program(build, sources, defines, include)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        runs = list(pool.map(lambda angle: _run(program, periods, angle), ANGLES))
    rms = [
        (runs[0][i][0], math.sqrt(statistics.fmean(run[i][1] ** 2 for run in runs)))
        for i in range(len(runs[0]))
    ]
    say(f"long run: {len(ANGLES)} starts of {periods:,} periods")
    exponent = _slope([x for x in rms if x[0] >= FROM])
    return LongRun(periods, rms[-1][1], exponent, len(runs), str(build))


def _run(program: Path, periods: int, angle: float) -> list[tuple[float, float]]:
    command = [program, str(periods), str(STEPS_A_PERIOD), repr(angle)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode == 3:
        raise Unavailable("this pkgen has no gauss8")
    if done.returncode:
        raise Broken(f"the long run failed ({done.returncode})")
    return [tuple(map(float, line.split())) for line in done.stdout.splitlines()]


def _slope(points: list[tuple[float, float]]) -> float:
    """Least squares in logarithms."""
    return statistics.linear_regression(
        [math.log(t) for t, _ in points], [math.log(e) for _, e in points]
    ).slope
