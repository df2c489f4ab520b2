"""Families of rotations beside the same rotations declared one by one, with ends put in by hand."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from rotation_models import made

from conftest import ran, seeds, table


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
