"""What the tests of sweeps share."""

from __future__ import annotations

from pathlib import Path

from conftest import ROOT

DOUBLE = ROOT / "models/double_pendulum.lag"
PLAN = """members = 8
method = "rk4"
step = 0.1
until = 1
keep = ["final"]
[random]
theta1 = "-3 .. 3 [rad]"
"""


def contents(folder: Path) -> dict[str, bytes]:
    """The files of its data sets."""
    found = sorted(folder.glob("*/*.parquet"))
    assert found
    return {str(path.relative_to(folder)): path.read_bytes() for path in found}
