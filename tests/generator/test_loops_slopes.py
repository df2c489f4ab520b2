"""Bands of derivatives of families kept as loops: against the dense ones of the unrolled code."""

from __future__ import annotations

import ctypes
import random

import pytest
from conftest import long_but
from loop_harness import Looped, Unrolled
from loop_models import MODELS, STATES

DENSE = ("gravity", "spin", "field")  # a sum over all members: no bands
SHORT = ("cart",)
CASES = {**MODELS, **STATES}


def dense(at, kernel: str, state, count: int) -> list[list[float]]:
    """Matrices by coordinates, row after row, of the pattern of struct pk_pattern."""
    sizes = [ctypes.c_size_t() for _ in range(3)]
    params = ctypes.byref(at.params)
    at.of.function("slopes_pattern")(params, *map(ctypes.byref, sizes))
    rows, width, border = (x.value for x in sizes)
    across, size = 2 * width + 1, rows * (2 * width + 1) + (2 * rows + border) * border
    place_of = at.of.function("slopes_place", ctypes.c_ssize_t)
    place = [place_of(params, ctypes.c_size_t(i)) for i in range(rows + border)]
    assert sorted(p for p in place if p >= 0) == list(range(at.n))
    _, found = at.call(kernel, *state, (size,) * count)
    result = []
    for matrix in found:
        entries = {(i, i + k - width): i * across + k for i in range(rows) for k in range(across)}
        start = rows * across
        for i in range(rows):
            for c in range(border):
                entries[i, rows + c] = start + i * border + c
                entries[rows + c, i] = start + (rows + i) * border + c
        start += 2 * rows * border
        for c in range(border):
            entries |= {(rows + c, rows + d): start + c * border + d for d in range(border)}
        whole = [0.0] * at.n**2
        for (i, j), x in entries.items():
            inside = 0 <= j < rows + border
            if inside and place[i] >= 0 and place[j] >= 0:
                whole[place[i] * at.n + place[j]] = matrix[x]
            else:  # a place that is empty, or beyond the ends
                assert matrix[x] == (kernel == "slopes_mass" and i == j and inside)
        result.append(whole)
    return result


@pytest.mark.parametrize("name", long_but(SHORT, [name for name in CASES if name not in DENSE]))
def test_bands_of_derivatives_are_those_of_the_unrolled_code(name: str, tmp_path) -> None:
    text, sizes = CASES[name]
    loops = Looped(text, tmp_path / "loops")
    largest = [0.0] * 4
    for size in (n for n in sizes if n <= 15):
        unrolled = Unrolled(text, size, tmp_path / f"n{size}")
        at = loops.at(size)
        dice = random.Random(size)
        inputs = len(unrolled.program.equations.inputs)
        for _ in range(3):
            state = (
                dice.uniform(0, 3),
                *([dice.uniform(-1, 1) for _ in range(n)] for n in (at.n, at.n, inputs)),
            )
            found = [*dense(at, "slopes_mass", state, 1), *dense(at, "slopes_jacobian", state, 3)]
            expected = [*unrolled.call("mass", *state)[1], *unrolled.call("jacobian", *state)[1]]
            for k, (one, other) in enumerate(zip(found, expected, strict=True)):
                largest[k] = max(largest[k], *map(abs, other))
                assert one == pytest.approx(other, rel=2e-13, abs=2e-13), f"{name} N = {size}, {k}"
    assert largest[0] > 0 and largest[2] + largest[3] > 0


@pytest.mark.parametrize("name", DENSE)
def test_sums_over_all_members_have_no_bands(name: str, tmp_path) -> None:
    loops = Looped(MODELS[name][0], tmp_path)
    assert not hasattr(loops.library, f"{name}_slopes_pattern")
    assert hasattr(loops.library, f"{name}_force")
