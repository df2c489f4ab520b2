"""Families of rotations beside the same rotations declared one by one, with ends put in by hand."""

from __future__ import annotations

import csv
import io
import random
from pathlib import Path

import pytest
from rotation_models import made

from conftest import case, ran, seeds


def numbers(pkgen, model: Path, *options: object) -> list[list[float]]:
    done = ran("run", model, *options)
    return [[float(x) for x in row] for row in list(csv.reader(io.StringIO(done.stdout)))[1:]]


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


WAVE = Path(__file__).parent / "spin_wave.lag"


@pytest.mark.parametrize(
    "method",
    ["gauss rtol 1e-12", "dop853 rtol 1e-12", "rkmk8 step 0.05"],
)
def test_a_spin_wave_of_any_size(method: str, pkgen, tmp_path: Path) -> None:
    """The axes of a ring of tops turn about the vertical at one angle a, each k ahead of the one
    before: of (I w n x n' + S n)' = n x J (the two beside it) there is left
    I w^2 cos a - S w - 2 J (1 - cos k) cos a = 0, for every a."""
    model = tmp_path / "wave.lag"
    model.write_text(WAVE.read_text().replace("gauss rtol 1e-12", method))
    done = pkgen("run", model, "--scene", "wave")
    assert done.returncode == 0 and "3 of 3 met" in done.stderr, done.stderr


def test_one_of_a_family_is_a_free_body(pkgen, tmp_path: Path) -> None:
    """As long loops, and alone."""
    body = "kinetic {a}0.5*omega({R}).x^2 + omega({R}).y^2 + 2*omega({R}).z^2{b}\n"
    start = "start omega({R}) = [1, 0.1, 0.2], {R} = rot([1, 2, 3], 0.5)\n"
    of = "observe w = omega({R}).y\nobserve x = ({R}*[1, 0, 0]).z\n"
    many = "model m\nsize N = 40\nrotation R[1..N]\n"
    many += body.format(R="R[i]", a="sum(", b=", i = 1..N)") + (start + of).format(R="R[23]")
    alone = "model m\nrotation R\n" + (body + start + of).format(R="R", a="", b="")
    found = []
    for text in (many, alone):
        model = tmp_path / "m.lag"
        model.write_text(text)
        how = "--until", 9, "--every", 3, "--method", "dop853", "--rtol", 1e-13, "--record", "w,x"
        found.append(numbers(pkgen, model, *how))
    assert off(*found) < 1e-11


RING = case("rotation_families_ring")


def test_members_by_name(tmp_path: Path) -> None:
    model = tmp_path / "ring.lag"
    model.write_text(RING)
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
