"""Variational steps of families kept as loops, solved by M and rows of constraints in their bands.
Beside the same steps of members written out, whose matrices are whole."""

from __future__ import annotations

from pathlib import Path

import pytest
from test_loops_features import both  # noqa: F401 (a fixture)

from conftest import case, rows

ROPE = case("rope")


def test_a_long_rope_keeps_its_energy_and_rods_by_rattle_alone(pkgen, tmp_path: Path) -> None:
    """Order 2, and no drift: of rk2 at the same step the energy leaves."""
    model = tmp_path / "rope.lag"
    model.write_text(ROPE)

    def drift(method: str, step: float) -> float:
        how = ("--method", method, "--step", step, "--until", 2, "--every", 0.1)
        found = rows(pkgen, model, *how, "--record", "energy")
        return max(abs(row["energy"] - found[0]["energy"]) for row in found)

    coarse, fine = drift("rattle", 2e-3), drift("rattle", 1e-3)
    assert 3 < coarse / fine < 5
    assert 0 < coarse < drift("rk2", 2e-3) / 100


GROWING = """\
model growing
size N = {size}
coord q[1..N]
fixed q[0] = 0.3
state u[1..N]
kinetic sum((1 + u[i]^2/4)*q[i]'^2, i = 1..N)
potential sum((q[i] - q[i-1])^2/2, i = 1..N)
rate u[i = 1..N] = -u[i]^3 + sin(q[i])
start q[i = 1..N] = 0.6*sin(i), q[i = 1..N]' = cos(i)/2, u[i = 1..N] = cos(i)
"""


@pytest.mark.parametrize("method", ["rattle", "lie_midpoint"])
def test_momenta_that_depend_on_states_are_stepped_as_they_are(method: str, both) -> None:  # noqa: F811
    """Both ways by (p, p'), not by (v, a), and of order 2."""
    words = ("--until", 1, "--every", 1, "--record", "q[1],q[3]'")
    found = {}
    for step in (0.04, 0.02):
        (loops, _), (written, _) = both(
            GROWING.format(size=3), *words, "--method", method, "--step", step
        )
        assert loops[-1] == pytest.approx(written[-1], rel=1e-12)
        found[step] = loops[-1][1:]
    (exact, _), _ = both(GROWING.format(size=3), *words, "--method", "dop853", "--rtol", 1e-12)
    off = [max(abs(a - b) for a, b in zip(x, exact[-1][1:], strict=True)) for x in found.values()]
    assert 3.5 < off[0] / off[1] < 4.5
