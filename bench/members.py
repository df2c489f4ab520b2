"""`python -m bench members [--docs] [--members N]`: members a second and core at equal final error.

Double pendulums over a second, each from a start of its own, in double precision on one core:
pkgen's lanes and adaptive members, heyoka's batch mode, SciPy's DOP853 by Dask, diffrax under
JAX's vmap. Seconds are of the processor, so that what else runs counts little.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import os
import resource
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from . import machine, matching, reference, tables
from .builds import ROOT, Unavailable
from .environment import with_peers
from .models import error, model
from .peers.taylor import system
from .peers.vectors import _accelerations, starts
from .report import write_block

NAME, T_END, SHOWN, ROUNDS = "double_pendulum", 1.0, 8, 3
AT = (1e-4, 1e-6, 1e-8, 1e-10)
TOLERANCES = [10.0**-k for k in range(3, 13)]
FEW = 256  # members, by which what a command costs at all is known
PKGEN = (ROOT / ".venv/bin/python", "-m", "pkgen")
HEYOKA, SCIPY = 4096, 64  # members, of slow ones fewer: all alike
# Reported by others, on other machines: docs say so.
JULIA = (
    "Of Julia's `EnsembleGPUKernel` no figure of this work is published, and there is no GPU here. "
    "Its authors report 20 to 100 times the speed of `vmap` in JAX and PyTorch on one GPU "
    "(U. Utkarsh and others, *Automated translation and accelerated solving of differential "
    "equations on multiple GPU platforms*, 2024)."
)
Way = Callable[[int], Iterator[tuple[float, float, list]]]


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench members")
    parser.add_argument(
        "--docs", action="store_true", help="write the table into docs/dev/results/benchmarks.md"
    )
    parser.add_argument("--members", type=int, default=65536)
    parser.add_argument("--here", action="store_true", help="this Python has the peers")
    options = parser.parse_args(words)
    if not options.here:
        return with_peers("members", [*words, "--here"])
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    here = machine.describe()
    firsts = [tuple(map(float, row)) for row in starts(SHOWN)]
    exact = reference.finals_at(model(NAME), firsts, T_END)
    rows, missing = [], []
    for title, way in WAYS.items():
        try:
            points = _curve(way, options.members, exact)
        except (ImportError, Unavailable) as why:
            missing.append(f"- {title}: {why}")
            continue
        rows.append((title, *(_rate(points, e) for e in AT)))
        print(rows[-1], flush=True)
    heading = ["members a second and core, at a final error of", *(f"{e:.0e}" for e in AT)]
    text = "\n\n".join([
        "## Members a second and core",
        "Written by `python -m bench members --docs`: double pendulums over a second, the median "
        "error of eight of them, seconds of the processor.",
        "\n".join(here.lines()),
        tables.table(heading, rows),
        *(["\n".join(missing)] if missing else []),
        "pkgen reads its starts from a file and writes the rows to one; heyoka and diffrax have "
        "both in memory.",
        JULIA,
    ])  # fmt: skip
    print(text)
    if options.docs:
        write_block("members", text)
    return 0


def _curve(way: Way, members: int, exact: list) -> list[matching.Point]:
    seconds: dict[float, list[float]] = {}
    errors: dict[float, float] = {}
    for _ in range(ROUNDS):
        for setting, took, finals in way(members):
            seconds.setdefault(setting, []).append(took)
            pairs = zip(finals[:SHOWN], exact, strict=True)
            errors[setting] = statistics.median(error(f, e) for f, e in pairs)
    settings = list(seconds)
    return matching.curve(settings, [[errors[s]] for s in settings], list(seconds.values()))


def _rate(points: list[matching.Point], wanted: float) -> str:
    found = matching.seconds_at(points, wanted)
    return "-" if found is None else f"{'> ' if found.bound else ''}{1 / found.seconds:,.3g}"


def _pkgen(method: str, settings: list[str]) -> Way:
    def way(members: int) -> Iterator[tuple[float, float, list]]:
        import numpy

        of = model(NAME)
        values = zip(of.parameters, of.values, strict=True)
        fixed = [f"--set={str(p).removeprefix('p_')}={x!r}" for p, x in values]
        names = ["theta1", "theta2"]
        with tempfile.TemporaryDirectory() as folder:
            table, rows = Path(folder, "starts.csv"), Path(folder, "rows.npy")

            def spent(some: int, *words: str) -> float:
                """Seconds of the processor of all that pkgen does, files too."""
                head = ",".join([*names, *(name + "'" for name in names)])
                lines = (",".join(map(repr, map(float, row))) for row in starts(some))
                table.write_text("\n".join([head, *lines]) + "\n")
                command = [*PKGEN, "run", ROOT / f"models/{NAME}.lag", *fixed, *words]
                command += ["--ensemble", table, "--until", str(T_END), "--threads", "1"]
                began = resource.getrusage(resource.RUSAGE_CHILDREN)
                done = subprocess.run([*command, "-o", rows], capture_output=True, text=True)
                ended = resource.getrusage(resource.RUSAGE_CHILDREN)
                if done.returncode:
                    raise SystemExit(f"bench: {done.stderr}")
                return ended.ru_utime + ended.ru_stime - began.ru_utime - began.ru_stime

            for setting in settings:
                words = "--method", method, setting
                spent(FEW, *words)  # it is compiled
                few = spent(FEW, *words)
                took = max(spent(members, *words) - few, 1e-9) / (members - FEW)
                made = numpy.load(rows)[:SHOWN]  # a record a row: member, t, q, v, ...
                finals = [list(one)[2:6] for one in made.tolist()]
                yield float(setting.partition("=")[2]), took, finals

    return way


def _heyoka(members: int) -> Iterator[tuple[float, float, list]]:
    import heyoka
    import numpy

    width = heyoka.recommended_simd_size()
    first = starts(min(members, HEYOKA))
    for tolerance in TOLERANCES:
        start = numpy.ascontiguousarray(first[:width].T)
        integrator = heyoka.taylor_adaptive_batch(system(model(NAME), True), start, tol=tolerance)
        final = numpy.empty_like(first)
        begin = time.process_time()
        for k in range(0, len(first), width):
            integrator.set_time(0.0)
            integrator.state[:] = first[k : k + width].T
            integrator.propagate_until(T_END)
            final[k : k + width] = integrator.state.T
        yield tolerance, (time.process_time() - begin) / len(first), final.tolist()


def _solved(first, tolerance: float) -> tuple[float, list]:
    """On a worker of Dask."""
    from scipy.integrate import solve_ivp

    f = _accelerations(model(NAME), "math")

    def rates(_: float, y):
        return (y[2], y[3], *f(*y))

    begin = time.process_time()
    how = {"method": "DOP853", "rtol": tolerance, "atol": tolerance}
    finals = [solve_ivp(rates, (0, T_END), y, **how).y[:, -1].tolist() for y in first]
    return time.process_time() - begin, finals


def _scipy_dask(members: int) -> Iterator[tuple[float, float, list]]:
    from distributed import Client, LocalCluster

    first = starts(min(members, SCIPY))
    pieces = [first[k : k + 16] for k in range(0, len(first), 16)]
    one = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": None}
    with LocalCluster(**one) as cluster, Client(cluster) as client:
        for tolerance in TOLERANCES:
            tasks = [client.submit(_solved, piece, tolerance, pure=False) for piece in pieces]
            found = client.gather(tasks)
            finals = [y for _, some in found for y in some]
            yield tolerance, sum(seconds for seconds, _ in found) / len(first), finals


def _diffrax(members: int) -> Iterator[tuple[float, float, list]]:
    os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false"
    os.environ["JAX_PLATFORMS"] = "cpu"
    import diffrax
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    f = _accelerations(model(NAME), "jax")

    def rates(t, y, args):
        return jnp.stack((y[2], y[3], *f(*y)))

    first = jnp.asarray(starts(min(members, 4096)))

    @jax.jit
    def all_of(y0, tolerance):
        def one(y):
            return diffrax.diffeqsolve(
                diffrax.ODETerm(rates), diffrax.Dopri8(), 0.0, T_END, None, y, max_steps=10_000,
                stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
            ).ys[-1]  # fmt: skip

        return jax.vmap(one)(y0)

    for tolerance in TOLERANCES:
        all_of(first, tolerance).block_until_ready()
        begin = time.process_time()
        final = all_of(first, tolerance).block_until_ready()
        yield tolerance, (time.process_time() - begin) / len(first), final.tolist()


def _version(*names: str) -> str:
    def of(name: str) -> str:
        try:
            return f"{name} {importlib.metadata.version(name)}"
        except importlib.metadata.PackageNotFoundError:
            return name

    return ", ".join(map(of, names))


WAYS: dict[str, Way] = {
    "pkgen rk4, lanes": _pkgen(
        "rk4", [f"--step={1 / n!r}" for n in (20, 50, 100, 250, 1000, 4000)]
    ),
    "pkgen dop853": _pkgen("dop853", [f"--rtol={10.0**-k!r}" for k in range(4, 13)]),
    "pkgen taylor": _pkgen("taylor", [f"--rtol={10.0**-k!r}" for k in range(3, 14)]),
    f"{_version('heyoka')}, batch mode": _heyoka,
    f"{_version('scipy', 'distributed')}, DOP853": _scipy_dask,
    f"{_version('diffrax', 'jax')}, Dopri8 by vmap": _diffrax,
}
