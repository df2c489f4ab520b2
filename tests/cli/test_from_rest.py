"""A motion from rest has no scale but what its first steps give it."""

from __future__ import annotations

import json
from pathlib import Path

MOVING_PIVOT = """model pivot
coord a
let X = 0.3*t + 0.02*t^2
let P = [X + sin(a), -cos(a), 0]
kinetic dot(P', P')/2
potential 9.81*P.y
"""


def test_a_momentum_at_rest_is_rounded_too(pkgen, tmp_path: Path) -> None:
    """p has the rounding of cos(a)*X', beside which a' at first is nothing: radau rejected 62 steps
    down to 1e-29."""
    (tmp_path / "pivot.lag").write_text(MOVING_PIVOT)
    words = ("--method", "radau", "--rtol", "1e-12", "--until", "0.1", "--every", "0.05")
    done = pkgen("run", tmp_path / "pivot.lag", *words, "--json")
    report = json.loads(done.stdout)["report"]
    assert report["rejections"] < 5 and report["step_min"] > 1e-6
