"""Messages of commands about contacts; tests/runs/test_contacts_random.py has their motions."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import pkgen as package
from conftest import ROOT

CONTACT = ROOT / "models" / "contact"
BALL = CONTACT / "bouncing_ball.lag"
CRADLE = CONTACT / "newton_cradle.lag"


def test_a_ball_comes_to_rest_at_its_time(pkgen, tmp_path: Path) -> None:
    done = pkgen("run", BALL, "--until", 6, "--json", "-o", tmp_path / "rows.csv")
    (floor,) = json.loads(done.stdout)["report"]["contacts"]
    assert floor["rests"] == pytest.approx(2 * 5 / 9.81 / (1 - 0.8), rel=1e-9)
    assert floor["lost"] == pytest.approx(12.5, rel=1e-12) and floor["impacts"] > 60
    done = pkgen("run", BALL, "--until", 6, "--every", 6)
    assert "contact floor: at rest from t = 5.09683996 on" in done.stderr


def test_an_order_that_counts_is_told(pkgen) -> None:
    touching = pkgen("run", CRADLE, "--scene", "touching").stderr
    assert "warning: hit[1] and hit[2] strike at once at t = 0.274691993" in touching
    assert "strike at once" not in pkgen("run", CRADLE, "--scene", "apart").stderr


@pytest.mark.parametrize("method", ["gauss", "dop853", "radau"])
def test_no_pin_is_overlooked(method: str, pkgen) -> None:
    """One sample alone of a long step was behind the last pin, which the ball passed through."""
    board = CONTACT / "galton_board.lag"
    done = pkgen("run", board, "--scene", "falls", "--method", method, "--rtol", "1e-11")
    assert "expected: 2 of 2 met" in done.stderr


def test_a_short_step_after_an_impact_goes_on(pkgen) -> None:
    """An impact at a time just before a step of the grid was found again and again, for the gap was
    still negative, by rounding, at the end of the step that was left."""
    plate = ROOT / "tests/regimes/models/shaken_plate.lag"
    grid = ("--method", "rk4", "--step", "0.1", "--every", "0.1")
    done = pkgen("run", plate, *grid, "--until", 100)
    assert done.returncode == 0, done.stderr
    assert "event hit: 100 times" in done.stderr or "event hit: 99 times" in done.stderr


def test_what_cannot_be_is_said(pkgen) -> None:
    below = pkgen("run", BALL, "--start", "y=-1", "--until", 1)
    assert below.returncode == 4
    assert "a contact begins violated: floor is -1" in below.stderr
    rattle = pkgen("run", BALL, "--method", "rattle", "--step", 0.01)
    refused = "rattle takes no constraints that hold at times, such as the contact floor"
    assert refused in rattle.stderr
    assert "pkgen stability knows no contacts" in pkgen("stability", BALL).stderr


def test_a_jump_by_sign_gets_the_hint(pkgen, tmp_path: Path) -> None:
    model = tmp_path / "slides.lag"
    text = "model slides\ncoord x\nkinetic x'^2/2\npotential x^2\nforce x = -0.5*sign(x')\n"
    model.write_text(text + "start x = 1.6\n", encoding="utf-8")
    done = pkgen("run", model, "--until", 10)
    assert "help: a law that sticks too, for a force F: friction x = F" in done.stderr
    assert done.returncode == 4 and "'friction NAME = F' does" in done.stderr
    model.write_text(text.replace("force x = -0.5*sign(x')", "friction x = 0.5"), encoding="utf-8")
    assert pkgen("run", model, "--until", 10).returncode == 0


@pytest.mark.parametrize("how", [{"method": "rk4", "step": 0.01}, {"method": "radau"}])
def test_an_integrator_goes_past_what_changes_the_motion(how: dict) -> None:
    """A row of a run, which no one writes here, was once looked for before the last step."""
    model = package.load(CONTACT / "rocking_block.lag")
    it, run = model.integrator(**how), model.run(until=5, every=1, **how)
    for k in range(1, 6):
        it.to(k)
        assert it.q == pytest.approx(np.array([run[x][k] for x in model.coordinates]), abs=1e-6)


@pytest.mark.parametrize("more, told", [(1e-10, 1), (1e-9, 1), (1e-7, 0), (-1e-7, 0)])
def test_a_graze_is_told(more: float, told: int, pkgen, tmp_path: Path) -> None:
    """A ball thrown up to a ceiling, or a little more or less."""
    model = tmp_path / "graze.lag"
    model.write_text(
        "model graze\nparam more = 0\ncoord x, y\nkinetic (x'^2 + y'^2)/2\npotential 9.81*y\n"
        "contact ceiling: 1 >= y restitution 0.5\nstart y' = sqrt(2*9.81)*(1 + more)\n",
        encoding="utf-8",
    )
    done = pkgen("run", model, "--until", 1, "--set", f"more={more}")
    assert done.stderr.count("contact ceiling: touched without a normal force") == told, done.stderr


def test_a_touch_without_a_force_is_told(pkgen, tmp_path: Path) -> None:
    model = tmp_path / "floats.lag"
    text = "model floats\ncoord x, y\nkinetic (x'^2 + y'^2)/2\ncontact floor: y >= 0 friction 0.3\n"
    model.write_text(text + "start x' = 1\n", encoding="utf-8")
    assert (
        "floor: touched without a normal force at t = 0:"
        in pkgen("run", model, "--until", 1).stderr
    )


def test_a_description_has_contacts_by_name(pkgen) -> None:
    said = pkgen("describe", CONTACT / "box_on_incline.lag").stdout
    assert "contacts:     back, front\n" in said and "inputs:" not in said
