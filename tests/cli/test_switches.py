"""step, abs, min and max in the equations: their zeros are located, so methods keep their order."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from conftest import case, ran

PULSE = case("switches_pulse")
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


def test_a_force_for_a_while_is_exact(pkgen, write) -> None:
    path = write(PULSE)
    a, on = 3 / 2, 0.7123 - 0.3
    exact = 2 + a * on**2 / 2 + a * on * (2 - 0.7123), 1 + a * on
    for method in (
        "gauss --rtol 1e-13",
        "verlet --step 0.2",
    ):
        found = last(pkgen("run", path, "--until", "2", "--json", "--method", *method.split()))
        assert found[1:3] == [pytest.approx(x, rel=2e-15) for x in exact], method
    done = pkgen("run", path, "--until", "2", "--json", "--every", "0.17")  # by dense output
    report = json.loads(done.stdout)
    for t, x, *_ in report["rows"]:
        s = min(max(t - 0.3, 0), on)
        assert x == pytest.approx(t + a * s**2 / 2 + a * s * max(t - 0.7123, 0), abs=2e-15)
    assert report["report"]["method"] == "gauss"
    switches = report["report"]["switches"]
    assert [(s["name"], s["count"]) for s in switches] == [("t - t0", 1), ("t1 - t", 1)]
    assert switches[1]["times"] == [pytest.approx(0.7123, abs=1e-15)]


def test_a_one_sided_spring_keeps_the_order(pkgen, write) -> None:
    path = write(TRAMPOLINE)
    exact = trampoline(20)
    for method, bound in (("gauss", 3e-12), ("dop853", 3e-11)):
        run = ("run", path, "--until", "20", "--every", "20", "--json", "--method", method)
        assert abs(last(pkgen(*run, "--rtol", "1e-14"))[1] - exact) < bound
    for method, order in (("rk4", 4), ("verlet", 2)):
        errors = []
        for step in ("0.01", "0.005", "0.0025"):
            run = ("run", path, "--until", "20", "--every", "20", "--json")
            found = last(pkgen(*run, "--method", method, "--step", step))[1]
            errors.append(abs(found - exact))
        slope = math.log2(errors[0] / errors[-1]) / 2
        assert errors[-1] > 0 and abs(slope - order) < 0.35, (method, slope)


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


def test_what_stays_on_a_switch_ends_with_the_reason(pkgen, write) -> None:
    path = write(case("block"))
    done = pkgen("run", path, "--until", "20", "--json")
    report = json.loads(done.stdout)["report"]
    assert done.returncode == 4 and report["status"] == "PK_SLIDING"
    assert (
        "the motion stays on x' = 0" in done.stderr and "last valid time 6.28318530" in done.stderr
    )
    assert report["t"] == pytest.approx(2 * math.pi, rel=1e-10) and report["steps"] < 300


def test_explain_lists_them(pkgen, write) -> None:
    said = pkgen("explain", write(PULSE)).stdout
    assert "between zeros of t - t0, t1 - t, which a run locates" in said
    said = pkgen("explain", write(PULSE.replace("step(t1 - t)", "step(m - F)"))).stdout
    assert "between zeros of t - t0, which" in said  # of parameters alone it is a constant


def test_a_box_of_soft_walls(pkgen, write) -> None:
    """Twenty thousand switchings, several of them in one step: two methods find the same ones."""
    text = case("box")
    for method in ("gauss", "dop853"):
        text += f"""scene by_{method}
  swarm k = 1..300
  start x = sin(k), y = cos(3*k)*0.99, x' = 2*sin(7*k), y' = 3*cos(11*k)
  until 20
  method {method} rtol 1e-12
  record x, y every 20
end
"""
    path = write(text)
    runs = [pkgen("run", path, "--scene", f"by_{m}", "--json") for m in ("gauss", "dop853")]
    one, two = (json.loads(run.stdout) for run in runs)
    for a, b in zip(one["rows"], two["rows"], strict=True):
        assert a == pytest.approx(b, abs=2e-10)
    assert one["report"]["switches"] == two["report"]["switches"]
    assert sum(s["count"] for s in one["report"]["switches"]) > 20000


def test_an_argument_that_stays_zero_is_above(tmp_path: Path) -> None:
    """step(0) = 1, also where another switch has made it 0: max(y, 0) for y < 0."""
    path = tmp_path / "plateau.lag"
    path.write_text(
        "model plateau\ncoord y, z\nkinetic (y'^2 + z'^2)/2\npotential (y^2 + z^2)/2\n"
        "force y = 0.2*step(max(y, 0))\nforce z = 0.2\nstart y = 1, z = 1\n"
    )
    done = ran("run", path, "--until", "6", "--every", "2")
    table = [[float(x) for x in row.split(",")] for row in done.stdout.splitlines()[1:]]
    assert len(table) == 4 and table[2][1] < -0.3
    for row in table:
        assert row[1] == pytest.approx(row[2], abs=1e-9)


def test_steps_end_where_what_has_no_value_beyond_begins(pkgen, tmp_path: Path) -> None:
    """Hertz's contact, max(0, -x)^1.5, held on one side would be a root of what is negative."""
    path = tmp_path / "hertz.lag"
    path.write_text(
        "model hertz\ncoord x\nkinetic x'^2/2\npotential 9.81*x\n"
        "force x = 1000*max(0, -x)^1.5\nstart x = 0.5\n"
    )
    done = ran("run", path, "--until", "5", "--every", "5", "--rtol", "1e-10")
    assert "dop853" in done.stderr
    last = [float(x) for x in done.stdout.splitlines()[-1].split(",")]
    assert last[1:3] == pytest.approx([0.40022, -1.39917], abs=2e-5)  # by SciPy
    refused = pkgen("run", path, "--until", "5", "--method", "gauss")
    assert refused.returncode == 4 and "needs a system that is smooth" in refused.stderr
    report = json.loads(pkgen("run", path, "--until", "5", "--json").stdout)["report"]
    assert len(report["switches"][0]["times"]) > 8  # in and out of each bounce
    assert "roots of what bends; between zeros of x, which" in pkgen("explain", path).stdout


def test_what_bends_in_time_alone_and_moves_nothing_is_smooth(write) -> None:
    path = write("model told\ncoord x\nkinetic x'^2/2\npotential x^2/2 + abs(t - 1)\nstart x = 1\n")
    done = ran("run", path, "--until", "3", "--every", "3", "--method", "gauss")
    last = [float(x) for x in done.stdout.splitlines()[-1].split(",")]
    assert last[1:3] == pytest.approx([math.cos(3), -math.sin(3)], abs=1e-9)
