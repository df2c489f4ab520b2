"""Families of rotations beside the same rotations declared one by one, with ends put in by hand."""

from __future__ import annotations

import csv
import io
import random
from pathlib import Path

import pytest
from conftest import long_but
from rotation_models import made


def numbers(pkgen, model: Path, *options: object) -> list[list[float]]:
    done = pkgen("run", model, *options)
    assert done.returncode == 0, done.stderr
    return [[float(x) for x in row] for row in list(csv.reader(io.StringIO(done.stdout)))[1:]]


def off(one: list[list[float]], other: list[list[float]]) -> float:
    """The largest difference beside the largest number."""
    assert len(one) == len(other) > 1
    pairs = [(a, b) for x, y in zip(one, other, strict=True) for a, b in zip(x, y, strict=True)]
    return max(abs(a - b) for a, b in pairs) / max(abs(a) for a, _ in pairs)


@pytest.mark.parametrize("seed", long_but([1, 5], range(40)))
def test_members_are_rotations_one_by_one(seed: int, pkgen, tmp_path: Path) -> None:
    m = made(random.Random(seed), 1 + seed % 4)
    model, singles = tmp_path / "spins.lag", tmp_path / "singles.lag"
    model.write_text(m.text)
    singles.write_text(m.singles)
    how = "--until", 1.3, "--every", 0.65, "--method", "dop853", "--rtol", "1e-12"
    how += "--record", ",".join(m.outputs)
    found = numbers(pkgen, model, *how)
    assert found[0][1] != found[-1][1]
    assert off(numbers(pkgen, singles, *how), found) < 1e-12


RING = """\
model ring
size N = 3
rotation R[1..N]
periodic R
kinetic sum(dot(omega(R[i]), omega(R[i])), i = 1..N)
potential -sum(dot(R[i]*[0, 0, 1], R[i+1]*[0, 0, 1]), i = 1..N)
start R[2] = rot([1, 0, 0], 0.5)
start omega(R[i = 1..N-1]) = [0, 0.1*i, 1]
event tilted: R[2].x - 0.2 falling
observe L3 = sum((R[i]*p_R[i]).z, i = 1..N)

scene one
  start omega(R[3]) = [0, 0, 2]
  until 1
  record R[2], omega(R[2]), p_R[3], L3 every 0.5
  expect drift(L3) < 1e-12
end
"""


def test_members_by_name(pkgen, tmp_path: Path) -> None:
    model = tmp_path / "ring.lag"
    model.write_text(RING)
    done = pkgen("run", model, "--scene", "one")
    assert done.returncode == 0, done.stderr
    names = "t,R[2].w,R[2].x,R[2].y,R[2].z,omega(R[2]).x,omega(R[2]).y,omega(R[2]).z"
    names += ",p_R[3].x,p_R[3].y,p_R[3].z,L3.x,L3.y,L3.z"
    assert done.stdout.startswith(names.replace("L3.x,L3.y,L3.z", "L3"))
    first = [float(x) for x in done.stdout.split()[1].split(",")]
    assert first[2] == pytest.approx(0.2474039592545229) and first[5:8] == [0, 0.2, 1]
    assert first[8:11] == [0, 0, 4]
    given = "--start", "R[3].w=0.8", "--start", "R[3].y=0.6", "--start", "omega(R[1]).z=-3"
    done = pkgen("run", model, "--until", 1, *given, "--record", "R[3],omega(R[1])")
    assert done.returncode == 0, done.stderr
    assert done.stdout.split()[1] == "0,0.8,0,0.6,0,0,0.1,-3"
    assert "tilted" in done.stderr


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("let w = omega(R)", "'R' is a family: it needs an index"),
        ("let up = R[4]*[0, 0, 1]", "R[4] is outside the family: there is R[1..3]"),
        ("force R = [0, 0, 1]", "'R' is a family: it needs an index"),
        ("start omega(R[4]) = [0, 0, 1]", "R[4] is outside the family"),
        ("fixed R[0] = 3", "3 is no rotation"),
        ("fixed R[0] = R[1]", "'R' is a rotation: a fixed end cannot use it"),
        ("fixed R[2] = rot([0, 0, 1], 1)", "R[2] is a rotation; an end lies outside 1..3"),
    ],
)
def test_what_is_wrong_with_an_index(line: str, says: str, pkgen, tmp_path: Path) -> None:
    model = tmp_path / "ring.lag"
    model.write_text(RING.replace("periodic R\n", "").replace("R[i+1]", "R[1]") + line + "\n")
    done = pkgen("check", model)
    assert done.returncode == 1 and says in done.stderr, done.stderr
