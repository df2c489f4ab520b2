"""step, abs, min and max in the equations: their zeros are located, so methods keep their order."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from conftest import case, ran, run_pkgen, written

# It falls on a spring that pushes and does not pull.
TRAMPOLINE = case("trampoline")
K, G, DROP = 40.0, 9.81, 0.5


def trampoline(t: float) -> float:
    """x at t: parabolas, and arcs of an oscillation about -g/k."""
    w, fall, speed = math.sqrt(K), math.sqrt(2 * DROP / G), math.sqrt(2 * G * DROP)
    arc = 2 * (math.pi - math.atan(speed * w / G)) / w
    s = math.fmod(t + fall, 2 * fall + arc)
    if s < 2 * fall:
        return DROP - G * (s - fall) ** 2 / 2
    s -= 2 * fall
    return G / K * (math.cos(w * s) - 1) - speed / w * math.sin(w * s)


def last(done) -> list[float]:
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["rows"][-1]


def test_an_accuracy_is_kept_across_switches(write) -> None:
    done = ran("run", write(TRAMPOLINE), "--scene", "bounces", "--json")
    found = json.loads(done.stdout)
    assert all(abs(x - trampoline(t)) < 1e-10 * 0.79 for t, x in found["rows"])
    assert found["report"]["switches"][0]["count"] > 20


def test_an_event_at_a_switch_is_met_once(pkgen, write) -> None:
    """Drag that turns with the rate: the apex is an event and the zero of abs."""
    path = write(TRAMPOLINE.replace("start x = 0.5", "force x = -0.02*x'*abs(x')\nstart x' = 50"))
    done = pkgen("run", path, "--until", "4", "--json", "--rtol", "1e-13", "--set", "k=1e-9")
    report = json.loads(done.stdout)["report"]
    apex = math.atan(50 * math.sqrt(0.02 / G)) / math.sqrt(0.02 * G)
    at = {s["name"]: s["times"] for s in report["switches"]}["x'"]
    assert at == [pytest.approx(apex, rel=1e-13)] and report["method"] == "gauss"
    assert report["events"][0]["count"] == 0


JUMPS = """model jumps
coord x, y
kinetic x'^2/2 + y'^2/2
force x = -2*step(x - 1)
force y = floor(-2*x)
start x = 0.2, x' = 1
event brakes: x'' < -1
event again: x'' + 1 rising
event far: if(x > 1, x, 0) > 0.5
event third: floor(-2*x) < -2.5
event through: x > 1
event late: x'' < -1 and x > 1.1
"""


@pytest.mark.parametrize("method", [("gauss",), ("dop853",), ("rk4", "--step", "0.07")])
def test_what_jumps_across_zero_at_a_switch_is_met_there(write, method: tuple[str, ...]) -> None:
    """An event function with the same step as a force crosses zero where this step jumps."""
    path = write(JUMPS)
    report = json.loads(ran("run", path, "--until", 3, "--json", "--method", *method).stdout)
    met = {e["name"]: e["times"] for e in report["report"]["events"]}
    # x = 1 + s - s^2, with s the time since 0.8
    wanted = {
        "brakes": [0.8],
        "again": [1.8],
        "far": [0.8],
        "third": [0.8],
        "through": [0.8],
        "late": [0.8 + (1 - math.sqrt(0.6)) / 2],
    }
    assert met == {name: pytest.approx(times, rel=1e-12) for name, times in wanted.items()}
    done = ran("run", write(JUMPS.replace("-1\n", "-1 stop\n", 1)), "--until", 3, "--json")
    report = json.loads(done.stdout)
    assert report["rows"][-1][0] == pytest.approx(0.8) and "brakes" in done.stderr


def test_steps_end_where_what_has_no_value_beyond_begins(pkgen, tmp_path: Path) -> None:
    """Hertz's contact, max(0, -x)^1.5, held on one side would be a root of what is negative."""
    path = written(
        tmp_path,
        "model hertz\ncoord x\nkinetic x'^2/2\npotential 9.81*x\n"
        "force x = 1000*max(0, -x)^1.5\nstart x = 0.5\n",
    )
    done = ran("run", path, "--until", "5", "--every", "5", "--rtol", "1e-10")
    assert "dop853" in done.stderr
    last = [float(x) for x in done.stdout.splitlines()[-1].split(",")]
    assert last[1:3] == pytest.approx([0.40022, -1.39917], abs=2e-5)  # by SciPy
    report = json.loads(pkgen("run", path, "--until", "5", "--json").stdout)["report"]
    assert len(report["switches"][0]["times"]) > 8  # in and out of each bounce


@pytest.mark.parametrize("method", ["gauss", "dop853", "radau"])
def test_a_relay_from_rest_at_its_jump_slides(tmp_path: Path, method: str) -> None:
    path = written(tmp_path, "model m\ncoord x\nkinetic x'^2/2\nforce x = 1 - 2*step(x)\n")
    done = run_pkgen("run", path, "--until", "3", "--method", method)
    assert done.returncode == 4 and "the motion stays on x = 0" in done.stderr


def test_a_switch_may_begin_with_a_number(pkgen, tmp_path: Path) -> None:
    """Such names of events are of contacts, which reports leave out."""
    text = "model m\ncoord x\nkinetic x'^2/2\nforce x = step(1 - x)\nstart x' = 1\n"
    done = pkgen("run", written(tmp_path, text), "--until", "2", "--json")
    (switch,) = json.loads(done.stdout)["report"]["switches"]
    assert switch["name"] == "1 - x" and switch["count"] == 1
