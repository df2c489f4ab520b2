"""What units compute: starts, derivatives, inputs between communication points, events."""

from __future__ import annotations

import math
import random
from pathlib import Path

import numpy as np
import pytest
from columns import MODELS
from units import (  # noqa: F401
    PENDULUM,
    RIG,
    TOP,
    FMICallException,
    FMU3Model,
    Unit,
    exact,
    fmpy,
    method,
    rig_,
    unit_,
)

import pkgen
from conftest import long_but

OSCILLATOR = """model oscillator
param m = 2 [kg] in (0, 10]
coord x [m]
kinetic m/2*x'^2
potential (4 [N/m])*x^2
start x = 1
"""


def test_starts_that_follow_parameters_do_so_until_they_are_set(rig) -> None:
    assert rig().start().get("x", "k") == [1, 8]
    assert rig().start(m=3).get("x", "k") == [1.5, 12]
    # As importers do that set every exact start.
    assert rig().start(m=3, k=8.0, x=1.0).get("x", "k") == [1.5, 12]
    assert rig().start(m=3, k=7.0, x=1.25).get("x", "k") == [1.25, 7]


@pytest.mark.parametrize("model", long_but({PENDULUM, TOP}, MODELS), ids=lambda m: m.stem)
def test_accelerations_are_those_of_the_kernels(model: Path, unit) -> None:
    found = pkgen.load(model)
    u = Unit(unit(model), FMU3Model).start()
    n = u.fmu.getNumberOfContinuousStates()
    n_q = len(found.coordinates)
    assert n == n_q + len(found.rates)
    chance, compared = random.Random(1), 0
    start = np.array(found.start)
    for k in range(20):
        x = start + [chance.uniform(-0.1, 0.1) for _ in range(n)]
        a = found.acceleration(x[:n_q], x[n_q:], float(k))
        if not np.all(np.isfinite(a)):
            continue
        u.go(x, float(k))
        if any(x.counted for x in found.compilation.equations.switches):
            # Pieces of tables and of floor are held from event to event.
            u.fmu.enterEventMode()
            u.fmu.updateDiscreteStates()
            u.fmu.enterContinuousTimeMode()
        rates = (np.ctypeslib.ctypes.c_double * n)()
        u.fmu.getContinuousStateDerivatives(rates, n)
        assert list(rates)[:n_q] == list(x[n_q : 2 * n_q])
        size = np.max(np.abs(a)) if len(a) else 1.0
        assert np.max(np.abs(np.array(rates)[n_q:] - a)) <= 1e-12 * size
        compared += 1
    assert compared > 5


@pytest.mark.parametrize("model", [PENDULUM, TOP, RIG], ids=["pendulum", "top", "rig"])
def test_derivatives_are_the_slopes_of_what_is_computed(model, unit) -> None:
    """Against differences of its own that are taken along complex roundings of the seed: by two
    steps of other lengths than the unit's."""
    u = Unit(unit(model), FMU3Model).start()
    chance = random.Random(2)
    n = u.fmu.getNumberOfContinuousStates()
    variables = u.model.modelVariables
    rates = [v.valueReference for v in variables if v.derivative and v.causality == "local"]
    outputs = [v.valueReference for v in variables if v.causality == "output"]
    states = [v.derivative.valueReference for v in variables if v.valueReference in rates]
    inputs = [v.valueReference for v in variables if v.name == "F"]
    x0 = np.array(u.fmu.getFloat64(states)) + [chance.uniform(-0.3, 0.3) for _ in range(n)]
    assert len(rates) == n
    for unknowns in (rates, [*rates, *outputs]):
        u.fmu.enterContinuousTimeMode() if unknowns is rates else None
        seed = np.array([chance.uniform(-1, 1) for _ in range(n)])
        slope = chance.uniform(-1, 1)

        def at(e, seed=seed, slope=slope, unknowns=unknowns):
            u.fmu.setContinuousStates(np.ctypeslib.as_ctypes(np.array(x0 + e * seed)), n)
            if inputs:
                u.fmu.setFloat64(inputs, [0.5 + e * slope])
            return np.array(u.fmu.getFloat64(unknowns))

        def slopes(h):
            return (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)

        expected = slopes(1e-3)
        assert np.max(np.abs(expected)) > 0.1
        at(0)
        knowns, seeds = [*states, *inputs], [*seed, *([slope] * len(inputs))]
        found = np.array(u.fmu.getDirectionalDerivative(unknowns, knowns, seeds))
        size = np.maximum(1, np.abs(expected))
        assert np.max(np.abs(found - expected) / size) < 1e-10
        # What is exact is so: rows of the transpose, by other calls.
        weights = [chance.uniform(-1, 1) for _ in unknowns]
        adjoint = u.fmu.getAdjointDerivative(unknowns, knowns, weights, len(knowns))
        assert np.dot(adjoint, seeds) == pytest.approx(np.dot(weights, found), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("how", ["held", "slopes", "asked"])
def test_inputs_between_communication_points(how: str, rig) -> None:
    u = None

    def update(env, t, set_requested, get_allowed, finished, may_return, asked, when):
        if set_requested:
            u.fmu.setFloat64([u.by_name["F"]], [math.sin(3 * t)])

    more = {"intermediateUpdate": update, "requiredIntermediateVariables": [2 << 20]}
    u = rig(**(more if how == "asked" else {})).start(m=2.0)
    assert u.by_name["F"] == 2 << 20
    errors = []
    for h in (0.1, 0.05):
        u = rig(**(more if how == "asked" else {})).start(m=2.0)
        for k in range(round(1 / h)):
            t = k * h
            u.set(F=math.sin(3 * t))
            if how == "slopes":
                u.set(**{"der(F)": 3 * math.cos(3 * t)})
            u.fmu.doStep(t, h)
        errors.append(abs(u.get("x")[0] - exact(1)))
    order = math.log2(errors[0] / errors[1])
    if how == "held":
        assert 0.8 < order < 1.2 and errors[1] > 1e-3
    elif how == "slopes":
        assert 1.8 < order < 2.3
    else:
        assert max(errors) < 1e-9


def test_an_event_that_stops_ends_a_step_early(rig) -> None:
    """x = 3 cos 2t falls through -2."""
    ends = math.acos(-2 / 3) / 2
    u = rig(earlyReturnAllowed=True).start(x=3.0)
    assert u.fmu.doStep(0, 1) == (False, False, False, 1)
    _, terminate, early, last = u.fmu.doStep(1, 0.5)
    assert terminate and early and last == pytest.approx(ends, abs=1e-9)
    u = rig().start(x=3.0)
    u.fmu.doStep(0, 1)
    with pytest.raises(FMICallException) as error:
        u.fmu.doStep(1, 0.5)
    assert error.value.status == 2  # discard
    assert u.get("x")[0] == pytest.approx(-2, abs=1e-9)


@pytest.mark.parametrize(("back", "found"), [(0.0, 0.375), (0.07, 0.5)])
def test_an_importer_may_return_early(back: float, found: float, rig) -> None:
    """Where it asks for a later time than there is, at the first step from there on."""
    wanted: list[float] = []

    def update(env, t, set_requested, get_allowed, finished, may_return, asked, when):
        if may_return and t > 0.3:
            wanted.append(t + back)
            asked[0] = True
            when[0] = wanted[0]

    u = rig(earlyReturnAllowed=True, intermediateUpdate=update)
    u.fmu.setFloat64([u.by_name["integrator.step"]], [0.125])
    u.fmu.setInt64([u.by_name["integrator.method"]], [method(u.path, "rk4")])
    u.start()
    assert u.fmu.doStep(0, 1) == (False, False, True, found)
    assert u.fmu.doStep(found, 0.125) == (False, False, False, found + 0.125)


def test_model_exchange_stops_where_an_event_falls(unit) -> None:
    rows = fmpy.simulate_fmu(
        str(unit(RIG)), fmi_type="ModelExchange", stop_time=3, start_values={"x": 3.0},
        relative_tolerance=1e-9, output_interval=0.01,
    )  # fmt: skip
    assert rows["time"][-1] == pytest.approx(math.acos(-2 / 3) / 2, abs=1e-2)


def test_parameters_change_on_the_way(rig) -> None:
    """From the state there: 2 x'' = -32 x has half the period."""
    u = rig().start(x=1.0)
    u.fmu.doStep(0, math.pi / 2)
    u.set(k=32.0)
    u.fmu.doStep(math.pi / 2, math.pi / 4)
    assert u.get("x")[0] == pytest.approx(1, abs=1e-9)
    assert "outside" in u.refused(u.fmu.setFloat64, [u.by_name["k"]], [-1.0])


@pytest.mark.long
def test_methods_of_the_authors_own_are_in_a_unit(unit) -> None:
    """Two Verlet steps of half the length each, of a separable system."""
    path = unit(OSCILLATOR, "3", "--composition", "0.5,0.5")
    name = "composition"
    ends = []
    for method_name, h in ((name, 0.25), ("verlet", 0.125)):
        u = Unit(path)
        u.fmu.setFloat64([u.by_name["integrator.step"]], [h])
        u.fmu.setInt64([u.by_name["integrator.method"]], [method(path, method_name)])
        u.start()
        for k in range(4):
            u.fmu.doStep(k * 0.25, 0.25)
        ends.append(u.get("x", "x'"))
    assert ends[0] == pytest.approx(ends[1], rel=1e-12)
