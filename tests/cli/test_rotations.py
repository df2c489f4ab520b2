"""`rotation` at the command line: rows, options, members, reductions, what is refused."""

from __future__ import annotations

import math

import pytest

from conftest import case, rows, written

THROWN = case("thrown")


def test_rows_are_in_the_order_of_the_model(pkgen, tmp_path):
    path = written(tmp_path, THROWN)
    done = pkgen("run", path, "--until", "1", "--every", "1")
    header = done.stdout.splitlines()[0]
    assert header == ("t,x,R.w,R.x,R.y,R.z,z,x',omega(R).x,omega(R).y,omega(R).z,z',energy")
    record = pkgen("run", path, "--until", "1", "--every", "1", "--record", "R,omega(R).z,z'")
    assert record.stdout.splitlines()[0] == "t,R.w,R.x,R.y,R.z,omega(R).z,z'"
    assert done.stdout.splitlines()[1].startswith(f"0,0,{math.cos(0.15)!r},")


@pytest.mark.parametrize(("scene", "gone"), [("rates", "R.w"), ("flight", "omega(R).x")])
def test_a_reduced_motion_is_the_whole(pkgen, tmp_path, scene, gone):
    path = written(tmp_path, THROWN)
    reduced = rows(pkgen, path, "--scene", scene)
    whole = rows(pkgen, path, "--scene", scene, "--no-reduce")
    assert len(reduced) == len(whole) > 4
    for mine, theirs in zip(reduced, whole, strict=True):
        assert mine.keys() == theirs.keys()
        for name in mine:
            assert mine[name] == pytest.approx(theirs[name], abs=1e-7)
    assert max(abs(row[name]) for row in whole for name in row if name != "t") > 0.5
    said = pkgen("explain", path, "--scene", scene).stdout
    (line,) = (x for x in said.splitlines() if x.endswith("nothing recorded depends on it"))
    assert gone in line


def test_a_motion_of_an_attitude_is_the_whole(pkgen, tmp_path):
    path = written(tmp_path, THROWN)
    mine = rows(pkgen, path, "--scene", "attitude")
    theirs = rows(pkgen, path, "--scene", "attitude", "--no-reduce")
    for a, b in zip(mine, theirs, strict=True):
        assert a == pytest.approx(b, abs=1e-7)
    assert mine[-1]["p_R.y"] == pytest.approx(
        2 * rows(pkgen, path, "--scene", "rates")[-1]["omega(R).y"], abs=1e-8
    )


def test_an_event_is_met_by_a_step_on_the_group(pkgen, tmp_path):
    (row,) = rows(pkgen, written(tmp_path, THROWN), "--scene", "landing")
    assert row["t"] == pytest.approx(2 + math.sqrt(3), abs=1e-9)
    assert sum(row[f"R.{c}"] ** 2 for c in "wxyz") == pytest.approx(1, abs=1e-15)


def test_a_momentum_of_the_body_is_constant_where_that_is_proved(pkgen, tmp_path):
    """A root in L hides what is under it from residues: no proof that it does not turn."""
    path = written(
        tmp_path,
        "model hung\nrotation R\nkinetic dot(omega(R), omega(R))/2\n"
        "potential sqrt(2 + (R*[0, 0, 1]).z)\nstart omega(R) = [1, 0.2, 0.3]\n",
    )
    said = pkgen("explain", path).stdout
    assert "p_R.z" in said and "p_R.x" not in said.partition("Constants")[2].partition("Kern")[0]
