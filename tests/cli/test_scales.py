"""The same motion in other units: tolerances follow the size of the motion, so a rescaled model has
the same relative result. One letter, U, is the unit of length that a model has its numbers in."""

from __future__ import annotations

import math
import random

import pytest

from conftest import rows, written

METHODS = ["gauss", "dop853", "dopri5", "radau", "gsl_rk8pd"]
SIZES = [1e-15, 1e-12, 1e-3, 1e9, 1e15]

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


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", MODELS)
def test_units_do_not_matter(pkgen, tmp_path, name, method):
    powers = MODELS[name][1]
    path = written(tmp_path, model(name, 1.0))
    run = ("--until", "10", "--every", "10", "--rtol", "1e-10", "--method", method)
    one = rows(pkgen, path, *run)[-1]
    exact = rows(pkgen, path, *run[:4], "--rtol", "1e-13", "--method", "dop853")[-1]
    for size in SIZES:
        scaled = rows(pkgen, path, *run, "--set", f"U={size!r}")[-1]
        for x, power in powers.items():
            found = scaled[x] / size**power
            assert abs(exact[x]) > 1e-6
            assert found == pytest.approx(one[x], rel=1e-6), (size, x)
            assert found == pytest.approx(exact[x], rel=1e-6), (size, x)


@pytest.mark.parametrize("method", METHODS)
def test_a_seismometer_and_a_pendulum_that_hardly_moves(pkgen, tmp_path, method):
    seismometer = "model s\ncoord x\nkinetic x'^2/2\npotential 2*x^2\nstart x = 1e-12\n"
    pendulum = "model p\ncoord a\nkinetic a'^2/2\npotential -9.81*cos(a)\nstart a = 1e-15\n"
    for text, name, size, w in (
        (seismometer, "x", 1e-12, 2),
        (pendulum, "a", 1e-15, math.sqrt(9.81)),
    ):
        path = written(tmp_path, text)
        common = ("--until", "20", "--every", "20", "--method", method, "--rtol", "1e-10")
        exact = size * math.cos(20 * w)
        assert rows(pkgen, path, *common)[-1][name] == pytest.approx(exact, rel=1e-6)
        told = rows(pkgen, path, *common, "--atol", "1e-3")[-1][name]  # absolute, if said
        assert abs(told - exact) > 1e-4 * size


def test_a_body_that_turns_and_flies(pkgen, tmp_path):
    """A rotation beside picometres: neither has the other's scale."""
    text = (
        "model b\nparam U = 1\ncoord x, y\nrotation R\nlet w = omega(R)\n"
        "kinetic (x'^2 + y'^2)/2 + U^2*(w.x^2 + 2*w.y^2 + 3*w.z^2)/2\n"
        "potential x^2 + y^2*2\nstart x = U, y' = U, omega(R) = [1, 2, 0.5]\n"
    )
    path = written(tmp_path, text)
    run = ("--until", "7", "--every", "7", "--rtol", "1e-10", "--record", "x,y,w")
    one = rows(pkgen, path, *run)[-1]
    for size in (1e-12, 1e9):
        scaled = rows(pkgen, path, *run, "--set", f"U={size!r}")[-1]
        assert len(scaled) == 6
        for x, found in scaled.items():
            found = found / size if x in "xy" else found
            assert found == pytest.approx(one[x], rel=1e-6), (size, x)


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
