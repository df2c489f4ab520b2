"""A second importer, fmi-sim of Rust's registry (cargo install fmi-sim), runs both versions.
It has nothing in common with FMPy but the standard."""

from __future__ import annotations

import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest
from columns import ran
from units import PENDULUM, TOP, unit_  # noqa: F401

from conftest import ROOT

pytestmark = pytest.mark.skipif(
    not shutil.which("fmi-sim"), reason="no fmi-sim here: cargo install fmi-sim"
)
STONE = ROOT / "models" / "particles" / "thrown_stone.lag"
STEP = 2.0**-7


def readable(path: Path, folder: Path) -> Path:
    """fmi-sim 0.7 refuses the standard's attribute `unit` of FMI 3: without it."""
    with zipfile.ZipFile(path) as given, zipfile.ZipFile(folder / path.name, "w") as new:
        for name in given.namelist():
            data = given.read(name)
            if name == "modelDescription.xml":
                data = re.sub(rb'(<Float64 [^>]*?) unit="[^"]*"', rb"\1", data)
            new.writestr(name, data)
    return folder / path.name


@pytest.mark.parametrize("version", ["3", "2"])
@pytest.mark.parametrize(
    ("kind", "method", "model"),
    [
        ("co-simulation", "rk4", PENDULUM),
        ("co-simulation", "rk4", TOP),
        ("co-simulation", "rk4", STONE),
        ("model-exchange", "euler", PENDULUM),
        ("model-exchange", "euler", STONE),
    ],
)
def test_it_runs_a_unit_as_pkgen_does(
    kind: str, method: str, model: Path, version: str, unit, tmp_path: Path
) -> None:
    """In model exchange by its own Euler steps, which are those of pkgen's euler."""
    path = readable(unit(model, version, "--method", "rk4", "--step", str(STEP)), tmp_path)
    words = ("--step", STEP, "--output-interval", STEP, "-f", 16 * STEP)
    command = ["fmi-sim", "--model", path, "-o", "rows.csv", kind, *map(str, words)]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    head, *lines = (tmp_path / "rows.csv").read_text().splitlines()
    once = {line.partition(",")[0]: line for line in lines}  # two rows at an event
    rows = zip(*(map(float, line.split(",")) for line in once.values()), strict=True)
    found = dict(zip(head.split(","), rows, strict=True))
    words = ("--method", method, "--step", STEP, "--until", 16 * STEP, "--every", STEP)
    expected = ran(model, *words)
    common = (found.keys() & expected.keys()) - {"t"}
    assert len(common) >= 2 and len(found["time"]) == 17
    for name in common:
        assert found[name] == pytest.approx(expected[name], abs=1e-11), name
