"""Constraints and rotations of families kept as loops, as runs: beside members written out, by
explicit and implicit methods, with events on members, in rings, in ensembles."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from loop_runs import bodies, rope
from rotation_models import made
from test_loops_features import both, rows  # noqa: F401 (a fixture)

from conftest import ran

METHODS = {
    "gauss2": ("--step", "0.05"),
    "dop853": ("--rtol", "1e-11"),
    "radau": ("--rtol", "1e-9"),
    "lobatto3": ("--step", "0.05"),
    "gauss": ("--rtol", "1e-11"),
    "radau5": ("--step", "0.05"),
    "gauss4": ("--step", "0.1"),
    "rk4": ("--step", "0.02"),
}
SHORT = {("rope", 1)}
MADE = {"rope": rope, "bodies": bodies, "spins": lambda dice: made(dice, 3).text}
CASES = [
    pytest.param(name, seed, marks=[] if (name, seed) in SHORT else pytest.mark.long)
    for name in MADE
    for seed in range(5)
]


@pytest.mark.parametrize(("name", "seed"), CASES)
def test_random_models_are_those_of_members_written_out(name: str, seed: int, both) -> None:  # noqa: F811
    dice = random.Random(seed)
    text = MADE[name](dice)
    method = [*METHODS][(seed * 3 + len(name)) % len(METHODS)]
    words = ("--until", 1, "--every", 0.25, "--method", method, *METHODS[method])
    words = (*words, "--max-seconds", 60)  # a loaded machine writes out for more than 8
    (loops, told), (written, said) = both(text, *words)
    error = 1e-8 if method == "radau" else 3e-11
    assert len(loops) == len(written) == 5
    for one, other in zip(loops, written, strict=True):
        # Rotations stand one behind the other if written out.
        assert sorted(one) == pytest.approx(sorted(other), rel=error, abs=error), text
    for one, other in zip(told.get("events", []), said.get("events", []), strict=True):
        assert one["times"] == pytest.approx(other["times"], abs=1e-7), text
    assert loops[0][1:] != loops[-1][1:]


@pytest.mark.parametrize("method", [("rk4", "--step", "0.02"), ("gauss2", "--step", "0.05")])
def test_members_of_an_ensemble_of_ropes_are_single_runs(
    method: tuple[str, ...],
    pkgen,
    tmp_path: Path,
) -> None:
    model, table = tmp_path / "rope.lag", tmp_path / "members.csv"
    model.write_text(rope(random.Random(5), 70))
    table.write_text("k,X'\n0.5,0\n1.5,0\n0.7,0\n")
    how = ("--until", 0.5, "--every", 0.25, "--method", *method, "--record", "x[3],y[70],pull")
    several = ran("run", model, *how, "--ensemble", table, "--threads", 2)
    found = rows(several.stdout)
    for member, k in enumerate((0.5, 1.5, 0.7)):
        done = ran("run", model, *how, "--set", f"k={k}")
        mine = [row[1:] for row in found if row[0] == member + 1]
        assert len(mine) == 3
        for one, other in zip(rows(done.stdout), mine, strict=True):
            assert one == pytest.approx(other, rel=1e-10, abs=1e-10)
    assert found[2][2:] != found[5][2:]


LINEAR = """\
model linear
size N = 6
coord x[1..N], y[1..N], X
fixed x[0] = sin(t)
kinetic sum((1 + i/N)*x[i]'^2/2 + y[i]'^2{inertia}, i = 1..N) + X'^2
potential sum((x[i] - x[i-1])^4 + cos(y[i]), i = 1..N)
constraint tie[i = 1..N]: y[i] = x[i]/2 + 0.1*X{row}
constraint mean: sum(y[i]*i, i = 1..N) = sum(x[i]*i, i = 1..N)/2
start x[i = 1..N] = 0.3*i, y[i = 1..N] = 0.15*i
observe pull = lambda_tie[2]
"""


@pytest.mark.parametrize("inertia", ["", " + x[i]'*X'/20"], ids=["diagonal", "banded"])
@pytest.mark.parametrize("method", ["verlet", "yoshida4"])
def test_splitting_methods_run_on_linear_constraints(method: str, inertia: str, both) -> None:  # noqa: F811
    text = LINEAR.format(inertia=inertia, row=" + t^2/5 - t^2/5")
    words = ("--until", 0.5, "--every", 0.25, "--method", method, "--step", 0.05)
    (loops, _), (written, _) = both(text, *words)
    for one, other in zip(loops, written, strict=True):
        assert one == pytest.approx(other, rel=1e-12, abs=1e-12)
    assert len(loops) == 3 and loops[0][1:] != loops[2][1:]
