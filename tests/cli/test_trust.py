"""Runs that end well by their steps, and not by the energy that the motion keeps."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from conftest import case
from pkgen.__main__ import main

FALL = case("trust_fall")
STOP = FALL + "event out: x^2 + y^2 - 100 rising stop\n"
CLOSE = case("close")
SWING = case("trust_swing")
HUMP = case("hump")
END = 1.3363  # of the motion: it spirals into the centre


@pytest.fixture
def run(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    def call(model: str, options: str) -> tuple[int, dict, str]:
        path = tmp_path / "model.lag"
        path.write_text(model)
        code = main(["run", str(path), *options.split(), "--json"])
        shown = capsys.readouterr()
        return code, json.loads(shown.out)["report"], shown.err

    return call


def test_an_event_that_stops_is_no_proof_of_the_way_there(run) -> None:
    code, report, said = run(STOP, "--method euler --step 0.01 --until 50")
    assert code == 4 and report["t"] > END
    assert said.count("stopped at event out") == 1 and f"ends at t = {END}" in said


def test_the_report_of_steps_behind_the_end_is_of_a_failure(run) -> None:
    code, report, said = run(FALL, "--method euler --step 0.05 --until 20")
    assert code == 4 and report["status"] == "RUN_BEYOND_END" and report["code"] < 0
    assert report["text"] == "the motion ends before these steps do"
    assert report["t"] == 20 and report["last_valid"] < END
    assert report["reason"].startswith("arrived at t = 20, but the motion ends at t = 1.3363")
    assert "rows after that are of the steps alone: make the step shorter (--step)" in said
    assert f"last valid time {report['last_valid']}" in said


def test_a_wrong_energy_at_arrival_is_a_warning(run) -> None:
    code, report, said = run(CLOSE, "--method verlet --step 0.01 --until 5")
    assert code == 0 and report["status"] == "PK_DONE"
    warning = "the energy, which the motion keeps, is off by more than 0.01 of its scale after t ="
    assert report["warning"].startswith(warning)
    assert f"run: warning: {warning} 1." in said
    assert said.rstrip().endswith("make the steps shorter (--step, --rtol)")
    code, report, said = run(CLOSE, "--until 5")
    assert code == 0 and report["warning"] == "" and "warning" not in said


def test_a_large_drift_is_not_called_bounded(run) -> None:
    """Verlet's energy of an oscillator comes back, and is off by (h omega)^2/8 of it in between."""
    words = [
        run(SWING, f"--method verlet --step {h} --until 900")[1]["drifts"][0]["growth"]
        for h in (1.5, 0.1)
    ]
    assert words == ["off by more than a tenth", "bounded"]


def test_steps_that_end_alone_blame_neither_model_nor_equations(run) -> None:
    """The motion turns back on the slope of the hump, where Euler's steps come over it."""
    code, report, said = run(HUMP, "--method euler --step 0.5 --until 9")
    assert code == 4 and report["reason"].startswith("the steps come to x = 0 at t =")
    assert "end here" not in said and "without the division" not in said
    assert "the motion goes on to t = " in said
    assert said.rstrip().endswith("only these steps end: make the step shorter (--step)")


def test_members_with_a_wrong_energy_are_counted(run, tmp_path: Path) -> None:
    members = tmp_path / "members.csv"
    members.write_text("y'\n1\n0.1\n0.01\n")
    options = f"--ensemble {members} --method rk4 --step 0.01 --until 2"
    code, report, said = run(CLOSE, options)
    assert code == 0 and (report["astray"], report["first_astray"]) == (2, 2)
    warning = "run: warning: energy off by more than 0.01 of its scale at the end in 2 of 3 members"
    assert f"{warning}, first member 2: make the step shorter (--step)" in said
    code, report, said = run(CLOSE, options.replace("rk4 --step 0.01", "dop853"))
    assert code == 0 and (report["astray"], report["first_astray"]) == (0, None)
    assert "warning" not in said
