"""The same motion in other units: tolerances follow the size of the motion, so a rescaled model has
the same relative result. One letter, U, is the unit of length that a model has its numbers in."""

from __future__ import annotations

import math
import random

import pytest

from conftest import rows, written

# Text, and what is compared with the size it has by the power of U.
MODELS = {
    "oscillator": (
        "coord x\nkinetic x'^2/2\npotential w^2*x^2/2 + g*x^4/U^2/4\nstart x = a*U, x' = b*U\n",
        {"x": 1},
    ),
    "kepler": (
        "coord x, y\nkinetic (x'^2 + y'^2)/2\npotential -w*U^3/sqrt(x^2 + y^2)\n"
        "start x = a*U, y' = U*sqrt(w/a)*0.9\n",
        {"x": 1, "y": 1},
    ),
    "two sizes": (  # of one unit, and coupled: the small one is a thousandth
        "coord x, y\nkinetic (x'^2 + 1e6*y'^2)/2\npotential w^2*x^2/2 + 1e6*y^2 + 1e3*g*x*y/9\n"
        "start x = a*U, y = b*U/1000\n",
        {"x": 1, "y": 1},
    ),
    "length and angle": (  # an elastic pendulum
        "coord r, s\nkinetic (r'^2 + r^2*s'^2)/2\npotential 20*w*(r - U)^2/2 - 2*U*r*cos(s)\n"
        "start r = 1.1*U, s = a\n",
        {"r": 1, "s": 0},
    ),
    "forced from zero": (
        "coord x\nkinetic x'^2/2\npotential w^2*x^2/2\nforce x = b*U*sin(g*t)\nstart x = 0\n",
        {"x": 1},
    ),
    "let go": (
        "coord x\nkinetic x'^2/2\npotential w^2*(x - U)^2/2 + g*(x - U)^4/U^2\nstart x = 0\n",
        {"x": 1},
    ),
    "rod": (
        "coord x, y\nkinetic (x'^2 + y'^2)/2\npotential w*U*y\nconstraint rod: x^2 + y^2 = U^2\n"
        "start x = U*sin(a), y = -U*cos(a)\n",
        {"x": 1, "y": 1},
    ),
}


def model(name: str, unit: float, seed: int = 1) -> str:
    draw = random.Random(f"{name} {seed}")
    numbers = {"w": draw.uniform(1, 2), "g": draw.uniform(0.3, 0.9), "a": draw.uniform(0.5, 1)}
    numbers["b"] = draw.uniform(-1, 1)
    given = "".join(f"param {k} = {x!r}\n" for k, x in numbers.items())
    return f"model scaled\nparam U = {unit!r}\n{given}{MODELS[name][0]}"


def test_members_of_an_ensemble_have_scales_of_their_own(pkgen, tmp_path):
    text = (
        "model e\nparam a = 1\ncoord x\nkinetic x'^2/2\npotential 2*x^2\nstart x = a\n"
        "scene many\n  swarm k = 0..5\n  start x = a*10^(-3*k)\n  until 20\n"
        "  method dop853 rtol 1e-10\n  record x every 20\nend\n"
    )
    found = rows(pkgen, written(tmp_path, text), "--scene", "many")
    ends = [row["x"] for row in found if row["t"] == 20]
    assert len(ends) == 6
    for k, x in enumerate(ends):
        assert x == pytest.approx(10.0 ** (-3 * k) * math.cos(40), rel=1e-6)
