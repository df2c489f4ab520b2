"""Linear models against differences of the motion, and their trims."""

from __future__ import annotations

import json
import math
import random
from pathlib import Path

import numpy
import pytest
from drawn_models import drawn, slope

import pkgen as package
from conftest import ROOT, ran, run_pkgen, seeds, written

pytestmark = pytest.mark.needs_addon("linear")

SWING = ROOT / "models/controlled/cart_pole_swing_up.lag"


@pytest.mark.parametrize("seed", seeds([0, 2, 5], 6))
def test_a_linear_model_is_the_slope_of_the_motion(seed: int, tmp_path: Path) -> None:
    text, _, _ = drawn(random.Random(seed))
    model = package.load(written(tmp_path, text))
    found = model.linearise(at=0.0)
    A, B, _, _ = found
    y = numpy.array([found.state[x] for x in (*model.coordinates, *model.rates)])
    names = [*model.coordinates, *model.rates]
    m, of = len(model.coordinates), [names.index(x) for x in found.states]
    assert {*found.states} <= {*names} and found.outputs == ("a", "b")

    def rate(z: numpy.ndarray) -> numpy.ndarray:
        """The rates of the states, at the states and inputs z."""
        x, u = numpy.split(z, [len(of)])
        place = y.copy()
        place[of] = x
        if "R.w" in names:  # the quaternion keeps its length
            Q = [names.index(f"R.{k}") for k in "wxyz"]
            assert {*Q[1:]} <= {*of}
            place[Q[0]] = math.copysign(math.sqrt(1 - (place[Q[1:]] ** 2).sum()), y[Q[0]])
        a = model.acceleration(place[:m], place[m:], u=u)
        return numpy.array([*place[m : 2 * m], *a])[of]

    z = numpy.array([*y[of], *numpy.zeros(B.shape[1])])
    whole = numpy.array([slope(rate, z, by) for by in numpy.eye(len(z))]).T
    assert abs(numpy.concatenate([A, B], 1) - whole).max() < 1e-8 * max(1, abs(whole).max())


def test_a_rod_is_linear_as_an_angle() -> None:
    rod = package.load(ROOT / "models/constrained/pendulum_rod.lag").linearise()
    assert rod.states == ("x", "x'") and rod.state["y"] == pytest.approx(-1)
    assert rod.poles == pytest.approx([-1j * math.sqrt(9.81), 1j * math.sqrt(9.81)])


def test_a_trim_gives_the_regulator_of_the_model() -> None:
    scipy = pytest.importorskip("scipy.linalg")
    model = package.load(SWING)
    upright = model.linearise("trim", want={"theta": 0})
    assert upright.inputs == ("u",) and upright.controllability()[0] == 4
    A, B, _, _ = upright.discrete(model.params["T"])
    P = scipy.solve_discrete_are(A, B, numpy.diag([5.0, 20, 1, 1]), [[0.1]])
    (gains,) = numpy.linalg.solve(0.1 + B.T @ P @ B, B.T @ P @ A)
    assert -gains == pytest.approx([model.params[f"f{k}"] for k in (1, 2, 3, 4)], abs=1e-6)


@pytest.mark.parametrize("wanted", [{"a": 0.5}, {"height": -math.cos(0.5)}, {"u": math.sin(0.5)}])
def test_a_trim_finds_what_is_left_free(tmp_path: Path, wanted: dict[str, float]) -> None:
    text = (
        "model arm\ncoord a, b\ninput u\nkinetic (a'^2 + b'^2)/2\npotential -cos(a) + (b - a)^2\n"
    )
    text += "force a = u\nobserve height = -cos(a)\nstart a = 0.3, b = 0.4\n"
    found = package.load(written(tmp_path, text)).linearise("trim", want=wanted)
    state = found.state["a"], found.state["b"], found.input["u"]
    assert state == pytest.approx((0.5, 0.5, math.sin(0.5)), abs=1e-9)


def test_a_command_gives_matrices_with_their_names() -> None:
    words = ("linearise", SWING, "--at", "trim", "--want", "theta=0")
    found = json.loads(ran(*words, "--json").stdout)
    assert found["states"] == ["x", "theta", "x'", "theta'"]
    assert found["A"][3][1] == pytest.approx(23.544) and found["B"] == [[0], [0], [1], [-2]]
    assert found["units"] == {
        "states": ["m", "rad", "m/s", "rad/s"],
        "inputs": ["N"],
        "outputs": ["m", "rad", "m/s", "rad/s"],
    }
    assert "sys = ss(A, B, C, D);" in ran(*words, "--matlab").stdout
    assert "controllable: 4 of 4" in ran(*words).stdout


HEAD = "coord x\ninput u\nkinetic x'^2/2\nforce x = u\nobserve twice = 2*x\nstart x = 1\n"
MODELS = {
    "driven": f"model driven\n{HEAD}potential x^2/2 - x*cos(t)\n",
    "falls": f"model falls\n{HEAD}potential x*u^2 + x\n",
    "hits": "model hits\ncoord y\nkinetic y'^2/2\ncontact floor: y >= 0\nstart y = 1\n",
}
REFUSED = [
    ("driven", "", 2, "--at equilibrium: the equations depend on time; give --at t=…"),
    ("driven", "--at trim", 2, "--at trim: the equations depend on time; give --at t=…"),
    ("driven", "--at 2", 2, "--at 2: give equilibrium, trim, or a time as t=2"),
    ("driven", "--at t=later", 2, "--at t=later: unknown name 'later'"),
    ("driven", "--at t=-1", 2, "--at t=-1: the motion begins at t = 0"),
    ("driven", "--at t=0 --want x=1", 2, "--want is for --at trim"),
    ("driven", "--at t=0 --want y=1", 2, "--want y=1: it has: x, x', twice, u"),
    ("driven", "--at t=0 --period 0", 2, "--period 0: period must be positive"),
    ("falls", "", 4, "no equilibrium was found from 101 starts: --at t=0 is of the start itself"),
    ("falls", "--at trim --want u=0", 2, "no steady state was found with u = 0: want less"),
    ("hits", "", 1, "pkgen linearise knows no contacts"),
]


@pytest.mark.parametrize(("model", "options", "code", "said"), REFUSED)
def test_what_is_not_there_is_said(
    tmp_path: Path, model: str, options: str, code: int, said: str
) -> None:
    done = run_pkgen("linearise", written(tmp_path, MODELS[model]), *options.split())
    assert (done.returncode, said in done.stderr) == (code, True), done.stderr
