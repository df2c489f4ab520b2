"""RK4 on 102,400 double pendulums: pkgen's lanes against scalar libm, libmvec and numpy.

    python bench/ensemble.py [MEMBERS]

Builds bench/ensemble.c in double and in float with gcc, times every way interleaved in one run, and
prints medians in ns a trajectory-step and ratios. pkgen's members have parameters of their own
and compensated sums; the peers have neither.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy

ROOT = Path(__file__).resolve().parent.parent
RUNTIME = ROOT / "runtime"
FLAGS = ["-O3", "-march=native", "-fno-tree-slp-vectorize", "-ffp-contract=off"]
FLAGS += ["-fno-math-errno", "-fno-trapping-math"]
# The peers may fuse, and libmvec is only called with fast-math.
SCALAR = ["-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math"]
VECTOR = ["-O3", "-march=native", "-ffast-math", "-fno-builtin-sincos", "-DVECTOR"]
GRAVITY, STEP, STEPS = 9.81, 0.01, 100


def build(folder: Path, scalar: list[str], compiler: str = "gcc") -> Path:
    """The program for one scalar type."""

    def run(*command: object) -> None:
        subprocess.run([str(x) for x in command], check=True, cwd=folder)

    pkgen = [sys.executable, "-m", "pkgen", ROOT / "models/double_pendulum.lag", "-o", folder]
    run(*pkgen)
    for name, flags in (("scalar", SCALAR), ("vector", VECTOR)):
        peers = ROOT / "bench/ensemble_peers.c"
        run("gcc", "-std=c11", *flags, *scalar, "-c", peers, "-o", f"{name}.o")
    inline = ["-DPK_RUNTIME", "-DPK_INLINE_ERK", "-DPK_INLINE_ENSEMBLE"]
    sources = [*sorted((RUNTIME / "src").glob("*.c")), RUNTIME / "omp/threads.c"]
    include = [f"-I{RUNTIME / 'include'}", "-I."]
    flags = ["-std=gnu11", *FLAGS, "-fopenmp", *inline, *scalar, *include]
    run(compiler, *flags, "double_pendulum.c", ROOT / "bench/ensemble.c", *sources, "scalar.o",
        "vector.o", "-lmvec", "-lm", "-o", "ensemble")  # fmt: skip
    return folder / "ensemble"


def numpy_rk4(members: int) -> float:
    """ns a trajectory-step of the same in numpy, whole arrays at a time."""

    def slope(y: numpy.ndarray) -> numpy.ndarray:
        s, c = numpy.sin(y[:2]), numpy.cos(y[:2])
        sine, cosine = s[0] * c[1] - c[0] * s[1], c[0] * c[1] + s[0] * s[1]
        f0 = -sine * y[3] * y[3] - 2 * GRAVITY * s[0]
        f1 = sine * y[2] * y[2] - GRAVITY * s[1]
        det = 1 / (2 - cosine * cosine)
        return numpy.stack([y[2], y[3], (f0 - cosine * f1) * det, (2 * f1 - cosine * f0) * det])

    y = numpy.stack([numpy.linspace(-2, 2, members), *([numpy.full(members, 0.4)] * 3)])
    began = time.perf_counter()
    for _ in range(STEPS):
        k1 = slope(y)
        k2 = slope(y + STEP / 2 * k1)
        k3 = slope(y + STEP / 2 * k2)
        k4 = slope(y + STEP * k3)
        y = y + STEP / 6 * (k1 + 2 * (k2 + k3) + k4)
    return (time.perf_counter() - began) * 1e9 / (members * STEPS)


def main() -> None:
    members = int(sys.argv[1]) if len(sys.argv) > 1 else 102400
    print(f"RK4, {members} double pendulums; flags {' '.join(FLAGS)}; libmvec by -ffast-math")
    whole = min(numpy_rk4(members) for _ in range(3))
    for scalar in ([], ["-DPK_FLOAT"]):
        with tempfile.TemporaryDirectory() as folder:
            program = build(Path(folder), scalar)
            said = subprocess.run(
                [program, str(members)], check=True, capture_output=True, text=True
            ).stdout
        rows = [line.split(";") for line in said.splitlines()]
        ns = {row[0]: statistics.median(float(x) for x in row[1:-1]) for row in rows}
        if not scalar:
            ns["numpy"] = whole
        print(f"\n{'float' if scalar else 'double'}: ns a trajectory-step, over pkgen's")
        apart = {row[0]: row[-1] for row in rows}
        for name, value in ns.items():
            ratio = f"{value / ns['pkgen']:6.2f}"
            print(f"  {name:15} {value:8.2f} {ratio}   differs by {apart.get(name, '-')}")


if __name__ == "__main__":
    main()
