"""Steps of lie_midpoint that end in the gimbals' lock, where a row is of attitudes that cancel."""

from __future__ import annotations

import random

import pytest

from conftest import ROOT, ran, seeds

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
