"""`pkgen run` by the exact flow of a linear model: no step is asked for, and events are seen."""

from __future__ import annotations

import json
import math

from conftest import ROOT, case

HUNG = case("hung")


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
    assert 120 < report["steps"] < 200 and report["order"] == 0
    (lowest,) = report["events"]
    assert len(lowest["times"]) == 32
    for i, t in enumerate(lowest["times"]):
        assert abs(t - (i + 0.5) * math.pi) < 1e-13
    done = pkgen(*exact, "--step", "50")
    assert done.returncode == 4
    assert "crossings of events could be missed in steps of 50: give at most 1.5" in done.stderr


def test_an_event_leaves_the_exact_flow(pkgen, tmp_path) -> None:
    """By default, with rows by time and at the event; of Foucault's pendulum the model has one."""
    model = tmp_path / "hung.lag"
    model.write_text(HUNG, encoding="utf-8")
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


def test_dense_output_of_long_steps_is_exact(pkgen, tmp_path) -> None:
    """Rows between the ends of steps of 50, by pieces of the series."""
    model = tmp_path / "hung.lag"
    model.write_text(HUNG.replace("event lowest: x' rising\n", ""), encoding="utf-8")
    run = ("run", model, "--until", "100", "--every", "0.5", "--method", "exponential", "--json")
    for t, x, *_ in json.loads(pkgen(*run, "--step", "50").stdout)["rows"]:
        assert abs(x - 0.25 - 0.75 * math.cos(2 * t)) < 1e-15
