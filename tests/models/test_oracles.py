"""The oracles of rigid and constrained bodies against themselves: motions integrated by their laws
against their closed forms, and both against published figures. Nothing here runs pkgen."""

import re
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest
from oracles import attitude, averaged_rattleback, free_body
from oracles.dumbbell import Body, Dumbbell
from oracles.gimbals import Gimbals
from oracles.heavy_top import Top
from oracles.integrate import crossing, integrate
from oracles.rolling import Rolling, disk, ellipsoid, growth_to_first_order
from oracles.rolling_disk import Disk

MODELS = Path(__file__).resolve().parents[2] / "models"
UP = np.array([0.0, 0.0, 1.0])


def text(path: str) -> str:
    return (MODELS / path).read_text(encoding="utf-8")


def stands_in(path: str, value: mp.mpf, digits: int = 16) -> bool:
    """Whether a model's text has a number that is this one to so many digits."""
    written = re.findall(r"\d+\.\d{8,}", text(path))
    return any(abs(mp.mpf(w) / abs(value) - 1) < mp.mpf(10) ** (1 - digits) for w in written)


@pytest.fixture(autouse=True)
def thirty_digits():
    with mp.workdps(30):
        yield


# --- a free body, I = (1, 2, 3) ----------------------------------------------------------------

INERTIA = (1, 2, 3)


def freely(t: float, y: np.ndarray) -> np.ndarray:
    moments = np.array(INERTIA, float)
    w = y[4:]
    return np.concatenate([attitude.rate(y[:4], w), np.cross(moments * w, w) / moments])


def test_periods_of_a_free_body_are_those_of_the_regimes() -> None:
    """T4."""
    long = free_body.period_from_the_middle(INERTIA, "0.01", 1, 0)
    other = free_body.period_from_the_middle(INERTIA, 0, 1, "0.01")
    assert long == pytest.approx(41.509219529, abs=5e-10)
    assert other == pytest.approx(37.702071587, abs=5e-10)
    assert stands_in("bodies/free_body.lag", long) and stands_in("bodies/free_body.lag", other)


@pytest.mark.parametrize(("w1", "w3"), [(1, 1.2), (2, 0.5)])
def test_jacobis_functions_solve_eulers_equations(w1: float, w3: float) -> None:
    end = float(free_body.period(INERTIA, w1, w3))
    times = np.array([0, 0.3, 1.7, end])
    start = np.array([1, 0, 0, 0, w1, 0, w3], float)
    rows = integrate(freely, start, times, 0.05)
    closed = np.array([[float(x) for x in free_body.rates(INERTIA, w1, w3, t)] for t in times])
    assert 0 < np.abs(rows[:, 4:] - closed).max() < 1e-11
    assert np.abs(integrate(freely, start, times, 1.7)[:, 4:] - closed).max() > 1e-10
    # Of order 16, long steps do.
    end_of_long = integrate(freely, start, np.array([0, 2.4]), 0.8)[-1, 4:]
    assert end_of_long == pytest.approx(
        [float(x) for x in free_body.rates(INERTIA, w1, w3, 2.4)], abs=2e-11
    )
    # After a period it is turned about the momentum, by an angle that a quadrature gives.
    angle = free_body.turn_about_momentum(INERTIA, w1, w3)
    momentum = np.array(INERTIA) * start[4:]
    turned = attitude.matrix(attitude.turn(momentum, float(angle)))
    assert np.abs(attitude.matrix(rows[-1, :4]) - turned).max() < 1e-11
    assert np.abs(turned - np.eye(3)).max() > 0.1
    if w1 == 1:
        assert stands_in("bodies/free_body.lag", angle, 15)


# --- the heavy top, I1 = 1, I3 = 1/2, m g l = 1 --------------------------------------------------


def test_a_top_let_go_is_that_of_the_regimes() -> None:
    """T2, and the motion by Euler's equations."""
    period, turned, lowest = Top().released(mp.pi / 3, 3)
    assert period == pytest.approx(2.2783019977, abs=5e-11)
    assert turned == pytest.approx(0.7865212438, abs=5e-11)
    assert mp.degrees(lowest) == pytest.approx(72.6962369, abs=5e-8)
    for value in (period, turned, mp.cos(lowest)):
        assert stands_in("bodies/heavy_top_rotation.lag", value)
    start = np.concatenate([attitude.turn((1, 0, 0), np.pi / 3), [0, 0, 6]])
    times = np.array([0, float(period / 2), float(period)])
    _, middle, end = integrate(Top().rate, start, times, 0.02)
    assert attitude.matrix(middle[:4])[2, 2] == pytest.approx(float(mp.cos(lowest)), abs=1e-12)
    axis = attitude.matrix(end[:4])[:, 2]
    place = np.sqrt(0.75) * np.array([np.sin(float(turned)), -np.cos(float(turned))])
    assert np.abs(axis[:2] - place).max() < 1e-12


def test_steady_precession_is_rest_in_the_well() -> None:
    top, theta, p_psi = Top(), mp.pi / 3, 3
    slow, fast = top.precessions(theta, p_psi)
    assert 0.3 < slow < 0.4 and 5 < fast < 6
    for turn in (slow, fast):
        p_phi = top.i1 * turn * mp.sin(theta) ** 2 + p_psi * mp.cos(theta)
        assert abs(top.equilibrium(p_phi, p_psi) - theta) < 1e-15
        bend = mp.diff(lambda x, p=p_phi: top.potential(x, p, p_psi), theta, 2)
        assert abs(top.nutation(theta, turn, p_psi) ** 2 / bend - 1) < 1e-12


def test_a_sleeping_top_wakes_below_its_limit() -> None:
    """T3; and thrown from upright it is so again after the period that the cubic's roots give."""
    top = Top()
    assert top.sleeping_growth("1.8").real == pytest.approx(0.4358898944, abs=5e-11)
    assert mp.degrees(top.excursion("1.8")) == pytest.approx(51.683866, abs=5e-7)
    assert top.sleeping_growth("2.1").real == 0 and top.sleeping_growth("2.1").imag > 0.3
    period, lowest = top.through_upright(3, 2)
    assert stands_in("bodies/heavy_top_rotation.lag", period)
    assert stands_in("bodies/heavy_top_rotation.lag", mp.cos(lowest))
    start = np.array([1, 0, 0, 0, 2, 0, 6], float)
    found = integrate(top.rate, start, np.array([0, float(period / 2), float(period)]), 0.02)
    height = [attitude.matrix(y[:4])[2, 2] for y in found]
    assert height == pytest.approx([1, float(mp.cos(lowest)), 1], abs=1e-12)


# --- rolling -------------------------------------------------------------------------------------

STONE = np.array([[2, -0.2, 0], [-0.2, 16, 0], [0, 0, 17]]) * 1e-4


def stone(drag: float = 0.0) -> Rolling:
    """Of Kane and Levinson."""
    return Rolling(ellipsoid(0.2, 0.03, 0.02, 0.01), STONE, drag=drag)


def test_what_rolls_keeps_its_energy() -> None:
    tilted = attitude.product(attitude.turn((1, 0, 0), 0.01), attitude.turn((0, 1, 0), 0.01))
    start = np.concatenate([tilted, [0, 0], [0.1, 0.2, -5]])
    level = stone().energy(start)
    end = integrate(stone().rate, start, np.array([0, 0.2]), 0.005)[-1]
    assert 0 < abs(stone().energy(end) / level - 1) < 1e-11
    assert abs(end[8] + 5) > 0.01  # the spin has changed
    damped = stone(1e-4)
    assert damped.energy(integrate(damped.rate, start, np.array([0, 0.2]), 0.005)[-1]) < level


def test_both_senses_of_spin_grow_as_walker_found() -> None:
    """What his first order leaves is of third order in the spin: 8 times for twice of it."""
    errors = []
    for n in (0.5, 1.0):
        told = np.array(growth_to_first_order(stone(), (2.0, 0.045), 0.01, n))
        found = stone().linear(UP, n * UP)
        found = found[np.argsort(found.imag)][-2:]
        assert found.imag == pytest.approx(told[:, 0], rel=1e-3)
        assert found.real == pytest.approx(told[:, 1], rel=5e-3)
        errors.append(abs(found.real - told[:, 1]))
        back = stone().linear(UP, -n * UP)
        assert back[np.argsort(back.imag)][-2:].real == pytest.approx(-found.real, abs=1e-9)
    assert (errors[1] / errors[0] > 7.5).all() and (errors[1] / errors[0] < 8.5).all()
    rolling, pitching = growth_to_first_order(stone(), (2.0, 0.045), 0.01, -5.0)
    assert pitching[1] == pytest.approx(2.1303, abs=1e-4)
    assert rolling[1] / rolling[0] ** 2 == pytest.approx(-pitching[1] / pitching[0] ** 2)
    assert rolling[1] == pytest.approx(-0.21211, abs=1e-5)


def test_without_skewness_no_sense_is_preferred() -> None:
    straight = Rolling(ellipsoid(0.2, 0.03, 0.02, 0.01), np.diag(np.diag(STONE)))
    assert abs(straight.linear(UP, 2 * UP).real).max() < 1e-7
    assert abs(stone().linear(UP, 2 * UP).real).max() > 0.08


def test_a_disk_by_its_angles_and_by_its_point_of_contact() -> None:
    flat, whole = Disk(), Rolling(disk(1.0), np.diag([0.25, 0.25, 0.5]))
    theta, nod, W, w = 0.9, 0.3, 1.1, -0.8
    times = np.linspace(0, 3, 4)
    angles = integrate(flat.rate, np.array([theta, nod, W, w]), times, 0.02)
    start = [attitude.turn((1, 0, 0), theta), [0, 0], [nod, W * np.sin(theta), w]]
    rows = integrate(whole.rate, np.concatenate(start), times, 0.02)
    tilts = [np.arccos(attitude.matrix(y[:4])[2, 2]) for y in rows]
    assert tilts == pytest.approx(angles[:, 0], abs=1e-11)
    assert rows[:, 8] == pytest.approx(angles[:, 3], abs=1e-11)
    assert np.ptp(angles[:, 0]) > 0.1 and np.ptp(angles[:, 3]) > 0.1
    assert whole.energy(rows[-1]) == pytest.approx(whole.energy(rows[0]), rel=1e-12)


def test_an_upright_disk_falls_below_the_classical_speeds() -> None:
    flat, g = Disk(), 9.81
    for part, stays in ((1.001, True), (0.999, False)):
        on = flat.frequency_squared(np.pi / 2, 0, np.sqrt(part * g / 3))
        spot = flat.frequency_squared(np.pi / 2, np.sqrt(part * 4 * g / 5), 0)
        assert (on > 1e-4) == stays == (spot > 1e-4)
    # Euler's disk: its centre at rest.
    W = np.sqrt(4 * g / np.sin(0.1))
    assert flat.steady_spin(0.1, W) == pytest.approx(0, abs=1e-12)
    assert flat.nod(0.1, W, 0) == pytest.approx(0, abs=1e-11)
    assert abs(flat.nod(0.1, 1.01 * W, 0)) > 0.1


# --- the averaged rattleback ---------------------------------------------------------------------


def averaged(growth: float, friction: float):
    def rate(t: float, y: np.ndarray) -> np.ndarray:
        P, R, S = y
        return np.array([growth * P * S, -R * S, R**2 - growth * P**2]) - friction * y

    return rate


def test_reversals_by_quadrature_and_by_integration() -> None:
    p0 = mp.mpf("0.01")
    early, late = averaged_rattleback.quarters(4, p0)
    for many, value in ((16, early), (16, late)):
        assert stands_in("bodies/rattleback_reduced.lag", value, many)
    assert stands_in("bodies/rattleback_reduced.lag", early + late)
    start = np.array([0.01, 0.02, 1.0])
    found, _ = crossing(averaged(4, 0), start, 0.02, lambda y: y[2], 3)
    assert found == pytest.approx(float(early), abs=1e-12)
    found, _ = crossing(averaged(4, 0), start * [1, 1, -1], 0.02, lambda y: y[2], 6)
    assert found == pytest.approx(float(late), abs=1e-11)
    # lambda = 1 is elliptic, and prefers no sense.
    one, other = averaged_rattleback.quarters(1, p0)
    s1 = mp.sqrt(1 + 4 * p0**2)
    assert abs(one - other) < 1e-25 and abs(one - mp.ellipk(1 / s1**2) / s1) < 1e-20


def test_friction_leaves_those_reversals_that_come_before_its_time() -> None:
    friction = mp.mpf("0.25")
    after = averaged_rattleback.damped(averaged_rattleback.reversals(4, 0.01, 4), friction)
    assert len(after) == 1 and stands_in("bodies/rattleback_reduced.lag", after[0])
    start = np.array([0.01, 0.02, 1.0])
    found, _ = crossing(averaged(4, 0.25), start, 0.02, lambda y: y[2], 3)
    assert found == pytest.approx(float(after[0]), abs=1e-12)
    assert not averaged_rattleback.damped(averaged_rattleback.reversals(4, 0.01, 4, -1), friction)
    assert len(averaged_rattleback.damped(averaged_rattleback.reversals(4, 0.01, 4), 0.1)) == 2


# --- joints --------------------------------------------------------------------------------------


def test_a_dumbbell_keeps_its_momenta_and_its_joint() -> None:
    one = Body(1.0, np.array([0.3, 0.4, 0.1]), np.array([0, 0, -0.5]))
    two = Body(2.0, np.array([0.2, 0.3, 0.1]), np.array([0, 0.1, 0.4]))
    w1, w2, v1 = np.array([0.7, -0.4, 3]), np.array([-0.9, 1.1, -2]), np.array([0.2, 0, 0.1])

    def whole(y: np.ndarray) -> tuple[float, np.ndarray]:
        """Energy and angular momentum about the origin; the second body's place by the joint."""
        a, b = attitude.matrix(y[:4]), attitude.matrix(y[4:8])
        w1, w2, r1, v1 = y[8:11], y[11:14], y[14:17], y[17:20]
        r2 = r1 + a @ one.joint - b @ two.joint
        v2 = v1 + a @ np.cross(w1, one.joint) - b @ np.cross(w2, two.joint)
        kinetic = one.mass * v1 @ v1 + two.mass * v2 @ v2
        kinetic += w1 @ (one.inertia * w1) + w2 @ (two.inertia * w2)
        angular = one.mass * np.cross(r1, v1) + a @ (one.inertia * w1)
        angular = angular + two.mass * np.cross(r2, v2) + b @ (two.inertia * w2)
        return kinetic / 2, np.concatenate([angular, one.mass * v1 + two.mass * v2])

    start = np.concatenate([[1, 0, 0, 0], [1, 0, 0, 0], w1, w2, np.zeros(3), v1])
    end = integrate(Dumbbell(one, two).rate, start, np.array([0, 2.0]), 0.02)[-1]
    (energy, momenta), (energy2, momenta2) = whole(start), whole(end)
    assert 0 < abs(energy2 / energy - 1) < 1e-11
    assert np.abs(momenta2 - momenta).max() < 1e-11 < 0.1 < np.abs(end[8:11] - w1).max()


def test_gimbals_keep_their_energy_through_the_lock() -> None:
    rings, p = Gimbals(), 0.6

    def energy(y: np.ndarray) -> float:
        s, c = np.sin(y[1]), np.cos(y[1])
        outer = rings.J + (rings.K2 + rings.A) * s**2 + rings.K3 * c**2
        return (outer * y[2] ** 2 + (rings.K1 + rings.A) * y[3] ** 2) / 2

    start = np.array([0.4, np.radians(20), 2.5, -6])
    rows = integrate(lambda t, y: rings.rate(p, y), start, np.linspace(0, 2, 81), 0.01)
    assert rows[:, 1].min() < -0.1 < 0.1 < rows[:, 1].max()
    assert 0 < max(abs(energy(y) / energy(start) - 1) for y in rows) < 1e-10
