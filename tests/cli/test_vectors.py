"""Vectors as outputs, columns and expectations, and rot() against the motion it describes."""

from __future__ import annotations

import csv
import json
import math
import subprocess
from pathlib import Path

import pytest

from conftest import STRICT, case, ran

# A free particle, in coordinates of a frame that is tilted and then turns: it moves straight on in
# space. No two of its angles commute.
TURNING = case("turning")


@pytest.fixture
def turning(tmp_path: Path) -> Path:
    path = tmp_path / "turning.lag"
    path.write_text(TURNING)
    return path


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(text.splitlines()))


def test_a_free_particle_moves_straight_on_in_space(turning: Path) -> None:
    done = ran("run", turning, "--scene", "straight")
    assert "expected: 4 of 4 met" in done.stderr
    last = rows(done.stdout)[-1]
    assert list(last) == [
        *("t", "place.x", "place.y", "place.z", "r.x", "r.y", "r.z", "r.x'", "r.y'", "r.z'", "P.z")
    ]
    # Back from space by the inverse, written out.
    s = [float(last[f"place.{axis}"]) for axis in "xyz"]
    a, b = 0.7 * 2, 0.3
    x, y = math.cos(a) * s[0] + math.sin(a) * s[1], math.cos(a) * s[1] - math.sin(a) * s[0]
    r = [x, math.cos(b) * y + math.sin(b) * s[2], math.cos(b) * s[2] - math.sin(b) * y]
    assert [float(last[f"r.{axis}"]) for axis in "xyz"] == pytest.approx(r, abs=1e-14)
    assert abs(s[1]) > 0.1 < abs(s[2])


def test_swarms_and_starts_turn_vectors_as_the_equations_do(pkgen, tmp_path: Path) -> None:
    """The same rotation by three: of a start, of a swarm's start, in C."""
    path = tmp_path / "three.lag"
    path.write_text(case("vectors_three"))
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


@pytest.mark.parametrize("size", [3, 60])  # unrolled, and kept as loops
def test_sums_of_vectors(tmp_path: Path, size: int) -> None:
    path = tmp_path / "many.lag"
    path.write_text(case("many"))
    how = ("--size", f"N={size}", "--until", "0.5", "--every", "0.5", "--record", "P,Q,Y,L.x,L.z")
    done = ran("run", path, *how)
    first, last = rows(done.stdout)
    sin, cos = math.sin(0.5), math.cos(0.5)
    found = [float(last[k]) for k in ("P.x", "P.y", "P.z", "Q.x", "Q.y", "Q.z", "Y", "L.x", "L.z")]
    exact = [-sin, 18 * cos, 0, 2 * cos, 14 * sin, 0, 7 * sin, -18 * cos, 0]
    assert found == pytest.approx(exact, abs=1e-9)
    assert float(first["P.y"]) == 18
