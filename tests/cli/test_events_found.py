"""Events that turn many times within a step: all are found, or it is said that some may be not."""

from __future__ import annotations

import json
import math

import pytest

from conftest import case, ran

MODEL = case("moving")


@pytest.mark.parametrize("method", ["gauss", "dop853", "rk4 --step 7", "gauss4 --step 4"])
def test_all_are_found(write, method: str) -> None:
    done = ran("run", write(MODEL), "--until", "30", "--json", "--method", *method.split())
    e, tops, pair = json.loads(done.stdout)["report"]["events"]
    assert e["count"] == 95 and e["doubts"] == 0
    for k, t in enumerate(e["times"], 1):
        assert t == pytest.approx(2 * math.pi * k / 20, rel=1e-14)
    away = math.acos(0.999)
    exact = sorted(2 * math.pi * k + s * away for k in range(5) for s in (-1, 1))[1:]
    assert tops["times"] == pytest.approx(exact, abs=1e-12)
    assert pair["times"] == pytest.approx([7.3 - 1e-4, 7.3 + 1e-4], abs=1e-10)
    assert "warning" not in done.stderr


def test_of_members_too(pkgen, write) -> None:
    done = pkgen("run", write(MODEL), "--scene", "members", "--json")
    events = json.loads(done.stdout)["report"]["events"]
    assert done.returncode == 0, done.stderr
    assert events[0]["count"] == sum(int(10 * k * 20 / (2 * math.pi)) for k in (1, 2, 3))


def test_what_turns_too_often_is_said_to(pkgen, write) -> None:
    done = pkgen("run", write(MODEL), "--set", "w=1e7", "--method", "rk4", "--step", "1", "--json")
    found = json.loads(done.stdout)["report"]["events"][0]
    assert found["doubts"] > 0
    assert "warning: event e: from t = 0 on its function turns too often" in done.stderr


def test_what_is_rounding_alone_is_told_and_not_followed_far(write) -> None:
    """On a rod x^2 + y^2 - 1 is noise: no window of a step shows it, and eight of the narrowest
    are enough to know."""
    path = write(
        "model rod\ncoord x, y\nkinetic (x'^2 + y'^2)/2\npotential 9.81*y\n"
        "constraint rod: x^2 + y^2 = 1\nstart x = 1, y = 0\nevent e: x^2 + y^2 - 1 rising\n"
    )
    steps = ["--until", "1", "--method", "rk4", "--step", "0.1"]
    done = ran("run", path, *steps, "--every", "1", "--json")
    assert "turns too often" in done.stderr
    (event,) = json.loads(done.stdout)["report"]["events"]
    assert 0 < event["doubts"] <= 20 * 10
