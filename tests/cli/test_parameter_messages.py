"""A parameter that cannot be: its name, value and bounds, or what of it is not finite."""

from __future__ import annotations

from pathlib import Path

import pytest

MODEL = """model spring
param m = 2 [kg]
param k = 3 [N/m] in (0, 50]

param s = 1 in [-1, 1]
coord x [m]
kinetic m/2*x'^2
potential k/2*x^2 + s*(0 [J])
start x = 1
"""
CASES = {
    "k=-2": "parameter k is outside its bounds: -2 [N/m] is not in (0, 50]",
    "k=0": "parameter k is outside its bounds: 0 [N/m] is not in (0, 50]",
    "s=1.5": "parameter s is outside its bounds: 1.5 is not in [-1, 1]",
}


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("spring") / "spring.lag"
    path.write_text(MODEL)
    return path


@pytest.mark.parametrize("given", CASES)
def test_bounds_and_value(pkgen, model: Path, given: str) -> None:
    done = pkgen("run", model, "--set", given, "--until", "1")
    assert (done.returncode, done.stderr.strip()) == (2, f"run: {CASES[given]}")


def test_what_is_not_finite(pkgen, model: Path) -> None:
    done = pkgen("run", model, "--set", "m=0", "--until", "1")
    assert done.returncode == 2
    assert done.stderr.strip() == "run: 1/m is not finite at m = 0 [kg]"


def test_of_a_member(pkgen, model: Path, tmp_path: Path) -> None:
    members = tmp_path / "members.csv"
    members.write_text("x,k\n1,3\n1,60\n")
    done = pkgen("run", model, "--ensemble", members, "--until", "1", "-o", tmp_path / "o.csv")
    assert done.returncode == 2
    assert "members.csv:3: k is outside its bounds: 60 [N/m] is not in (0, 50]" in done.stderr
