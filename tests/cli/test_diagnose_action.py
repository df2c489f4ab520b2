"""`--diagnose action` against closed forms."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from conftest import case, ran, written

PENDULUM = case("diagnose_action_swing")
KEPLER = case("keplerpolar")


def action(pkgen, tmp_path: Path, text: str, *arguments: object) -> tuple[dict, str]:
    path = written(tmp_path, text)
    done = ran("run", path, "--diagnose", "action", "-o", tmp_path / "rows.csv", *arguments)
    report = json.loads((tmp_path / "rows.csv.json").read_text())["report"]
    return report["diagnostics"]["action"], done.stderr


@pytest.mark.parametrize(
    ("width", "height", "lo", "period"),
    [(0.01, 0.6, 0.506923, 2.0970046556), (0.003, 0.3, -1, 6.29347498263)],
)
def test_humps_narrower_than_its_panels(
    pkgen, tmp_path: Path, width: float, height: float, lo: float, period: float
) -> None:
    """One turns the motion back, one is passed; periods from events, and by quadrature."""
    text = f"""model hump
coord x
lagrangian x'^2/2 - x^2/2 - {height}*exp(-(x - 0.5)^2/{width}^2)
start x = 1
"""
    how = ["--until", "1", "--method", "rk4", "--step", "0.001", "--every", "1"]
    found, _ = action(pkgen, tmp_path, text, *how)
    assert found["lo"] == pytest.approx(lo, abs=1e-6)
    assert found["period"] == pytest.approx(period, rel=1e-10)


def test_of_a_pendulum(pkgen, tmp_path: Path) -> None:
    # REGIMES P2 and P1; and its rows by a method that keeps the energy.
    steps = ["--until", "20", "--method", "gauss8", "--step", "0.1"]
    found, said = action(pkgen, tmp_path, PENDULUM, *steps)
    assert found["orbit"] == "to and fro" and abs(found["lo"] + found["hi"]) < 1e-15
    assert abs(found["action"] - 1.0787052024) < 6e-11
    assert abs(found["frequency"] - 0.8472130848) < 6e-11
    assert abs(found["period"] / (2 * math.pi) - 1.1803405990) < 6e-11
    assert 0 < found["error"] < 1e-14 and found["nodes"] == 64
    assert len(found["rows"]) == 200 and found["rows"][-1][0] == 20 and found["changes"] is None
    assert 0 < found["drift"]["max"] < 1e-13
    assert "action: to and fro between -1.570796327 and 1.570796327: J = 1.07870520" in said
    # A worse method.
    worse, _ = action(
        pkgen, tmp_path, PENDULUM, "--until", "20", "--method", "rk4", "--step", "0.1"
    )
    assert 1e-6 < worse["drift"]["max"] < 1e-3


def test_where_the_force_nearly_vanishes(pkgen, tmp_path: Path) -> None:
    """A row at 5e-5 of the bottom of x^4/4: the first panel is 1e12 long, its end is not."""
    quartic = "model m\ncoord x\nkinetic x'^2/2\npotential x^4/4\nstart x = 1\n"
    found, _ = action(pkgen, tmp_path, quartic, "--until", "3", "--every", "0.003")
    quarter = math.gamma(1 / 4)
    assert abs(found["period"] / (quarter**2 / math.sqrt(math.pi)) - 1) < 1e-14
    assert 0 < found["drift"]["max"] < 1e-10


def test_kinks(pkgen, tmp_path: Path) -> None:
    kinked = "model m\ncoord x\nkinetic x'^2/2\npotential x^2/2 + max(0, x - 1)^2\nstart x = {}\n"
    path = written(tmp_path, kinked.format(1.5))
    done = pkgen("run", path, "--diagnose", "action", "--until", "1")
    assert done.returncode == 2 and "have a kink (abs, min, max, step) on its way" in done.stderr
    found, _ = action(pkgen, tmp_path, kinked.format(0.9), "--until", "1")  # it has none on its way
    assert abs(found["period"] - 2 * math.pi) < 1e-14


def test_adiabatic_invariance(pkgen, tmp_path: Path) -> None:
    # While the pendulum grows to three times its length J keeps to some rate/omega of its size,
    # and its frequency (of small swings l^-1/2) does not.
    slow = ["--until", "2000", "--rtol", "1e-10", "--set"]
    small = ["--start", "theta=0.1", *slow]
    found, said = action(pkgen, tmp_path, PENDULUM, *small, "grow=0.001")
    faster, _ = action(pkgen, tmp_path, PENDULUM, *small, "grow=0.01")
    assert found["held"] and "with t and any inputs held" in said
    assert 1e-4 < found["drift"]["max"] < 2e-3
    assert faster["drift"]["max"] > 5 * found["drift"]["max"]
    assert found["drift"]["growth"] == "bounded"
    first, last = found["rows"][0], found["rows"][-1]
    assert abs(last[2] / first[2] - math.sqrt(3)) < 0.002
    # Shortened from above the other side: what turned round becomes a swing, and that is said.
    turning = [*slow[:-1], "--set", "grow=0.001", "--start", "theta'=2.2", "--start", "theta=0"]
    found, said = action(pkgen, tmp_path, PENDULUM, *turning)
    assert found["orbit"] == "round and round" and found["changes"] == "to and fro"
    assert found["rows"][-1][1] is None and "then, at t = " in said


def test_of_what_a_scene_leaves(pkgen, tmp_path: Path) -> None:
    # Kepler's radius, phi being cyclic: T = 2 pi a^(3/2), J = sqrt(mu a) - L (Landau 50).
    found, _ = action(pkgen, tmp_path, KEPLER, "--scene", "radius")
    a = 1 / (2 - 0.8**2)
    assert abs(found["period"] / (2 * math.pi * a**1.5) - 1) < 1e-13
    assert abs(found["action"] - (math.sqrt(a) - 0.8)) < 1e-14
    assert not found["held"] and not found["of_forces"]
    done = pkgen("run", tmp_path / "model.lag", "--diagnose", "action", "--until", "1")
    assert done.returncode == 2 and "2 coordinates: it is of one" in done.stderr
    assert "a scene whose reductions leave one" in done.stderr


def test_motions_that_have_none(pkgen, tmp_path: Path) -> None:
    for start, orbit in (
        (["theta=0"], "at rest in an equilibrium"),
        (["theta=0", "theta'=2"], "on a separatrix"),
    ):
        starts = [x for text in start for x in ("--start", text)]
        found, said = action(pkgen, tmp_path, PENDULUM, "--until", "1", *starts)
        assert found["orbit"].startswith(orbit) and f"action: {orbit}" in said
        assert found["action"] is None and found["period"] is None and "rows" not in found
    falling = "model fall\ncoord x\nkinetic x'^2/2\npotential x\n"
    found, _ = action(pkgen, tmp_path, falling, "--until", "1")
    assert found["orbit"].startswith("not periodic") and found["action"] is None
    # States are no coordinates, and a scene may leave them out.
    states = (
        "model m\ncoord x\nstate S, R\nkinetic x'^2/2\npotential x^2/2\nrate S = L\nrate R = x\n"
    )
    states += "start x = 1\nscene alone\n  until 1\n  record x\nend\n"
    path = written(tmp_path, states)
    done = pkgen("run", path, "--diagnose", "action", "--until", "1")
    assert done.returncode == 2 and "states: 1 and 2; it is of one coordinate" in done.stderr
    found, _ = action(pkgen, tmp_path, states, "--scene", "alone")
    assert abs(found["period"] - 2 * math.pi) < 1e-14
    path.write_text("model m\nstate x, y\nrate x = y\nrate y = -x\nstart x = 1\n")
    done = pkgen("run", path, "--diagnose", "action", "--until", "1")
    assert done.returncode == 2 and "states: 0 and 2; it is of one coordinate" in done.stderr
    assert "scene" not in done.stderr
    charged = "model charged\ncoord x\nkinetic -sqrt(1 - x'^2)\npotential x^2/2\nstart x = 1\n"
    path = written(tmp_path, charged)
    done = pkgen("run", path, "--diagnose", "action", "--until", "1")
    assert done.returncode == 2 and "not of second degree in the rate" in done.stderr
