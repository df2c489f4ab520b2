"""What a family kept as loops can do that straight-line code can: beside the same model with its
members written out, or beside single runs; other models are loops_*.lag of tests/runs."""

from __future__ import annotations

import random
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT, case, ran, seeds, table, written

sys.path.insert(0, str(ROOT / "tests" / "fuzz"))
import families

CHAIN = case("loops_features_chain")
# M is diagonal, or a band with a border that is factored at every step in the member's own memory.
BANDED = "+ sum((2 + cos(q[i]))*(q[i+1]' - q[i]')^2/8, i = 1..N-1)"
BY = {
    "verlet": ("", "verlet", "--step", "0.01"),
    "rk4": (BANDED, "rk4", "--step", "0.01"),
    "dop853": (BANDED, "dop853", "--rtol", "1e-11"),
}


def rows(text: str) -> list[list[float]]:
    return table(text)[1]


@pytest.mark.parametrize("by", BY)
def test_members_of_an_ensemble_are_single_runs(by: str, tmp_path: Path) -> None:
    inertia, *method = BY[by]
    model, table = written(tmp_path, CHAIN.format(inertia=inertia)), tmp_path / "members.csv"
    dice = random.Random(by)
    names = {"k": "set", "m[3]": "set", "pull": "set"} | dict.fromkeys(
        ("q[70]", "X'", "q[2]'"), "start"
    )
    given = [[dice.uniform(0.5, 2) for _ in names] for _ in range(7)]
    table.write_text("\n".join([",".join(names), *(",".join(map(repr, x)) for x in given)]) + "\n")
    common = ("--until", 3, "--every", 0.7, "--method", *method, "--set", "m[5]=0.9")
    found = rows(ran("run", model, *common, "--ensemble", table, "--threads", 2).stdout)
    assert len(found) == 6 * len(given) and len(found[0]) == 1 + 1 + 2 * 71 + 1
    for member, values in enumerate(given):
        words = (f"--{how}={x}={y!r}" for (x, how), y in zip(names.items(), values, strict=True))
        alone = rows(ran("run", model, *common, *words).stdout)
        for one, other in zip(alone, found[6 * member : 6 * member + 6], strict=True):
            assert other == pytest.approx([member + 1, *one], rel=1e-9, abs=1e-10)
    assert found[5][2] != found[11][2]


@pytest.mark.parametrize("seed", seeds(range(3), 3))
def test_rows_of_loops_that_all_but_follow_from_others_are_told(seed: int, tmp_path: Path) -> None:
    """In O(N): a bound from below of the condition number that the matrix itself gives."""
    dice = random.Random(seed)
    apart = (3e-4, 0.5, 1e-3, 0.2)[seed % 4]
    m, a, b, c = (dice.uniform(0.5, 2) for _ in range(4))
    text = (
        f"model rails\nsize N = {dice.randint(1, 6)}\ncoord x[1..N], y[1..N], z[1..N]\n"
        f"kinetic sum((x[i]'^2 + {m!r}*y[i]'^2 + z[i]'^2)/2, i = 1..N)\n"
        f"potential sum(z[i] + {c!r}*x[i]*z[i] + x[i]^2*y[i], i = 1..N)\n"
        f"fixed x[0] = 0, y[0] = 0, z[0] = 0\nlet r[i = 0..N] = x[i] - {a!r}*y[i] + {b!r}*z[i]\n"
        f"constraint one[i = 1..N]: r[i] - r[i-1]/3 = 0\n"
        f"constraint two[i = 1..N]: r[i] - {apart!r}*y[i] = 0\n"
        f"start x[i = 1..N] = {b!r}, z[i = 1..N] = -1\n"
    )
    words = ("--until", "0.5", "--every", "0.5", "--method", "dop853")
    answers = families.both(tmp_path, "run", str(written(tmp_path, text)), *words)
    found = [report["condition"] for _, _, report, _ in answers]
    ours, whole = (x["constraints"]["cond"] for x in found)
    assert whole / 20 < ours < 1.1 * whole, text
    assert [x["lost"]["digits"] > 5 for x in found] == [apart < 0.1] * 2, (found, text)


LIMIT = 1 << 30  # bytes of address space: of 20,000 numbers a matrix of each with each takes 3.2e9


@pytest.mark.parametrize("method", [("radau", "--rtol", "1e-4"), ("gauss2", "--step", "1e-5")])
def test_memory_grows_with_the_members(method: tuple[str, ...], write) -> None:
    """Radau's tolerances once had M whole."""
    model = write(
        "model chain\nsize N = 20000\nparam k = 1e6\ncoord q[1..N]\nfixed q[0] = 0\n"
        "kinetic sum(q[i]'^2/2, i = 1..N) + sum((q[i] - q[i-1])'^2/8, i = 1..N)\n"
        "potential sum(k*(q[i] - q[i-1])^2/2, i = 1..N)\nstart q[i = 1..N] = 1e-3*sin(i/100)\n"
    )
    words = ("--until", "1e-5", "--every", "1e-5", "--record", "energy", "--method", *method)
    done = subprocess.run(
        [sys.executable, "-m", "pkgen", "run", model, *words],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (LIMIT, LIMIT)),
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    first, last = (row[1] for row in rows(done.stdout))
    assert first != last and last == pytest.approx(first, rel=1e-9)
