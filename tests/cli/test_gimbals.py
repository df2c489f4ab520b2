"""Steps of lie_midpoint that end in the gimbals' lock, where a row is of attitudes that cancel."""

from __future__ import annotations

import random

import pytest

from conftest import ROOT, ran, seeds, written

GIMBALS = ROOT / "models" / "constrained" / "gimbals.lag"


@pytest.mark.parametrize("seed", seeds(range(3), 57))
def test_steps_that_end_in_the_lock_converge(seed: int) -> None:
    """They do at the event. What is left of a row there is what rounding made of a turn."""
    draw = random.Random(seed)
    start = {
        "beta0": f"{-draw.uniform(0.0005, 0.01)!r} [rad]",
        "dip": f"{draw.uniform(1, 7)!r} [rad/s]",
        "turn": f"{draw.choice([0, draw.uniform(-0.01, 0.01)])!r} [rad/s]",
        "spin": f"{draw.uniform(5, 20)!r} [rad/s]",
        "alpha0": f"{draw.uniform(0, 300)!r} [rad]",
    }
    run = ("run", GIMBALS, "--method", "lie_midpoint", "--step", "0.002")
    given = [word for name, value in start.items() for word in ("--set", f"{name}={value}")]
    done = ran(*run, "--until", "0.02", "--every", "0.02", *given)
    assert "event lock: once" in done.stderr


@pytest.mark.parametrize(
    ("angles", "start", "lock"),
    [
        ("tait_bryan", "rot([0, 1, 0], -90 [deg])", "cos(pitch)^2 of tait_bryan(R)"),
        ("euler", "rot([0, 0, 1], 0.3)", "sin(theta)^2 of euler(R)"),
    ],
)
def test_a_start_in_the_lock_of_angles_is_told(pkgen, tmp_path, angles, start, lock) -> None:
    text = (ROOT / "tests" / "cases" / "bushing.lag").read_text()
    text = text.replace("tait_bryan", angles).replace("rot([0, 1, 0], -90 [deg])", start)
    done = pkgen("run", written(tmp_path, text), "--until", "1")
    assert done.returncode == 4 and f"{lock} vanishes at t = 0" in done.stderr, done.stderr
