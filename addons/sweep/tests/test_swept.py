"""`pkgen show` of a sweep: the plan's options come first, what is asked beside them wins."""

from __future__ import annotations

from pathlib import Path

import pytest
from sweeps import DOUBLE

from pkgen.cli.commands import parsed
from pkgen_sweep import folder

pytest.importorskip("pyarrow")
PLAN = """members = 4
until = 1
method = "rk4"
step = 0.1
set = ["l1=2 [m]"]
start = ["theta1'=0.5"]
keep = ["final"]
[random]
theta2 = "-3 .. 3 [rad]"
m2 = "1 .. 2 [kg]"
"""


@pytest.mark.needs_addon("web")
def test_options_beside_the_plan_win(pkgen, tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text(PLAN)
    done = pkgen("sweep", DOUBLE, "--plan", tmp_path / "plan.toml", "-o", tmp_path / "s")
    assert done.returncode == 0, done.stderr

    def taken(*words: str) -> object:
        _, options = parsed(["show", str(tmp_path / "s"), *words])
        folder.taken(options)
        return options

    plain = taken()
    assert (plain.until, plain.set, plain.start) == ("1", ["l1=2 [m]"], ["theta1'=0.5"])
    asked = taken("--until", "3", "--set", "l1=3", "--member", "2")
    assert asked.until == "3"
    names = [one.partition("=")[0] for one in (*asked.set, *asked.start)]
    assert asked.set[:2] == ["l1=2 [m]", "l1=3"]  # the last of a name is in force
    assert names[2:] == ["m2", "theta1'", "theta2"]
