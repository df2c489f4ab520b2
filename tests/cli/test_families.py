"""Families kept as loops, as a user meets them: emission, runs at any size, what is said."""

from __future__ import annotations

import csv
import io
import json
import re
from itertools import pairwise
from pathlib import Path

import pytest

from conftest import ROOT, case
from pkgen.scenes import lengths

FPUT = ROOT / "models" / "chains" / "fput.lag"
PARTS = case("parts")


def rows(text: str) -> tuple[list[str], list[list[float]]]:
    table = list(csv.reader(io.StringIO(text)))
    return table[0], [[float(x) for x in row] for row in table[1:]]


def ran(pkgen, *arguments) -> tuple[list[str], list[list[float]]]:
    done = pkgen("run", *arguments)
    assert done.returncode == 0, done.stderr
    return rows(done.stdout)


@pytest.fixture
def parts(tmp_path: Path) -> Path:
    path = tmp_path / "parts.lag"
    path.write_text(PARTS, encoding="utf-8")
    return path


def test_emission_keeps_loops_whatever_the_size(pkgen, tmp_path: Path) -> None:
    for size in (2, 5_000_000):
        options = ("--runtime", "--no-unroll", "--size", f"N={size}")
        assert pkgen(FPUT, *options, "-o", tmp_path).returncode == 0
        text = (tmp_path / "fput.c").read_text()
        assert "fput_advance" in text and f"p->N = {size};" in text


def test_a_small_family_runs_unrolled_and_agrees_with_loops(pkgen, parts: Path) -> None:
    common = (
        "--until",
        "2",
        "--every",
        "1",
        "--rtol",
        "1e-12",
        "--set",
        "m[2]=3.5",
        "--set",
        "k=1.3",
        "--start",
        "q[1]'=0.7",
        "--start",
        "X=0.4",
    )
    loops = ran(pkgen, parts, "--size", "N=17", *common)
    # 16 coordinates and fewer are unrolled: the same chain, its far end cut off and held.
    names, table = loops
    assert names[:4] == ["t", "X", "q[0]", "q[1]"] and names[20:23] == ["X'", "q[0]'", "q[1]'"]
    assert names[-2:] == ["seen", "energy"] and len(table) == 3
    assert table[0][1] == 0.4 and table[0][22] == 0.7
    assert table[2][-2] == pytest.approx(table[2][5] + 1.3 * table[2][1], rel=1e-14)
    energies = [row[-1] for row in table]
    assert energies == pytest.approx([energies[0]] * 3, rel=1e-10)
    small = ran(pkgen, parts, "--size", "N=6", *common)[1]
    assert len(small[0]) == 2 * 8 + 3


def test_a_member_that_is_set_changes_what_follows_it(pkgen, parts: Path) -> None:
    """kk[2] = k*m[2] follows m[2]; kk[3] = 9 is set, kk[4] still follows k."""
    base = ("--until", "1e-3", "--every", "1e-3", "--size", "N=30")
    energy = {}
    for key, more in {
        "plain": (),
        "set": ("--set", "m[2]=5"),
        "both": ("--set", "m[2]=5", "--set", "kk[2]=2.4"),
    }.items():
        names, table = ran(pkgen, parts, *base, *more)
        energy[key] = table[0][-1]
        q2 = table[0][names.index("q[2]")]
    assert energy["set"] - energy["plain"] == pytest.approx(q2**2 / 2 * 2 * (5 - 1.2), rel=1e-9)
    assert energy["both"] - energy["plain"] == pytest.approx(0, abs=1e-12)


def test_a_million_members(pkgen, tmp_path: Path) -> None:
    out = tmp_path / "rows.csv"
    done = pkgen(
        "run",
        FPUT,
        "--size",
        "N=1000000",
        "--method",
        "verlet",
        "--step",
        "0.1",
        "--until",
        "0.5",
        "--every",
        "0.5",
        "-o",
        out,
    )
    assert done.returncode == 0, done.stderr
    with open(out, encoding="utf-8") as file:
        assert file.readline().startswith("t,q[1],q[2],")
        assert file.readline().count(",") == 2_000_001
    about = json.loads((tmp_path / "rows.csv.json").read_text())
    assert [c["name"] for c in about["columns"]][:3] == ["t", "q[1..1000000]", "q[1..1000000]'"]
    assert about["report"]["steps"] == 5
    assert 0 < about["report"]["drifts"][0]["max"] < 1e-11


def test_zeros_before_a_size_are_none_of_it():
    assert lengths.given(["N=00000000005", " M = 64 "]) == {"N": 5, "M": 64}


GRAVITY = case("gravity")
ENDS = case("families_ends")


def test_chains_are_run_by_dop853_and_pair_sums_by_gauss(pkgen, tmp_path: Path) -> None:
    gravity = tmp_path / "gravity.lag"
    gravity.write_text(GRAVITY, encoding="utf-8")
    for model, method in ((FPUT, "dop853"), (gravity, "gauss")):
        done = pkgen("run", model, "--size", "N=300", "--until", "0.5", "--every", "0.5", "--json")
        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)["report"]["method"] == method


def test_rows_of_gauss_lie_between_its_steps_on_a_long_chain(pkgen) -> None:
    """Its steps, at whose ends it errs by up to 60 tolerances here, are longer than what their
    interpolation can bear in one piece."""
    common = (FPUT, "--size", "N=1000", "--until", "100", "--every", "5")
    exact = ran(pkgen, *common, "--method", "dop853", "--rtol", "1e-13")[1]
    for rtol in ("1e-6", "1e-10"):
        asked = ("--method", "gauss", "--rtol", rtol, "--atol", rtol)
        done = pkgen("run", *common, *asked, "--json")
        assert done.returncode == 0, done.stderr
        said = json.loads(done.stdout)
        assert len(said["rows"]) == 21 and 2 * said["report"]["step_max"] > 20
        pairs = zip(said["rows"], exact, strict=True)
        errors = [max(abs(a - b) for a, b in zip(*pair, strict=True)) for pair in pairs]
        assert 0 < max(errors) < 100 * float(rtol)


def test_end_terms_of_the_potential_are_explained_and_fused(pkgen, tmp_path: Path) -> None:
    path = tmp_path / "ends.lag"
    path.write_text(ENDS, encoding="utf-8")
    done = pkgen("explain", path)
    assert done.returncode == 0, done.stderr
    assert "f[q[i]] = q[i+1] + q[i-1] - 2*q[i]   for i = 2..N-1\n" in done.stdout
    assert "f[q[1]] = -k*q[1] - q[1] + q[2]\n" in done.stdout
    assert "fused steps      yes" in done.stdout
    force = json.loads(pkgen("explain", path, "--json").stdout)["force"]
    assert list(force) == ["f[q[i]] for i = 2..N-1", "f[q[1]]", "f[q[N]]"]
    fused = ("--method", "verlet", "--step", "1e-3", "--until", "1", "--every", "1")
    verlet, dop853 = ran(pkgen, path, *fused)[1], ran(pkgen, path, *fused[4:])[1]
    assert verlet[1][1:32] == pytest.approx(dop853[1][1:32], abs=1e-6)


def test_explain_says_which_way_and_why(pkgen, tmp_path: Path) -> None:
    done = pkgen("explain", FPUT)
    assert "families         loops in C" in done.stdout
    assert "for i = 1..N\n" in done.stdout and "one pass over memory" in done.stdout
    links = tmp_path / "links.lag"
    links.write_text(
        "model links\nsize N = 3\ncoord a[1..N]\nlet x[0] = 0\n"
        "let x[i = 1..N] = x[i-1] + a[i]'\n"
        "kinetic sum(x[i]^2/2 + a[i]'^2, i = 1..N)\n"
    )
    done = pkgen("explain", links)
    assert "families         unrolled: a carried value is made of the rate" in done.stdout
    done = pkgen("check", links, "--size", "N=20000")
    assert done.returncode == 1 and "which cannot stay loops" in done.stderr


GAS = case("gas")


@pytest.mark.parametrize("method", ["dop853", "verlet --step 0.01"])
def test_a_collision_is_the_same_unrolled_and_as_loops(pkgen, tmp_path: Path, method: str) -> None:
    """Where all attract each other, those at either end fall first, both at once."""
    path, members = tmp_path / "gas.lag", tmp_path / "members.csv"
    path.write_text(GAS, encoding="utf-8")
    members.write_text("g\n-1\n", encoding="utf-8")
    common = ("run", path, "--until", "5", "--every", "0.1", "--method", *method.split(), "--json")
    last, ends = [], []
    for size in (8, 17, 32):  # up to 16 coordinates families are unrolled
        done = pkgen(*common, "--size", f"N={size}", "--set", "g=-1")
        report = json.loads(done.stdout)["report"]
        assert done.returncode == 4 and report["status"] == "PK_SINGULAR_TIME"
        last.append(report["t"])
        ends.append(float(re.search(r"x\[\d+\] vanishes at t = (\S+),", done.stderr)[1]))
    done = pkgen(*common, "--size", "N=17", "--ensemble", members)
    failed = json.loads(done.stdout)["report"]["first_failed"]
    assert done.returncode == 4 and failed["status"] == "PK_SINGULAR_TIME"
    last.append(failed["t"])
    assert last == pytest.approx([1.0] * 4 if "verlet" in method else [ends[0]] * 4, rel=1e-6)
    assert 1 < ends[0] < 1.01 and ends == pytest.approx([ends[0]] * 3, rel=1e-6)


def test_what_repels_passes_near_and_never_ends(pkgen, tmp_path: Path) -> None:
    path = tmp_path / "gas.lag"
    walls = "fixed x[0] = 0, x[N+1] = N + 1\nstart x[i = 1..N]' = 3*sin(7*i^2)\n"
    path.write_text(GAS.replace("i = 1..N-1)", "i = 0..N)") + walls, encoding="utf-8")
    for method in ("dop853", "verlet --step 0.002"):
        names, table = ran(
            pkgen, path, "--until", "200", "--every", "0.5", "--method", *method.split()
        )
        places = [row[1 : names.index("x[1]'")] for row in table]
        gaps = [b - a for row in places for a, b in pairwise(row)]
        assert 0 < min(gaps) < 0.15 and len(table) == 401


def test_a_member_of_a_definition_is_recorded_of_loops_too(pkgen, tmp_path: Path) -> None:
    """Of a scene, `let D[i = ..]` is an output D[3] that the family D has no name of."""
    text = PARTS.replace("observe seen", "let D[i = 1..N] = q[i] - q[0]\nobserve seen")
    path = tmp_path / "parts.lag"
    scene = (
        "scene few\n  until 1\n  method gauss rtol 1e-12\n  record D[3], q[3], q[0] every 1\nend\n"
    )
    path.write_text(text + scene, encoding="utf-8")
    for size in (8, 40):  # up to 16 coordinates families are unrolled
        names, table = ran(pkgen, path, "--scene", "few", "--size", f"N={size}")
        assert names == ["t", "D[3]", "q[3]", "q[0]"]
        assert all(abs(row[1]) > 1e-3 for row in table)
        assert all(row[1] == pytest.approx(row[2] - row[3], abs=1e-12) for row in table)
