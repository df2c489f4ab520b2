"""Orbits of step maps that close: ghosts, cycles, motions in step with a driver."""

from __future__ import annotations

import math
import random
from pathlib import Path

import numpy
import pytest
from scipy.integrate import quad, solve_ivp
from stability_asker import PENDULUM, asker, mapped, start

from conftest import case, seeds
from pkgen.analysis.stability import cycles, ghosts
from pkgen.compiler import compile_model
from pkgen.front.read import from_text

LOGISTIC = case("stability_orbits_logistic")


@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_ghosts_of_the_logistic_map(seed: int) -> None:
    """Whatever the units, Euler's 2-cycle is where its square has it, and rk2 rests at 2/h."""
    draw = random.Random(seed)
    d, tau = (10 ** draw.uniform(-6, 6) if seed else 1.0 for _ in range(2))
    y = draw.uniform(2.05, 2.4) if seed else 2.3
    model = asker(LOGISTIC.format(size=d, time=tau), until=20 * tau)
    asked = {"h": y * tau, "first": 1, "count": 2, "tries": 24}

    found = model.orbits(method="euler", **asked)
    (two,) = (o for o in found if not o.rests)
    root = math.sqrt(y * y - 4)
    closed_form = [(y + 2 - root) / (2 * y), (y + 2 + root) / (2 * y)]
    assert sorted(x for _, x in two.states) == pytest.approx([x * d for x in closed_form], rel=1e-9)
    slope = math.prod(1 + y * (1 - 2 * x) for x in closed_form)
    assert two.multipliers == (pytest.approx(slope, abs=1e-7),)
    if not seed:
        assert closed_form == pytest.approx([0.687874, 1.181692], abs=5e-7)
    rest = sorted(o.states[0][1] for o in found if o.rests)
    assert rest == pytest.approx([0, d], rel=1e-9, abs=1e-9 * d)

    places = sorted(o.states[0][1] for o in model.orbits(method="rk2", **asked) if o.steps == 1)
    assert places == pytest.approx([0, 2 / y * d, d, (1 + 2 / y) * d], rel=1e-8, abs=1e-9 * d)


@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_two_cycles_of_random_polynomials(seed: int) -> None:
    """All that Euler's method makes of a cubic, against their roots; of three models in 20 the
    search misses some, as it says it may."""
    draw = random.Random(seed)
    a, b, h = draw.uniform(0.5, 2), draw.uniform(-0.5, 0.5), draw.uniform(0.9, 1.6)
    model = asker(f"model c\nstate x\nrate x = {a}*x + {b}*x^2 - x^3\nstart x = 0.3\n", until=30)
    step = numpy.polynomial.Polynomial([0, 1 + h * a, h * b, -h])
    roots = (step(step) - numpy.polynomial.Polynomial([0, 1])).roots()
    found = model.orbits(method="euler", h=h, first=1, count=2, tries=60)
    seen = [state[1] for o in found for state in o.states[: o.steps]]
    own = {min(range(9), key=lambda k, x=x: abs(roots[k] - x)) for x in seen}
    assert len(own) == len(seen) > 1
    assert all(min(abs(roots - x)) < 1e-6 for x in seen)
    if seed < 3:
        assert len(seen) == sum(abs(roots.imag) < 1e-9)
    fixed = sum(abs(step(x) - x) < 1e-6 for x in seen)
    assert sum(o.steps == 1 for o in found) == fixed == sum(o.rests for o in found)


def test_ghosts_are_found_over_steps_and_stay() -> None:
    model = asker(LOGISTIC.format(size=1, time=1), until=20)
    hs = [3.0 * (k + 1) / 24 for k in range(24)]
    (one,) = (g for g in ghosts.ghosts(model, "euler", hs) if g.holds)
    assert one.steps == 2 and one.stays
    # It attracts from h = 2 to sqrt(6), where it doubles again.
    assert all(2 < o.h < math.sqrt(6) for o in one.orbits)
    assert [o.h for o in one.orbits] == [h for h in hs if 2 < h < math.sqrt(6)]
    assert ghosts.ghosts(model, "gauss1", hs) == []  # the midpoint rule is regular


def test_a_step_resonance_of_the_pendulum_is_a_ghost() -> None:
    """Verlet's pendulum is the standard map: q = pi/2 +- a, there and back, with
    h^2 cos a = 2 (a - pi/2) and so on; Newton must find what its own equation says."""
    h = 2.2
    found = start(asker(PENDULUM), 0.5).orbits(method="verlet", h=h, first=2, count=2, tries=16)
    assert any(not o.rests for o in found)
    for o in found:
        (q, v), (r, w) = o.states[:2]
        half = v - h / 2 * math.sin(q)
        assert q + h * half - r == pytest.approx(
            2 * math.pi * round((q + h * half - r) / 6.28), abs=1e-7
        )
        assert half - h / 2 * math.sin(r) == pytest.approx(w, abs=1e-7)


MATHIEU = case("stability_orbits_mathieu")


@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_multipliers_of_mathieu_at_rest(seed: int) -> None:
    """Verlet's, in closed form: a product of kicks and drifts. The trace is what they are told
    from, whatever the size of the motion that is the unit."""
    draw = random.Random(seed)
    w, e, rate = draw.uniform(0.5, 2), draw.uniform(0.1, 1), draw.uniform(0.5, 3)
    begin = 10 ** draw.uniform(-9, 9)
    model = asker(MATHIEU.format(w=w, e=e, rate=rate, start=begin), until=50)
    m = draw.randint(5, 40)
    h = 2 * math.pi / rate / m

    def kick(k: int) -> numpy.ndarray:
        return numpy.array([[1, 0], [-h / 2 * (w * w + e * math.cos(rate * k * h)), 1]])

    product = numpy.eye(2)
    for k in range(m):
        product = kick(k + 1) @ numpy.array([[1, h], [0, 1]]) @ kick(k) @ product
    (found,) = model.orbits(method="verlet", h=h, count=m)
    assert abs(found.states[0][0]) < 1e-6 * begin and not found.rests
    assert sum(found.multipliers).real == pytest.approx(numpy.trace(product), abs=1e-7)
    assert model.orbits(method="verlet", h=1.01 * h, count=m) is None


def test_a_driven_method_loses_its_orbit_where_predicted() -> None:
    slow = asker(MATHIEU.format(w=1.3, e=0.4, rate=0.2, start=0.1), until=100)
    cycle = cycles.find(slow, 10 * math.pi)
    assert cycle is not None and cycle.stays and not cycle.damped
    lost = cycles.lost(slow, "verlet", cycle)
    # Locally 2/omega is between 2/sqrt(w^2 + e) and 2/w.
    assert 1.35 < lost.h < 2 / 1.3 and lost.sharp
    assert lost.measured == pytest.approx(lost.h, rel=0.01)
    assert cycles.lost(slow, "gauss1", cycle).h is None


DUFFING = case("stability_orbits_duffing")


@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_a_damped_driven_oscillator_is_kept_as_long_as_damping_outweighs(seed: int) -> None:
    """Euler's method drives an oscillation by h omega^2/2, damping takes c: small motions are
    lost at h = 2 c/omega^2; of larger ones the two predictions must agree."""
    draw = random.Random(seed)
    rate, c, f = draw.uniform(0.6, 1.4), draw.uniform(0.05, 0.2), draw.uniform(0.001, 0.3)
    model = asker(DUFFING.format(f=f, rate=rate, c=c), until=300)
    cycle = cycles.find(model, 2 * math.pi / rate)
    lost = cycles.lost(model, "euler", cycle)
    assert lost.sharp and "torus" in lost.how
    assert lost.measured == pytest.approx(lost.h, rel=0.01)
    if f < 0.01:
        assert lost.h == pytest.approx(4 * c, rel=0.05)


VAN_DER_POL = case("v")
OSCILLATOR = (
    "model v\ncoord x\nkinetic x'^2/2\npotential x^2/2\nforce x = (1 - x^2)*x'\nstart x = 0.5\n"
)


@pytest.mark.parametrize("text", [VAN_DER_POL, OSCILLATOR], ids=["states", "coordinate"])
def test_the_cycle_of_van_der_pol(text: str) -> None:
    cycle = cycles.find(asker(text, until=60), None)
    assert cycle.period == pytest.approx(6.6632868593231, rel=1e-9)
    assert cycle.trivial == 1 and not cycle.driven and cycle.stays
    x, y = cycle.orbit.states[0][-2:] if "state" in text else cycle.orbit.states[0]
    # Liouville: the product of the multipliers is exp of the trace's integral.
    slopes = lambda t, z: [z[1], (1 - z[0] ** 2) * z[1] - z[0], 1 - z[0] ** 2]  # noqa: E731
    area = solve_ivp(slopes, (0, cycle.period), (x, y, 0), rtol=1e-8).y[2, -1]
    assert math.log(abs(cycle.orbit.beyond(1))) == pytest.approx(area, abs=1e-2)


def test_what_goes_round_returns() -> None:
    """Angles by whole turns, cyclic ones anyhow: a pendulum that rotates, an orbit's radius."""
    turning = start(asker(PENDULUM, until=20), 0.0, 3.0)
    cycle = cycles.find(turning, None)
    period = quad(lambda a: 1 / math.sqrt(3.0**2 - 2 + 2 * math.cos(a)), 0, 2 * math.pi)[0]
    # One orbit of a family: that of an energy close by.
    assert cycle.period == pytest.approx(period, rel=2e-4)
    kepler = asker(
        "model k\ncoord r, phi\nkinetic (r'^2 + r^2*phi'^2)/2\npotential -1/r\n"
        "start r = 1, phi' = 1.2\n",
        until=60,
    )
    half_axis = 1 / (2 - 1.2**2)
    assert cycles.find(kepler, None).period == pytest.approx(2 * math.pi * half_axis**1.5, rel=1e-4)


@pytest.mark.parametrize(
    ("force", "period"),
    [
        ("cos(3*t)", 2 * math.pi / 3),
        ("sin(2*t) + cos(3*t + 1)", 2 * math.pi),
        ("a*sin(w*t)^2", math.pi / 1.5),
        ("cos(t)*sin(sqrt(2)*t)", None),
        ("t", None),
        ("x", None),
    ],
)
def test_the_period_of_a_driver(force: str, period: float | None) -> None:
    text = (
        "model d\nparam a = 2\nparam w = 1.5\ncoord x\nkinetic x'^2/2\n"
        f"potential x^2/2\nforce x = {force}\nstart x = 1\n"
    )
    made = compile_model(from_text("model.lag", text), unroll=None)
    found = cycles.driven_period(made.equations, (2.0, 1.5))
    if period is None:
        assert found is None
    else:  # a square may have half of it
        assert found in (pytest.approx(period), pytest.approx(2 * period))


def test_ghosts_stand_in_the_map(tmp_path: Path) -> None:
    """Euler's 2-cycle at h = 2.3, and rk2's fixed point 2/h at h = 2.5."""
    asked = "--methods", "euler,rk2", "--steps", "2.3..2.5", "--points", "2x2"
    made = mapped(tmp_path, LOGISTIC.format(size=1, time=1), *asked)

    def places(method: str, h: float) -> list[float]:
        return sorted(
            round(state[1], 6)
            for ghost in made["ghosts"]
            if ghost["method"] == method and ghost["stays"]
            for orbit in ghost["orbits"]
            if orbit["h"] == h
            for state in orbit["states"]
        )

    assert places("euler", 2.3) == [0.687874, 1.181692]
    assert places("rk2", 2.5) == [0.8]
    assert "ghost that repels" in (tmp_path / "logistic_stability.svg").read_text()
    made = mapped(tmp_path, LOGISTIC.format(size=1, time=1), "--methods", "gauss1")
    assert made["ghosts"] == []


def test_a_driven_map_predicts_the_loss_of_its_orbit(tmp_path: Path) -> None:
    text = DUFFING.format(f=0.3, rate=1.2, c=0.1)
    made = mapped(tmp_path, text, "--methods", "rk2,gauss2", "--points", "4x2")
    assert made["cycle"]["driven"]
    assert made["cycle"]["period"] == pytest.approx(2 * math.pi / 1.2, rel=1e-12)
    (one,) = (p for p in made["predictions"] if p["method"] == "rk2")
    assert one["kind"] == "cycle" and one["sharp"]
    assert one["measured"] == pytest.approx(one["h"], rel=0.01)


def test_a_period_may_be_given(tmp_path: Path) -> None:
    """As a multiple of that of its sines; one that the equations have not is no cycle."""
    text = (
        "model d\ncoord x\nkinetic x'^2/2\npotential x^2/2\n"
        "force x = 0.1*sin(1.3*t) - 0.2*x'\nstart x = 0.5\n"
    )
    period = 2 * math.pi / 1.3
    asked = "--methods", "rk2", "--points", "4x2", "--period", f"{2 * period!r}"
    made = mapped(tmp_path, text, *asked)
    assert made["cycle"]["period"] == pytest.approx(2 * period, rel=1e-12)
    asked = "--methods", "rk2", "--points", "4x2", "--period", f"{1.1 * period!r}"
    assert mapped(tmp_path, text, *asked)["cycle"] is None
