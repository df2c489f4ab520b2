"""Runs that end well by their steps, and not by the energy that the motion keeps."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from conftest import case, written
from pkgen.__main__ import main

SWING = case("trust_swing")


@pytest.fixture
def run(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    def call(model: str, options: str) -> tuple[int, dict, str]:
        path = written(tmp_path, model)
        code = main(["run", str(path), *options.split(), "--json"])
        shown = capsys.readouterr()
        return code, json.loads(shown.out)["report"], shown.err

    return call


def test_a_large_drift_is_not_called_bounded(run) -> None:
    """Verlet's energy of an oscillator comes back, and is off by (h omega)^2/8 of it in between."""
    words = [
        run(SWING, f"--method verlet --step {h} --until 900")[1]["drifts"][0]["growth"]
        for h in (1.5, 0.1)
    ]
    assert words == ["off by more than a tenth", "bounded"]
