"""`constraint` and `rolling` at the command line: what is kept, ended, tied and refused."""

from __future__ import annotations

import json
import math
import re

import pytest

from conftest import ROOT, case, ran, rows, written

ROD = case("constrained_rod")


def test_a_rod_keeps_its_length(pkgen, tmp_path):
    path = written(tmp_path, ROD)
    done = ran("run", path, "--scene", "swing", "--json")
    assert [x["met"] for x in json.loads(done.stdout)["expects"]] == [True] * 3
    assert pkgen("run", path, "--scene", "many").returncode == 0


def test_a_rod_is_a_pendulum(pkgen, tmp_path):
    """Against the angle, by its own model and another method."""
    pendulum = written(
        tmp_path,
        "model swung\nparam l = 1\ncoord a\nkinetic l^2*a'^2/2\npotential -9.81*l*cos(a)\n"
        "start a = 2\n",
    )
    common = ("--until", "4", "--every", "0.5")
    mine = rows(pkgen, written(tmp_path, ROD), *common, "--method", "gauss")
    theirs = rows(pkgen, pendulum, *common, "--method", "dop853", "--rtol", "1e-12")
    for a, b in zip(mine, theirs, strict=True):
        assert a["x"] == pytest.approx(math.sin(b["a"]), abs=1e-7)
        pull = b["a'"] ** 2 + 9.81 * math.cos(b["a"])
        assert a["pull"] == pytest.approx(pull, abs=1e-5)
    assert max(abs(row["x"]) for row in mine) > 0.9


WRONG = [
    (("--set", "l=1.1", "--start", "x=0.9"), "rod by"),
    (("--start", "x'=1"), "rod, as rates go, by"),
]


@pytest.mark.parametrize(("options", "named"), WRONG)
def test_a_start_off_the_constraints_is_refused(pkgen, tmp_path, options, named):
    done = pkgen("run", written(tmp_path, ROD), "--until", "1", *options)
    assert done.returncode == 4
    assert named in done.stderr and "Traceback" not in done.stderr
    assert len(done.stdout.splitlines()) <= 2  # no rows of a motion that there is not


def test_where_constraints_come_to_depend_on_each_other_the_run_ends(pkgen, tmp_path):
    """A point on a plane that is lowered onto the top of a sphere: there both say the same."""
    path = written(
        tmp_path,
        "model pinched\ncoord x, y, z\nkinetic (x'^2 + y'^2 + z'^2)/2\n"
        "constraint sphere: x^2 + y^2 + z^2 = 1\nconstraint plane: z = t\n"
        "start x = 1, z' = 1, y' = 0.5\n",
    )
    for method in ("gauss", "dop853", "rk4", "rattle"):
        options = () if method in ("gauss", "dop853") else ("--step", "0.001")
        done = pkgen("run", path, "--until", "3", "--method", method, *options)
        assert done.returncode == 4, method
        valid = re.search(r"last valid time ([0-9.]+)", done.stderr)
        assert 0.9 < float(valid[1]) <= 1.001, done.stderr
        if method in ("gauss", "rk4"):
            assert re.search(
                "the constraints cannot be fulfilled here: (plane depends on sphere|"
                "at t = (1|1.0000[0-9]+|0.9999[0-9]+) plane ends or depends on others, "
                "and behind it the branch of the motion cannot)",
                done.stderr,
            )


CHAIN = case("constrained_chain")


def test_a_chain_of_links_hangs_on_them(pkgen, tmp_path):
    """As loops, and written out: so few members are, where they run."""
    path = written(tmp_path, CHAIN)
    options = ("--until", "0.5", "--every", "0.25", "--record", "x[1],y[1],x[9],y[9]")
    ends = []
    for method in ("gauss", "dop853"):
        last = rows(pkgen, path, *options, "--method", method)[-1]
        assert math.hypot(last["x[1]"], last["y[1]"]) == pytest.approx(1, abs=1e-15)
        ends.append(last["y[9]"])
    assert ends[0] == pytest.approx(ends[1], abs=1e-6) and abs(ends[0]) > 3
    said = pkgen("explain", path).stdout
    assert "link[i] = -l^2 + (-x[i-1] + x[i])^2 + (-y[i-1] + y[i])^2   for i = 1..N" in said
    pkgen(path, "-o", tmp_path)
    assert "chain_constraints" in (tmp_path / "chain.c").read_text()


def test_a_turning_point_of_all_rates_but_a_spin():
    """The row of the pivots hardly has the fast spin, and is rounded by it: no failure."""
    path = ROOT / "models" / "constrained" / "gimbals.lag"
    ran("run", path, "--scene", "nutates", "--set", "turn=0")


HELD = case("held")


def test_a_constraint_that_what_is_held_fulfils_is_gone(pkgen, tmp_path):
    path = written(tmp_path, HELD)
    assert rows(pkgen, path, "--scene", "turned")[-1]["z"] == pytest.approx(1)
    done = pkgen("run", path, "--scene", "wrong")
    assert done.returncode == 1
    assert "the constraint 'rod' holds or fails whatever the motion" in done.stderr


TIED = case("tied")
GEARED = case("geared")


@pytest.mark.parametrize("text", [TIED, GEARED])
def test_what_constraints_tie_is_not_reduced(pkgen, tmp_path, text):
    """A force that vanishes leaves no momentum constant, and rows of body rates need the body."""
    path = written(tmp_path, text)
    mine = rows(pkgen, path, "--scene", "one")
    theirs = rows(pkgen, path, "--scene", "one", "--no-reduce")
    for a, b in zip(mine, theirs, strict=True):
        assert a == pytest.approx(b, abs=1e-12)
    assert max(abs(x) for row in theirs for x in row.values()) > 1


AXLE = case("axle")
RAMP = case("ramp")


@pytest.mark.parametrize("method", ["rattle", "lie_midpoint", "rattle6"])
@pytest.mark.parametrize("text", [AXLE, RAMP])
def test_steps_from_rest_and_beside_a_spin(tmp_path, text, method):
    """Rates that rows hardly have are rounding beside the spin; coordinates at 0 have no size."""
    path = written(tmp_path, text)
    ran("run", path, "--until", "1", "--method", method, "--step", "0.01", "--every", "1")


CANCELLING = case("cancelling")


@pytest.mark.parametrize("step", ["1e-2", "1e-3", "1e-4"])
@pytest.mark.parametrize("method", ["rk4", "gauss4", "rattle"])
def test_terms_that_cancel_are_known_by_their_rounding(pkgen, tmp_path, method, step):
    """From rest at 0, where the terms of phi are large and J q is not."""
    path = written(tmp_path, CANCELLING)
    last = rows(pkgen, path, "--until", "1", "--every", "1", "--method", method, "--step", step)[-1]
    assert last["y"] < -0.3
    assert abs(math.sin(last["y"] + 0.3) - 0.5 * last["z"] - math.sin(0.3)) < 2e-15


@pytest.mark.parametrize("method", ["rattle", "rattle6", "lie_midpoint4"])
@pytest.mark.parametrize(("a", "b"), [(1, 1), (300, 400), (30000, 40000)])
def test_terms_that_coordinates_are_small_beside(pkgen, tmp_path, a, b, method):
    """From rest at 0 on a circle, down its slope."""
    text = "model circle\ncoord x, y\nkinetic (x'^2 + y'^2)/2\npotential y\n"
    path = written(tmp_path, f"{text}constraint c: ({a} + x)^2 + ({b} + y)^2 = {a * a + b * b}\n")
    for step in (1e-2, 1e-3, 1e-4, 1e-5):
        options = ("--method", method, "--step", step, "--until", "0.1", "--every", "0.1")
        y = rows(pkgen, path, *options)[-1]["y"]
        assert y == pytest.approx(-0.005 * a * a / (a * a + b * b), rel=1e-2)
