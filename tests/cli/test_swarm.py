"""`swarm` in scenes: members as single runs, what they start at, what cannot be one."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from conftest import case, written
from pkgen.front.check.check import check_text
from pkgen.front.check.scene_numbers import Values
from pkgen.run.ensemble import Column
from pkgen.scenes import swarm
from pkgen.source import Source
from pkgen.system.exits import UsageError

PENDULUM = case("swarm_pendulum")


@pytest.fixture
def pendulum(tmp_path: Path) -> Path:
    path = written(tmp_path, PENDULUM)
    return path


def test_members_are_single_runs(pkgen, pendulum: Path) -> None:
    done = pkgen("run", pendulum, "--scene", "many", "--json")
    assert done.returncode == 4
    result = json.loads(done.stdout)
    assert [c["name"] for c in result["columns"]] == ["k", "t", "theta", "energy"]
    rows = result["rows"]
    assert [row[0] for row in rows[::4]] == list(range(-2, 71)) and len(rows) == 4 * 73
    alone = json.loads(pkgen("run", pendulum, "--scene", "one", "--json").stdout)["rows"]
    assert [row[1:] for row in rows if row[0] == 5] == [pytest.approx(x, rel=1e-12) for x in alone]
    # The worst member is named by its k: the energy at rest is -4.905 and grows with k^2.
    first, second, third = result["expects"]
    assert first["met"] and third["met"] and not second["met"]
    assert second["member"] == 70 and second["t"] == 0.8
    worst = max(rows, key=lambda row: row[3] if row[1] == 0.8 else -math.inf)
    assert worst[0] == 70 and second["value"] == worst[3]
    assert third["member"] > 55  # it swings the most
    assert result["settings"]["ensemble"] == "swarm k"


FUNCTIONS = case("swarm_m")


def test_the_starts_of_all_members_are_what_each_alone_has() -> None:
    model, _ = check_text(Source("m.lag", FUNCTIONS))
    names = ("q[1]", "q[2]", "q[3]", "q[1]'", "q[3]'", "x")
    known = {name: Column(name, "q", i, "") for i, name in enumerate(names)}
    found = swarm.members(model, model.scenes[0], Values(model, {}), known, {"q[3]"})
    assert [c.name for c in found.columns] == ["q[1]", "q[2]", "q[1]'", "q[3]'"]
    assert (found.lines, found.counted) == (range(1, 6), "k")
    for k, row in enumerate(found.values, 1):
        assert list(row) == pytest.approx(
            [
                k - 10 * k / 7 + 1 / 3,
                -(2**k) * math.atan2(k, 3) + math.sqrt(k * k + 4 + k),
                sum(math.sin(j * k) / j for j in (1, 2, 3)) + (k >= 3) + max(k, 2) - abs(1 - k),
                k * k + 3 * k + 3 + math.asin(k / 5),
            ],
            rel=1e-14,
        )


def test_a_start_that_is_no_number_names_its_member() -> None:
    text = FUNCTIONS.replace("asin(k/5)", "asin(k/4)")
    model, _ = check_text(Source("m.lag", text))
    known = {"q[3]'": Column("q[3]'", "v", 2, "")}
    with pytest.raises(UsageError, match=r"m.lag:11:17: .*start q': no finite number for k = 5"):
        swarm.members(model, model.scenes[0], Values(model, {}), known, ())


def test_too_many_starts_are_refused_before_they_take_the_memory() -> None:
    text = (
        "model m\nsize n = 6\ncoord q[1..n]\nkinetic sum(q[i]'^2/2, i = 1..n)\n"
        "scene s\n  swarm k = 1..9000000\n  start q[i = 1..n] = i*k\nend\n"
    )
    model, _ = check_text(Source("m.lag", text))
    known = {f"q[{i}]": Column(f"q[{i}]", "q", i, "") for i in range(1, 7)}
    said = r"m.lag:6:9: .* 9,000,000 members with 6 starts each; the limit is 50,000,000 in all"
    with pytest.raises(UsageError, match=said):
        swarm.members(model, model.scenes[0], Values(model, {}), known, ())
