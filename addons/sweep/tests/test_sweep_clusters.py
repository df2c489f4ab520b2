"""Clusters whose workers are killed in the middle: nothing is lost, nothing is made twice."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

import pytest
from sweeps import DOUBLE, PLAN, contents

pytest.importorskip("pyarrow")
SLOW = PLAN.replace("members = 8", "members = 60").replace("step = 0.1", "step = 2e-6")
# The package, and what the command line of a worker has at work.
ENGINES = {"dask": ("distributed", b"spawn_main"), "ray": ("ray", b"ray::task")}


def below(pid: int) -> list[tuple[int, bytes]]:
    """The processes that come of it, with their command lines."""
    found, parents = [], {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            parents[int(stat.parent.name)] = int(stat.read_text().rpartition(")")[2].split()[1])
        except OSError:
            continue
    for one in parents:
        above = one
        while above in parents and above != pid:
            above = parents[above]
        if above == pid and one != pid:
            try:
                found.append((one, Path(f"/proc/{one}/cmdline").read_bytes()))
            except OSError:
                continue
    return found


@pytest.mark.long
@pytest.mark.parametrize("engine", ENGINES)
def test_a_worker_that_is_killed_costs_nothing(pkgen, tmp_path: Path, engine: str) -> None:
    package, mark = ENGINES[engine]
    if not find_spec(package):
        pytest.skip(f"pip install {package}")
    path = tmp_path / "plan.toml"
    path.write_text(SLOW)
    assert pkgen("sweep", DOUBLE, "--plan", path, "-o", tmp_path / "calm").returncode == 0
    command = [sys.executable, "-m", "pkgen", "sweep", DOUBLE, "--plan", path, "--engine", engine]
    command += ["-o", tmp_path / "s", "--workers", "2", "--shard", "4"]
    running = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    killed, shards = 0, tmp_path / "s/shards"
    while running.poll() is None and killed < 2:
        time.sleep(0.02)
        if len(list(shards.glob("[0-9]*"))) <= killed:
            continue
        workers = [pid for pid, text in below(running.pid) if mark in text]
        if workers:
            os.kill(random.choice(workers), signal.SIGKILL)
            killed += 1
            time.sleep(0.5)
    said = running.communicate()[1]
    assert running.returncode == 0 and killed == 2, said
    assert contents(tmp_path / "s") == contents(tmp_path / "calm")
    assert not list((tmp_path / "s").glob("**/*.partial"))
    assert not list((tmp_path / "s/failed").iterdir())
