"""Modes about equilibria against closed forms."""

from __future__ import annotations

import math
import random

import pytest
from stability_asker import PENDULUM, asker

from conftest import case
from pkgen.analysis.linear.rest import Mode

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


LINE = "model m\ncoord x\nkinetic x'^2/2\npotential {}\nstart {}\n"
PLANE = "model m\ncoord x, y\nkinetic (x'^2 + y'^2)/2\npotential {}\nstart {}\n"
STATES = "model m\nstate x, y\nrate x = 1 + x^2*y - 4*x\nrate y = 3*x - x^2*y\nstart x = 1, y = 2\n"
NEGATIVE = "model m\ncoord x\nkinetic (1 - x)*x'^2/2\npotential (x - 0.5)^2/2\nstart x = 0.4\n"
MEMS = case("mems")  # a double well a micrometre wide, in SI units
STABLE, UNSTABLE, OPEN = "stable", "unstable", "not decided by the linear terms"
MOVES = math.sqrt(1.3**2 + 0.35**2)
WELLS = [(STABLE, [(0, math.sqrt(2) * 1e6)])] * 2 + [(UNSTABLE, [(1e6, 0), (-1e6, 0)])]
LENNARD_JONES = [(STABLE, [(0, math.sqrt(72) / 2 ** (1 / 6))])] * 2
# A start, and the verdicts and modes of what there is, by energy; and the places of q or of states.
EQUILIBRIA = [
    (PENDULUM, [(STABLE, [(0, 1)]), (UNSTABLE, [(1, 0), (-1, 0)])], [0, math.pi]),
    (
        PENDULUM + "dissipation 0.1*theta'^2\n",
        [(STABLE, [(-0.1, math.sqrt(0.99))]), None],
        [0, math.pi],
    ),
    (
        case("stability_predictions_damped"),
        [(STABLE, [(-0.45, math.sqrt(1.7**2 - 0.45**2))])],
        None,
    ),
    (case("magnetic"), [(STABLE, [(0, MOVES + 0.35), (0, MOVES - 0.35)])], None),
    (
        STATES,
        [(UNSTABLE, [(0.5, math.sqrt(0.75))])],
        [1, 3],
    ),  # the Brusselator: trace, determinant 1
    (NEGATIVE, [(STABLE, [(0, math.sqrt(2))])], [0.5]),
    *(
        (MEMS.replace("x = 1.2e-6", s), WELLS, [-1e-6, 0, 1e-6])
        for s in ("x = 1.2e-6", "x' = 0.3", "x = 1e-8")
    ),
    # In a box that reaches to where forces are of 1e20 all others are small beside them.
    *(
        (
            LINE.format("4*(1/x^12 - 1/x^6)", f"x = {x}"),
            LENNARD_JONES,
            [-(2 ** (1 / 6)), 2 ** (1 / 6)],
        )
        for x in (1.0, 1.13, 1.5, 3.0)
    ),
    # An angle of great inertia beside a coordinate that is none, whose equation is a small one.
    (case("turn"), [None, None], [0, 10, math.pi, 10]),
    # -x^4/4 is unstable all the same.
    (
        LINE.format("-x^4/4 + x^6/6", "x = 0.3"),
        [(STABLE, None)] * 2 + [(OPEN, [(0, 0)] * 2)],
        [-1, 0, 1],
    ),
    (PLANE.format("2*x^2 + y^4/4", "y = 1"), [(OPEN, [(0, 2), (0, 0), (0, 0)])], None),
]


@pytest.mark.parametrize(("text", "told", "places"), EQUILIBRIA)
def test_equilibria_have_their_modes(text: str, told: list, places: list | None) -> None:
    found = asker(text).rest(8 if "state" in text else 100).equilibria
    assert len(found) == len(told)
    for e, known in zip(found, told, strict=True):
        verdict, modes = known or (e.verdict, None)
        turns = verdict == OPEN and any(m.rate for m in e.modes)
        assert (e.verdict, e.stable) == (verdict, verdict == STABLE or turns)
        if modes is not None:
            assert rates(e.modes) == [pytest.approx(mode, rel=1e-9, abs=1e-9) for mode in modes]
    if places:
        at = sorted((e.v if "state" in text else e.q) for e in found)
        scale = max(map(abs, places))
        assert [x for place in at for x in place] == pytest.approx(places, abs=1e-9 * scale)


def test_modes_of_a_magnetic_field_are_circles() -> None:
    for m in asker(case("magnetic")).rest().equilibria[0].modes:  # y is a quarter turn beside x
        x, y = complex(m.re[0], m.im[0]), complex(m.re[1], m.im[1])
        assert abs(x) == pytest.approx(abs(y), rel=1e-9)
        assert abs((x.conjugate() * y).real) < 1e-9


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
    folded = asker(NEGATIVE.replace("0.5", "1.5").replace("0.4", "1.4"))
    assert folded.rest(0).singular == 1
