"""What a map watches besides energy: exchange between coordinates, constants, the phase."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest
from stability_asker import asker, point

from conftest import case, seeds

# Off its resonance: the swing of a motion that stretches stays as small as it was.
ELASTIC = case("stability_watch_elastic")
PLANET = case("stability_watch_planet")
PERIHELION = "conserve A = y'*(x*y' - y*x') - x/sqrt(x^2 + y^2)"
LINE = "model m\ncoord x\nkinetic x'^2/2\npotential x^2/2\nstart x = 1\n"


def test_energy_that_goes_to_another_coordinate() -> None:
    """Steps of the midpoint rule that turn both modes in step: the swing gains a hundredfold."""
    swing = asker(ELASTIC)
    for h in (1.1, 1.13, 1.17):
        found = point(swing, "gauss1", h)
        assert found.kind == found.shown == "exchange" and 50 < found.exchange < 2000, h
    for method, h in (("gauss1", 0.3), ("gauss1", 0.9), ("gauss2", 0.5), ("rk4", 0.05)):
        found = point(swing, method, h)
        assert found.kind != "exchange" and found.exchange == pytest.approx(1, abs=0.1), h


def test_a_coordinate_alone_has_nothing_to_exchange_with() -> None:
    assert point(asker(LINE), "verlet", 1.99).exchange == 0


def test_constants_that_are_lost_are_named() -> None:
    planet = asker(PLANET, until=40.0)
    lost = point(planet, "rk4", 0.35)
    assert (lost.constant, lost.moved > 0.01) == ("L", True)
    # Verlet keeps angular momentum to round-off, the midpoint rule any quadratic constant.
    for method, h in (("verlet", 0.3), ("gauss1", 0.1)):
        kept = point(planet, method, h)
        assert kept.kind == "bounded" and kept.moved < 1e-10


def test_a_constant_that_is_zero_has_no_scale() -> None:
    fallen = PLANET.replace("y' = 0.9", "y' = 0").replace("1/sqrt(x^2 + y^2)", "1/(2 + x^2 + y^2)")
    assert point(asker(fallen), "rk4", 0.5).moved == 0


def test_a_method_that_keeps_energy_may_lose_another_constant() -> None:
    """Verlet's ellipse turns, so the vector to its perihelion does."""
    turning = PLANET.replace("conserve L = x*y' - y*x'", PERIHELION)
    found = point(asker(turning, until=60.0), "verlet", 0.1)
    assert found.kind == "constant lost" and found.constant == "A" and 0.01 < found.moved < 2
    assert point(asker(turning, until=60.0), "gauss3", 0.1).kind == "bounded"


@pytest.mark.parametrize("h", [0.3, 0.6, 1.0])
def test_the_phase_is_lost_when_the_frequency_says(h: float) -> None:
    """Verlet turns by 2 asin(h/2) a step, so it is a third of pi ahead after so long; half of how
    far the motion goes, 1 of 2, is then between it and the motion, at the next swing."""
    late = math.pi / 3 / (2 * math.asin(h / 2) / h - 1)
    found = point(asker(LINE, until=3 * late), "verlet", h)
    assert found.kind == "bounded" and found.shown == "out of phase"
    assert late - h <= 3 * late * found.follows <= late + math.pi + h
    kept = point(asker(LINE, until=0.9 * late), "verlet", h)
    assert kept.shown == "bounded" and kept.follows == 1


def test_of_chaos_the_phase_is_judged_up_to_its_horizon() -> None:
    double = (
        "model m\ncoord a, b\nkinetic a'^2 + b'^2/2 + a'*b'*cos(a - b)\n"
        "potential -2*cos(a) - cos(b)\nstart a = 2.5, b = 2.5\n"
    )
    chaos = asker(double, until=300.0)
    horizon = chaos.motion().horizon
    assert 20 < horizon < 150
    assert asker(double.replace("a = 2.5, b = 2.5", "a = 0.3"), until=300.0).motion().horizon == 300
    # A method more exact than the horizon asks for follows all the way to it.
    assert chaos.point("gauss4", 0.02).follows == 1 and chaos.point("verlet", 0.02).follows != 1


FUNCTIONS = ("cos({})", "-cos({})", "({})^2/2", "exp(-({})^2)", "({})^4/4", "log(1 + ({})^2)")


@pytest.mark.parametrize("seed", seeds(range(3), 3))
def test_short_steps_of_random_models_do_as_the_motion_does(seed: int) -> None:
    chance = random.Random(seed)
    terms = [chance.choice(FUNCTIONS).format(chance.choice(("x", "y", "x - y"))) for _ in range(3)]
    rates = "x'^2/2 + (1.5 + sin(x)^2)*y'^2/2" if seed % 2 else "x'^2/2 + y'^2"
    text = (
        f"model m\ncoord x, y\nkinetic {rates}\npotential {' + '.join(terms)} + (x^2 + y^2)/4\n"
        f"start x = {chance.uniform(0.1, 1)}, y = {chance.uniform(-1, 1)}, y' = 0.3\n"
    )
    asked = asker(text, until=30.0)
    good = point(asked, "gauss4", 0.05)
    assert good.shown == "bounded" and good.exchange == pytest.approx(1, abs=0.05)
    assert good.follows == 1 and good.moved == 0
    worse = asked.point("euler", 0.2)
    assert worse.kind != "bounded" or worse.follows < 1


def test_what_fails_has_none_of_it() -> None:
    swing = asker(LINE.replace("x^2/2", "-cos(x)").replace("x = 1", "x = 2"))
    swing = swing.with_settings(replace(swing.settings, iteration="fixed"))
    failed = point(swing, "gauss1", 4.0)
    assert failed.kind == "not converged"
    assert failed.exchange is None and failed.moved is None and failed.follows is None
