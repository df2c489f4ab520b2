"""`pkgen run` with events: stops, sections, reports; scenes run, options override them."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from conftest import ROOT, case, ran, table, written

STONE = ROOT / "models/particles/thrown_stone.lag"

# Closed forms (REGIMES X2): with s = sqrt(k/m), v falls as tan on the way up, and the speed at the
# ground follows from the work of drag.
M, K, G, V0 = 1.0, 0.02, 9.81, 50.0
APEX_T = math.sqrt(M / (K * G)) * math.atan(V0 * math.sqrt(K / (M * G)))
APEX_Y = M / (2 * K) * math.log(1 + K * V0**2 / (M * G))
IMPACT = V0 / math.sqrt(1 + K * V0**2 / (M * G))

PENDULUM = case("events_pendulum")


def test_a_run_stops_at_its_event() -> None:
    assert f"{APEX_T:.9f} {APEX_Y:.9f} {IMPACT:.9f}" == "2.604896472 45.194264937 20.249653994"
    done = ran("run", STONE, "--rtol", "1e-13", "--every", "2")
    head, rows = table(done.stdout)
    assert [row[0] for row in rows[:-1]] == [0, 2, 4, 6]
    t, y, v, _ = rows[-1]
    assert head == ["t", "y", "y'", "energy"]
    assert v == pytest.approx(-IMPACT, rel=1e-11) and -1e-12 < y <= 0
    assert f"stopped at event ground at t = {t:.17g}" in done.stderr
    assert "event apex: once, at t = 2.60489647" in done.stderr


def test_the_report_lists_them(pkgen, tmp_path: Path) -> None:
    done = pkgen("run", STONE, "--rtol", "1e-13", "--json", "-o", tmp_path / "rows.csv")
    report = json.loads(done.stdout)["report"]
    apex, ground = report["events"]
    assert (apex["name"], apex["stop"], apex["count"]) == ("apex", False, 1)
    assert apex["times"] == [pytest.approx(APEX_T, rel=1e-12)]
    assert (ground["stop"], ground["times"]) == (True, [report["t"]])
    assert report["status"] == "PK_STOPPED_EVENT" and report["event_tries"] > 5
    assert report["drifts"] == [] and report["step_min"] > 0


def test_a_row_at_each_crossing(pkgen) -> None:
    done = pkgen("run", STONE, "--rtol", "1e-13", "--at", "apex", "--record", "y,energy")
    head, rows = table(done.stdout)
    assert head == ["t", "y", "energy"]
    assert rows == [pytest.approx([APEX_T, APEX_Y, M * G * APEX_Y], rel=1e-12)]


def test_rows_by_time_and_at_events_are_in_order(pkgen, tmp_path: Path) -> None:
    path = written(tmp_path, PENDULUM)
    command = ["run", path, "--scene", "swings", "--every", "0.5", "--method"]
    for method in ("gauss", "dop853", "verlet --step 0.01"):
        _, rows = table(pkgen(*command, *method.split()).stdout)
        times = [row[0] for row in rows]
        assert times == sorted(times) and len(times) == 81 + 4
        assert times[0] == 0 and times[-1] == 40


def test_a_scene_runs_and_options_override_it(pkgen) -> None:
    options = ["--set", "g=2", "--until", "7", "--every", "1", "--method", "rk4", "--step", "0.25"]
    done = pkgen("run", STONE, "--scene", "moon", *options, "--start", "y'=3.3", "--json")
    result = json.loads(done.stdout)
    assert result["report"]["method"] == "rk4" and result["report"]["step"] == 0.25
    assert [row[0] for row in result["rows"]] == pytest.approx([0, 1, 2, 3, 3.3])
    assert result["rows"][-1][2] == pytest.approx(-3.3, rel=1e-13)
    assert [c["name"] for c in result["columns"]] == ["t", "y", "p_y"]
    assert [c["unit"] for c in result["columns"]] == ["s", "m", "kg*m/s"]
    # until and g of the scene depend on each other: with --set g=2 it is longer than the flight.
    done = pkgen("run", STONE, "--scene", "moon", "--set", "g=2")
    assert table(done.stdout)[1][-1][0] == pytest.approx(50, rel=1e-13)


FALL = (math.pi / 4 + 0.5) / math.sqrt(2)  # from rest at r = 1 to 1/2 under -1/r^2; pi/sqrt(8) to 0


def test_an_event_before_a_singularity_in_the_same_step(pkgen, tmp_path: Path) -> None:
    path = written(
        tmp_path,
        "model fall\ncoord r\nkinetic r'^2/2\npotential -1/r\nstart r = 1\n"
        "event half: r - 0.5 falling\n",
    )
    command = ["run", path, "--until", "4", "--every", "2", "--step", "2", "--method", "gauss8"]
    done = pkgen(*command, "--json")
    report = json.loads(done.stdout)["report"]
    assert done.returncode == 4 and report["status"] == "PK_SINGULAR_TIME"
    assert "r vanishes at t = 1.11" in report["reason"]
    assert report["events"][0]["times"] == [pytest.approx(FALL, abs=1e-5)]
    path.write_text(path.read_text().replace("falling", "falling stop"))
    done = ran(*command)
    t, r, *_ = table(done.stdout)[1][-1]
    assert t == pytest.approx(FALL, abs=1e-5) and r == pytest.approx(0.5, abs=1e-12)
