"""`python -m bench scale [--docs] [--members N]`: what sweeps of 1e6, 1e9, 1e12 members cost.

The costs of a member, of a shard and of a byte are measured, as seconds of the processor, by sweeps
of one model that differ in how they are cut. A simulation of 1e5 shards on workers that die says
what failures cost, and demands that each shard is done once in the data set: scale_farm.py.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from . import machine
from .models import ROOT
from .scale_farm import Farm, simulated
from .tables import table

PAGE = ROOT / "addons/sweep/scale.md"
MARK = "<!-- python -m bench scale --docs -->\n"
MODEL = ROOT / "models" / "double_pendulum.lag"
PLAN = """until = 5
method = "dop853"
rtol = 1e-9
members = {members}
keep = ["max(theta2)"]
[random]
theta1 = "-3 .. 3 [rad]"
theta2 = "-3 .. 3 [rad]"
"""
SHARD = 10.0  # s of work, the least
DASK = 1e-3  # s that Dask's scheduler takes for a task, its documentation says ("about 1 ms")
SLURM_TASKS = 1000  # of an array: MaxArraySize is 1001 as Slurm comes
DAY = 86400.0


@dataclass(frozen=True)
class Costs:
    """Of the processor in seconds, and of the disk in bytes."""

    start: float  # of a sweep
    member: float
    shard: float
    bytes: float  # of a member, in the data set
    status: float  # of a shard, in --status


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench scale", description=__doc__)
    parser.add_argument("--docs", action="store_true", help="write the tables into its page")
    parser.add_argument("--members", type=int, default=40_000, metavar="N", help="of a measurement")
    options = parser.parse_args(words)
    costs = measured(options.members)
    text = "\n\n".join([_constants(costs), _table(costs), _failures(costs)]) + "\n"
    print(text)
    if options.docs:
        before, mark, _ = PAGE.read_text().partition(MARK)
        said = "\n".join(machine.describe().lines())
        PAGE.write_text(f"{before}{mark}\n{said}\n\n{text}")
    return 0


def measured(members: int) -> Costs:
    """By differences: twice as many members, a hundred times as many shards."""
    with tempfile.TemporaryDirectory() as folder:
        run = lambda name, n, shard: _sweep(Path(folder, name), n, shard)  # noqa: E731
        run("first", 100, 100)  # compiles
        small, _ = run("small", members // 2, members // 2)
        whole, size = run("whole", members, members)
        parts = 400
        cut, _ = run("cut", members, members // parts)
        status = _status(Path(folder, "cut")) - _status(Path(folder, "whole"))
    member = (whole - small) / (members - members // 2)
    start = whole - member * members
    return Costs(start, member, (cut - whole) / (parts - 1), size / members, status / (parts - 1))


def _sweep(folder: Path, members: int, shard: int) -> tuple[float, int]:
    """Seconds of the processor, all its processes', and bytes of its data set."""
    plan = folder.with_suffix(".toml")
    plan.write_text(PLAN.format(members=members))
    began = _children()
    _pkgen("sweep", MODEL, "--plan", plan, "-o", folder, "--shard", shard, "--workers", 1)
    return _children() - began, sum(f.stat().st_size for f in (folder / "data").iterdir())


def _status(folder: Path) -> float:
    began = _children()
    _pkgen("sweep", "--status", folder)
    return _children() - began


def _pkgen(*words: object) -> None:
    command = [sys.executable, "-m", "pkgen", *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"pkgen {' '.join(map(str, words))}: {done.stderr}")


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _constants(costs: Costs) -> str:
    rows = [
        ["a sweep, whatever its size", f"{costs.start:.2f} s"],
        ["a member (double pendulum, 5 s, dop853 at 1e-9)", f"{1e6 * costs.member:.1f} µs"],
        ["a shard, beside its members", f"{1e3 * costs.shard:.2f} ms"],
        [
            "a member in the data set: two starts, status, time, one number",
            f"{costs.bytes:.1f} bytes",
        ],
        ["`--status`, a shard", f"{1e6 * costs.status:.0f} µs"],
    ]
    return table(["measured, of one core", "cost"], rows)


def shards_of(costs: Costs, members: float, seconds: float) -> float:
    return max(1.0, members * costs.member / seconds)


def _table(costs: Costs) -> str:
    rows = []
    for members in (1e6, 1e9, 1e12):
        work = members * costs.member
        # Long enough that an hour's bookkeeping is a thousandth, short enough for a queue.
        seconds = min(3600.0, max(SHARD, work / 1e5))
        shards = shards_of(costs, members, seconds)
        size = members * costs.bytes
        rows.append(
            [
                f"{members:.0e}",
                _hours(work / 3600),
                _bytes(size),
                _bytes(size * (8 / costs.bytes)),
                f"{seconds:.0f} s",
                _count(shards),
                _count(max(1, members / 2**20)),
                f"{100 * shards * costs.shard / work:.2g} %",
                _time(shards * DASK),
                _count(max(1, shards / SLURM_TASKS)),
            ]
        )
    head = ["members", "core-hours", "data set", "one number of each", "a shard", "shards", "files"]
    head += ["bookkeeping", "Dask's scheduler", "shards a Slurm task"]
    return table(head, rows)


def _failures(costs: Costs) -> str:
    rows = []
    for seconds in (10.0, 60.0, 600.0, 3600.0):
        for between in (3600.0, DAY, 30 * DAY):
            farm = Farm(shards=100_000, seconds=seconds, workers=1000, between=between)
            found = simulated(farm)
            rows.append(
                [
                    f"{seconds:.0f} s",
                    _time(between),
                    f"{found.died:,}",
                    f"{found.again:,}",
                    f"{found.given_up:,}",
                    f"{100 * found.lost:.2g} %",
                    _time(found.wall),
                ]
            )
    head = ["a shard", "between failures of a worker", "died", "run again", "failed for good"]
    return table([*head, "work lost", "wall"], rows)


def _count(x: float) -> str:
    return f"{x:,.0f}" if x < 1e7 else f"{x:.1e}"


def _hours(x: float) -> str:
    return f"{x:,.0f}" if x >= 10 else f"{x:.2g}"


def _bytes(x: float) -> str:
    for unit in ("B", "kB", "MB", "GB", "TB"):
        if x < 1000:
            return f"{x:.3g} {unit}"
        x /= 1000
    return f"{x:.3g} PB"


def _time(x: float) -> str:
    for unit, size in (("days", DAY), ("h", 3600.0), ("min", 60.0)):
        if x >= 2 * size:
            return f"{x / size:.3g} {unit}"
    return f"{x:.2g} s"
