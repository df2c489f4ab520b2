"""`--diagnose action` against closed forms."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from conftest import case, diagnosed

PENDULUM = case("diagnose_action_swing")
KEPLER = case("keplerpolar")


def action(folder: Path, text: str, *arguments: object) -> tuple[dict, str]:
    found, said, _ = diagnosed(folder, text, "action", *arguments)
    return found["action"], said


@pytest.mark.parametrize(
    ("width", "height", "lo", "period"),
    [(0.01, 0.6, 0.506923, 2.0970046556), (0.003, 0.3, -1, 6.29347498263)],
)
def test_humps_narrower_than_its_panels(
    tmp_path: Path, width: float, height: float, lo: float, period: float
) -> None:
    """One turns the motion back, one is passed; periods from events, and by quadrature."""
    text = f"""model hump
coord x
lagrangian x'^2/2 - x^2/2 - {height}*exp(-(x - 0.5)^2/{width}^2)
start x = 1
"""
    how = ["--until", "1", "--method", "rk4", "--step", "0.001", "--every", "1"]
    found, _ = action(tmp_path, text, *how)
    assert found["lo"] == pytest.approx(lo, abs=1e-6)
    assert found["period"] == pytest.approx(period, rel=1e-10)


def test_of_a_pendulum(tmp_path: Path) -> None:
    # REGIMES P2 and P1; and its rows by a method that keeps the energy.
    steps = ["--until", "20", "--method", "gauss8", "--step", "0.1"]
    found, said = action(tmp_path, PENDULUM, *steps)
    assert found["orbit"] == "to and fro" and abs(found["lo"] + found["hi"]) < 1e-15
    assert abs(found["action"] - 1.0787052024) < 6e-11
    assert abs(found["frequency"] - 0.8472130848) < 6e-11
    assert abs(found["period"] / (2 * math.pi) - 1.1803405990) < 6e-11
    assert 0 < found["error"] < 1e-14 and found["nodes"] == 64
    assert len(found["rows"]) == 200 and found["rows"][-1][0] == 20 and found["changes"] is None
    assert 0 < found["drift"]["max"] < 1e-13
    assert "action: to and fro between -1.570796327 and 1.570796327: J = 1.07870520" in said
    # A worse method.
    worse, _ = action(tmp_path, PENDULUM, "--until", "20", "--method", "rk4", "--step", "0.1")
    assert 1e-6 < worse["drift"]["max"] < 1e-3


def test_where_the_force_nearly_vanishes(tmp_path: Path) -> None:
    """A row at 5e-5 of the bottom of x^4/4: the first panel is 1e12 long, its end is not."""
    quartic = "model m\ncoord x\nkinetic x'^2/2\npotential x^4/4\nstart x = 1\n"
    found, _ = action(tmp_path, quartic, "--until", "3", "--every", "0.003")
    quarter = math.gamma(1 / 4)
    assert abs(found["period"] / (quarter**2 / math.sqrt(math.pi)) - 1) < 1e-14
    assert 0 < found["drift"]["max"] < 1e-10


def test_adiabatic_invariance(tmp_path: Path) -> None:
    # While the pendulum grows to three times its length J keeps to some rate/omega of its size,
    # and its frequency (of small swings l^-1/2) does not.
    slow = ["--until", "2000", "--rtol", "1e-10", "--set"]
    small = ["--start", "theta=0.1", *slow]
    found, said = action(tmp_path, PENDULUM, *small, "grow=0.001")
    faster, _ = action(tmp_path, PENDULUM, *small, "grow=0.01")
    assert found["held"] and "with t and any inputs held" in said
    assert 1e-4 < found["drift"]["max"] < 2e-3
    assert faster["drift"]["max"] > 5 * found["drift"]["max"]
    assert found["drift"]["growth"] == "bounded"
    first, last = found["rows"][0], found["rows"][-1]
    assert abs(last[2] / first[2] - math.sqrt(3)) < 0.002
    # Shortened from above the other side: what turned round becomes a swing, and that is said.
    turning = [*slow[:-1], "--set", "grow=0.001", "--start", "theta'=2.2", "--start", "theta=0"]
    found, said = action(tmp_path, PENDULUM, *turning)
    assert found["orbit"] == "round and round" and found["changes"] == "to and fro"
    assert found["rows"][-1][1] is None and "then, at t = " in said


def test_of_what_a_scene_leaves(tmp_path: Path) -> None:
    # Kepler's radius, phi being cyclic: T = 2 pi a^(3/2), J = sqrt(mu a) - L (Landau 50).
    found, _ = action(tmp_path, KEPLER, "--scene", "radius")
    a = 1 / (2 - 0.8**2)
    assert abs(found["period"] / (2 * math.pi * a**1.5) - 1) < 1e-13
    assert abs(found["action"] - (math.sqrt(a) - 0.8)) < 1e-14
    assert not found["held"] and not found["of_forces"]
