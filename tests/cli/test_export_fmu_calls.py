"""What units do when they are called, rightly and wrongly: derivatives, inputs, events, states."""

from __future__ import annotations

import math
import random
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pkgen
import pytest
from columns import MODELS
from conftest import long_but
from units import PENDULUM, TOP, fmpy, method, unit_  # noqa: F401

FMICallException = pytest.importorskip("fmpy.fmi1").FMICallException
FMU2Slave = fmpy.fmi2.FMU2Slave
FMU3Model, FMU3Slave = fmpy.fmi3.FMU3Model, fmpy.fmi3.FMU3Slave

RIG = """model rig
param m = 2 [kg] in (0, 10]
param k = 4*m*(1 [1/s^2]) in [0, inf)
param d = 0 [N] in [0, inf)
input F [N]
coord x [m]
kinetic m/2*x'^2
potential k/2*x^2
force x = F - d*(2*step(x' - (1000 [m/s])) - 1)
observe power = F*x'
observe a = x''
event low: x + (2 [m]) falling stop
start x = m*(0.5 [m/kg])
"""
OSCILLATOR = """model oscillator
param m = 2 [kg] in (0, 10]
coord x [m]
kinetic m/2*x'^2
potential (4 [N/m])*x^2
start x = 1
"""


class Unit:
    """A unit as FMPy calls it, by names."""

    def __init__(self, path: Path, kind=FMU3Slave, **how):
        self.path = path
        self.model = fmpy.read_model_description(str(path))
        self.by_name = {v.name: v.valueReference for v in self.model.modelVariables}
        self.said: list[str] = []
        modes = self.model.modelExchange if kind is FMU3Model else self.model.coSimulation
        self.fmu = kind(
            guid=self.model.guid or self.model.instantiationToken,
            unzipDirectory=fmpy.extract(str(path)),
            modelIdentifier=modes.modelIdentifier,
            instanceName="one",
        )
        if kind is not FMU2Slave:
            how["logMessage"] = lambda env, status, category, text: self.said.append(text.decode())
        self.fmu.instantiate(**how)

    def start(self, **values):
        self.set(**values)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        return self

    def set(self, **values):
        for name, value in values.items():
            self.fmu.setFloat64([self.by_name[name]], [value])

    def get(self, *names):
        return self.fmu.getFloat64([self.by_name[name] for name in names])

    def go(self, x, t=0.0):
        """To a state in model exchange."""
        if t == 0:
            self.fmu.enterContinuousTimeMode()
        self.fmu.setTime(t)
        self.fmu.setContinuousStates(np.ctypeslib.as_ctypes(np.array(x, float)), len(x))

    def refused(self, call, *arguments) -> str:
        before = len(self.said)
        with pytest.raises(FMICallException):
            call(*arguments)
        assert len(self.said) == before + 1
        return self.said[-1]


@pytest.fixture
def rig(unit):
    return lambda *a, version="3", **how: Unit(unit(RIG, version), *a, **how)


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
        assert np.max(np.abs(found - expected) / size) < 1e-8
        # What is exact is so: rows of the transpose, by other calls.
        weights = [chance.uniform(-1, 1) for _ in unknowns]
        adjoint = u.fmu.getAdjointDerivative(unknowns, knowns, weights, len(knowns))
        assert np.dot(adjoint, seeds) == pytest.approx(np.dot(weights, found), rel=1e-9, abs=1e-9)


def _exact(t: float) -> float:
    """2 x'' + 8 x = F of x(0) = 1: F = sin 3t."""
    return math.cos(2 * t) + (math.sin(3 * t) / -5 + 3 / 10 * math.sin(2 * t)) / 2


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
        errors.append(abs(u.get("x")[0] - _exact(1)))
    order = math.log2(errors[0] / errors[1])
    if how == "held":
        assert 0.8 < order < 1.2 and errors[1] > 1e-3
    elif how == "slopes":
        assert 1.8 < order < 2.3
    else:
        assert max(errors) < 1e-9


def test_input_derivatives_of_fmi_2(rig) -> None:
    """Of third order: a step errs by the fourth power of its length."""
    errors = []
    for h in (0.1, 0.05):
        u = rig(FMU2Slave, version="2")
        u.fmu.setupExperiment(startTime=0.0)
        u.fmu.enterInitializationMode()
        u.fmu.exitInitializationMode()
        f = [u.by_name["F"]]
        for k in range(round(1 / h)):
            t = k * h
            u.fmu.setReal(f, [math.sin(3 * t)])
            slopes = [3 * math.cos(3 * t), -9 * math.sin(3 * t), -27 * math.cos(3 * t)]
            u.fmu.setRealInputDerivatives(f * 3, [1, 2, 3], slopes)
            u.fmu.doStep(t, h)
        errors.append(abs(u.fmu.getReal([u.by_name["x"]])[0] - _exact(1)))
    assert 3.7 < math.log2(errors[0] / errors[1]) < 4.4 and errors[1] < 1e-5


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


def test_an_importer_may_return_early(rig) -> None:
    def update(env, t, set_requested, get_allowed, finished, may_return, asked, when):
        if may_return and t > 0.3:
            asked[0] = True
            when[0] = t

    u = rig(earlyReturnAllowed=True, intermediateUpdate=update)
    u.fmu.setFloat64([u.by_name["integrator.step"]], [0.125])
    u.fmu.setInt64([u.by_name["integrator.method"]], [method(u.path, "rk4")])
    u.start()
    assert u.fmu.doStep(0, 1) == (False, False, True, 0.375)
    assert u.fmu.doStep(0.375, 0.125) == (False, False, False, 0.5)


def test_model_exchange_stops_where_an_event_falls(unit) -> None:
    rows = fmpy.simulate_fmu(
        str(unit(RIG)), fmi_type="ModelExchange", stop_time=3, start_values={"x": 3.0},
        relative_tolerance=1e-9, output_interval=0.01,
    )  # fmt: skip
    assert rows["time"][-1] == pytest.approx(math.acos(-2 / 3) / 2, abs=1e-2)


@pytest.mark.parametrize("name", ["rk4", "dop853", "gauss"])
def test_states_are_kept_and_serialised(name: str, unit) -> None:
    def made():
        u = Unit(unit(PENDULUM))
        u.fmu.setFloat64([u.by_name["integrator.step"]], [0.01])
        u.fmu.setInt64([u.by_name["integrator.method"]], [method(u.path, name)])
        return u

    u = made().start(l2=0.5)
    u.fmu.doStep(0, 0.5)
    state = u.fmu.getFMUState()
    kept = u.fmu.serializeFMUState(state)
    at = u.get("theta1", "theta2'")
    u.fmu.doStep(0.5, 0.5)
    first = u.get("theta1", "theta2'")
    assert first != at
    u.fmu.setFMUState(state)
    assert u.get("theta1", "theta2'") == at
    u.fmu.doStep(0.5, 0.5)
    assert u.get("theta1", "theta2'") == pytest.approx(first, rel=1e-9)
    other = made().start()  # of other parameters
    again = other.fmu.deserializeFMUState(kept)
    other.fmu.setFMUState(again)
    assert other.get("theta1", "theta2'", "l2") == [*at, 0.5]
    other.fmu.doStep(0.5, 0.5)
    assert other.get("theta1", "theta2'") == pytest.approx(first, rel=1e-9)
    for wrong in (kept[:-1], bytes(len(kept)), b"", kept[:20] + b"\xff" * (len(kept) - 20)):
        other.refused(other.fmu.deserializeFMUState, wrong)
    u.fmu.freeFMUState(state)
    other.fmu.freeFMUState(again)


def test_bad_use_is_refused_with_a_message(rig) -> None:
    u = rig()
    f64 = u.fmu.setFloat64
    m, x, rate = (u.by_name[name] for name in ("m", "x", "der(x')"))
    assert "m = 11 is outside its bounds, from 0 to 10" in u.refused(f64, [m], [11.0])
    assert "not finite" in u.refused(f64, [m], [math.nan])
    assert "cannot be set at all" in u.refused(f64, [rate], [1.0])
    assert "there is no variable 4294967295" in u.refused(f64, [2**32 - 1], [1.0])
    assert "counts differ" in u.refused(f64, [m], [1.0, 2.0])
    assert "instantiated" in u.refused(u.fmu.doStep, 0.0, 0.1)
    assert "no such method" in u.refused(u.fmu.setInt64, [u.by_name["integrator.method"]], [99])
    assert "no enumeration" in u.refused(u.fmu.getInt64, [m])
    assert "no variable is of that type" in u.refused(u.fmu.getBoolean, [m])
    f64([m], [0.0])  # a bound of FMI is closed; the model's is not
    assert "m is outside its bounds" in u.refused(u.fmu.getFloat64, [m])
    f64([m], [2.0])
    u.start()
    u.fmu.doStep(0.0, 0.1)
    assert "but the unit is at t = 0.1" in u.refused(u.fmu.doStep, 0.05, 0.1)
    assert "goes forward" in u.refused(u.fmu.doStep, 0.1, -0.1)
    assert "goes forward" in u.refused(u.fmu.doStep, 0.1, math.inf)
    assert "cannot be set now" in u.refused(f64, [x], [1.0])
    assert "no derivatives by variable" in u.refused(
        u.fmu.getDirectionalDerivative, [rate], [m], [1.0]
    )
    assert "in step mode" in u.refused(u.fmu.enterEventMode)
    u.fmu.terminate()
    assert "terminated" in u.refused(u.fmu.doStep, 0.1, 0.1)
    u.fmu.reset()
    assert u.start().get("x") == [1.0]
    null = u.fmu.fmi3GetFloat64
    assert "null" in u.refused(null, u.fmu.component, None, 1, None, 1)
    u.fmu.freeInstance()


def test_parameters_change_on_the_way(rig) -> None:
    """From the state there: 2 x'' = -32 x has half the period."""
    u = rig().start(x=1.0)
    u.fmu.doStep(0, math.pi / 2)
    u.set(k=32.0)
    u.fmu.doStep(math.pi / 2, math.pi / 4)
    assert u.get("x")[0] == pytest.approx(1, abs=1e-9)
    assert "outside" in u.refused(u.fmu.setFloat64, [u.by_name["k"]], [-1.0])


def test_wrong_tokens_and_modes_make_no_unit(rig) -> None:
    u = rig()
    u.fmu.guid = "{another}"
    with pytest.raises(Exception, match="instantiate"):
        u.fmu.instantiate(logMessage=lambda *said: u.said.append(said[3].decode()))
    assert "token" in u.said[-1]


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


@pytest.mark.parametrize("version", ["3", "2"])
def test_sources_compile_alone_and_declare_what_the_standard_does(
    version: str,
    unit,
    tmp_path: Path,
) -> None:
    with zipfile.ZipFile(unit(RIG, version)) as archive:
        archive.extractall(tmp_path)
    sources = tmp_path / "sources"
    if version == "3":
        text = (sources / "buildDescription.xml").read_text()
    else:
        text = (tmp_path / "modelDescription.xml").read_text()
    files = [str(p.relative_to(sources)) for p in sorted(sources.rglob("*.c"))]
    assert all(f'name="{name}"' in text for name in files)
    flags = ["-std=c11", "-O0", "-fPIC", "-shared", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(["gcc", *flags, *files, "-o", "unit.so", "-lm"], cwd=sources, check=True)
    # The standard's own headers in place of ours.
    headers = Path(fmpy.__file__).parent / "c-code"
    ours = [f"-DUNIT_FMI{version}_H", "-include", "stdbool.h", "-include", "stdint.h"]
    theirs = ["-include", headers / f"fmi{version}Functions.h", "-fsyntax-only"]
    subprocess.run(["gcc", *ours, *theirs, f"fmi{version}.c"], cwd=sources, check=True)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(4))
def test_calls_at_random_under_sanitizers(seed: int, unit, tmp_path: Path) -> None:
    path = unit(RIG)
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path)
    files = [*map(str, (tmp_path / "sources").rglob("*.c")), Path(__file__).parent / "fmu_fuzz.c"]
    flags = ["-std=c11", "-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    headers = f"-I{Path(fmpy.__file__).parent / 'c-code'}"
    subprocess.run(["gcc", *flags, headers, *files, "-o", tmp_path / "fuzz", "-lm"], check=True)
    token = fmpy.read_model_description(str(path)).instantiationToken
    said = subprocess.run(
        [tmp_path / "fuzz", str(seed), "300000", token], capture_output=True, text=True, timeout=120
    )
    assert said.returncode == 0, said.stdout + said.stderr
    steps, done, refusals, *_ = (int(word.split()[0]) for word in said.stdout.split(", "))
    assert steps > 100 and done > 10_000 and refusals > 10_000
