"""Every scene of every model runs, and what it expects is met; and would be missed by worse."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from conftest import ROOT

MODELS = sorted((ROOT / "models").rglob("*.lag"))
SCENES = [
    pytest.param(path, name, body.count("\n  expect "), id=f"{path.stem}-{name}")
    for path in MODELS
    for name, body in re.findall(r"^scene (\w+)(.*?)^end$", path.read_text(), re.M | re.S)
]
# What makes each scene's expectations fail: a worse tolerance or step, another start. By default
# the former; the text of the C stays the same.
WORSE = {
    "balanced": ["--start", "theta=1.17"],
    "pendulums": ["--step", "0.2"],
    "slowest": ["--start", "q[1]=0.7"],
    "precession": ["--start", "theta=1.05"],
    "harmonic": ["--step", "0.5"],
    "long": ["--step", "0.2"],
    "slow": ["--start", "theta1=1.001e-4"],
    "moon": ["--start", "y'=49.99"],
}


def test_each_model_has_two_scenes_that_expect_something() -> None:
    for path in MODELS:
        assert sum(s.values[0] == path and s.values[2] > 0 for s in SCENES) >= 2, path.name


@pytest.mark.parametrize(("path", "name", "expected"), SCENES)
def test_a_scene_is_as_expected(pkgen, tmp_path: Path, path: Path, name: str, expected: int):
    command = ["run", path, "--scene", name, "-o", tmp_path / "rows.csv"]
    done = pkgen(*command)
    assert done.returncode == 0, done.stderr
    assert (f"expected: {expected} of {expected} met" in done.stderr) == (expected > 0)
    if expected:
        worse = pkgen(*command, *WORSE.get(name, ["--rtol", "1e-5"]))
        assert worse.returncode == 4 and "error: expectation missed: " in worse.stderr, name
