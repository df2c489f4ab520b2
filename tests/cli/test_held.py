"""What stands still takes few steps: what rounding leaves of forces that cancel is no motion."""

from __future__ import annotations

import json
from pathlib import Path

from conftest import case, ran

HELD = case("held_held")


def test_a_body_that_points_hold_at_rest(tmp_path: Path) -> None:
    """Once 11,060 steps. Steps are rejected if one sample tells the rounding of accelerations, or
    the forces in rows do not; if quaternions do not err by what rounding turns; if radau refuses
    corrections that rounding leaves."""
    model = tmp_path / "held.lag"
    ones = {"r.x", "s.y"}
    places = [f"{point}.{axis}" for point in "prs" for axis in "xyz"]
    rows = (f"constraint {p.replace('.', '')}: {p} = {int(p in ones)}\n" for p in places)
    model.write_text(HELD + "".join(rows))
    how = ("--until", 1, "--every", 1, "--method", "radau")
    done = ran("run", model, *how, "--json", "-o", tmp_path / "rows.csv")
    report = json.loads(done.stdout)["report"]
    assert (report["steps"], report["rejections"]) == (1, 0)
    assert "nearly singular" not in done.stderr  # J M^-1 J^T is not: its condition number is 26
