"""What a family kept as loops can do that straight-line code can: each beside the same model with
its members written out (`--kernels` unrolls, a run of few members does), or beside single runs."""

from __future__ import annotations

import csv
import io
import random
from pathlib import Path

import pytest

CHAIN = """\
model chain
size N = 70
param k = 1.5
param m[i = 1..N] = k*(1 + 0.1*cos(i)) in (0, inf)
input pull
coord q[1..N]
coord X
fixed q[0] = 0
kinetic sum(m[i]*q[i]'^2/2, i = 1..N) + X'^2 {inertia}
potential sum(k*(q[i+1] - q[i])^2/2 + (q[i+1] - q[i])^4/4, i = 0..N-1) - pull*q[N] + (q[1] - X)^2
start q[i = 1..N] = 0.3*sin(i), X = 0.1
"""
# M is diagonal, or a band with a border that is factored at every step in the member's own memory.
INERTIA = {"diagonal": "", "banded": "+ sum((2 + cos(q[i]))*(q[i+1]' - q[i]')^2/8, i = 1..N-1)"}


def rows(text: str) -> list[list[float]]:
    return [[float(x) for x in row] for row in list(csv.reader(io.StringIO(text)))[1:]]


@pytest.mark.parametrize("inertia", INERTIA)
@pytest.mark.parametrize("method", [("verlet", "--step", "0.01"), ("dop853", "--rtol", "1e-11")])
def test_members_of_an_ensemble_are_single_runs(
    inertia: str, method: tuple[str, ...], pkgen, tmp_path: Path
) -> None:
    if inertia == "banded" and method[0] == "verlet":
        method = ("rk4", "--step", "0.01")
    model, table = tmp_path / "chain.lag", tmp_path / "members.csv"
    model.write_text(CHAIN.format(inertia=INERTIA[inertia]))
    dice = random.Random(f"{inertia} {method}")
    names = ["k", "m[3]", "pull", "q[70]", "X'", "q[2]'"]
    given = [[dice.uniform(0.5, 2) for _ in names] for _ in range(7)]
    table.write_text("\n".join([",".join(names), *(",".join(map(repr, x)) for x in given)]) + "\n")
    common = ("--until", 3, "--every", 0.7, "--method", *method, "--set", "m[5]=0.9")
    several = pkgen("run", model, *common, "--ensemble", table, "--threads", 2)
    assert several.returncode == 0, several.stderr
    found = rows(several.stdout)
    assert len(found) == 6 * len(given) and len(found[0]) == 1 + 1 + 2 * 71 + 1
    for member, values in enumerate(given):
        words = [
            word
            for name, x in zip(names, values, strict=True)
            for word in (
                "--start" if name in ("q[70]", "X'", "q[2]'") else "--set",
                f"{name}={x!r}",
            )
        ]
        alone = rows(pkgen("run", model, *common, *words).stdout)
        mine = [row[1:] for row in found if row[0] == member + 1]
        assert len(alone) == len(mine) == 6
        for one, other in zip(alone, mine, strict=True):
            assert other == pytest.approx(one, rel=1e-9, abs=1e-10)
    assert found[5][2] != found[11][2]
