"""What FMI 2 has of its own: when a run begins, slopes of inputs, how a step says that it ended."""

from __future__ import annotations

import math

import pytest
from units import FMICallException, FMU2Model, FMU2Slave, Unit, exact, rig_, unit_  # noqa: F401

LAST, ENDED = 2, 3  # of fmi2StatusKind


def begun(rig, kind=FMU2Slave, t: float = 0.0, **starts: float) -> Unit:
    u = rig(kind, version="2")
    for name, value in starts.items():
        u.fmu.setReal([u.by_name[name]], [value])
    u.fmu.setupExperiment(startTime=t)
    u.fmu.enterInitializationMode()
    u.fmu.exitInitializationMode()
    return u


def test_input_derivatives_of_fmi_2(rig) -> None:
    """Of third order: a step errs by the fourth power of its length."""
    errors = []
    for h in (0.1, 0.05):
        u = begun(rig)
        f = [u.by_name["F"]]
        for k in range(round(1 / h)):
            t = k * h
            u.fmu.setReal(f, [math.sin(3 * t)])
            slopes = [3 * math.cos(3 * t), -9 * math.sin(3 * t), -27 * math.cos(3 * t)]
            u.fmu.setRealInputDerivatives(f * 3, [1, 2, 3], slopes)
            u.fmu.doStep(t, h)
        errors.append(abs(u.fmu.getReal([u.by_name["x"]])[0] - exact(1)))
    assert 3.7 < math.log2(errors[0] / errors[1]) < 4.4 and errors[1] < 1e-5


def test_slopes_are_of_one_step(rig) -> None:
    u = begun(rig)
    f = [u.by_name["F"]]
    u.fmu.setReal(f, [1.0])
    u.fmu.setRealInputDerivatives(f, [1], [5.0])
    u.fmu.doStep(0, 0.5)
    assert u.fmu.getReal(f) == [3.5]
    u.fmu.doStep(0.5, 0.5)
    assert u.fmu.getReal(f) == [3.5]  # held


def test_inputs_are_at_the_end_of_a_step_what_their_slopes_say(rig) -> None:
    u = begun(rig, **{"integrator.step": 0.5})
    f = [u.by_name["F"]]
    u.fmu.setReal(f, [1.0])
    u.fmu.setRealInputDerivatives(f * 3, [1, 2, 3], [2.0, 3.0, 4.0])
    u.fmu.doStep(0, 0.5)
    assert u.fmu.getReal(f)[0] == pytest.approx(1 + 2 / 2 + 3 / 8 + 4 / 48)


def test_a_run_begins_when_it_is_said_to_and_ends_at_an_event(rig) -> None:
    ends = math.acos(-2 / 3) / 2  # x = 3 cos 2t falls through -2
    u = begun(rig, t=2.0, x=3.0)
    u.fmu.doStep(2.0, 1.0)
    assert u.fmu.getRealStatus(LAST) == 3 and not u.fmu.getBooleanStatus(ENDED)
    with pytest.raises(FMICallException) as error:
        u.fmu.doStep(3.0, 0.5)
    assert error.value.status == 2  # discard
    assert u.fmu.getBooleanStatus(ENDED)
    assert u.fmu.getRealStatus(LAST) == pytest.approx(2 + ends, abs=1e-9)


def test_an_event_in_model_exchange_ends_it(rig) -> None:
    u = begun(rig, FMU2Model)
    u.fmu.newDiscreteStates()
    for t, x, ends in ((0, -1.0, False), (1, -3.0, True)):
        u.go([x, -1.0], t)
        u.fmu.completedIntegratorStep()
        u.fmu.enterEventMode()
        assert u.fmu.newDiscreteStates()[1] is ends
        u.fmu.enterContinuousTimeMode()
