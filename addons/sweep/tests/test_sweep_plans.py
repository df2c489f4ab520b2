"""What plans of sweeps say, right and wrong, and what is kept of members."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from sweeps import DOUBLE, PLAN, contents

from conftest import long_but

pq = pytest.importorskip("pyarrow.parquet")
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
