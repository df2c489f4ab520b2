"""What an N-link pendulum costs: to derive and emit, in operations, to compile.

    .venv/bin/python -m bench.derivation [--all] [N ...]        (default 20 100)

M and f alone, or with --all every kernel; the start of the process aside. Times are CPU times, so
that what else the machine does hardly counts: the median of five compilations, one where N > 20;
of gcc at -O2, once. Ends with a line of JSON, which measure() reads: pkgen's interpreter is another
than that of the peers, and pkgen is imported by the former alone. The figures for the same work by
SymPy stand in docs/dev/architecture.md.
"""

from __future__ import annotations

import json
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from .builds import Broken
from .models import ROOT
from .peers.own import pkgen_python

KERNELS = frozenset({"mass", "force"})
COMMAND = ["gcc", "-std=c99", "-O2", "-ffp-contract=off", "-c", "chain.c", "-o", "chain.o"]
MODEL = """model chain
size N = {n}
param m = 1 [kg]
param l = 1 [m]
param g = 9.81 [m/s^2]
coord theta[1..N] [rad]
let x[0] = 0 [m]
let y[0] = 0 [m]
let x[i = 1..N] = x[i-1] + l*sin(theta[i])
let y[i = 1..N] = y[i-1] - l*cos(theta[i])
kinetic   sum(m/2*(x[i]'^2 + y[i]'^2), i = 1..N)
potential sum(m*g*y[i], i = 1..N)
"""


def measure() -> dict[int, dict[str, float]]:
    """By N: derive_seconds, emit_seconds, operations, gcc_seconds."""
    command = [pkgen_python(), "-m", "bench.derivation", "20", "100"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    said = done.stdout.strip().splitlines()
    if done.returncode or not said or not said[-1].startswith("{"):
        raise Broken((done.stderr.strip().splitlines() or ["no JSON at the end"])[-1])
    return {row["n"]: row for row in json.loads(said[-1])["rows"]}


def main() -> None:
    from pkgen.compiler import STAGES

    derived = STAGES.index("derive")
    kernels = None if "--all" in sys.argv else KERNELS
    sizes = [int(a) for a in sys.argv[1:] if a.isdigit()] or [20, 100]
    compiled(2, kernels)  # templates and parser are made once
    print(f"{'N':>4} {'derive':>9} {'derive and emit':>16} {'operations':>11} {'gcc -O2':>9}")
    rows = []
    for n in sizes:
        runs = [compiled(n, kernels) for _ in range(5 if n <= 20 else 1)]
        (program, *_), files = runs[-1][1][-2:]
        row = {
            "n": n,
            "derive_seconds": statistics.median(ends[derived] for ends, _ in runs),
            "emit_seconds": statistics.median(ends[-1] for ends, _ in runs),
            "operations": sum(sum(k.operations.values()) for k in program.kernels),
            "gcc_seconds": compiling(files),
        }
        rows.append(row)
        print(
            f"{n:4} {row['derive_seconds']:7.3f} s {row['emit_seconds']:14.3f} s"
            f" {row['operations']:11,} {row['gcc_seconds']:7.2f} s"
        )
    kernel_names = "all" if kernels is None else sorted(kernels)
    made_on = {"python": platform.python_version(), "gcc": " ".join(COMMAND[:4])}
    print(json.dumps({"kernels": kernel_names, **made_on, "rows": rows}))


def compiled(n: int, kernels: frozenset[str] | None) -> tuple[list[float], list]:
    """The CPU time until the end of each stage, and what each made."""
    from pkgen.compiler import stages
    from pkgen.source import Source

    start = time.process_time()
    ends, made = [], []
    for product in stages(Source("chain.lag", MODEL.format(n=n)), {}, kernels):
        ends.append(time.process_time() - start)
        made.append(product)
    return ends, made


def compiling(files: dict[str, str]) -> float:
    """CPU seconds of the C compiler."""
    with tempfile.TemporaryDirectory() as directory:
        for name, text in files.items():
            Path(directory, name).write_text(text)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(COMMAND, cwd=directory, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


if __name__ == "__main__":
    main()
