"""`pkgen sweep`: members are single runs; the data set has the same bytes whoever made it, whatever
was killed meanwhile."""

from __future__ import annotations

import csv
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

import pytest
from sweeps import DOUBLE, PLAN, contents

from conftest import long_but

pq = pytest.importorskip("pyarrow.parquet")
SEEDS = range(12)
RATE = "theta2'(0)"
COLUMNS = ("t", "theta1", "theta2", "theta1'", "theta2'", "energy")


def axes(kind: str, members: int) -> str:
    if kind == "list":
        pick = random.Random(members)
        values = [[pick.uniform(-2, 2) for _ in range(members)] for _ in range(2)]
        return f"theta1 = {values[0]}\nm1 = {[abs(x) + 0.1 for x in values[1]]}\n"
    if kind == "grid":
        return 'theta1 = ["-120 .. 120 [deg]", 9]\nm1 = ["1 [kg]", "0.5 [kg]", 2, "3000 [g]"]\n'
    return 'theta1 = "-3 .. 3 [rad]"\n"theta2\'" = "-1 .. 100 [deg/s]"\nm1 = "0.5 .. 2 [kg]"\n'


def plan(folder: Path, seed: int) -> tuple[Path, int]:
    """One of many."""
    pick = random.Random(seed)
    kind = ("random", "grid", "list", "sobol", "latin")[seed % 5]
    members = 36 if kind == "grid" else pick.randint(20, 200)
    keep = pick.choice(
        ['["final"]', '["rows", "final"]', '["max(theta1)", "mean(energy)", "final"]']
    )
    method = pick.choice(
        ['"rk4"\nstep = 0.01', '"dop853"\nrtol = 1e-9', '"gauss2"\nstep = "10 [ms]"']
    )
    path = folder / "plan.toml"
    path.write_text(
        f"until = 1\nevery = 0.25\nmethod = {method}\nmembers = {members}\nseed = {seed}\n"
        f'keep = {keep}\nset = ["l2=80 [cm]"]\n[{kind}]\n{axes(kind, members)}'
    )
    return path, members


def table(text: str) -> list[list[float]]:
    return [[float(x) for x in row] for row in list(csv.reader(text.splitlines()))[1:]]


@pytest.mark.parametrize("seed", long_but((0, 4), SEEDS))
def test_bytes_are_the_same_and_members_are_single_runs(pkgen, tmp_path: Path, seed: int) -> None:
    path, members = plan(tmp_path, seed)
    made = []
    for shards, workers in ((1, 1), (3, 3), (7, 2)):
        folder = tmp_path / f"by{shards}"
        more = ("--shard", -(-members // shards), "--workers", workers)
        done = pkgen("sweep", DOUBLE, "--plan", path, "-o", folder, *more)
        assert done.returncode == 0, done.stderr
        assert f"{members} of {members} members (100%)" in done.stderr
        assert not list((folder / "shards").iterdir())
        made.append(contents(folder))
    assert made[0] == made[1] == made[2]
    found = pq.read_table(folder / "data").to_pydict()
    assert found["member"] == list(range(1, members + 1)) and set(found["status"]) == {"PK_DONE"}
    text = path.read_text()
    settings = [
        f"--{k}={v}" for k, v in re.findall(r'^(method|step|rtol) = "?([^"\n]+)', text, re.M)
    ]
    for k in random.Random(seed).sample(range(members), 2):
        starts = [f"--start=theta1={found['theta1(0)'][k]!r}", f"--set=m1={found['m1'][k]!r}"]
        if RATE in found:
            starts.append(f"--start=theta2'={found[RATE][k]!r}")
        fixed = ["--set", "l2=0.8", "--until", "1", "--every", "0.25"]
        rows = table(pkgen("run", DOUBLE, *settings, *starts, *fixed).stdout)
        assert rows[-1] == [found[c][k] for c in COLUMNS]
        if "max(theta1)" in found:
            assert found["max(theta1)"][k] == max(row[1] for row in rows)
            mean = sum(row[-1] for row in rows) / len(rows)
            assert found["mean(energy)"][k] == pytest.approx(mean, rel=1e-15)
        if "rows" in text:
            kept = pq.read_table(folder / "rows").to_pydict()
            of = [i for i, m in enumerate(kept["member"]) if m == k + 1]
            assert rows == [[kept[c][i] for c in list(kept)[1:]] for i in of]


SLOW = """until = 4
method = "rk4"
step = 2e-4
members = 40
seed = 5
[random]
theta1 = "-3 .. 3 [rad]"
"""


def workers_of(pid: int) -> list[int]:
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(stat.read_text().rpartition(")")[2].split()[1])
            if parent == pid and b"sweep.worker" in (stat.parent / "cmdline").read_bytes():
                found.append(int(stat.parent.name))
        except (OSError, IndexError):
            continue
    return found


@pytest.mark.parametrize("seed", long_but((0,), range(8)))
def test_what_is_killed_is_not_lost_and_not_made_twice(pkgen, tmp_path: Path, seed: int) -> None:
    pick = random.Random(seed)
    path = tmp_path / "plan.toml"
    path.write_text(SLOW)
    done = pkgen("sweep", DOUBLE, "--plan", path, "-o", tmp_path / "calm", "--workers", 2)
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "killed"
    command = [sys.executable, "-m", "pkgen", "sweep", DOUBLE, "--plan", path, "-o", folder]
    command += ["--shard", "5", "--workers", "2"]
    killed = 0
    for again in range(20):
        running = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        due = pick.randrange(1, 3)  # shards of eight, which no machine is too quick for
        while running.poll() is None and again < 3:
            time.sleep(0.002)
            if len(list((folder / "shards").glob("[0-9]*"))) < due:
                continue
            workers = workers_of(running.pid)
            if not workers or pick.random() < 0.5:
                running.kill()
            else:
                os.kill(pick.choice(workers), signal.SIGKILL)
            killed += 1
            due += pick.randrange(1, 4)
        said = running.communicate()[1]
        if running.returncode == 0:
            break
        assert running.returncode in (-9, 4), said
    assert running.returncode == 0, said
    assert killed
    assert contents(folder) == contents(tmp_path / "calm")
    assert not list(folder.glob("**/*.partial"))


def test_a_torn_file_is_made_again(pkgen, tmp_path: Path) -> None:
    path, _ = plan(tmp_path, 5)
    folder = tmp_path / "sweep"
    assert pkgen("sweep", DOUBLE, "--plan", path, "-o", folder, "--shard", 11).returncode == 0
    before = contents(folder)
    (name,) = [name for name in before if name.startswith("data")]
    torn = bytearray(before[name])
    torn[len(torn) // 2] ^= 1
    (folder / name).write_bytes(torn)
    done = pkgen("sweep", "--resume", folder)
    assert done.returncode == 0, done.stderr
    assert contents(folder) == before


CLUSTERS = {"dask": "distributed", "ray": "ray"}


def _engine(name: str) -> str:
    """Why it is not here, or ""."""
    if name != "slurm":
        return "" if find_spec(CLUSTERS[name]) else f"pip install {CLUSTERS[name]}"
    found = shutil.which("sinfo") and subprocess.run(["sinfo"], capture_output=True)
    return "" if found and found.returncode == 0 else "no Slurm answers"


@pytest.mark.long
@pytest.mark.parametrize("engine", [*CLUSTERS, "slurm"])
def test_engines_make_the_same_bytes(pkgen, tmp_path: Path, engine: str) -> None:
    if why := _engine(engine):
        pytest.skip(why)
    path, members = plan(tmp_path, 6)
    command = ("sweep", DOUBLE, "--plan", path, "--workers", 2)
    assert pkgen(*command, "-o", tmp_path / "local").returncode == 0
    more = ("--engine", engine, "--shard", members // 5, "-o", tmp_path / engine)
    done = pkgen(*command, *more, env=dict(os.environ))
    assert done.returncode == 0, done.stderr
    assert contents(tmp_path / engine) == contents(tmp_path / "local")


def test_a_full_disk_is_told_and_leaves_no_half_file(pkgen, tmp_path: Path) -> None:
    """A limit of the size of files stands for it."""
    path, folder = tmp_path / "plan.toml", tmp_path / "sweep"
    path.write_text(PLAN)
    done = pkgen("sweep", DOUBLE, "--plan", path, "-o", tmp_path / "first")
    assert done.returncode == 0, done.stderr  # its library is in the cache
    path.write_text(PLAN.replace("members = 8", "members = 20000"))
    command = (
        f"ulimit -f 100; exec {sys.executable} -m pkgen sweep {DOUBLE} --plan {path} -o {folder}"
    )
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True)
    assert done.returncode == 2 and "File too large; what is done stays" in done.stderr
    assert not list(folder.glob("**/*.partial")) and not list(folder.glob("shards/*"))
    done = pkgen("sweep", "--resume", folder)
    assert done.returncode == 0, done.stderr
    assert pq.read_table(folder / "data").num_rows == 20000
