"""What stands still takes few steps: what rounding leaves of forces that cancel is no motion."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

HELD = """model held
gravity [0, 0, -9.81]
body b mass 2 inertia [0.1, 0.2, 0.25] at [0.1, 0.3, -0.4]
joint j: ground to b free at O
let p = b.point([0, 0, 0])
let r = b.point([1, 0, 0])
let s = b.point([0, 1, 0])
"""


@pytest.mark.parametrize("method", ["radau", "gauss", "dop853"])
def test_a_body_that_points_hold_at_rest(method: str, pkgen, tmp_path: Path) -> None:
    """Once 11,060 steps of radau: the forces in the rows cancel to 1e-15 of themselves."""
    rows = (f"constraint {p}{c}: {p}.{c} = {int((p, c) in (('r', 'x'), ('s', 'y')))}\n"
            for p in "prs" for c in "xyz")  # fmt: skip
    model = tmp_path / "held.lag"
    model.write_text(HELD + "".join(rows))
    done = pkgen("run", model, "--until", 1, "--every", 1, "--method", method, "--json")
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout[done.stdout.index("{") :])["report"]
    assert report["steps"] + report["rejections"] <= 20
