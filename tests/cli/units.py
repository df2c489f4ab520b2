"""Units of models, as FMPy calls them."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import ROOT, run_pkgen

fmpy = pytest.importorskip("fmpy", reason="FMPy is missing: pip install 'pkgen[fmu]'")
for _version in ("fmi2", "fmi3"):
    pytest.importorskip(f"fmpy.{_version}")

PENDULUM = ROOT / "models" / "double_pendulum.lag"
TOP = ROOT / "models" / "bodies" / "heavy_top_rotation.lag"


@pytest.fixture(scope="session", name="unit")
def unit_(tmp_path_factory):
    """The path of a unit of a model, made once."""
    made: dict[tuple, Path] = {}

    def make(model: Path | str, version: str = "3", *more: str) -> Path:
        key = (model, version, more)
        if key not in made:
            folder = tmp_path_factory.mktemp("unit")
            path = model
            if isinstance(model, str):
                path = folder / "m.lag"
                path.write_text(model)
            done = run_pkgen("export", path, "--as", "fmu", "--fmi", version, "-o", folder, *more)
            assert done.returncode == 0, done.stderr
            (made[key],) = folder.glob("*.fmu")
        return made[key]

    return make


def method(path: Path, name: str) -> int:
    """Its number in the enumeration."""
    found = fmpy.read_model_description(str(path))
    (variable,) = (v for v in found.modelVariables if v.name == "integrator.method")
    return next(int(item.value) for item in variable.declaredType.items if item.name == name)
