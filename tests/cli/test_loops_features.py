"""What a family kept as loops can do that straight-line code can: each beside the same model with
its members written out, or beside single runs. Models are random."""

from __future__ import annotations

import csv
import io
import json
import random
from collections.abc import Callable
from pathlib import Path

import pytest
from loop_runs import states

from conftest import case, seeds
from pkgen.__main__ import main
from pkgen.compiler import compile_model
from pkgen.scenes import lengths
from pkgen.source import Source

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


@pytest.fixture
def both(tmp_path: Path, capsys, monkeypatch) -> Callable[..., list[tuple[list, dict]]]:
    """Rows and report of a run as loops, and with all members written out."""

    def ran(text: str, *words: object) -> list[tuple[list, dict]]:
        model, found = tmp_path / "chain.lag", []
        model.write_text(text)
        for unrolled in (0, 10**6):
            monkeypatch.setattr(lengths, "UNROLL", unrolled)
            out = tmp_path / f"{unrolled}.csv"
            code = main([*map(str, ("run", model, *words, "--json", "-o", out))])
            told = capsys.readouterr()
            assert code == 0, f"{text}{told.out}{told.err}"
            found.append((rows(out.read_text()), json.loads(told.out)["report"]))
        whole = compile_model(Source(str(model), text))
        assert whole.looped, f"{text}{whole.equations.unrolled}"
        return found

    return ran


@pytest.mark.parametrize("seed", seeds(range(3), 3))
def test_rows_of_loops_that_all_but_follow_from_others_are_told(seed: int, both) -> None:
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
    (_, told), (_, said) = both(text, "--until", 0.5, "--every", 0.5, "--method", "dop853")
    ours, whole = (x["condition"]["constraints"]["cond"] for x in (told, said))
    assert whole / 20 < ours < 1.1 * whole, text
    for found in (told, said):
        assert (found["condition"]["lost"]["digits"] > 5) == (apart < 0.1), (found, text)


@pytest.mark.parametrize("seed", seeds(range(3), 3))
def test_outputs_for_each_index_are_those_of_members_written_out(
    seed: int,
    both,
    tmp_path: Path,
) -> None:
    dice = random.Random(seed)
    text = states(dice)
    felt = (
        "q[i]",
        "q[i]'*u[i]",
        "w[i]*(q[i] - q[i-1])",
        "X + q[1]",
        "sin(u[i] - u[i+1])",
        "s*q[N]",
    )
    for k, over in enumerate(("1..N", "2..N-1", "1..1")):
        body = " + ".join(dice.sample(felt, 2))
        text += f"observe out{k}[i = {over}] = {body}\nobserve between{k} = u[{k + 1}]\n"
    words = ("--until", 1, "--every", 0.5, "--method", "rk4", "--step", 0.02)
    (loops, _), (written, _) = both(text, *words)
    assert len(loops[0]) == len(written[0]) == 1 + 2 * 24 + 24 + 1 + 23 + 21 + 1 + 3 + 1
    for one, other in zip(loops, written, strict=True):
        assert one == pytest.approx(other, rel=1e-12, abs=1e-12), text
    few = (*words, "--record", "out0[23],out1[2],between1,out2[1]")
    for one, other in zip(*(x for x, _ in both(text, *few)), strict=True):
        assert one == pytest.approx(other, rel=1e-12, abs=1e-12), text
        assert len(one) == 5


DRIVEN = """\
model driven
size N = 3
coord q[1..N]
fixed q[{end}] = sin(t)
kinetic sum((q[i]' - q[i-1]')^2/2, i = {over})
potential sum(q[i]^2, i = 1..N)
"""


@pytest.mark.parametrize(("end", "over"), [("0", "1..N"), ("N+1", "2..N+1")])
def test_an_end_that_accelerates_pulls_by_inertia_alone(end: str, over: str, both) -> None:
    """Its acceleration is all that the row beside it has of it."""
    text = DRIVEN.format(end=end, over=over)
    (loops, _), (written, _) = both(text, "--until", 2, "--every", 1, "--method", "dop853")
    for one, other in zip(loops, written, strict=True):
        assert one == pytest.approx(other, rel=1e-8, abs=1e-8)
    assert max(map(abs, loops[-1][1:4])) > 0.1


FOLLOWING = """\
model following
size N = {size}
param w[i = 1..N] = i
param M = w[2]
param m[i = 1..N] = w[i] + M
coord q[1..N]
kinetic sum(q[i]'^2/2, i = 1..N)
potential sum(w[i]*q[i]^2*m[i], i = 1..N)
observe s = m[2] + 100*m[1] + 10000*m[4]
"""


@pytest.mark.parametrize("size", [16, 20])
def test_members_that_follow_given_members_follow_them(size: int, pkgen, tmp_path: Path) -> None:
    """w[2] is given, and so is another member of m, which follows w by M and by itself."""
    model = tmp_path / "following.lag"
    model.write_text(FOLLOWING.format(size=size))
    words = ("--until", 1, "--every", 1, "--record", "s", "--method", "rk4", "--step", 0.1)
    done = pkgen("run", model, *words, "--set", "w[2]=3", "--set", "m[4]=7")
    assert rows(done.stdout)[-1][1] == 6 + 100 * 4 + 10000 * 7, done.stderr


@pytest.mark.parametrize("potential", ["max(q[i] - i, 0)^2", "abs(q[i])^3", "abs(q[i])"])
def test_forces_that_bend_or_jump_stay_loops(potential: str) -> None:
    text = "model m\nsize N = 20\ncoord q[1..N]\nkinetic sum(q[i]'^2/2, i = 1..N)\n"
    made = compile_model(Source("m.lag", f"{text}potential sum({potential}, i = 1..N)\n"))
    assert made.looped, made.equations.unrolled


ONE = case("loops_features_chain")


def test_an_index_of_one_member_is_that_member(both) -> None:
    """A scene that holds one of two members makes such ranges too."""
    words = ("--until", 1e-3, "--every", 1e-3, "--record", "q[3],q[7]',q[40],q[5]',a[4],b")
    (loops, _), (written, _) = both(ONE, *words)
    assert written[0][1:] == [24, 0, 120, 5, 96, 81.5]
    for one, other in zip(loops, written, strict=True):
        assert one == pytest.approx(other, rel=1e-12)


CARRIED = case("driven")


def test_what_is_carried_moves_by_another_value_s_lower_members(both) -> None:
    """Of b, which is met first, only through a: h is then no longer T + V."""
    (loops, _), (written, _) = both(
        CARRIED, "--until", 1, "--every", 0.5, "--record", "energy,q[3]"
    )
    for one, other in zip(loops, written, strict=True):
        assert one == pytest.approx(other, rel=1e-9)
    assert loops[0][1] != loops[-1][1]


RING = case("ring")


def test_inertia_beside_a_free_end_lies_in_the_band(both) -> None:
    """x[0] is x[1], a place farther from q[0]."""
    for method in ("rk4", "gauss2"):
        words = ("--until", 0.4, "--every", 0.2, "--method", method, "--step", 0.1)
        (loops, _), (written, _) = both(RING, *words)
        for one, other in zip(loops, written, strict=True):
            assert one == pytest.approx(other, rel=1e-12, abs=1e-14)
        assert loops[0][1:] != loops[-1][1:]


JUMPING = ("potential abs(sum(q[i], i = 1..N))", "force X = sum(step(q[i]), i = 1..N)^2")
TOTALS = """\
model totals
size N = 6
coord q[1..N], X
kinetic sum(q[i]'^2/2, i = 1..N) + X'^2/2
potential sum(q[i]^2, i = 1..N) + X^2
{}
start q[i = 1..N] = cos(3*i)/N - 0.01, X = 0.2
"""


@pytest.mark.parametrize("statement", JUMPING)
def test_totals_that_jump_are_those_written_out(statement: str, both) -> None:
    words = ("--until", 2, "--every", 1, "--method", "dop853", "--rtol", 1e-11)
    (loops, _), (written, _) = both(TOTALS.format(statement), *words)
    for one, other in zip(loops, written, strict=True):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-10)


def test_a_chain_that_nothing_moves_at_first_runs(both) -> None:
    words = ("--until", 0.4, "--every", 0.1, "--method", "dop853", "--rtol", "1e-11")
    (loops, _), (written, _) = both(case("still"), *words)
    for one, other in zip(loops, written, strict=True):
        assert one == pytest.approx(other, rel=1e-8, abs=1e-8)
