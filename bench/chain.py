"""How long an N-link pendulum takes to derive and emit, and how many operations it costs.

    .venv/bin/python bench/chain.py [N ...]        (default 2 5 10 20 50)

M and f alone, the start of the process aside; the median of five compilations. gcc is timed at
-O2. The figures of 2026 for the same work by SymPy stand in docs/architecture.md.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from pkgen.compiler import compile_model
from pkgen.source import Source

KERNELS = frozenset({"mass", "force"})
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


def main() -> None:
    sizes = [int(a) for a in sys.argv[1:]] or [2, 5, 10, 20, 50]
    compile_model(Source("warm-up", MODEL.format(n=2)), kernels=KERNELS)
    print(f"{'N':>4} {'derive and emit':>16} {'operations':>11} {'C lines':>8} {'gcc -O2':>9}")
    for n in sizes:
        source = Source("chain.lag", MODEL.format(n=n))
        times = []
        for _ in range(5 if n <= 20 else 1):
            start = time.perf_counter()
            compilation = compile_model(source, kernels=KERNELS)
            times.append(time.perf_counter() - start)
        operations = sum(sum(k.operations.values()) for k in compilation.program.kernels)
        lines = compilation.files["chain.c"].count("\n")
        print(
            f"{n:4} {statistics.median(times):14.3f} s {operations:11,} {lines:8,}"
            f" {compiling(compilation.files):7.2f} s"
        )


def compiling(files: dict[str, str]) -> float:
    with tempfile.TemporaryDirectory() as directory:
        for name, text in files.items():
            Path(directory, name).write_text(text)
        start = time.perf_counter()
        command = ["gcc", "-std=c99", "-O2", "-ffp-contract=off", "-c", "chain.c", "-o", "chain.o"]
        subprocess.run(command, cwd=directory, check=True)
        return time.perf_counter() - start


if __name__ == "__main__":
    main()
