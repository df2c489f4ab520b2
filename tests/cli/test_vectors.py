"""Vectors as outputs, columns and expectations, and rot() against the motion it describes."""

from __future__ import annotations

import csv
import json
import subprocess
from pathlib import Path

import pytest

from conftest import STRICT, case, ran, written

# A free particle, in coordinates of a frame that is tilted and then turns: it moves straight on in
# space. No two of its angles commute.
TURNING = case("turning")


@pytest.fixture
def turning(tmp_path: Path) -> Path:
    path = written(tmp_path, TURNING)
    return path


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(text.splitlines()))


def test_swarms_and_starts_turn_vectors_as_the_equations_do(pkgen, tmp_path: Path) -> None:
    """The same rotation by three: of a start, of a swarm's start, in C."""
    path = written(tmp_path, case("vectors_three"))
    one = ran("run", path, "--scene", "one", "--json")
    assert json.loads(one.stdout)["report"]["t"] == pytest.approx(1, abs=1e-15)
    many = rows(pkgen("run", path, "--scene", "many").stdout)
    single = rows(pkgen("run", path, "--until", "1", "--record", "again.y,x").stdout)
    assert float(many[0]["x"]) == pytest.approx(float(single[0]["x"]), abs=1e-15)
    assert abs(float(many[0]["x"]) - float(many[-1]["x"])) > 1e-2
    assert list(single[0]) == ["t", "again.y", "x"]
    for scene in ([], ["--scene", "one"]):  # a vector's name is its components
        done = pkgen("run", path, "--until", "1", "--record", "x,again", *scene)
        assert list(rows(done.stdout)[0]) == ["t", "x", "again.x", "again.y", "again.z"]


def test_components_have_names_of_their_own_in_c(pkgen, turning: Path, tmp_path: Path) -> None:
    """`place.x` and `place_x` are two outputs; families of vectors lie component by component."""
    turning.write_text(turning.read_text() + "observe pair[i = 1..2] = i*s\n")
    assert pkgen(turning, "-o", tmp_path).returncode == 0
    header = (tmp_path / "turning.h").read_text()
    for name, index in (("place_x_", 0), ("place_y", 1), ("place_x", 3), ("pair_z", 8)):
        assert f" turning_o_{name} = {index}" in header
    done = subprocess.run(
        ["gcc", *STRICT, "-c", "turning.c", "-o", "turning.o"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
