"""`pkgen sweep`: members are single runs; the data set has the same bytes whoever made it, whatever
was killed meanwhile."""

from __future__ import annotations

import csv
import json
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
from conftest import ROOT, long_but

pq = pytest.importorskip("pyarrow.parquet")
DOUBLE = ROOT / "models/double_pendulum.lag"
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


def contents(folder: Path) -> dict[str, bytes]:
    found = sorted(folder.glob("*/*.parquet"))
    assert found
    return {str(path.relative_to(folder)): path.read_bytes() for path in found}


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
        end = time.monotonic() + pick.uniform(0.5, 2.5)
        while running.poll() is None and again < 3:
            time.sleep(pick.uniform(0.05, 0.3))
            if time.monotonic() > end:
                running.kill()
            elif (workers := workers_of(running.pid)) and pick.random() < 0.3:
                os.kill(pick.choice(workers), signal.SIGKILL)
                killed += 1
        said = running.communicate()[1]
        if running.returncode == 0:
            break
        assert running.returncode in (-9, 4), said
    assert running.returncode == 0, said
    assert killed or again
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


PLAN = """members = 8
method = "rk4"
step = 0.1
until = 1
keep = ["final"]
[random]
theta1 = "-3 .. 3 [rad]"
"""


WRONG = [
    ("members = 8", "members = 0", "plan.toml:1:11: error: members must be at least 1"),
    ("members = 8", "members = nan", "plan.toml:1:11: error: members is a whole number"),
    ("members = 8", "members = 1e12", "plan.toml:1:11: error: 1,000,000,000,000 members; the"),
    ("members = 8", "", "how many members? give members = N"),
    ("members = 8", "member = 8", "plan has no 'member'\n    1 | member = 8"),
    ("members = 8", "member = 8", "help: did you mean 'members'"),
    ("members = 8", "members = 8\nseed = -1", "plan.toml:2:8: error: seed must be at least 0"),
    ("until = 1", "until = -1", "plan.toml:4:9: error: until -1: until must be positive"),
    ("until = 1", 'until = "1 [kg]"', "plan.toml:4:9: error: until 1 [kg]: "),
    ("until = 1", "until = [1]", "plan.toml:4:9: error: until is one value"),
    ('"rk4"', '"rk5"', "plan.toml:2:10: error: method rk5: there is no such method"),
    ('["final"]', '["finale"]', "plan.toml:5:8: error: nothing is kept as 'finale'"),
    ('["final"]', '["max(theta3)"]', "theta3: the model has no such column; did you mean"),
    ('["final"]', '["time(flip)"]', "plan.toml:5:8: error: the model has no event flip"),
    ('["final"]', '["final", "final(energy)", "final(energy)"]', "is kept twice"),
    ("[random]", "[randon]", "plan.toml:6:1: error: a plan has no [randon]"),
    ("[random]", "[grid]", "plan.toml"),
    ("[random]", "[list]", "plan.toml:7:10: error: theta1 is a list of values"),
    ("[random]", "[sobol]\nm1 = 3\n[latin]", "[sobol] and [latin]: members are drawn in one"),
    ("theta1 =", "theta3 =", "plan.toml:7:10: error: the model has no such parameter"),
    ("-3 .. 3 [rad]", "-3 .. 3 [m]", "plan.toml:7:11: error: theta1: "),
    ("-3 .. 3 [rad]", "3 .. -3 [rad]", "plan.toml:7:10: error: theta1: the range runs back"),
    ("-3 .. 3 [rad]", "0 .. nan", "plan.toml:7:16: error: theta1: "),
    ("-3 .. 3 [rad]", "0 .. 1e999", "plan.toml:7:16: error: theta1: an exponent beyond 400"),
    ("-3 .. 3 [rad]", "-1e308 .. 1.5e308", "the range is wider than any double"),
    ("-3 .. 3 [rad]", "0 .. __import__('os')", "plan.toml:7:27: error: theta1: "),
    ("-3 .. 3 [rad]", "3 [rad]", "plan.toml:7:10: error: theta1 is a range"),
    ("theta1 = ", "theta1 = = ", "plan.toml:7:10: not TOML: "),
    ('"rk4"', '"verlet"', "verlet needs a system that is separable"),
]


@pytest.mark.parametrize("case", long_but([WRONG[0], WRONG[4], WRONG[20], WRONG[25]], WRONG))
def test_wrong_plans_are_told_with_their_place(pkgen, tmp_path: Path, case) -> None:
    old, new, said = case
    path = tmp_path / "plan.toml"
    path.write_text(PLAN.replace(old, new))
    done = pkgen("sweep", DOUBLE, "--plan", path, "-o", tmp_path / "sweep")
    if new == "[grid]":  # 8 points of one axis
        assert done.returncode == 0, done.stderr
        return
    assert done.returncode in (2, 4) and said in done.stderr, done.stderr
    assert "Traceback" not in done.stderr and "internal" not in done.stderr
    assert not (tmp_path / "sweep").exists()


def test_a_member_that_fails_costs_itself_alone(pkgen, tmp_path: Path) -> None:
    model = tmp_path / "heavy.lag"
    model.write_text(
        "model heavy\nparam m = 1 in (0, inf)\ncoord q\nkinetic m*(1 - q)*q'^2/2\n"
        "event half: q - 0.5 rising\nstart q' = 0.5\n"
    )
    path = tmp_path / "plan.toml"
    path.write_text(
        'until = 0.5\nmethod = "rk4"\nstep = 1e-3\n'
        'keep = ["final", "count(half)", "time(half)", "drift"]\n'
        "[list]\nq = [0.1, 0.9, 0.4, 0.2]\nm = [1, 1, 2, -1]\n"
    )
    done = pkgen("sweep", model, "--plan", path, "-o", tmp_path / "sweep", "--shard", 3)
    assert done.returncode == 0, done.stderr
    assert "2 of 4 members failed" in done.stderr
    assert "PK_OUT_OF_BOUNDS, first member 4: a parameter is outside its bounds: m" in done.stderr
    found = pq.read_table(tmp_path / "sweep/data").to_pydict()
    assert found["status"] == ["PK_DONE", "PK_SINGULAR_COORDINATES", "PK_DONE", "PK_OUT_OF_BOUNDS"]
    assert found["q"][1] is found["q"][3] is found["drift(energy)"][1] is None
    assert 0.05 < found["t"][1] < 0.2 and found["t"][3] == 0
    assert found["count(half)"] == [0, None, 1, None] and found["time(half)"][0] is None
    # (1 - q)^(3/2) falls at an equal rate.
    assert found["time(half)"][2] == pytest.approx((0.6**1.5 - 0.5**1.5) / (0.75 * 0.6**0.5))
    status = json.loads(pkgen("sweep", "--status", tmp_path / "sweep", "--json").stdout)
    assert (status["done"], status["failed"], status["running"]) == (4, 2, False)


def test_a_folder_is_of_one_plan(pkgen, tmp_path: Path) -> None:
    path, folder = tmp_path / "plan.toml", tmp_path / "sweep"
    path.write_text(PLAN)
    command = ("sweep", DOUBLE, "--plan", path, "-o", folder)
    assert pkgen(*command).returncode == pkgen(*command).returncode == 0
    path.write_text(PLAN.replace("3 [rad]", "2 [rad]"))
    done = pkgen(*command)
    assert done.returncode == 2 and "the sweep there is of another plan" in done.stderr
    (folder / "plan.toml").write_text(PLAN.replace("members = 8", "members = 9"))
    done = pkgen("sweep", "--resume", folder)
    assert done.returncode == 2 and "begin it anew" in done.stderr
    (tmp_path / "own.txt").write_text("mine")
    done = pkgen(*command[:-1], tmp_path)
    assert done.returncode == 2 and "is no sweep's" in done.stderr
    done = pkgen("sweep", "--status", tmp_path)
    assert done.returncode == 2 and "no sweep lies there" in done.stderr


def _engine(name: str) -> str:
    """Why it is not here, or ""."""
    if name == "dask":
        return "" if find_spec("distributed") else "pip install distributed"
    found = shutil.which("sinfo") and subprocess.run(["sinfo"], capture_output=True)
    return "" if found and found.returncode == 0 else "no Slurm answers"


@pytest.mark.long
@pytest.mark.parametrize("engine", ["dask", "slurm"])
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


BASINS = """model basins
coord x, y
kinetic (x'^2 + y'^2)/2
potential x^4/4 - x^2/2 + y^2/2 + x*y^2/3
event right: x - 0.9 rising
"""
REFINED = """until = 3
method = "rk4"
step = 0.02
keep = ["count(right)"]
[grid]
x = ["-1.5 .. 1.5", {0}]
"y'" = ["0 .. 1.5", {0}]
"""


def _cut(found: dict, size: int, at: tuple[int, int], wanted: set) -> None:
    """The corners of a cell, and of the pieces that it is cut into."""
    corners = [(at[0] + i * size, at[1] + j * size) for i in (0, 1) for j in (0, 1)]
    wanted.update(corners)
    if size > 1 and len({found[c] for c in corners}) > 1:
        half = size // 2
        for i in (0, 1):
            for j in (0, 1):
                _cut(found, half, (at[0] + i * half, at[1] + j * half), wanted)


def test_grids_are_refined_where_classes_change(pkgen, tmp_path: Path) -> None:
    """Against the whole of the finest grid, cut by a recursion."""
    model, path, whole = (tmp_path / name for name in ("basins.lag", "plan.toml", "whole.toml"))
    model.write_text(BASINS)
    path.write_text(REFINED.format(5) + '[refine]\nwhere = "count(right)"\nlevels = 2\n')
    whole.write_text(REFINED.format(17))
    for name, of, shard in (("by7", path, 7), ("by99", path, 99), ("whole", whole, 300)):
        done = pkgen("sweep", model, "--plan", of, "-o", tmp_path / name, "--shard", shard)
        assert done.returncode == 0, done.stderr
    assert contents(tmp_path / "by7") == contents(tmp_path / "by99")
    table = {}
    for name in ("by7", "whole"):
        rows = pq.read_table(tmp_path / name / "data").sort_by("member").to_pydict()
        places = (round((x + 1.5) / 3 * 16) for x in rows["x(0)"])
        places = list(zip(places, (round(v / 1.5 * 16) for v in rows["y'(0)"]), strict=True))
        table[name] = dict(zip(places, rows["count(right)"], strict=True))
        assert len(table[name]) == len(places)  # each once
        assert rows["member"] == list(range(1, len(places) + 1))
    wanted: set[tuple[int, int]] = set()
    for i in range(0, 16, 4):
        for j in range(0, 16, 4):
            _cut(table["whole"], 4, (i, j), wanted)
    assert table["by7"] == {place: table["whole"][place] for place in wanted}
    assert 25 < len(wanted) < 17 * 17


def test_exponents_are_those_of_single_runs(pkgen, tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    more = 'keep = ["lyapunov"]\n[list]\ntheta1 = [0.01, 2.5]\n'
    path.write_text('until = 20\nmethod = "rk4"\nstep = 0.01\n' + more)
    done = pkgen("sweep", DOUBLE, "--plan", path, "-o", tmp_path / "sweep")
    assert done.returncode == 0, done.stderr
    found = pq.read_table(tmp_path / "sweep/data").column("lyapunov").to_pylist()
    for start, exponent in zip((0.01, 2.5), found, strict=True):
        options = ("--start", f"theta1={start}", "--until", 20, "--method", "rk4", "--step", 0.01)
        done = pkgen("run", DOUBLE, *options, "--diagnose", "lyapunov", "--json")
        alone = json.loads(done.stdout)["report"]["diagnostics"]["lyapunov"]["exponent"]
        assert exponent == pytest.approx(alone, rel=1e-12)
    assert found[1] > 0.3
