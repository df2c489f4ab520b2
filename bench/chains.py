"""Velocity Verlet on a Fermi-Pasta-Ulam-Tsingou chain (beta): the generated fused step against one
pass over memory, a callback integrator in C and numpy. All in one run, interleaved, medians.

    .venv/bin/python bench/chains.py [--repeat 15] [N ...]      (default 1000 16000 1000000)

Prints ns a mass-step and ratios; --json prints them as one object. $CC and $CFLAGS as for pkgen.
The roofline reads and writes q and v once a step; where they fit a cache it is that cache's.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import os
import re
import shlex
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy
from pkgen.compiler import compile_model
from pkgen.source import Source

MODEL = """\
model chain
size  N = 31
param beta = 0.25
coord q[1..N]
fixed q[0] = 0, q[N+1] = 0
kinetic   sum(q[i]'^2/2, i = 1..N)
potential sum((q[i+1]-q[i])^2/2 + beta/4*(q[i+1]-q[i])^4, i = 0..N)
start q[i = 1..N] = sin(pi*i/(N+1))
"""
FLAGS = "-std=c99 -O3 -march=native -ffp-contract=off -fno-math-errno -fno-trapping-math"
STEP, BETA = 0.05, 0.25
WORK = 4_000_000  # mass-steps that one timing covers at least
SLOW = {"numpy": 8}  # of which so many fewer are made


class Params(ctypes.Structure):
    _fields_ = (
        ("N", ctypes.c_ssize_t),
        ("beta", ctypes.c_double),
        ("c_", ctypes.c_double * 16),
        ("work_", ctypes.c_void_p),
        ("failed_", ctypes.c_int),
    )


def library(directory: Path) -> ctypes.CDLL:
    for name, text in compile_model(Source("chain.lag", MODEL)).files.items():
        # Params below has room for any number of hoisted constants.
        (directory / name).write_text(re.sub(r"pk_real c_\[\d+\]", "pk_real c_[16]", text))
    cc = shlex.split(os.environ.get("CC", "gcc"))
    flags = shlex.split(os.environ.get("CFLAGS", FLAGS))
    sources = ["chain.c", str(Path(__file__).with_name("chains.c"))]
    command = [*cc, *flags, "-shared", "-fPIC", "-I.", *sources, "-o", "chains.so", "-lm"]
    subprocess.run(command, cwd=directory, check=True)
    return ctypes.CDLL(str(directory / "chains.so"))


def by_numpy(q: numpy.ndarray, v: numpy.ndarray, steps: int) -> None:
    """As it is written by hand, without temporary arrays that can be avoided."""
    bond, force = numpy.empty(len(q) + 1), numpy.empty(len(q) + 1)
    padded = numpy.zeros(len(q) + 2)
    padded[1:-1] = q
    inner = padded[1:-1]

    def kick(h: float) -> None:
        numpy.subtract(padded[1:], padded[:-1], out=bond)
        numpy.multiply(bond, bond, out=force)
        numpy.multiply(force, BETA, out=force)
        numpy.add(force, 1, out=force)
        numpy.multiply(force, bond, out=force)
        numpy.multiply(force, h, out=force)
        numpy.add(v, force[1:], out=v)
        numpy.subtract(v, force[:-1], out=v)

    kick(STEP / 2)
    for k in range(steps):
        inner += STEP * v
        kick(STEP if k + 1 < steps else STEP / 2)
    q[:] = inner


def measure(lib: ctypes.CDLL, n: int, repeat: int) -> dict[str, float]:
    params = Params()
    lib.chain_sizes(ctypes.byref(params))
    params.N = n
    lib.chain_defaults(ctypes.byref(params))
    arrays = [numpy.zeros(n) for _ in range(3)]
    q, v, _ = arrays
    pq, pv, pa = (ctypes.c_void_p(x.ctypes.data) for x in arrays)
    steps = max(16, WORK // n)
    h = ctypes.c_double(STEP)
    ways = {
        "fused": lambda s: lib.chains_verlet(ctypes.byref(params), h, ctypes.c_long(s), pq, pv),
        "roofline": lambda s: lib.chains_roofline(
            ctypes.c_long(n), ctypes.c_double(1e-3), ctypes.c_long(s), pq, pv
        ),
        "callback": lambda s: lib.chains_callback(
            ctypes.byref(params), h, ctypes.c_long(s), pq, pv, pa
        ),
        "numpy": lambda s: by_numpy(q, v, s),
    }
    times: dict[str, list[float]] = {name: [] for name in ways}
    ends: dict[str, numpy.ndarray] = {}
    for _ in range(repeat):
        for name, way in ways.items():
            lib.chain_start(ctypes.byref(params), pq, pv)
            made = max(2, steps // SLOW.get(name, 1))
            begun = time.perf_counter()
            way(made)
            times[name].append((time.perf_counter() - begun) / (made * n) * 1e9)
    for name in ("fused", "callback", "numpy"):  # that they do the same
        lib.chain_start(ctypes.byref(params), pq, pv)
        ways[name](3)
        ends[name] = q.copy()
    for name in ("callback", "numpy"):
        assert numpy.allclose(ends["fused"], ends[name], rtol=0, atol=1e-13), name
    return {name: statistics.median(t) for name, t in times.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--repeat", type=int, default=15)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("sizes", type=int, nargs="*", metavar="N")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as directory:
        lib = library(Path(directory))
        found = {
            n: measure(lib, n, options.repeat) for n in options.sizes or [1000, 16000, 1000000]
        }
    if options.json:
        json.dump(found, sys.stdout)
        return
    print("ns a mass-step; fused over roofline, numpy and callback over fused")
    for n, t in found.items():
        print(
            f"N = {n:8}  fused {t['fused']:.3f}  roofline {t['roofline']:.3f}"
            f"  callback {t['callback']:.3f}  numpy {t['numpy']:.2f}"
            f"   {t['fused'] / t['roofline']:.2f}  {t['numpy'] / t['fused']:.1f}"
            f"  {t['callback'] / t['fused']:.1f}"
        )
    sizes = sorted(found)
    print(
        f"cost a mass-step from N = {sizes[0]} to {sizes[-1]}:"
        f" x {found[sizes[-1]]['fused'] / found[sizes[0]]['fused']:.2f}"
    )


if __name__ == "__main__":
    main()
