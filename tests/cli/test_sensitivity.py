"""Derivatives of runs, forward and backward, against differences of whole runs and closed forms."""

from __future__ import annotations

import math
import random
import re
from pathlib import Path

import numpy
import pytest
from drawn_models import drawn, slope

import pkgen as package
from conftest import ROOT, seeds, written
from pkgen.analysis.sensitivity.gradient import at_end

UNTIL = 1.5
FREE = ["rk4", "dop853", "dopri5", "gauss4", "lobatto3", "radau5", "gauss", "radau", "heun"]
TURNING = ["rk4", "dop853", "rkmk4", "lie_midpoint", "rattle", "gauss2", "gauss"]
SEPARABLE = [
    "verlet",
    "kahan_li8",
    "yoshida4",
    "lie_midpoint4",
    "rk3",
    "boris",
    "stochastic_verlet",
]
ADAPTIVE = ("dop853", "dopri5", "gauss", "radau")


def options(method: str) -> dict[str, object]:
    if method in ADAPTIVE:
        return {"method": method, "rtol": 1e-11 if method == "radau" else 1e-13}
    return {"method": method, "step": 0.02}


def with_kinks(text: str, chance: random.Random) -> str:
    """Adds forces with kinks and jumps, and an event after which the motion goes on otherwise."""
    start, k2 = (float(re.search(rf"{x} = (-?[\d.]+)", text)[1]) for x in ("start q0", "k2"))

    def beside(place: float, scale: float = 1.0) -> float:
        """The start is not so close to a jump that differences cross it."""
        return place + (0.05 if abs(start - scale * place) < 0.02 else 0)

    edge = beside(chance.uniform(-0.3, 0.3))
    text += f"force q0 = -{chance.uniform(0.5, 2):.3f}*k0*abs(q0 - {edge:.3f})\n"
    text += f"force q0 = 0.4*k1*step(q0 - {beside(chance.uniform(-0.5, 0.5), k2):.3f}*k2)\n"
    place = beside(chance.uniform(0.0, 0.4))
    then = "q0' = q0' - 0.3*k1, q0 = q0 + 0.02*k0*(1 + t)"
    return text + f"event bump: q0 + 0.2*sin(t)*k2 > {place:.3f} then {then}\n"


def separable(chance: random.Random) -> str:
    text = "model apart\nparam k0 = 1.2\nparam k1 = 0.7\nparam k2 = 0.9\ncoord q0, q1\ninput u0\n"
    text += f"kinetic k0*q0'^2 + 0.6*q1'^2 + {chance.uniform(0.1, 0.4):.3f}*k2*q0'*q1'\n"
    text += "potential k1*q0^4/4 + q1^2 + k2*sin(q0 + q1)\nforce q1 = u0*cos(2*t)*q0\n"
    text += f"start q0 = 0.5*k1\nstart q1 = {chance.uniform(-1, 1):.3f}\nstart q0' = 0.4\n"
    return text + "observe a = k1*q0*q1'^2 + u0\nobserve b = q0*exp(k2*q1/5)\n"


def bound(chance: random.Random) -> str:
    text = "model tied\nparam k0 = 1.2\nparam k1 = 0.7\nparam k2 = 1.1\ncoord x, y, z\ninput u0\n"
    text += "kinetic k0*(x'^2 + y'^2 + z'^2)/2 + k1*x*z'*y'/5\npotential k1*y + 0.3*z^2\n"
    text += "constraint rod: x^2 + y^2 + 0.1*z = k2^2\n"
    text += "rolling v: z' = 0.2*k1*x'\n" if chance.random() < 0.5 else ""
    text += "force x = u0*y\nstart x = k2\nstart y' = 0.3*k0\n"
    return text + "observe a = k1*x*y'\nobserve b = y + z\n"


def differences(model: package.api.model.Model, of: list[str], by: str, **how: object):
    """The derivatives of columns, at the middle and the end of a run, by differences of runs."""
    starts = dict(zip((*model.coordinates, *model.rates), model.start, strict=True))

    def values(x: float) -> numpy.ndarray:
        more: dict[str, object] = {}
        if by in model.params:
            model.params[by] = x
        else:
            more = {"start" if by in starts else "inputs": {by: x}}
        run = model.run(UNTIL, every=UNTIL / 2, **how, **more)
        model.params.update(kept)
        return numpy.array([run[name][1:] for name in of])

    kept = {by: model.params[by]} if by in model.params else {}
    return slope(values, kept.get(by, starts.get(by, 0.0)), 1.0, 1e-3)


def compared(model: package.api.model.Model, by: list[str], **how: object) -> None:
    of = ["a", "b", model.coordinates[0], "energy"]
    run = model.run(UNTIL, every=UNTIL / 2, sensitivity=by, **how)
    # A neighbour of a run with adaptive steps takes other steps, and crossings are rounded.
    close = 1e-9 if "step" in how else 1e-6 if how["method"] == "radau" else 2e-8
    close = max(close, 1e-8) if model.compilation.model.resetting else close
    for name in by:
        mine = numpy.array([run.sensitivity[column, name][1:] for column in of])
        theirs = differences(model, of, name, **how)
        assert mine == pytest.approx(theirs, rel=close, abs=close * max(1, abs(theirs).max())), (
            name,
            how,
        )
    for k, column in enumerate(of):
        back = model.gradient(column, by, until=UNTIL, every=UNTIL / 2, **how)
        forward = [run.sensitivity[column, name][-1] for name in by]
        assert [*back.values()] == pytest.approx(forward, rel=1e-9, abs=1e-9), k


@pytest.mark.parametrize("seed", seeds([0, 1, 2, 3], 100))
def test_random_models(seed: int, tmp_path: Path) -> None:
    chance = random.Random(seed)
    kind = seed % 4
    by = ["k0", "k1", "k2", "u0"]
    if kind == 0:
        text, methods = separable(chance), SEPARABLE
        by += ["q1", "q0'"]
    elif kind == 1:
        text = bound(chance)
        methods = ["rk4", "dop853", "gauss2", "gauss"] if "rolling" in text else TURNING
    else:
        text, _, _ = drawn(chance)
        methods = TURNING if "rotation" in text else FREE
        by += ["q0", "q0'", *(["s"] if "state s" in text else [])]
        if kind == 3:
            text = with_kinks(text, chance)
            methods = ["rk4", "dop853", "gauss4"]
    model = package.load(written(tmp_path, text))
    for method in chance.sample(methods, 2):
        compared(model, by, **options(method))


COUPLED = """
model coupled
param k0 = 1.2
param k1 = 0.7
coord x, y
input u0
state s
rate s = k1*x*y' - s
kinetic k0*x'^2/2 + (1 + x^2)*y'^2/2 + 0.3*cos(y)*x'*y'
potential k1*x^4/4 + cos(x - y)
force x = -0.2*x'*y'^2 + s*u0
force y = k0*sin(3*t)
start x = 0.5*k0
start y' = 0.4
observe a = k1*x*y'^2 + s
"""
BACKWARD = ["rk4", "dopri5", "gauss1", "gauss8", "lobatto4", "radau5", "radau9", "gauss", "radau"]


@pytest.mark.parametrize("method", BACKWARD)
def test_one_pass_for_all_names(method: str, tmp_path: Path) -> None:
    """The adjoint of a model with M(q), a state, drag and a force in t."""
    model = package.load(written(tmp_path, COUPLED))
    how = {"until": UNTIL, "every": UNTIL, **options(method)}
    run = model.run(**how, sensitivity=["k0", "k1", "u0", "x", "y'", "s"])
    tape, forward = run.sensitivity.tape, run.sensitivity
    for of in ("a", "s"):
        slope = tape.backward(at_end(tape, of))
        assert slope is not None
        for name in forward.by:
            mine = tape.started(name) @ slope
            assert mine == pytest.approx(forward[of, name][-1], rel=1e-11, abs=1e-11), name


# -- closed forms and errors -----------------------------------------------------------------------


def test_a_ball_that_bounces(tmp_path: Path) -> None:
    """After n bounces from h: t_n = t_1 (1 + 2 e + ... + 2 e^(n-1)), and so y and y' by h and e."""
    text = "model ball\nparam h = 2\nparam e = 0.8\nparam g = 9.81\ncoord y\nkinetic y'^2/2\n"
    text += "potential g*y\nstart y = h\nevent floor: y < 0 then y' = -e*y'\n"
    model = package.load(written(tmp_path, text))
    until, bounces = 3.0, 3

    def y(h: float, e: float) -> float:
        fall, up = math.sqrt(2 * h / 9.81), e**bounces * math.sqrt(2 * 9.81 * h)
        t = until - fall * (1 + 2 * sum(e**k for k in range(1, bounces)))
        assert 0 < t < 2 * up / 9.81
        return up * t - 9.81 * t * t / 2

    found = model.gradient("y", ["h", "e"], until=until, method="dop853", rtol=1e-12)
    assert found["h"] == pytest.approx((y(2 + 1e-5, 0.8) - y(2 - 1e-5, 0.8)) / 2e-5, rel=1e-8)
    assert found["e"] == pytest.approx((y(2, 0.8 + 1e-6) - y(2, 0.8 - 1e-6)) / 2e-6, rel=1e-8)


def test_the_range_of_a_throw(tmp_path: Path) -> None:
    """An event ends the run: x = 2 v w/g at t = 2 w/g."""
    text = "model thrown\nparam g = 9.81\ncoord x, y\nkinetic (x'^2 + y'^2)/2\npotential g*y\n"
    text += "start x' = 3\nstart y' = 5\nevent ground: y < 0 stop\nobserve late = x*t\n"
    model = package.load(written(tmp_path, text))
    by, how = ["g", "x'", "y'"], {"until": 5.0, "method": "rk4", "step": 0.01}
    of_x, of_t = (model.gradient(of, by, **how) for of in ("x", "t"))
    assert [*of_x.values()] == pytest.approx([-30 / 9.81**2, 10 / 9.81, 6 / 9.81], rel=1e-9)
    assert [*of_t.values()] == pytest.approx([-10 / 9.81**2, 0, 2 / 9.81], rel=1e-9)
    run = model.run(**how, sensitivity="g")
    assert run.sensitivity["x", "g"][-1] == pytest.approx(of_x["g"], rel=1e-12)
    late = -8 * 3 * 25 / 9.81**3  # x t = 4 v w^2/g^2
    assert run.sensitivity["late", "g"][-1] == pytest.approx(late, rel=1e-9)
    assert model.gradient("late", "g", **how)["g"] == pytest.approx(late, rel=1e-9)


def test_a_default_that_follows_another(tmp_path: Path) -> None:
    text = "model osc\nparam a = 2\nparam k = a^2\ncoord x\nkinetic x'^2/2\npotential k*x^2/2\n"
    text += "start x = 1/a\n"
    model = package.load(written(tmp_path, text))
    found = model.gradient("x", ["a", "k"], until=1.0, method="gauss", rtol=1e-12)
    c, s = math.cos(2), math.sin(2)  # x = cos(a t)/a at a = 2
    assert found["a"] == pytest.approx(-c / 4 - s / 2, abs=1e-10)
    assert found["k"] == pytest.approx(-s / 8, abs=1e-10)
    given = model.gradient("x", "a", until=1.0, start={"x": 0.5}, method="gauss", rtol=1e-12)
    assert given["a"] == pytest.approx(-s / 2, abs=1e-10)  # x = cos(a t)/2
    model.params["k"] = 4.0  # then it follows no longer
    assert model.gradient("x", "a", until=1.0, method="gauss")["a"] == pytest.approx(-c / 4)


def test_a_start_on_a_constraint(tmp_path: Path) -> None:
    """The length of a rod at rest, first in a piece of the run, displaces constraint and start."""
    text = "model rod\nparam l = 2\ncoord x, y\nkinetic (x'^2 + y'^2)/2\nconstraint c: "
    model = package.load(written(tmp_path, text + "x^2 + y^2 = l^2\nstart x = l\n"))
    how = {"until": 1.0, "every": 0.5, "method": "rk4", "step": 0.01}
    assert model.gradient("x", "l", **how)["l"] == pytest.approx(1)
    assert model.run(**how, sensitivity="l").sensitivity["x", "l"] == pytest.approx([1, 1, 1])


def test_no_derivative(tmp_path: Path) -> None:
    text = "model m\nparam p = 1\ncoord x\nkinetic x'^2/2\npotential -p*x\nstart x = -1\n"
    model = package.load(written(tmp_path, f"{text}event top: x > 9 then x' = -x'\n"))
    with pytest.raises(package.UsageError, match="by q: it has"):
        model.gradient("x", ["q"], until=1.0)
    with pytest.raises(package.UsageError, match="of z: it has"):
        model.gradient("z", ["p"], until=1.0)
    with pytest.raises(package.UsageError, match=r"inputs: u: run\(\) alone takes functions"):
        model.gradient("x", ["p"], until=1.0, inputs={"u": lambda t, q, v: 0.0})
    with pytest.raises(package.UsageError, match="inputs and controllers in Python"):
        model.run(1.0, controllers={"c": lambda t, q, v, u: {}}, sensitivity="p")
    with pytest.raises(package.UsageError, match="by=3: give a name"):
        model.gradient("x", 3, until=1.0)
    assert model.gradient("x", [], until=1.0) == {}
    with pytest.raises(package.UsageError, match="rows at events"):
        model.gradient("x", ["p"], until=1.0, at="top")


@pytest.mark.parametrize("method", ["exponential", "boris", "gsl_rkf45"])
def test_steps_by_a_jacobian(method: str, tmp_path: Path) -> None:
    """Steps of exponential and boris depend on the Jacobian itself, those of GSL on no table."""
    text = "model osc\nparam k = 1.3\nparam c = 0.3\nparam e = 0.8\ncoord x\nkinetic x'^2/2\n"
    text += "potential k*x^2/2\nstart x = 1\nobserve a = x\nobserve b = x'*k\n"
    text += "force x = -c*x'\nevent low: x < 0.2 then x' = -e*x'\n"
    model = package.load(written(tmp_path, text))
    how = {"rtol": 1e-12} if method == "gsl_rkf45" else {"step": 0.05}
    compared(model, ["k", "c", "e", "x"], method=method, **how)


@pytest.mark.parametrize("method", ["rk4", "verlet"])
def test_steps_that_shift_with_an_event(method: str, tmp_path: Path) -> None:
    """Long steps of a force in t shift after the event, but for the one that ends at a row."""
    text = "model kicked\nparam k = 3\nparam e = 0.8\ncoord x\nkinetic x'^2/2\npotential k*x^2/2\n"
    text += "force x = 2*cos(5*t)*x\nstart x = 1\nevent low: x < 0.6 then x' = -e*x'\n"
    model = package.load(written(tmp_path, text + "observe a = x*t\nobserve b = x'*k\n"))
    compared(model, ["k", "e"], method=method, step=0.2)


NOISY = """
model bath
param c = 0.3
param k = 2
coord x
kinetic x'^2/2
potential k*x^2/2 + x^4/4
force x = -c*x'
noise x = 0.2*c
start x = 1
observe a = x
observe b = x'*k
"""


@pytest.mark.parametrize("method", ["heun", "baoab"])
def test_noise_is_the_same(method: str, tmp_path: Path) -> None:
    model = package.load(written(tmp_path, NOISY))
    compared(model, ["c", "k"], **options(method), seed=3)


def test_multistep_methods_are_refused(tmp_path: Path) -> None:
    model = package.load(written(tmp_path, GRAZING.format(2)))
    with pytest.raises(package.UsageError, match="gsl_msadams has no derivatives"):
        model.gradient("x", "p", until=0.1, method="gsl_msadams")


GRAZING = """
model graze
param p = 2
coord x
kinetic x'^2/2
potential -x
start x = {}
start x' = -p
event low: x < 0 then x' = 0.5*x'
"""


def test_a_grazing_has_no_derivative(tmp_path: Path) -> None:
    model = package.load(written(tmp_path, GRAZING.format("p^2/2 - 1e-14")))
    with pytest.raises(package.RunError, match=r"at t = 1.99999\d* the motion grazes low"):
        model.gradient("x", "p", until=4.0, method="dop853", rtol=1e-12)


def test_events_at_one_time_have_no_derivative(tmp_path: Path) -> None:
    text = GRAZING.format("0.5") + "event other: x < 0 then x = x + 0.1\n"
    with pytest.raises(package.RunError, match="several events come at once"):
        package.load(written(tmp_path, text)).gradient("x", "p", until=2.0)


def test_a_contact_that_lasts_and_samples_are_refused() -> None:
    model = package.load(ROOT / "models/contact/box_on_incline.lag")
    with pytest.raises(package.RunError, match="a contact holds: derivatives pass impacts"):
        model.gradient("x", "m", until=0.1)
    model = package.load(ROOT / "models/controlled/sampled_kapitza.lag")
    with pytest.raises(package.ModelError, match="sample blocks have no derivatives"):
        model.gradient(model.coordinates[0], model.coordinates[0], until=0.1)


@pytest.mark.parametrize("method", ["dop853", "rk4", "verlet"])
def test_a_contact_that_bounces(method: str) -> None:
    """Thrown up from the floor with v; after the first bounce with e v, after the second e^2 v."""
    model = package.load(ROOT / "models/contact/bouncing_ball.lag")
    g, e, v, until = 9.81, 0.8, 5.0, 2.0
    t = until - 2 * v * (1 + e) / g  # since the second bounce; y = e^2 v t - g t^2/2
    of_t = e**2 * v - g * t
    exact = {
        "v": e**2 * t - of_t * 2 * (1 + e) / g,
        "e": 2 * e * v * t - of_t * 2 * v / g,
        "g": -(t**2) / 2 + of_t * 2 * v * (1 + e) / g**2,
        "m": 0.0,
    }
    how = {"rtol": 1e-12} if method == "dop853" else {"step": 0.01}
    found = model.gradient("y", [*exact], until=until, method=method, **how)
    assert found == pytest.approx(exact, rel=1e-8, abs=1e-9)


def test_a_pendulum_that_bounces() -> None:
    model = package.load(ROOT / "models/contact/bouncing_double_pendulum.lag")
    how = {"until": 1.0, "method": "dop853", "rtol": 1e-12}
    first, second = model.coordinates
    for name in ("l", "g"):
        x0 = model.params[name]

        def value(x: float, name: str = name, x0: float = x0) -> float:
            model.params[name] = x
            try:
                return model.run(**how)[second][-1]
            finally:
                model.params[name] = x0

        found = model.gradient(second, name, **how)[name]
        assert found == pytest.approx(slope(value, x0, 1.0, 1e-4), rel=1e-7), first


def test_inputs_that_events_set_are_moved_too(tmp_path: Path) -> None:
    """The energy lost in impacts is an input that they set: (1 - e^2) m v^2/2 after the first."""
    text = "model struck\nparam m = 1.2\nparam v = 5\nparam e = 0.8 in [0, 1]\ncoord y\n"
    text += "kinetic m/2*y'^2\npotential 9.81*m*y\nstart y' = v\n"
    text += "impact floor: y falling with restitution e\nobserve o = loss(floor)^2\n"
    model = package.load(written(tmp_path, text))
    lost = 0.36 * 1.2 * 25 / 2
    exact = {"m": 2 * lost**2 / 1.2, "v": 4 * lost**2 / 5, "e": -2 * lost * 1.6 * 1.2 * 25 / 2}
    for how in ({"method": "dop853", "rtol": 1e-12}, {"method": "rk4", "step": 0.01}):
        run = model.run(1.5, every=0.25, sensitivity=[*exact], **how)
        assert run.sensitivity.values("o") == pytest.approx(run["o"], rel=1e-12)
        assert model.gradient("o", [*exact], until=1.5, **how) == pytest.approx(exact, rel=1e-8)
        for name, slope_ in exact.items():
            found = run.sensitivity["o", name]
            assert not found[:5].any() and found[5:] == pytest.approx(slope_, rel=1e-8)
