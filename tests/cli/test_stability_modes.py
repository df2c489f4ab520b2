"""Modes about equilibria against closed forms."""

from __future__ import annotations

import math
import random

import pytest
from stability_asker import PENDULUM, asker

from conftest import case
from pkgen.analysis.stability.rest import Mode

DOUBLE = case("stability_modes_double")


def rates(modes: tuple[Mode, ...]) -> list[tuple[float, float]]:
    return [(m.growth, m.frequency) for m in modes]


def test_a_double_pendulum() -> None:
    """omega^2 = g (2 -+ sqrt 2) hanging, growth^2 the same upright, and g sqrt 2 for both of the
    saddles with one rod up."""
    fast, slow = (math.sqrt(9.81 * (2 + x * math.sqrt(2))) for x in (1, -1))
    saddle = math.sqrt(9.81 * math.sqrt(2))
    hanging, one, other, upright = asker(DOUBLE).rest().equilibria
    assert rates(hanging.modes) == [(0, pytest.approx(x, rel=1e-12)) for x in (fast, slow)]
    # The fast mode has the rods against each other.
    assert hanging.modes[0].re == pytest.approx((-math.sqrt(0.5), 1), rel=1e-12)
    assert hanging.modes[1].re == pytest.approx((math.sqrt(0.5), 1), rel=1e-12)
    for place in (one, other):
        grows, turns, decays = rates(place.modes)
        assert grows == (pytest.approx(saddle, rel=1e-12), 0)
        assert turns == (0, pytest.approx(saddle, rel=1e-12))
        assert decays == (pytest.approx(-saddle, rel=1e-12), 0)
    expected = [fast, -fast, slow, -slow]
    assert rates(upright.modes) == [(pytest.approx(x, rel=1e-12), 0) for x in expected]


def test_a_pendulum_and_a_damped_one() -> None:
    below, above = asker(PENDULUM).rest().equilibria
    assert rates(below.modes) == [(0, pytest.approx(1, rel=1e-12))]
    assert rates(above.modes) == [(pytest.approx(x, rel=1e-12), 0) for x in (1, -1)]
    (damped, *_) = asker(PENDULUM + "dissipation 0.1*theta'^2\n").rest().equilibria
    ((growth, frequency),) = rates(damped.modes)
    assert growth == pytest.approx(-0.1, rel=1e-9)
    assert frequency == pytest.approx(math.sqrt(0.99), rel=1e-9)


def test_of_states() -> None:
    """The Brusselator at x = 1, y = 3: trace and determinant are 1."""
    text = (
        "model m\nstate x, y\nrate x = 1 + x^2*y - 4*x\nrate y = 3*x - x^2*y\nstart x = 1, y = 2\n"
    )
    (place,) = asker(text).rest(8).equilibria
    assert place.v == pytest.approx((1, 3), rel=1e-12)
    ((growth, frequency),) = rates(place.modes)
    assert (growth, frequency) == pytest.approx((0.5, math.sqrt(0.75)), rel=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_a_conical_pendulum(seed: int) -> None:
    """Cyclic momenta are held. About the cone of angle b it nutates at
    sqrt(g (1 + 3 cos^2 b)/cos b), and phi moves with it."""
    draw = random.Random(seed)
    g, b = draw.uniform(1, 10), draw.uniform(0.3, 1.2)
    turn = math.sqrt(g / math.cos(b))
    text = (
        "model m\ncoord theta, phi\nkinetic (theta'^2 + sin(theta)^2*phi'^2)/2\n"
        f"potential -{g!r}*cos(theta)\nstart theta = {b!r}, phi' = {turn!r}\n"
    )
    cone = min(asker(text).rest().equilibria, key=lambda e: abs(e.q[0] - b))
    assert (cone.q[0], cone.v[1]) == pytest.approx((b, turn), rel=1e-9)
    (mode,) = cone.modes
    nutation = math.sqrt(g * (1 + 3 * math.cos(b) ** 2) / math.cos(b))
    assert (mode.growth, mode.frequency) == (0, pytest.approx(nutation, rel=1e-9))
    # u_phi' = -2 phi' cot(b) u_theta, and u_phi that over i omega.
    assert mode.re == pytest.approx((1, 0), abs=1e-9)
    assert mode.im[1] == pytest.approx(2 * turn / math.tan(b) / nutation, rel=1e-9)


def test_where_mass_is_negative_there_are_none() -> None:
    text = "model m\ncoord x\nkinetic (1 - x)*x'^2/2\npotential (x - 0.5)^2/2\nstart x = 0.4\n"
    (place,) = asker(text).rest(0).equilibria
    assert rates(place.modes) == [(0, pytest.approx(math.sqrt(2), rel=1e-9))]
    folded = asker(text.replace("0.5", "1.5").replace("0.4", "1.4"))
    assert folded.rest(0).singular == 1
