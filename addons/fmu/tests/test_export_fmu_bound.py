"""Units in model exchange whose states constraints and quaternions bind: what importers integrate
drifts off, and is moved back at events that the unit asks for."""

from __future__ import annotations

import zipfile

import numpy as np
import pytest
from units import RIG, TOP, FMU2Model, FMU3Model, FMU3Slave, Unit, method, unit_  # noqa: F401

from conftest import ROOT

RODS = ROOT / "models" / "constrained" / "double_pendulum_rods.lag"
ROD = """model rod
param m = 2 [kg] in (0, inf)
param l = 1 [m] in (0, inf)
input F [N]
coord x, y [m]
kinetic m/2*(x'^2 + y'^2)
potential m*(9.81 [m/s^2])*y
force x = F
constraint rod: x^2 + y^2 = l^2
start x = 1, y = 0, y' = 3
"""
LIMIT = 100 * 1e-10  # so far off it may be, by the default tolerance
KINDS = {"3": FMU3Model, "2": FMU2Model}


class Importer:
    """One that makes steps of the classical method of Runge and Kutta."""

    def __init__(self, u: Unit, listens: bool = True) -> None:
        self.fmu, self.listens, self.events = u.fmu, listens, 0
        self.two = isinstance(u.fmu, FMU2Model)
        self.rates_of = self.fmu.getDerivatives if self.two else u.fmu.getContinuousStateDerivatives
        self.t, self.x = (
            0.0,
            np.zeros(sum(v.derivative is not None for v in u.model.modelVariables)),
        )
        assert not self.update()
        self.fmu.enterContinuousTimeMode()
        self.read()

    def read(self) -> None:
        self.fmu.getContinuousStates(np.ctypeslib.as_ctypes(self.x), len(self.x))

    def update(self) -> bool:
        """Whether states are others now."""
        call = self.fmu.newDiscreteStates if self.two else self.fmu.updateDiscreteStates
        again, ends, nominals, states, with_time, _ = call()
        assert not (again or ends or nominals or with_time)
        return bool(states)

    def go(self, t: float, x: np.ndarray) -> None:
        self.fmu.setTime(t)
        self.fmu.setContinuousStates(np.ctypeslib.as_ctypes(x), len(x))

    def rates(self, t: float, x: np.ndarray) -> np.ndarray:
        found = np.zeros_like(x)
        self.go(t, x)
        self.rates_of(np.ctypeslib.as_ctypes(found), len(x))
        return found

    def complete(self) -> bool:
        """Whether the unit asks for an event."""
        event, ends = self.fmu.completedIntegratorStep()
        assert not ends
        return bool(event)

    def event(self) -> bool:
        self.fmu.enterEventMode()
        changed = self.update()
        self.fmu.enterContinuousTimeMode()
        self.read()
        return changed

    def step(self, h: float) -> None:
        t, x = self.t, self.x
        k1 = self.rates(t, x)
        k2 = self.rates(t + h / 2, x + h / 2 * k1)
        k3 = self.rates(t + h / 2, x + h / 2 * k2)
        k4 = self.rates(t + h, x + h * k3)
        self.t, self.x = t + h, x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        self.go(self.t, self.x)
        if self.complete() and self.listens:
            self.events += 1
            assert self.event()


def off_rods(x: np.ndarray) -> float:
    """Of rods of length 1, and of the rates along them."""
    a, b, p, q, a1, b1, p1, q1 = x
    p, q, p1, q1 = p - a, q - b, p1 - a1, q1 - b1
    return max(map(abs, (a * a + b * b - 1, p * p + q * q - 1, a * a1 + b * b1, p * p1 + q * q1)))


def energy_rods(x: np.ndarray) -> float:
    return float(np.dot(x[4:], x[4:]) / 2 + 9.81 * (x[1] + x[3]))


@pytest.mark.parametrize("version", KINDS)
def test_over_a_long_run_constraints_hold_and_energy_drifts_as_in_co_simulation(
    version: str, unit
) -> None:
    step, count = 0.01, 3000
    path = unit(RODS, version, "--method", "rk4", "--step", str(step))

    def drifts(listens: bool) -> tuple[int, float, float]:
        i = Importer(Unit(path, KINDS[version]).start(), listens)
        first, worst, energy = energy_rods(i.x), 0.0, 0.0
        for _ in range(count):
            i.step(step)
            worst = max(worst, off_rods(i.x))
            energy = max(energy, abs(energy_rods(i.x) - first))
        return i.events, worst, energy

    events, worst, energy = drifts(True)
    assert 10 < events < count
    assert worst < 10 * LIMIT  # off by a correction of x, times 2 l or the rate's size
    never, drift, alone = drifts(False)
    assert never == 0 and drift > 100 * worst
    run = Unit(unit(RODS, "3", "--method", "rk4", "--step", str(step)), FMU3Slave).start()
    start = run.get("energy")[0]
    together = 0.0
    for k in range(count):
        run.fmu.doStep(k * step, step)
        together = max(together, abs(run.get("energy")[0] - start))
    assert energy < 3 * together and alone > 3 * energy


@pytest.mark.parametrize("version", KINDS)
def test_the_nearest_state_is_that_along_the_rod(version: str, unit) -> None:
    i = Importer(Unit(unit(ROD, version), KINDS[version]).start())
    rng = np.random.default_rng(1)
    for off in (1e-3, -1e-5, 3e-8):
        angle, rate = rng.uniform(-3, 3, 2)
        along = np.array([np.sin(angle), -np.cos(angle)])
        across = np.array([along[1], -along[0]])
        i.go(1.0, np.concatenate([(1 + off) * along, rate * across + off * along]))
        assert i.complete() and i.event()
        assert i.x == pytest.approx([*along, *(rate * across)], abs=1e-14)
        assert not i.complete() and not i.event()


def test_what_is_less_off_than_may_be_is_left(unit) -> None:
    i = Importer(Unit(unit(ROD), FMU3Model).start())
    for off, much in ((0.9, False), (1.1, True)):
        for x in ([1 + 2 * off * LIMIT, 0, 0, 3], [1, 0, off * LIMIT, 3]):  # nominals: 1 + |x|
            i.go(1.0, np.array(x))
            assert i.complete() is much, x
            assert i.event() is much
            assert (i.x == np.array([1, 0, 0, 3])).all() == much, i.x


def test_the_tolerance_is_the_importers(unit) -> None:
    u = Unit(unit(ROD), FMU3Model)
    u.fmu.enterInitializationMode(tolerance=1e-4)
    u.fmu.exitInitializationMode()
    i = Importer(u)
    i.go(1.0, np.array([1.005, 0, 0, 3]))
    assert not i.complete()
    i.go(1.0, np.array([1.05, 0, 0, 3]))
    assert i.complete()


@pytest.mark.parametrize("version", KINDS)
def test_quaternions_are_brought_back_to_length_1(version: str, unit) -> None:
    u = Unit(unit(TOP, version), KINDS[version]).start()
    i = Importer(u)
    names = [v.name for v in u.model.modelVariables if v.causality == "output"]
    at = [names.index(f"R.{k}") for k in "wxyz"]
    given = i.x.copy()
    given[at] = np.array([0.5, -0.5, 0.1, 0.7]) * 1.001
    i.go(0.5, given)
    assert i.complete() and i.event()
    expected = given.copy()
    expected[at] /= np.linalg.norm(given[at])
    assert i.x == pytest.approx(expected, abs=1e-15)
    rest = [k for k in range(len(given)) if k not in at]
    assert (i.x[rest] == given[rest]).all()


def test_parameters_that_the_state_breaks_are_refused_and_others_are_not(unit) -> None:
    u = Unit(unit(ROD), FMU3Model).start()
    i = Importer(u)
    i.go(1.0, np.array([1 + 1e-6, 0, 0, 3]))
    u.fmu.enterEventMode()
    u.set(m=3.0)
    assert i.update()
    assert u.get("x") == pytest.approx([1], abs=1e-15)
    u.set(l=1.1)
    assert "rod" in u.refused(u.fmu.updateDiscreteStates)


def test_a_start_that_breaks_a_constraint_is_refused(unit) -> None:
    u = Unit(unit(ROD), FMU3Model)
    u.set(x=1.1)
    u.fmu.enterInitializationMode()
    assert "rod" in u.refused(u.fmu.exitInitializationMode)
    u.set(x=0.0, y=-1.0, **{"y'": 0.0})
    u.fmu.exitInitializationMode()
    assert not Importer(u).complete()


def test_what_is_nowhere_near_is_an_error(unit) -> None:
    u = Unit(unit(ROD), FMU3Model).start()
    i = Importer(u)
    i.go(1.0, np.array([0.0, 0.0, 0, 3]))
    assert "rod" in u.refused(u.fmu.completedIntegratorStep)
    i.go(1.0, np.array([1.001, 0, 0, 3]))  # and it goes on from there
    assert i.complete() and i.event()


def test_a_state_that_is_restored_goes_on_alike(unit) -> None:
    u = Unit(unit(ROD), FMU3Model).start()
    i = Importer(u)
    for _ in range(20):
        i.step(0.05)
    state = u.fmu.getFMUState()
    at, x = i.t, i.x.copy()
    found = []
    for again in range(2):
        if again:
            u.fmu.setFMUState(state)
            i.t, i.x = at, x.copy()
        for _ in range(20):
            i.step(0.05)
        found.append(i.x)
    u.fmu.freeFMUState(state)
    assert found[0] == pytest.approx(found[1], abs=1e-14) and i.events > 10


BELT = """model belt
input w [m/s]
coord x, y [m]
kinetic ((1 [kg])*x'^2 + (1 [kg])*y'^2)/2
rolling drive: x' = w
"""


def test_inputs_that_constraints_depend_on_may_change(unit) -> None:
    """What is driven follows, also after a state that was stored with another input."""
    u = Unit(unit(BELT), FMU3Model).start()
    i = Importer(u)

    def driven(w: float) -> None:
        u.set(w=w)
        i.go(1.0, np.array([2, 3, 7, 5.0]))
        assert i.complete() and i.event()
        assert i.x == pytest.approx([2, 3, w, 5], abs=1e-15)

    driven(0.5)
    u.set(w=1.5)
    state = u.fmu.getFMUState()
    driven(2.5)
    u.fmu.setFMUState(state)
    assert u.get("w", "x'") == [1.5, 0.5]
    assert i.complete() and i.event() and i.x[2] == 1.5
    u.fmu.freeFMUState(state)


def test_parameters_change_where_the_state_allows_it(unit) -> None:
    """Upon the origin a slope may turn; at the start it might not."""
    slope = """model slope
param k = 1
coord x, y
kinetic (x'^2 + y'^2)/2
constraint slope: y = k*x
start x = 1, y = 1
"""
    u = Unit(unit(slope), FMU3Model).start()
    i = Importer(u)
    i.go(1.0, np.zeros(4))
    u.fmu.enterEventMode()
    u.set(k=2.0)
    assert not i.update()
    u.fmu.enterContinuousTimeMode()
    i.go(1.0, np.array([1.0, 3, 0, 0]))
    assert i.complete() and i.event()
    assert i.x == pytest.approx([7 / 5, 14 / 5, 0, 0], abs=1e-14)


@pytest.mark.parametrize("version", KINDS)
def test_a_unit_that_nothing_binds_asks_for_no_event(version: str, unit) -> None:
    path = unit(RIG.replace("event low: x + (2 [m]) falling stop\n", ""), version)
    i = Importer(Unit(path, KINDS[version]).start())
    i.go(1.0, np.array([17.0, -5.0]))
    assert not i.complete() and not i.event()
    assert list(i.x) == [17, -5]


def test_it_says_that_it_is_to_be_told_of_steps(unit) -> None:
    plain = "model one\ncoord x\nkinetic x'^2/2\nstart x = 1\n"
    body = "model body\nrotation R\nkinetic dot(omega(R), omega(R))/2\n"
    for model, told in ((ROD, "true"), (body, "true"), (plain, "false")):
        with zipfile.ZipFile(unit(model)) as archive:
            text = archive.read("modelDescription.xml").decode()
        assert f'needsCompletedIntegratorStep="{told}"' in text
