"""Events of a swarm's members and of an ensemble's: sections, stops, expectations of each."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from conftest import case

HENON_HEILES = case("henon_heiles")
SHOT = case("shot")


def test_a_section_is_that_of_each_member_alone(pkgen, write) -> None:
    path = write(HENON_HEILES)
    runs = [pkgen("run", path, "--scene", "many", "--json", "--threads", str(n)) for n in (1, 2)]
    found, other = (json.loads(run.stdout) for run in runs)
    rows = found["rows"]
    assert [c["name"] for c in found["columns"]] == ["k", "t", "y", "y'"]
    assert rows == other["rows"] and [row[0] for row in rows] == sorted(row[0] for row in rows)
    alone = json.loads(pkgen("run", path, "--scene", "one", "--json").stdout)["rows"]
    assert [row[1:] for row in rows if row[0] == 17] == alone and len(alone) > 5
    report = found["report"]
    assert report["events"][0]["count"] == len(rows) and report["done"] == 26
    times = [min(t for k, t, *_ in rows if k == member) for member in range(5, 31)]
    met, late = found["expects"]
    assert met["met"] and met["within"] == 1e-10 and 0 < abs(met["value"] - 1 / 12) < 1e-10
    assert late["met"] == (max(times) < 6.5) and late["value"] == max(times)
    assert late["member"] == 5 + times.index(max(times))


def test_a_stop_ends_its_member_alone(pkgen, write) -> None:
    done = pkgen("run", write(SHOT), "--scene", "angles", "--json")
    result = json.loads(done.stdout)
    assert done.returncode == 4 and result["report"]["failed"] == 0
    for k in range(1, 90):
        rows = [row[1:] for row in result["rows"] if row[0] == k]
        up, along = 30 * math.sin(math.pi * k / 180), 30 * math.cos(math.pi * k / 180)
        flight = 2 * up / 9.81
        assert [row[0] for row in rows[:-1]] == [2 * i for i in range(math.ceil(flight / 2))]
        assert rows[-1][:2] == [
            pytest.approx(flight, rel=1e-12),
            pytest.approx(along * flight, rel=1e-12),
        ]
    met = [expect["met"] for expect in result["expects"]]
    assert met == [True, True, False] and result["expects"][2]["member"] == 89
    said = pkgen("run", write(SHOT), "--scene", "angles").stderr
    assert "of k = 89 is not below 3: off by 0.0576" in said


def test_rows_at_an_event_of_an_ensemble(pkgen, write, tmp_path: Path) -> None:
    members = tmp_path / "members.csv"
    members.write_text("x',y'\n3,4\n5,-1\n1,40\n")
    run = ("run", write(SHOT), "--ensemble", members, "--until", "10", "--json")
    done = pkgen(*run, "--at", "apex")
    result = json.loads(done.stdout)
    assert [row[0] for row in result["rows"]] == [1, 3]
    assert [row[1] for row in result["rows"]] == [pytest.approx(v / 9.81) for v in (4, 40)]
    rows = json.loads(pkgen(*run).stdout)["rows"]  # nothing falls through zero from zero
    assert [row[1] for row in rows] == [pytest.approx(8 / 9.81), 10, pytest.approx(80 / 9.81)]
