"""What is wrong with a scene is said by `check`, as by a run of it; options that make a right scene
wrong are named."""

from __future__ import annotations

from pathlib import Path

import pytest

DAMPED = """model damped
param c = 0.1 in [0, inf)
coord x, y, z
kinetic   (x'^2 + y'^2 + z'^2)/2
potential x^2/2 + y^2
dissipation c*x'^2 + c*x'^4
observe twice = 2*x
event hit: x falling
start x = 1, y = 0.5
scene one
  until 1
  {}
end
"""
SWARM = "swarm k = 1..3\n  start x = k\n  record x every 0.25"
# What is wrong, and the text that the caret is below.
WRONG = [
    ("method verlet", "verlet has a fixed step: say how long it is", "method verlet"),
    ("method verle step 0.1", "there is no method 'verle'", "verle"),
    ("method rk4 step 0.1 rtol 1e-9", "rk4 has a fixed step: 'rtol' is for adaptive", "1e-9"),
    ("method exponential rtol 1e-9", "exponential is exact: 'rtol' is for adaptive", "1e-9"),
    ("method verlet step 0.1", "verlet needs a system that is separable", "verlet"),
    ("expect drift(energy) < 1", "drift(energy): the energy is not constant", "drift(energy)"),
    ("expect drift(p_x) < 1", "drift(p_x): p_x is not constant here", "drift(p_x)"),
    ("hold x = sin(t)\n  record p_x", "'p_x': x is held here, and has no momentum", "p_x"),
    (
        "swarm k = 1..3\n  start x = k, x' = 2*k\n  record z",
        "all members of the swarm would be the same: nothing recorded depends",
        "k = 1..3",
    ),
    ("record x every 1e-9", "1,000,000,001 rows of 2 numbers are some 40 GB", "1e-9"),
    (
        "record x every 0.01\n  swarm k = 1..9000000\n  start x = k",
        "9,000,000 members of 101 rows of 2 numbers are some 36 GB",
        "k = 1..9000000",
    ),
    (f"{SWARM}\n  expect x < 1 at 0.3", "members of a swarm have no row at t = 0.3", "0.3"),
]


def damped(folder: Path, clauses: str) -> Path:
    path = folder / "damped.lag"
    path.write_text(DAMPED.format(clauses))
    return path


@pytest.mark.parametrize("command", [["check"], ["run", "--scene", "one"]])
@pytest.mark.parametrize(("clauses", "said", "under"), WRONG)
def test_what_is_wrong_is_known_without_a_run(
    pkgen, tmp_path: Path, clauses: str, said: str, under: str, command: list[str]
) -> None:
    done = pkgen(*command, damped(tmp_path, clauses))
    assert done.returncode == 1
    message, line, caret, *_ = done.stderr.splitlines()
    assert f"error: {said}" in message
    assert line[caret.index("^") : caret.rindex("^") + 1] == under


def test_check_reports_all_scenes_and_explain_each_in_its_place(pkgen, tmp_path: Path) -> None:
    text = "expect drift(energy) < 1\nend\nscene two\n  method verlet step 0.1"
    path = damped(tmp_path, text)
    done = pkgen("check", path)
    assert done.returncode == 1 and done.stderr.count(": error: ") == 2
    done = pkgen("explain", path)
    first, second = done.stdout.split("\nScene ")[1:]
    assert done.returncode == 0 and "the energy is not constant here" in first
    assert "verlet needs a system that is separable" in second and "^^^^^^" in second
    done = pkgen(path, "--scene", "two", "-o", tmp_path)
    assert done.returncode == 1 and "verlet needs" in done.stderr
    assert not list(tmp_path.glob("*.c"))
