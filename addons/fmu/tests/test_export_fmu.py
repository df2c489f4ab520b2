"""`pkgen export --as fmu`: units of both versions, validated and run by FMPy, against `pkgen run`
and the kernels."""

from __future__ import annotations

import re
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from columns import MODELS, ran
from units import PENDULUM, TOP, fmpy, method, unit_  # noqa: F401

from conftest import ROOT, long_but
from pkgen.back.library import TARGETS

validate_fmu = pytest.importorskip("fmpy.validation").validate_fmu

BOTH = ("3", "2")


def columns(result: np.ndarray) -> dict[str, np.ndarray]:
    return {name: result[name] for name in result.dtype.names}


def agree(unit_rows: dict, rows: dict, within: float) -> float:
    """The largest difference of what both have, in units of each column's size, at least 1."""
    common = (unit_rows.keys() & rows.keys()) - {"t", "time"}
    assert len(common) >= 2
    assert len(rows["t"]) == len(unit_rows["time"])
    worst = 0.0
    for name in common:
        size = max(1.0, float(np.max(np.abs(rows[name]))))
        worst = max(worst, float(np.max(np.abs(rows[name] - unit_rows[name]))) / size)
    assert worst <= within
    return worst


@pytest.mark.parametrize("version", BOTH)
@pytest.mark.parametrize("model", long_but({PENDULUM, TOP}, MODELS), ids=lambda m: m.stem)
def test_a_unit_is_valid_and_steps_as_a_run_does(model: Path, version: str, unit, pkgen) -> None:
    path = unit(model, version)
    assert validate_fmu(str(path)) == []
    h, steps = 2.0**-7, 16
    # Steps of a run end at the knots of a table, those of a unit also at rows: they differ.
    step = h / 64 if "table" in model.read_text() else h
    found = fmpy.simulate_fmu(
        str(path),
        fmi_type="CoSimulation",
        stop_time=h * steps,
        output_interval=h,
        start_values={"integrator.step": step, "integrator.method": method(path, "rk4")},
    )
    options = ("--method", "rk4", "--step", step, "--until", h * steps, "--every", h)
    agree(columns(found), ran(model, *options), 1e-9)


SCENE = """model spun
param m = 2 [kg] in (0, 10]
param w = 3 [1/s] in [0, inf)
param k = m*w^2 in [0, inf)
input F [N]
rotation R
coord x [m]
state s
kinetic (1 [kg*m^2])*(omega(R).x^2 + 1.5*omega(R).y^2 + 2*omega(R).z^2) + m/2*x'^2
potential k/2*x^2
force x = F
rate s = x/(1 [m*s])
start x = w*(0.1 [m*s]), omega(R) = [w, 0.1*w, 0.5], s = 2
scene one
 set m = 3, F = 2
 start x' = m*(1 [m/s/kg]), s = w*(1 [s])
 until 1
 method rk4 step 0.01
 record x, x', s, omega(R) every 0.1
end
"""


@pytest.mark.parametrize("w", [2, 4])
def test_a_scene_is_the_default_of_a_unit_and_what_follows_follows(
    w: float, unit, tmp_path: Path
) -> None:
    (tmp_path / "m.lag").write_text(SCENE)
    path = unit(SCENE, "3", "--scene", "one", "--set", "w=2")
    found = fmpy.simulate_fmu(str(path), output_interval=0.1, start_values={"w": w})
    rows = ran(tmp_path / "m.lag", "--scene", "one", "--set", f"w={w}")
    agree(columns(found), rows, 1e-12)


MAGIC = {".so": b"\x7fELF", ".dll": b"MZ", ".dylib": b"\xcf\xfa\xed\xfe"}


@pytest.mark.long
def test_binaries_for_other_machines(unit) -> None:
    """By zig: each is what it says, with all calls of FMI; that of Linux runs here."""
    pytest.importorskip("ziglang", reason="zig is missing: pip install ziglang")
    path = unit(PENDULUM, "3", "--target", ",".join(TARGETS))
    with zipfile.ZipFile(path) as archive:
        for target in TARGETS.values():
            name = f"binaries/{target.fmi3}/double_pendulum{target.suffix}"
            code = archive.read(name)
            assert code.startswith(MAGIC[target.suffix]) and b"fmi3DoStep" in code, name
    assert validate_fmu(str(path)) == []
    rows = fmpy.simulate_fmu(str(path), fmi_type="CoSimulation", stop_time=1, output_interval=0.1)
    expected = ran(PENDULUM, "--until", 1, "--every", 0.1)
    agree(columns(rows), expected, 1e-9)


def test_the_pages_program_prints_what_the_page_says(unit) -> None:
    page = (ROOT / "addons/fmu/README.md").read_text()
    (program,) = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    command = [sys.executable, "-c", program]
    said = subprocess.run(command, cwd=unit(PENDULUM).parent, capture_output=True, text=True)
    shown = re.findall(r"# prints (.*)", program)
    assert said.stdout.split() == shown[0].split(), said.stderr
