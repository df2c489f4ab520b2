"""`expect` in scenes: where it is measured, what is said of a miss, what cannot be expected."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from conftest import case, ran, written

# x = cos t, exactly; the method is not, by some 1e-9.
SWING = case("expects_swing")


@pytest.fixture
def swing(tmp_path: Path) -> Path:
    path = written(tmp_path, SWING)
    return path


def test_what_is_met_is_counted_and_no_column(swing: Path) -> None:
    done = ran("run", swing, "--scene", "met")
    assert "expected: 12 of 12 met" in done.stderr
    assert "amplitude kept to " in done.stderr  # proved, but its drift is asked for
    assert done.stdout.splitlines()[0] == "t,x" and len(done.stdout.splitlines()) == 22
    # A time between rows is landed on, and the rows stay where they were.
    assert [row.split(",")[0] for row in done.stdout.splitlines()[5:8]] == ["2", "2.5", "3"]


def test_verdicts_in_json_and_beside_a_file(pkgen, swing: Path, tmp_path: Path) -> None:
    out = tmp_path / "rows.csv"
    done = pkgen("run", swing, "--scene", "missed", "--json", "-o", out)
    assert done.returncode == 4 and done.stderr == ""
    assert json.loads(done.stdout) == json.loads(Path(f"{out}.json").read_text())
    verdicts = json.loads(done.stdout)["expects"]
    assert [v["met"] for v in verdicts] == [False] * 7
    second = verdicts[1]
    assert second["text"] == "expect x = 0.5 within 0.1 at 2.25"
    assert second["value"] == pytest.approx(math.cos(2.25), abs=1e-7)
    assert (second["bound"], second["within"], second["t"]) == (0.5, 0.1, 2.25)
    assert verdicts[4]["value"] is None and "did not happen" in verdicts[4]["said"]


def test_members_of_a_file_are_held_to_the_scene(pkgen, swing: Path, tmp_path: Path) -> None:
    """Rows of what the scene records, the worst member named; at the start too, without its row."""
    (tmp_path / "w.csv").write_text("w,x\n1,1\n2,1.5\n3,0.5\n")
    options = ["--ensemble", tmp_path / "w.csv", "--json"]
    done = pkgen("run", swing, "--scene", "ensemble", *options)
    result = json.loads(done.stdout)
    assert [c["name"] for c in result["columns"]] == ["member", "t", "twice"]
    assert [row[:2] for row in result["rows"]] == [[1, 1], [2, 1], [3, 1]]
    wave, start, drift = result["expects"]
    assert wave["met"] and drift["met"] and not start["met"]
    assert (start["member"], start["value"], start["bound"]) == (2, 1.5, 1.4)


def test_c_of_a_scene_has_no_outputs_for_what_it_expects(pkgen, swing: Path, tmp_path: Path):
    assert pkgen(swing, "--scene", "met", "-o", tmp_path).returncode == 0
    header = (tmp_path / "swing_met.h").read_text()
    assert "swing_met_q_x = 0" in header and "swing_met_o_" not in header


def test_an_angle_that_is_expected_is_a_state_as_one_that_is_recorded(pkgen, tmp_path: Path):
    model = written(
        tmp_path,
        "model orbit\ncoord r, phi\nkinetic (r'^2 + r^2*phi'^2)/2\npotential -1/r\n"
        "start r = 1, phi' = 1\nevent tick: sin(3*t) + 0*r rising\nscene s\nuntil 7\n"
        "method gauss rtol 1e-13\nrecord r every 0.5\n"
        "expect phi = t within 1e-11\nexpect t = phi within 1e-11 at 0.77\n"
        "expect phi > 2 at tick\nexpect phi' = 1 within 1e-11\nend\n",
    )
    done = pkgen("run", model, "--scene", "s", "--json")
    verdicts = json.loads(done.stdout)
    assert [v["met"] for v in verdicts["expects"]] == [True] * 4, done.stderr
    (a, b), (c, d), *_ = ((x["a"], x["b"]) for x in verdicts["settings"]["watched"]["compared"])
    assert [x["kind"] for x in (a, b, c, d)] == ["v", "observed", "observed", "v"]
    done = pkgen("run", model, "--scene", "s", "--start", "phi=1")
    assert done.returncode == 4
    assert "of 4 met" in done.stderr and "is off" in done.stderr


DRAGGED = case("dragged")


@pytest.mark.parametrize("scene", ["loose", "many"])
def test_an_energy_that_a_parameter_left_to_the_run_makes_constant_is_watched(
    tmp_path: Path, scene: str
) -> None:
    (tmp_path / "dragged.lag").write_text(DRAGGED)
    found = []
    for option in ([], ["--no-reduce"]):
        words = ["--scene", scene, "--json", "-o", tmp_path / "rows.csv", *option]
        done = ran("run", tmp_path / "dragged.lag", *words)
        found.append(json.loads(done.stdout)["expects"][0]["value"])
    # By h^6/72 of it a step, and the scale of an energy is that of its parts, here 3 times it.
    assert found[0] == pytest.approx(100 * 0.1**6 / 72 / 3, rel=0.05)
    assert found[1] == pytest.approx(found[0], rel=1e-6)
