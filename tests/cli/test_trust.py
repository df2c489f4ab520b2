"""Runs that end well by their steps, and not by the energy that the motion keeps."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from conftest import case, written
from pkgen.__main__ import main

FALL = case("trust_fall")
SWING = case("trust_swing")
END = 1.3363  # of the motion: it spirals into the centre


@pytest.fixture
def run(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    def call(model: str, options: str) -> tuple[int, dict, str]:
        path = written(tmp_path, model)
        code = main(["run", str(path), *options.split(), "--json"])
        shown = capsys.readouterr()
        return code, json.loads(shown.out)["report"], shown.err

    return call


def test_the_report_of_steps_behind_the_end_is_of_a_failure(run) -> None:
    code, report, said = run(FALL, "--method euler --step 0.05 --until 20")
    assert code == 4 and report["status"] == "RUN_BEYOND_END" and report["code"] < 0
    assert report["text"] == "the motion ends before these steps do"
    assert report["t"] == 20 and report["last_valid"] < END
    assert report["reason"].startswith("arrived at t = 20, but the motion ends at t = 1.3363")
    assert "rows after that are of the steps alone: make the step shorter (--step)" in said
    assert f"last valid time {report['last_valid']}" in said


def test_a_large_drift_is_not_called_bounded(run) -> None:
    """Verlet's energy of an oscillator comes back, and is off by (h omega)^2/8 of it in between."""
    words = [
        run(SWING, f"--method verlet --step {h} --until 900")[1]["drifts"][0]["growth"]
        for h in (1.5, 0.1)
    ]
    assert words == ["off by more than a tenth", "bounded"]
