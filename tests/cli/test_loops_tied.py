"""Constraints and rotations of families kept as loops, as runs: beside members written out, by
explicit and implicit methods, with events on members, in rings, in ensembles."""

from __future__ import annotations

import pytest
from test_loops_features import both, rows  # noqa: F401 (a fixture)

LINEAR = """\
model linear
size N = 6
coord x[1..N], y[1..N], X
fixed x[0] = sin(t)
kinetic sum((1 + i/N)*x[i]'^2/2 + y[i]'^2{inertia}, i = 1..N) + X'^2
potential sum((x[i] - x[i-1])^4 + cos(y[i]), i = 1..N)
constraint tie[i = 1..N]: y[i] = x[i]/2 + 0.1*X{row}
constraint mean: sum(y[i]*i, i = 1..N) = sum(x[i]*i, i = 1..N)/2
start x[i = 1..N] = 0.3*i, y[i = 1..N] = 0.15*i
observe pull = lambda_tie[2]
"""


@pytest.mark.parametrize("inertia", ["", " + x[i]'*X'/20"], ids=["diagonal", "banded"])
@pytest.mark.parametrize("method", ["verlet", "yoshida4"])
def test_splitting_methods_run_on_linear_constraints(method: str, inertia: str, both) -> None:  # noqa: F811
    text = LINEAR.format(inertia=inertia, row=" + t^2/5 - t^2/5")
    words = ("--until", 0.5, "--every", 0.25, "--method", method, "--step", 0.05)
    (loops, _), (written, _) = both(text, *words)
    for one, other in zip(loops, written, strict=True):
        assert one == pytest.approx(other, rel=1e-12, abs=1e-12)
    assert len(loops) == 3 and loops[0][1:] != loops[2][1:]
