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
from conftest import ROOT, long_but, run_pkgen
from pkgen.back.library import TARGETS
from units import PENDULUM, TOP, fmpy, method, unit_  # noqa: F401

validate_fmu = pytest.importorskip("fmpy.validation").validate_fmu

MODELS = sorted((ROOT / "models").rglob("*.lag"))
BOTH = ("3", "2")


def columns(result: np.ndarray) -> dict[str, np.ndarray]:
    return {name: result[name] for name in result.dtype.names}


def ran(model: Path, *words: object) -> dict[str, np.ndarray]:
    done = run_pkgen("run", model, *map(str, words))
    assert done.returncode == 0, done.stderr
    names, *rows = done.stdout.splitlines()
    values = np.array([[float(x) for x in row.split(",")] for row in rows])
    return dict(zip(names.split(","), values.T, strict=True))


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
    found = fmpy.simulate_fmu(
        str(path),
        fmi_type="CoSimulation",
        stop_time=h * steps,
        output_interval=h,
        start_values={"integrator.step": h, "integrator.method": method(path, "rk4")},
    )
    options = ("--method", "rk4", "--step", h, "--until", h * steps, "--every", h)
    agree(columns(found), ran(model, *options), 1e-9)


MAGIC = {".so": b"\x7fELF", ".dll": b"MZ", ".dylib": b"\xcf\xfa\xed\xfe"}


@pytest.mark.long
def test_binaries_for_other_machines(unit) -> None:
    """By zig: each is what it says, with all calls of FMI; that of Linux runs here."""
    pytest.importorskip("ziglang", reason="zig is missing: pip install 'pkgen[targets]'")
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
    page = (ROOT / "docs" / "fmu.md").read_text()
    (program,) = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    command = [sys.executable, "-c", program]
    said = subprocess.run(command, cwd=unit(PENDULUM).parent, capture_output=True, text=True)
    shown = re.findall(r"# prints (.*)", program)
    assert said.stdout.split() == shown[0].split(), said.stderr
