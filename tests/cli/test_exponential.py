"""`pkgen run` by the exact flow of a linear model: no step is asked for, and events are seen."""

from __future__ import annotations

import json
import math

HUNG = """\
model hung
param k = 4
coord x
kinetic x'^2/2
potential k*x^2/2 - x
start x = 1
event lowest: x' rising
"""


def test_an_exact_method_needs_no_step(pkgen, tmp_path) -> None:
    """x = 1/4 + 3/4 cos 2t; steps are those of rows, but short enough to see every event."""
    model = tmp_path / "hung.lag"
    model.write_text(HUNG, encoding="utf-8")
    exact = ("run", model, "--method", "exponential", "--until", "100", "--every", "50", "--json")
    done = json.loads(pkgen(*exact).stdout)
    for t, x, rate, *_ in done["rows"]:
        assert abs(x - 0.25 - 0.75 * math.cos(2 * t)) < 1e-15
        assert abs(rate + 1.5 * math.sin(2 * t)) < 2e-15
    report = done["report"]
    assert 60 < report["steps"] < 100 and report["order"] == 0
    (lowest,) = report["events"]
    assert len(lowest["times"]) == 32
    for i, t in enumerate(lowest["times"]):
        assert abs(t - (i + 0.5) * math.pi) < 1e-13
    done = pkgen(*exact, "--step", "50")
    assert done.returncode == 4
    assert "crossings of events could be missed in steps of 50: give at most 1.5" in done.stderr
