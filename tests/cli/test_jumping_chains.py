"""Chains whose forces jump, as loops and with all members written out: same switchings, rows and
end."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from conftest import ROOT

sys.path.insert(0, str(ROOT / "tests" / "fuzz"))
import families

CHAIN = """model chain
size N = 20
param mu = 0.05
coord q[1..N]
fixed q[0] = 0
{end}
kinetic sum(q[i]'^2/2, i = 1..N)
potential sum((q[i+1] - q[i])^2/2 + q[i]^2/9, i = 0..N)
force q[i = 1..N] = {force}
start q[i = 1..N] = sin(2*i), q[i = 1..N]' = cos(3*i)
"""
PUSHED = {"end": "fixed q[N+1] = 0.3*sin(2*t)", "force": "-mu*step(q[i] - 0.3)"}
DRY = {"end": "free q[N+1]", "force": "-mu*sign(q[i]' - q[i+1]') - mu*sign(q[i]')"}
CASES = [
    (PUSHED, "verlet", "--step", "0.02"),  # in no fused steps
    (PUSHED, "gauss2", "--step", "0.05"),
    (DRY, "dop853", "--rtol", "1e-11"),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case[1])
def test_as_written_out(case: tuple, tmp_path: Path) -> None:
    words, method, *how = case
    model = tmp_path / "chain.lag"
    model.write_text(CHAIN.format(**words))
    run = ("run", str(model), "--until", "4", "--every", "0.5", "--method", method, *how)
    assert families.compared(tmp_path, run, 1e-11) == ""
    [loops, written] = families.both(tmp_path, *run)
    assert sum(x["count"] for x in loops[2]["switches"]) > 30
    assert len(loops[2]["switches"]) < len(written[2]["switches"])
    if words is DRY:
        assert (loops[0], loops[2]["status"]) == (4, "PK_SLIDING")
        assert "stays on q[11]' = 0" in loops[3] and "stays on q[11]' = 0" in written[3]
