"""Families of rotations beside the same rotations declared one by one, with ends put in by hand."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from rotation_models import made

from conftest import case, ran, seeds, table, written


def numbers(pkgen, model: Path, *options: object) -> list[list[float]]:
    done = ran("run", model, *options)
    return table(done.stdout)[1]


def off(one: list[list[float]], other: list[list[float]]) -> float:
    """The largest difference beside the largest number."""
    assert len(one) == len(other) > 1
    pairs = [(a, b) for x, y in zip(one, other, strict=True) for a, b in zip(x, y, strict=True)]
    return max(abs(a - b) for a, b in pairs) / max(abs(a) for a, _ in pairs)


@pytest.mark.parametrize("seed", seeds([5, 0, 1], 13))
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


RING = case("rotation_families_ring")


def test_members_by_name(tmp_path: Path) -> None:
    model = written(tmp_path, RING)
    done = ran("run", model, "--scene", "one")
    names = "t,R[2].w,R[2].x,R[2].y,R[2].z,omega(R[2]).x,omega(R[2]).y,omega(R[2]).z"
    names += ",p_R[3].x,p_R[3].y,p_R[3].z,L3.x,L3.y,L3.z"
    assert done.stdout.startswith(names.replace("L3.x,L3.y,L3.z", "L3"))
    first = [float(x) for x in done.stdout.split()[1].split(",")]
    assert first[2] == pytest.approx(0.2474039592545229) and first[5:8] == [0, 0.2, 1]
    assert first[8:11] == [0, 0, 4]
    given = "--start", "R[3].w=0.8", "--start", "R[3].y=0.6", "--start", "omega(R[1]).z=-3"
    done = ran("run", model, "--until", 1, *given, "--record", "R[3],omega(R[1])")
    assert done.stdout.split()[1] == "0,0.8,0,0.6,0,0,0.1,-3"
    assert "tilted" in done.stderr
