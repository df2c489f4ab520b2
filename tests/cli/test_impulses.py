"""Where L or a constraint jumps the rates do: against closed forms, and against the same model with
ramps of width w in place of what bends and jumps, whose error falls with w."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
import tomllib

from conftest import expanded

RAMPS = tomllib.loads(Path(__file__).with_name("ramps.toml").read_text(encoding="utf-8"))


def written_with(text: str, w: float | None) -> str:
    """The model with what bends and jumps, or with ramps of that width."""
    bend, jump = "max(0, {0})", "step({0})"
    if w is not None:
        bend, jump = f"({{0}})*(1 + tanh(({{0}})/{w}))/2", f"(1 + tanh(({{0}})/{w}))/2"
    return expanded(expanded(text, "BEND", bend), "JUMP", jump)


def last(pkgen, path, *more: str) -> list[float]:
    named = re.search(r"^scene (\w+)", path.read_text(), re.MULTILINE)
    scene = ("--scene", named.group(1)) if named else ()
    done = pkgen("run", path, "--until", "2", "--every", "2", "--json", *scene, *more)
    assert done.returncode == 0, done.stderr + done.stdout
    return json.loads(done.stdout)["rows"][-1][1:]


def off(a: list[float], b: list[float]) -> float:
    return max(abs(x - y) for x, y in zip(a, b, strict=True))


QUICK = ("hold", "wire that moves", "potential")


@pytest.mark.parametrize(
    "name", [n if n in QUICK else pytest.param(n, marks=pytest.mark.long) for n in RAMPS]
)
def test_it_is_the_limit_of_steep_ramps(pkgen, write, name: str) -> None:
    found = last(pkgen, write(written_with(RAMPS[name], None)), "--rtol", "1e-12")
    ramps = []
    for w in (4e-3, 2e-3):
        more = ("--method", "dop853", "--rtol", "1e-11", "--max-step", str(w / 3))
        ramps.append(last(pkgen, write(written_with(RAMPS[name], w)), *more))
    wide, narrow = (off(found, x) for x in ramps)
    limit = [2 * b - a for a, b in zip(*ramps, strict=True)]  # of errors that are as w is
    assert 1e-9 < narrow < 0.6 * wide < 0.1
    assert narrow < 0.3 * wide or off(found, limit) < 0.25 * narrow
    kinks = last(pkgen, write(re.sub(r"(BEND|JUMP)\(", "0*(", RAMPS[name])))
    assert off(found, kinks) > 0.02  # without it the motion is another one
