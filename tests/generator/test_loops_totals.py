"""Sums inside expressions and rates of states: every kernel against the unrolled code."""

from __future__ import annotations

import random

import pytest
from loop_harness import Looped, Unrolled
from test_loops import assert_kernels, assert_start
from total_models import RATES, TOTALS

CASES = TOTALS | RATES


@pytest.mark.parametrize("name", CASES)
def test_totals_equal_the_unrolled_code(name, tmp_path):
    text, sizes = CASES[name]
    loops = Looped(text, tmp_path / "loops")
    for size in sizes:
        written, at, dice = Unrolled(text, size, tmp_path / f"n{size}"), loops.at(size), None
        dice = random.Random(size)
        assert at.n == len(written.program.equations.coordinates)
        assert_start(written, at)
        for _ in range(4):
            q, v = ([dice.uniform(-1, 1) for _ in range(at.n)] for _ in range(2))
            u = [dice.uniform(-1, 1) for _ in written.program.equations.inputs]
            assert_kernels(written, at, (dice.uniform(0, 3), q, v, u), f"{name} N = {size}")
