"""Vectors as outputs, columns and expectations, and rot() against the motion it describes."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from conftest import STRICT, case, written

# A free particle, in coordinates of a frame that is tilted and then turns: it moves straight on in
# space. No two of its angles commute.
TURNING = case("turning")


@pytest.fixture
def turning(tmp_path: Path) -> Path:
    path = written(tmp_path, TURNING)
    return path


def test_components_have_names_of_their_own_in_c(pkgen, turning: Path, tmp_path: Path) -> None:
    """`place.x` and `place_x` are two outputs; families of vectors lie component by component."""
    turning.write_text(turning.read_text() + "observe pair[i = 1..2] = i*s\n")
    assert pkgen(turning, "-o", tmp_path).returncode == 0
    header = (tmp_path / "turning.h").read_text()
    for name, index in (("place_x_", 0), ("place_y", 1), ("place_x", 3), ("pair_z", 8)):
        assert f" turning_o_{name} = {index}" in header
    done = subprocess.run(
        ["gcc", *STRICT, "-c", "turning.c", "-o", "turning.o"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
