"""Events that give values on a constraint: rates are projected onto it, broken positions end the
run."""

from math import sqrt

import pytest

from conftest import run_pkgen

MODEL = """model pendulum
coord x, y
kinetic (x'^2 + 2*y'^2)/2
potential 9.81*y
constraint rod: x^2 + y^2 = 1
start x = 1
start y = 0
event hit: y + 0.5 falling stop then {}
"""


def test_rates_are_projected_in_the_metric_of_mass(tmp_path):
    model = tmp_path / "pendulum.lag"
    model.write_text(MODEL.format("x' = 5, y' = 1"))
    result = run_pkgen("run", str(model), "--until", "1", "--every", "1", "--rtol", "1e-12")
    *_, vx, vy, _ = map(float, result.stdout.splitlines()[-1].split(","))
    # J = (x, y), M = diag(1, 2): v - M^-1 J^T (J M^-1 J^T)^-1 J v
    x, y = sqrt(0.75), -0.5
    factor = (x * 5 + y * 1) / (x**2 + y**2 / 2)
    assert (vx, vy) == pytest.approx((5 - x * factor, 1 - y / 2 * factor), rel=1e-9)


def test_broken_positions_end_the_run(tmp_path):
    model = tmp_path / "pendulum.lag"
    model.write_text(MODEL.format("x = 0.5"))
    result = run_pkgen("run", str(model), "--until", "1")
    assert result.returncode == 4
    assert "the start, or an event, breaks a constraint: rod by -0.5" in result.stderr
    assert "; last valid time 0." in result.stderr
