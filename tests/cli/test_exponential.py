"""`pkgen run` by the exact flow of a linear model: no step is asked for, and events are seen."""

from __future__ import annotations

import json
import math

from conftest import ROOT, case, written

HUNG = case("hung")


def test_an_event_leaves_the_exact_flow(pkgen, tmp_path) -> None:
    """By default, with rows by time and at the event; of Foucault's pendulum the model has one."""
    model = written(tmp_path, HUNG)
    for rows in (("--every", "10"), ("--at", "lowest")):
        report = json.loads(pkgen("run", model, "--until", "1000", *rows, "--json").stdout)[
            "report"
        ]
        assert (report["method"], report["evaluations"]) == ("exponential", 1)
        times = report["events"][0]["times"]
        assert len(times) == 318
        assert max(abs(t - (i + 0.5) * math.pi) for i, t in enumerate(times)) < 1e-12
    foucault = ROOT / "models" / "pendulums" / "foucault.lag"
    done = pkgen("run", foucault, "--until", "36000", "--every", "3600", "--json")
    report = json.loads(done.stdout)["report"]
    (outermost,) = report["events"]
    assert report["method"] == "exponential" and outermost["count"] == 4390
    (energy,) = report["drifts"]
    assert energy["max"] < 4e-16
