"""Inputs that are functions or tables, and motions step by step, beside closed forms: a damped or
sampled oscillator x'' = -w^2 x + u."""

from __future__ import annotations

import math
import random

import numpy
import pytest

import pkgen
from conftest import case, written

MODEL = case("python_inputs_driven")
SAMPLED = {
    "dop853": {"rtol": 1e-11}, "gauss": {"rtol": 1e-11}, "rk4": {"step": 0.001},
    "gauss4": {"step": 0.01}, "radau": {"rtol": 1e-10}, "yoshida8": {"step": 0.005},
}  # fmt: skip


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> pkgen.Model:
    path = tmp_path_factory.mktemp("inputs") / "driven.lag"
    path.write_text(MODEL, encoding="utf-8")
    return pkgen.load(path)


def sampled(w: float, a: float, b: float, hold: float, count: int) -> numpy.ndarray:
    """x at the samples, u = -a x - b x' held in between: exact rotations."""
    x, v, found = 1.0, 0.0, [1.0]
    cos, sin = math.cos(w * hold), math.sin(w * hold)
    for _ in range(count):
        middle = (-a * x - b * v) / w**2
        x, v = middle + (x - middle) * cos + v / w * sin, v * cos - (x - middle) * w * sin
        found.append(x)
    return numpy.array(found)


@pytest.mark.parametrize("method", [None, "dopri5", "rk4"])
def test_feedback_at_each_evaluation(model: pkgen.Model, method: str | None) -> None:
    rng = random.Random(f"feedback {method}")
    for _ in range(5):
        a, b = rng.uniform(0, 8), rng.uniform(0.1, 2)
        how = {"step": 0.001} if method == "rk4" else {"rtol": 1e-11}
        r = model.run(
            4,
            method=method,
            every=0.5,
            inputs={"u": lambda t, q, v, a=a, b=b: -a * q[0] - b * v[0]},
            **how,
        )
        w = math.sqrt(4 + a - b * b / 4)
        exact = numpy.exp(-b / 2 * r.t) * (numpy.cos(w * r.t) + b / 2 / w * numpy.sin(w * r.t))
        assert numpy.abs(r["x"] - exact).max() < 1e-9
        assert numpy.abs(r["pushed"] + a * r["x"] + b * r["x'"]).max() < 1e-14
        assert r.report["method"] == (method or "dop853")


@pytest.mark.parametrize("method", SAMPLED)
def test_feedback_held_between_samples(model: pkgen.Model, method: str) -> None:
    rng = random.Random(f"held {method}")
    for _ in range(3):
        a, b, hold = rng.uniform(0, 8), rng.uniform(0, 2), rng.choice([0.1, 0.05, 0.2])
        times: list[float] = []

        def law(t, q, v, a=a, b=b, times=times):
            times.append(t)
            return -a * q[0] - b * v[0]

        r = model.run(4, method=method, every=hold, inputs={"u": law}, hold=hold, **SAMPLED[method])
        count = round(4 / hold)
        assert numpy.abs(r["x"] - sampled(2, a, b, hold, count)).max() < 1e-8
        assert times == pytest.approx([k * hold for k in range(count)], abs=1e-12)


def test_an_integrator_goes_on_with_inputs_of_each_call(model: pkgen.Model) -> None:
    it = model.integrator("dop853", rtol=1e-11)
    found = [it.q[0]]
    for k in range(40):
        it.u[0] = -3 * it.q[0] - it.v[0]
        it.to((k + 1) * 0.1)
        found.append(it.q[0])
    assert numpy.abs(found - sampled(2, 3, 1, 0.1, 40)).max() < 1e-9
    assert it.t == pytest.approx(4, abs=1e-15)


def test_an_integrator_steps(model: pkgen.Model) -> None:
    it = model.integrator("verlet", step=0.01)
    it.step()
    assert it.t == 0.01 and it.q[0] == pytest.approx(1 - 4 * 0.01**2 / 2, rel=1e-15)
    it.step(0.015)
    assert it.t == 0.015
    it = model.integrator(start={"x": "-99.9", "x'": "-200"}, rtol=1e-10)
    it.to(1)
    assert it.stopped and it.q[0] == pytest.approx(-100, abs=1e-9)


@pytest.mark.parametrize("method", ["dop853", "gauss", "verlet"])
def test_tables_are_joined_by_lines(model: pkgen.Model, method: str) -> None:
    """Beside a function of as many lines."""
    how = {"step": 1e-4} if method == "verlet" else {"rtol": 1e-11}
    knots, values = numpy.array([[0, 1.0, 2.5, 4.0], [0, 2.0, -1.0, 1.0]])
    r = model.run(4, method=method, every=0.25, inputs={"u": (knots, values)}, **how)
    lines = {"u": lambda t, q, v: numpy.interp(t, knots, values)}
    exact = model.run(4, method="dop853", every=0.25, inputs=lines, linear=0.5, rtol=1e-12)
    assert numpy.abs(r["x"] - exact["x"]).max() < (1e-7 if method == "verlet" else 1e-8)
    assert numpy.ptp(r["x"]) > 1


def test_tables_and_functions_hold_or_join(model: pkgen.Model) -> None:
    t = numpy.linspace(0, 2, 21)

    def end(u: object, **how: float) -> float:
        return model.run(2, inputs={"u": u}, rtol=1e-10, **how)["x"][-1]

    def sine(t, q, v):
        return math.sin(t)

    held, joined = end(sine, hold=0.1), end(sine, linear=0.1)
    assert abs(end((t, numpy.sin(t), "hold")) - held) < 1e-8
    assert abs(end((t, numpy.sin(t))) - joined) < 1e-8 < abs(joined - held)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"inputs": {"u": lambda t, q, v: 1}, "method": "gauss"}, "explicit methods"),
        ({"inputs": {"u": ([0, 1], [1, 2])}}, "from 0 to 1, the run from 0 to 4"),
        ({"inputs": {"u": ([0, 5], [1])}}, "times in order, and as many values"),
        ({"inputs": {"u": ([0, 2, 1, 5], [1, 1, 1, 1])}}, "times in order"),
        ({"inputs": {"u": ([0, 5], [1, 1], "cubic")}}, "kind one of"),
        ({"inputs": {"u": lambda t, q, v: 1}, "hold": 0.1, "method": "rk4", "step": 0.03}, "whole"),
        (
            {"inputs": {"u": ([0, 1.5, 5], [1, 1, 1], "hold")}, "method": "rk4", "step": 0.4},
            "whole",
        ),
        ({"hold": 0.1}, "a time between samples"),
        ({"inputs": {"u": lambda t, q, v: 1}, "hold": "0.1 [s]"}, "hold='0.1 .s.': give a number"),
        ({"inputs": {"u": lambda t, q, v: 1}, "linear": 1e-12}, "more than 10,000,000 samples"),
        ({"inputs": {"u": lambda t, q, v: 1}, "hold": 0.1, "linear": 0.2}, "one of them"),
        ({"inputs": {"u": lambda t, q, v: 1}, "hold": -1}, "a time between samples"),
        ({"inputs": {"push": lambda t, q, v: 1}}, "no such input; it has: u"),
        ({"inputs": {"u": [1, 2]}}, "inputs="),
    ],
)
def test_refusals(model: pkgen.Model, given: dict, said: str) -> None:
    with pytest.raises(pkgen.UsageError, match=said):
        model.run(4, **given)


def test_errors_of_a_function_end_the_run(model: pkgen.Model) -> None:
    with pytest.raises(ZeroDivisionError):
        model.run(4, inputs={"u": lambda t, q, v: 1 / 0})
    with pytest.raises(ValueError, match="'a'"):
        model.run(4, inputs={"u": lambda t, q, v: "a"})
    with pytest.raises(pkgen.RunError, match="finite"):
        model.run(4, inputs={"u": lambda t, q, v: math.nan})
    with pytest.raises(pkgen.UsageError, match="step="):
        model.integrator("verlet")


def test_inputs_of_each_kind_together(tmp_path) -> None:
    """x' = a + b + c of a held table, a joined one and a constant: x is a sum of areas."""
    path = written(
        tmp_path,
        "model sum\ninput a\ninput b\ninput c\ncoord y\nstate x\nkinetic y'^2/2\n"
        "rate x = a + b + c\nstart x = 0\n",
    )
    model = pkgen.load(path)
    rng = numpy.random.default_rng(3)
    for method in ("dop853", "gauss", "radau"):
        t = numpy.unique(numpy.concatenate([[0, 3], rng.uniform(0, 3, 9)]))
        held, joined, c = rng.normal(size=len(t)), rng.normal(size=len(t)), rng.normal()
        r = model.run(
            3, method=method, rtol=1e-11, inputs={"a": (t, held, "hold"), "b": (t, joined), "c": c}
        )
        areas = (held[:-1] + (joined[1:] + joined[:-1]) / 2 + c) * numpy.diff(t)
        assert r["x"][-1] == pytest.approx(areas.sum(), abs=1e-9)


def test_a_result_is_drawn(model: pkgen.Model) -> None:
    r = model.run(10, every=0.02)
    assert len(r.plot("x", "pushed").axes) == 1 and r.plot("x", "x'", kind="phase").axes
    with pytest.raises(pkgen.UsageError, match="names: foo"):
        r.plot("foo")
    with pytest.raises(pkgen.UsageError, match="name columns"):
        r.plot(kind="spectrum")
    with pytest.raises(pkgen.UsageError, match="phase, path"):
        r.plot(kind="pie")
