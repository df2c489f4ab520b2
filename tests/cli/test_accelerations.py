"""Accelerations beside finite differences of the rates; closed forms are accelerations*.lag of
tests/runs."""

from __future__ import annotations

import numpy as np
import pytest

from conftest import case, ran, table, written

# Inputs, drag, time, a state in a momentum; constraints; a switch; turns.
MODELS = {"slopes_driven": 4, "slopes_bound": 3, "slopes_kinked": 2, "slopes_body": 4}


@pytest.mark.parametrize("name", MODELS)
def test_accelerations_are_the_slopes_of_rates(tmp_path, name):
    done = ran("run", written(tmp_path, case(name)), "--scene", "s")
    v, a = np.split(np.array(table(done.stdout)[1])[:, 1:], 2, axis=1)
    assert a.shape[1] == MODELS[name]
    known = (v[:-4] - v[4:] + 8 * (v[3:-1] - v[1:-3])) / (12 * 0.005)
    smooth = np.full(len(known), True)
    if name == "slopes_kinked":  # not where accelerations jump
        jumps = (abs(np.diff(a[:, 1])) > 0.05).nonzero()[0]
        smooth = np.array([min(abs(k + 1.5 - jumps)) > 3 for k in range(len(known))])
    off = abs(a[2:-2] - known) / (1 + abs(a).max(axis=0))
    assert off[smooth].max() < 3e-8 and smooth.sum() > 100
    assert abs(a).max(axis=0).min() > 0.01
