"""Units of models, as FMPy calls them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from conftest import ROOT, run_pkgen

fmpy = pytest.importorskip("fmpy", reason="FMPy is missing: pip install fmpy")
for _version in ("fmi2", "fmi3"):
    pytest.importorskip(f"fmpy.{_version}")

PENDULUM = ROOT / "models" / "double_pendulum.lag"
TOP = ROOT / "models" / "bodies" / "heavy_top_rotation.lag"
FMICallException = pytest.importorskip("fmpy.fmi1").FMICallException
FMU2Model, FMU2Slave = fmpy.fmi2.FMU2Model, fmpy.fmi2.FMU2Slave
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


MADE: dict[tuple, Path] = {}  # of all test files, each of which has the fixture


@pytest.fixture(scope="session", name="unit")
def unit_(tmp_path_factory):
    """The path of a unit of a model, made once."""

    def make(model: Path | str, version: str = "3", *more: str) -> Path:
        key = (model, version, more)
        if key not in MADE:
            folder = tmp_path_factory.mktemp("unit")
            path = model
            if isinstance(model, str):
                path = folder / "m.lag"
                path.write_text(model)
            done = run_pkgen("export", path, "--as", "fmu", "--fmi", version, "-o", folder, *more)
            assert done.returncode == 0, done.stderr
            (MADE[key],) = folder.glob("*.fmu")
        return MADE[key]

    return make


def method(path: Path, name: str) -> int:
    """Its number in the enumeration."""
    found = fmpy.read_model_description(str(path))
    (variable,) = (v for v in found.modelVariables if v.name == "integrator.method")
    return next(int(item.value) for item in variable.declaredType.items if item.name == name)


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
        if kind in (FMU3Slave, FMU3Model):
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


def exact(t: float) -> float:
    """x of the rig, 2 x'' + 8 x = F, from x(0) = 1 with F = sin 3t."""
    return math.cos(2 * t) + (math.sin(3 * t) / -5 + 3 / 10 * math.sin(2 * t)) / 2


@pytest.fixture(name="rig")
def rig_(unit):
    return lambda *a, version="3", **how: Unit(unit(RIG, version), *a, **how)
