"""Units in model exchange: events and switches as an importer meets them, what it may not set."""

from __future__ import annotations

import math

import numpy as np
import pytest
from units import FMU3Model, Unit, unit_  # noqa: F401

ROOF = """model roof
param m = 2 [kg] in (0, inf)
coord x [m]
kinetic m/2*x'^2
potential (4 [N])*abs(x)
event low: x - (1 [m]) falling stop
event turns: x' either
start x = 1, x' = -1
"""
CHAIN = """model chain
size N = 20
coord q[1..N]
fixed q[0] = 0
kinetic sum(q[i]'^2/2, i = 1..N)
potential sum((q[i] - q[i-1])^2/2, i = 1..N)
force q[i = 1..N] = -step(q[i])
start q[i = 1..N] = -1
"""
WALL = "model wall\ncoord x\nkinetic x'^2/2\npotential step(x - 1)\nstart x' = 2\n"


@pytest.fixture
def roof(unit):
    return Unit(unit(ROOF), FMU3Model).start()


def event(u: Unit, completed: bool = True) -> bool:
    """Whether the events here end the motion; back to continuous time."""
    if completed:
        u.fmu.completedIntegratorStep()
    u.fmu.enterEventMode()
    _, ends, *_ = u.fmu.updateDiscreteStates()
    u.fmu.enterContinuousTimeMode()
    return ends


def rates(u: Unit) -> list[float]:
    found = (np.ctypeslib.ctypes.c_double * 2)()
    u.fmu.getContinuousStateDerivatives(found, 2)
    return list(found)


@pytest.mark.parametrize("completed", [True, False])
def test_events_end_the_motion_where_they_stop_and_fall(completed: bool, unit) -> None:
    """It begins upon `low`, which is no crossing; `turns` does not stop."""
    roof = Unit(unit(ROOF), FMU3Model).start()
    roof.go([0.5, -1])
    assert not event(roof, completed)
    for t, (x, rate), ends in (
        (1, (0.5, 1), False),
        (2, (1.5, 1), False),
        (3, (1.5, -1), False),
        (4, (0.9, -1), True),
    ):
        roof.go([x, rate], t)
        assert event(roof) is ends, t


def test_sides_of_switches_are_held_between_events(roof) -> None:
    roof.go([0.5, -1])
    assert rates(roof) == [-1, -2]
    roof.go([-0.5, -1], 1)
    assert rates(roof) == [-1, -2]  # smooth, until the importer says that it has seen it
    event(roof)
    assert rates(roof) == [-1, 2]
    roof.go([0, -1], 2)
    event(roof)
    assert rates(roof) == [-1, 2]  # upon the switch: the side that there was


def test_each_member_of_a_family_has_its_side(unit) -> None:
    chain = Unit(unit(CHAIN), FMU3Model).start()
    found = (np.ctypeslib.ctypes.c_double * 40)()

    def acceleration() -> list[float]:
        chain.fmu.getContinuousStateDerivatives(found, 40)
        return list(found)[20:]

    chain.go([-1.0] * 20 + [0.0] * 20)
    event(chain)
    assert acceleration() == [1] + [0] * 19
    chain.go([-1.0] * 4 + [1] + [-1.0] * 15 + [0.0] * 20, 1)
    assert acceleration()[3:6] == [2, -4, 2]
    event(chain)
    assert acceleration()[3:6] == [2, -5, 2]


def test_where_rates_jump_is_an_error(unit) -> None:
    u = Unit(unit(WALL), FMU3Model).start()
    u.go([0.5, 2])
    event(u)
    u.go([1.5, 2], 1)
    u.fmu.enterEventMode()
    assert "rates jump where" in u.refused(u.fmu.updateDiscreteStates)


def test_states_and_times_that_are_none_are_refused(roof) -> None:
    roof.go([0.5, -1])
    several = (np.ctypeslib.ctypes.c_double * 3)(1, 2, 3)
    assert "3 numbers are given, not 2" in roof.refused(roof.fmu.setContinuousStates, several, 3)
    for call, n in (
        (roof.fmu.getContinuousStates, 3),
        (roof.fmu.getContinuousStateDerivatives, 1),
        (roof.fmu.getEventIndicators, 4),
        (roof.fmu.getNominalsOfContinuousStates, 3),
    ):
        said = roof.refused(call, several, n)
        assert "numbers are given, not" in said or "counts differ" in said
    for wrong in (math.inf, math.nan):
        several[0] = wrong
        said = roof.refused(roof.fmu.setContinuousStates, several, 2)
        assert "state 0 is not finite" in said
        assert "the time is not finite" in roof.refused(roof.fmu.setTime, wrong)
    assert roof.get("x", "x'") == [0.5, -1]


def test_parameters_change_in_event_mode_alone(roof) -> None:
    roof.go([0.5, -1])
    m = [roof.by_name["m"]]
    assert "cannot be set now" in roof.refused(roof.fmu.setFloat64, m, [4.0])
    roof.fmu.enterEventMode()
    roof.set(m=4.0)
    roof.fmu.enterContinuousTimeMode()
    assert rates(roof) == [-1, -1]
    roof.fmu.reset()
    assert "instantiated" in roof.refused(roof.fmu.setTime, 1.0)
