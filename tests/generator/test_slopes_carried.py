"""Matrices of derivatives of chains of `let`s kept as loops: bands in which carried values, their
rates and what hangs on them are unknowns, against the dense ones of members written out."""

import random

import numpy as np
import pytest
from carried_models import links, tied_links
from loop_harness import Looped, Written
from test_loops_slopes import at_random, closed, matrices, order

from conftest import seeds


@pytest.mark.parametrize("seed", seeds(range(3), 13))
def test_bands_of_chains_are_the_dense_matrices(seed: int, tmp_path) -> None:
    dice = random.Random(seed)
    text = tied_links(dice, False) if seed % 4 == 3 else links(dice, seed % 4 == 2)
    loops = Looped(text, tmp_path / "loops")
    if "j = i+1..N" in text:
        assert not hasattr(loops.library, f"{loops.name}_slopes_pattern")
        return
    largest = 0.0
    for size in (5, 2)[: 1 + (seed > 0)]:
        unrolled, at = Written(text, size, tmp_path / f"n{size}"), loops.at(size)
        state, (M, p_q, pdot_q, pdot_v) = at_random(unrolled, at, order(unrolled, at, size), dice)
        nothing = [np.zeros((1, 1))] * 3
        alone = closed(matrices(at, "slopes_mass", state, 1), nothing, 0, 0)
        assert np.abs(alone - M).max() <= 1e-12 * np.abs(M).max(), text
        found = matrices(at, "slopes_closed", state, 1)
        _, more = matrices(at, "slopes_jacobian", state, 3)
        for h, k in ((0.3, 0.2), (0.05, 0.7)):
            expected = M + h * p_q - k * pdot_v - h * k * pdot_q
            off = np.abs(closed(found, more, h, k) - expected).max()
            assert off <= 1e-11 * np.abs(expected).max(), f"{text}N = {size}: {off}"
        largest = max(largest, np.abs(pdot_q).max(), np.abs(p_q).max())
    assert largest > 0
