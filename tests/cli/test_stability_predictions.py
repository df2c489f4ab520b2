"""What `pkgen stability` predicts and measures: closed forms, classes, limits, misses."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from stability_asker import PENDULUM, asker
from test_stability_modes import MEMS, PLANE

from conftest import ROOT, case
from pkgen.analysis.chart.chart import methods
from pkgen.analysis.stability import measure, misses, plan
from pkgen.analysis.stability.ask import Asker
from pkgen.analysis.stability.method import StepMap
from pkgen.analysis.stability.near import Close
from pkgen.analysis.stability.predict import Prediction, limit, predictions

# lambda = -c +- i sqrt(w^2 - c^2)
DAMPED = case("stability_predictions_damped")

# Resonance N3 of the elastic pendulum, in Cartesian coordinates: the spring's length at rest is 1,
# the swing's frequency 1, the stretch's 1.9.
ELASTIC = case("elastic")


@pytest.fixture(scope="module")
def pendulum() -> Asker:
    return asker(PENDULUM)


@pytest.fixture(scope="module")
def steps(pendulum: Asker) -> dict[str, StepMap]:
    return {m.name: StepMap(m, pendulum) for m in methods(None) if m.fixed}


@pytest.mark.parametrize(
    ("method", "closed"),
    [
        ("verlet", 2.0),
        ("symplectic_euler", 2.0),
        ("yoshida4", 1.5734019474),
        ("rk4", 2 * math.sqrt(2)),
        ("euler", 0.0),
        ("gauss1", None),
        ("gauss3", None),
    ],
)
def test_limits_of_methods(steps, method: str, closed: float | None) -> None:
    """From the table, and from steps on the oscillator where there is none."""
    step = steps[method]
    untold = StepMap(replace(step.traits, imaginary=None), step.asker)
    for found in (step.limit(0.0), untold.limit(0.0)):
        assert found == (closed if closed is None else pytest.approx(closed, rel=1e-9, abs=1e-9))


def test_a_damped_oscillator_has_a_limit_of_its_own(steps) -> None:
    # Critical damping is RK4 on the negative real axis: its limit there.
    assert steps["rk4"].limit(1.0) == pytest.approx(2.7852935634, rel=1e-4)
    assert steps["rk4"].limit(0.0) != pytest.approx(2.7852935634, rel=1e-2)


def test_the_angle_of_a_step(steps) -> None:
    # Verlet turns by 2 asin(y/2), the midpoint rule by 2 atan(y/2); RK4 damps, nothing resonates.
    third, quarter = 2 * math.pi / 3, math.pi / 2
    assert steps["verlet"].resonance(third) == pytest.approx(math.sqrt(3), rel=1e-11)
    assert steps["verlet"].resonance(quarter) == pytest.approx(math.sqrt(2), rel=1e-11)
    assert steps["gauss1"].resonance(third) == pytest.approx(2 * math.sqrt(3), rel=1e-11)
    assert steps["gauss1"].resonance(quarter) == pytest.approx(2, rel=1e-11)
    assert steps["rk4"].resonance(third) is None


def test_the_pole_of_an_implicit_step(steps) -> None:
    # Of Pade's denominators: 2; complex ones alone; 4.6443707.
    assert steps["gauss1"].pole() == pytest.approx(2, rel=1e-6)
    assert steps["gauss2"].pole() is None
    assert steps["gauss3"].pole() == pytest.approx(4.6443707, rel=1e-6)
    assert steps["verlet"].pole() is None


def test_resonances_between_two_modes(steps) -> None:
    # N3: h = .6244998 at a ratio of 1.9, by ratio = 2 sqrt(1 - (h/2)^2).
    h = 2 * math.sqrt(1 - (1.9 / 2) ** 2)
    assert h == pytest.approx(0.6244998, abs=5e-8)
    assert steps["verlet"].pair("1:2", 1.9) == pytest.approx(1.9 * h, rel=1e-10)
    assert steps["verlet"].pair("1:2", 2.0) is None
    # Midpoint, ratio 2: atan(y/2) + 2 atan(y/4) = pi where y^2 = 32.
    assert steps["gauss1"].pair("1+2", 2.0) == pytest.approx(math.sqrt(32), rel=1e-10)


def test_the_limit_of_a_damped_system(steps) -> None:
    at = asker(DAMPED).rest().equilibria[0]
    # |R(z)| = 1 on the ray of lambda.
    h = limit(steps["rk4"], 0, at).h
    z = h * complex(at.modes[0].growth, at.modes[0].frequency)
    assert abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24) == pytest.approx(1, abs=1e-8)
    assert h * 1.7 != pytest.approx(2 * math.sqrt(2), rel=1e-2)


def test_small_motions_are_small_beside_what_is_small(steps) -> None:
    mems = asker(MEMS)
    rest = mems.rest()
    amplitude = measure.small(rest, frozenset(), 2e-7)
    one = limit(steps["verlet"], 1, rest.equilibria[1])
    measured = measure.measured(mems, rest, one, 2e-7, amplitude)
    assert measured.h == pytest.approx(math.sqrt(2) * 1e-6, rel=1e-4)
    (growth,) = measure.growths(mems, rest, amplitude)
    assert growth.measured == pytest.approx(1e6, rel=1e-6)
    assert measure.small(rest, frozenset(), 0.0) == pytest.approx(1e-12)


def test_modes_that_are_not_found_decide_nothing(pendulum: Asker) -> None:
    failed = replace(pendulum.rest().equilibria[0], status="PK_NO_CONVERGENCE", modes=())
    assert failed.verdict == "modes: PK_NO_CONVERGENCE" and not failed.stable


@pytest.mark.parametrize("potential", ["x^4/4", "-x^4/4", "x^3/3", "x^10"])
def test_what_is_degenerate_alone_is_not_decided(steps, potential: str) -> None:
    found = asker(f"model d\ncoord x\nkinetic x'^2/2\npotential {potential}\nstart x = 1\n").rest()
    assert [e.verdict for e in found.equilibria] == ["not decided by the linear terms"]
    for method in ("verlet", "gauss1"):
        assert predictions(steps[method], found, 0) == []


def test_a_mode_is_decided_beside_one_that_is_not(steps) -> None:
    # No step is long for y^4/4 at rest, but x has its limit.
    at = asker(PLANE.format("2*x^2 + y^4/4", "y = 1")).rest().equilibria[0]
    assert limit(steps["verlet"], 0, at).h == pytest.approx(1, rel=1e-12)


def test_a_slow_growth_beside_a_fast_one_is_measured() -> None:
    saddle = asker(
        "model s\ncoord x, y\nkinetic (x'^2 + y'^2)/2\n"
        "potential -(400*(3*x+y)^2 + (x-3*y)^2)/20 + (x^4+y^4)/4\nstart x = 0.1\n"
    )
    rest = saddle.rest()
    top = next(e for e, at in enumerate(rest.equilibria) if at.energy == 0)
    found = [g.measured for g in measure.growths(saddle, rest, 1e-6) if g.equilibrium == top]
    assert found == [pytest.approx(20, rel=1e-3), pytest.approx(1, rel=1e-3)]


def test_motions_near_an_equilibrium_seek_none(pendulum: Asker, steps, monkeypatch) -> None:
    rest = pendulum.rest()
    asked = []
    for name in ("near", "leave", "rest"):
        real = getattr(Asker, name)
        monkeypatch.setattr(
            Asker, name, lambda *a, n=name, r=real, **k: (asked.append(n), r(*a, **k))[1]
        )
    for p in predictions(steps["verlet"], rest, 0):
        measure.measured(pendulum, rest, p, 0.5, 1e-6, measure.QUICK)
    measure.growths(pendulum, rest, 1e-6)
    assert set(asked) == {"near", "leave"}


def test_angles_count_by_the_shorter_way(pendulum: Asker) -> None:
    rest = pendulum.rest()
    turned = (6 * math.pi + 0.001,)
    at = plan.beside(rest, 0, turned, frozenset())
    assert at.q == (pytest.approx(6 * math.pi, abs=1e-9),)
    both = replace(rest, equilibria=(replace(rest.equilibria[0], q=(1.5,)), rest.equilibria[0]))
    assert plan.nearest(both, turned, frozenset()) == 1
    mems = asker(MEMS).rest()
    assert mems.turns == (False,) and rest.turns == (True,)
    assert plan.beside(mems, 0, (50.0,), frozenset()).q == mems.equilibria[0].q


def test_a_quick_map_measures_with_less(pendulum: Asker, steps, monkeypatch) -> None:
    rest = pendulum.rest()
    third = next(p for p in predictions(steps["verlet"], rest, 0) if p.kind == "1:3")
    asked, near = [0], Asker.near

    def counted(self: Asker, **question: object) -> Close:
        asked[0] += int(question["count"])
        return near(self, **question)

    monkeypatch.setattr(Asker, "near", counted)
    found = []
    for effort in (measure.FULL, measure.QUICK):
        asked[0] = 0
        one = measure.measured(pendulum, rest, third, 0.5, 1e-6, effort)
        assert one.h == pytest.approx(third.h, rel=1e-4) and one.response is not None
        found.append(asked[0])
    assert found[1] < found[0] / 3


def test_relative_equilibria_of_a_top() -> None:
    # Steady precession at the start's momenta; omega from the effective potential.
    top = asker((ROOT / "models/heavy_top.lag").read_text())
    at = next(e for e in top.rest().equilibria if e.q[1] > 0)
    i1, i3, mgl, theta0, phi, psi = 1.0, 0.5, 9.81, 0.6, 0.4, 18.0
    axis = i3 * (psi + phi * math.cos(theta0))
    vertical = i1 * phi * math.sin(theta0) ** 2 + axis * math.cos(theta0)

    def potential(x: float) -> float:
        turning = vertical - axis * math.cos(x)
        return turning**2 / (2 * i1 * math.sin(x) ** 2) + mgl * math.cos(x)

    d, x = 1e-4, at.q[1]
    assert abs(potential(x + d) - potential(x - d)) / (2 * d) < 1e-6
    second = (potential(x + d) - 2 * potential(x) + potential(x - d)) / d**2
    assert at.modes[0].frequency == pytest.approx(math.sqrt(second / i1), rel=1e-5)
    assert len(at.modes) == 1 and at.v[1] == 0


def test_predictions_are_measured_and_a_wrong_one_is_a_miss(pendulum: Asker, steps) -> None:
    rest = pendulum.rest()
    found = {p.kind: p for p in predictions(steps["verlet"], rest, 0)}
    assert set(found) == {"limit", "1:3", "1:4"}
    for p in found.values():
        measured = measure.measured(pendulum, rest, p, 0.5, 1e-6)
        assert measured.h == pytest.approx(p.h, rel=1e-4)
        assert misses.of_prediction(measured) is None
    wrong = replace(found["limit"], h=1.05 * found["limit"].h)
    miss = misses.of_prediction(measure.measured(pendulum, rest, wrong, 0.5, 1e-6))
    assert miss is not None and "-4.8 %" in miss.text and "h = 2.1" in miss.text
    never = Prediction("limit", "verlet", 0, 0, None, None, None)
    miss = misses.of_prediction(measure.measured(pendulum, rest, never, 0.5, 1e-6))
    assert miss is not None and "predicted nowhere" in miss.text
    (branch,) = (p for p in predictions(steps["gauss1"], rest, 0) if p.kind == "branch")
    lost = measure.measured(pendulum, rest, branch, 0.5, 1e-6)
    assert lost.h == pytest.approx(2, rel=1e-3) and lost.how == "PK_AMBIGUOUS_STEP"
    assert misses.of_prediction(lost) is None
    growths = measure.growths(pendulum, rest, 1e-6)
    assert [g.measured for g in growths] == [pytest.approx(1, rel=1e-6)]
    assert misses.of_growth(growths[0]) is None
    assert misses.of_growth(replace(growths[0], predicted=1.02)) is not None


def test_the_resonance_of_two_modes_is_found_and_answered(steps) -> None:
    # N3: the stretch drives the swing at h = .6244998, and nowhere beside it.
    elastic = asker(ELASTIC)
    rest = elastic.rest()
    primary = plan.nearest(rest, elastic.motion().q, frozenset())
    at = rest.equilibria[primary]
    assert [m.frequency for m in at.modes] == pytest.approx([1.9, 1.0], rel=1e-9)
    pair = next(p for p in predictions(steps["verlet"], rest, primary) if p.kind == "1:2")
    assert pair.h == pytest.approx(0.6244998, abs=5e-8)
    measured = measure.measured(elastic, rest, pair, 0.1, 1e-6)
    assert measured.h == pytest.approx(pair.h, rel=1e-4)
    assert measured.response > 10 and measured.peak == pytest.approx(pair.h, rel=0.02)
    assert not misses.unanswered((measured,), "verlet")
    silent = replace(measured, response=1.01)
    assert len(misses.unanswered((silent,), "verlet")) == 1
