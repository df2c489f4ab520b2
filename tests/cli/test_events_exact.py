"""Events of motions with a closed form, from rest at zero too, where a run has no scale but its
length: rows satisfy their event to rounding, and its time is that of the closed form."""

from __future__ import annotations

import math
import random
from functools import cache

import pytest

import pkgen
from conftest import ROOT, case, seeds

EPS = 2.0**-52
MODEL = case("events_exact_model")
EVENTS = {  # the function, and what of the motion is at `a`
    "x - a rising": "x",
    "x - a": "x",
    "x' - a": "v",
    "(x - a)*(b - x) rising": "x",
    "x^3 - a*x^2 rising": "x",
}
AT_REST = (
    "x^3 - a*x^2 rising",
)  # zero at the start: its scale is looked for in a motion from rest
ONCE = ("x - a rising", "x - a", "x' - a")

# Of length and time 1: the parameters and the start; x, x' and x'' at t.
MOTIONS = {
    "pushed": ({"f": 1}, {}, lambda t: (t * t / 2, t, 1)),
    "free": ({}, {"x'": 1}, lambda t: (t, 1, 0)),
    "thrown": ({"f": -0.1}, {"x'": 1}, lambda t: (t - t * t / 20, 1 - t / 10, -0.1)),
    "hung": ({"f": 1, "k": 1}, {}, lambda t: (1 - math.cos(t), math.sin(t), math.cos(t))),
    "braked": ({"c": 1}, {"x'": 1}, lambda t: (-math.expm1(-t), math.exp(-t), -math.exp(-t))),
    "dragged": (
        {"f": 1, "c": 1},
        {},
        lambda t: (t + math.expm1(-t), -math.expm1(-t), math.exp(-t)),
    ),
    "tipped": ({"k": -1}, {"x'": 1}, lambda t: (math.sinh(t), math.cosh(t), math.sinh(t))),
    "tipping": ({"f": 1, "k": -1}, {}, lambda t: (math.cosh(t) - 1, math.sinh(t), math.cosh(t))),
}
BY_TOLERANCE = "gauss dopri5 dop853 radau gsl_rkf45 gsl_rk8pd gsl_msadams gsl_msbdf gsl_bsimp"
BY_STEPS = """euler rk2 rk3 rk4 symplectic_euler verlet yoshida4 suzuki4 mclachlan4 blanes_moan4
yoshida6 kahan_li6 blanes_moan6 yoshida8 kahan_li8 gauss1 gauss2 gauss3 gauss4 gauss5 gauss6 gauss7
gauss8 lobatto2 lobatto3 lobatto4 radau5 radau9 exponential lie_midpoint lie_midpoint4 lie_midpoint6
rattle rattle4 rattle6 rkmk4 rkmk8 boris boris4 boris6"""
FIRST_ORDER = ("euler", "symplectic_euler")


@pytest.fixture(scope="module")
def load(tmp_path_factory):
    folder = tmp_path_factory.mktemp("exact")

    @cache
    def load(event: str):
        path = folder / f"{abs(hash(event))}.lag"
        path.write_text(MODEL % event, encoding="utf-8")
        return pkgen.load(path)

    return load


def run(load, seed: int) -> None:
    """A motion of some length and time, met at `tau` of its times, by a method, up to `span`."""
    draw = random.Random(seed)
    name, event = draw.choice(list(MOTIONS)), draw.choice(list(EVENTS))
    made_of, start, motion = MOTIONS[name]
    if (start and event in AT_REST) or (name == "free" and EVENTS[event] == "v"):
        event = "x - a"
    adaptive = draw.random() < 0.6
    method = draw.choice((BY_TOLERANCE if adaptive else BY_STEPS).split())
    length, time = 10.0 ** draw.uniform(-8, 8), 10.0 ** draw.uniform(-8, 8)
    tau, span = draw.uniform(0.2, 1.5), 10.0 ** draw.uniform(0.5, 15 if adaptive else 6)
    x, v, acceleration = motion(tau)
    of_x = EVENTS[event] == "x"
    wanted, rate = (x, v) if of_x else (v, acceleration)
    unit = length if of_x else length / time
    m = load(event)
    for key, of_one in (("f", length / time**2), ("c", 1 / time), ("k", 1 / time**2)):
        m.params[key] = made_of.get(key, 0) * of_one
    m.params["a"], m.params["b"] = wanted * unit, 4 * wanted * unit
    polynomial = name in ("pushed", "free") and event in ONCE and method not in FIRST_ORDER
    step = span * draw.random() if polynomial else 1 / 40
    own = method == "exponential"
    r = m.run(
        until=span * time,
        every=span * time,
        method=method,
        start={key: value * length / time for key, value in start.items()},
        **({"rtol": 1e-10} if adaptive else {} if own else {"step": step * time}),
    )
    said = (
        f"{seed}: {name}, {event}, {method}, times of {time:.3g}: {span:.3g}, length {length:.3g}"
    )
    assert len(r.events["there"]) == 1, said
    t, at = r.t[-1] / time, r["x" if of_x else "x'"][-1] / unit
    off = abs(at - wanted) / EPS
    assert off <= 128 * wanted + 8 * tau * abs(rate), f"{said}: off by {off:.3g} eps"
    inexact = not (adaptive or own or polynomial)
    allowed = 10 * step ** r.report["order"] if inexact else 1e-7 if adaptive else 0
    assert abs(t - tau) <= allowed + 1e-13, f"{said}: at {t}, not {tau}"


@pytest.mark.parametrize("seed", seeds(range(3), 597))
def test_rows_are_at_the_event(load, seed: int) -> None:
    run(load, seed)


@pytest.mark.parametrize("until", [1e3, 1e8, 1e12, 1e15])
@pytest.mark.parametrize("method", ["gauss", "gsl_rkf45"])
def test_the_first_step_spans_the_run(load, method: str, until: float) -> None:
    m = load("x - a")
    m.params.update(f=2, c=0, k=0, a=1)  # the model is shared
    r = m.run(until=until, every=until, method=method)
    assert r.t[-1] == pytest.approx(1, abs=1e-14)
    assert r["x"][-1] == pytest.approx(1, abs=1e-14)


@pytest.mark.parametrize("method", ["gauss", "dop853"])
def test_rounding_at_a_start_crosses_nothing(method: str) -> None:
    """r . v is 0 but for rounding at a pericentre: it falls through zero at the apocentre alone."""
    model = pkgen.load(ROOT / "models/particles/kepler_space.lag")
    rng = random.Random(1)
    for _ in range(20):
        for name in ("i", "Omega", "omega"):
            model.params[name] = rng.uniform(0, math.pi)
        model.params["e"] = e = rng.uniform(0.1, 0.8)
        found = model.run(1e5, method=method, rtol=1e-10).report["events"]
        (apogee,) = [x for x in found if x["name"] == "apogee"]
        half = math.pi * math.sqrt(26600e3**3 / 3.986004418e14)
        assert apogee["times"] == pytest.approx([half, 3 * half], rel=1e-6), e
