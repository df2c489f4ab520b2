"""`expect` in scenes: where it is measured, what is said of a miss, what cannot be expected."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from conftest import case, ran, written

# x = cos t, exactly; the method is not, by some 1e-9.
SWING = case("expects_swing")


@pytest.fixture
def swing(tmp_path: Path) -> Path:
    path = written(tmp_path, SWING)
    return path


def test_what_is_met_is_counted_and_no_column(swing: Path) -> None:
    done = ran("run", swing, "--scene", "met")
    assert "expected: 12 of 12 met" in done.stderr
    assert "amplitude kept to " in done.stderr  # proved, but its drift is asked for
    assert done.stdout.splitlines()[0] == "t,x" and len(done.stdout.splitlines()) == 22
    # A time between rows is landed on, and the rows stay where they were.
    assert [row.split(",")[0] for row in done.stdout.splitlines()[5:8]] == ["2", "2.5", "3"]


def test_verdicts_in_json_and_beside_a_file(pkgen, swing: Path, tmp_path: Path) -> None:
    out = tmp_path / "rows.csv"
    done = pkgen("run", swing, "--scene", "missed", "--json", "-o", out)
    assert done.returncode == 4 and done.stderr == ""
    assert json.loads(done.stdout) == json.loads(Path(f"{out}.json").read_text())
    verdicts = json.loads(done.stdout)["expects"]
    assert [v["met"] for v in verdicts] == [False] * 7
    second = verdicts[1]
    assert second["text"] == "expect x = 0.5 within 0.1 at 2.25"
    assert second["value"] == pytest.approx(math.cos(2.25), abs=1e-7)
    assert (second["bound"], second["within"], second["t"]) == (0.5, 0.1, 2.25)
    assert verdicts[4]["value"] is None and "did not happen" in verdicts[4]["said"]


def test_c_of_a_scene_has_no_outputs_for_what_it_expects(pkgen, swing: Path, tmp_path: Path):
    assert pkgen(swing, "--scene", "met", "-o", tmp_path).returncode == 0
    header = (tmp_path / "swing_met.h").read_text()
    assert "swing_met_q_x = 0" in header and "swing_met_o_" not in header
