"""Every scene of every model runs, and what it expects is met; and would be missed by worse.

`make test` runs all scenes of the models in models/ itself, and the first ones of IN_TEST in its
folders: a second a scene goes to the C compiler. `make test-long` and `python -m bench systems` run
all of them.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import tomllib

from conftest import ROOT, ran

MODELS = sorted((ROOT / "models").rglob("*.lag"))
IN_TEST = {"thrown_stone", "kepler", "henon_heiles", "n_body", "pendulum", "foucault"}
IN_TEST |= {"beats", "fput", "sine_gordon", "free_body", "pendulum_rod", "rattleback"}
WORSE = tomllib.loads(Path(__file__).with_name("worse.toml").read_text(encoding="utf-8"))


def scenes() -> list:
    found = []
    for path in MODELS:
        named = re.findall(r"^scene (\w+)(.*?)^end$", path.read_text(), re.M | re.S)
        for k, (name, body) in enumerate(named):
            long = path.parent != ROOT / "models" and (k > 0 or path.stem not in IN_TEST)
            numbers = [
                3 if "= [" in line else 1 for line in re.findall(r"^  expect .*", body, re.M)
            ]
            found.append(
                pytest.param(
                    *(path, name, sum(numbers)),  # of a vector three
                    id=f"{path.stem}-{name}",
                    marks=[pytest.mark.long] * long,
                )
            )
    return found


SCENES = scenes()


def test_each_model_has_two_scenes_that_expect_something() -> None:
    for path in MODELS:
        assert sum(s.values[0] == path and s.values[2] > 0 for s in SCENES) >= 2, path.name
    names = {f"{s.values[0].stem} {s.values[1]}" for s in SCENES}
    assert set(WORSE) <= names and {path.stem for path in MODELS} >= IN_TEST


@pytest.mark.parametrize(("path", "name", "expected"), SCENES)
def test_a_scene_is_as_expected(tmp_path: Path, path: Path, name: str, expected: int):
    command = ["run", path, "--scene", name, "-o", tmp_path / "rows.csv"]
    done = ran(*command)
    assert (f"expected: {expected} of {expected} met" in done.stderr) == (expected > 0)


@pytest.mark.parametrize(("path", "name", "expected"), SCENES)
def test_a_worse_run_misses(pkgen, tmp_path: Path, path: Path, name: str, expected: int):
    if expected:
        command = ["run", path, "--scene", name, "-o", tmp_path / "rows.csv"]
        worse = pkgen(*command, *WORSE.get(f"{path.stem} {name}", "--rtol 1e-4").split())
        assert worse.returncode == 4 and "error: expectation missed: " in worse.stderr, name
