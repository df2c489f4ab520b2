"""Families kept as loops, as a user meets them: emission, runs at any size, what is said."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from pathlib import Path

import pytest

from conftest import ROOT, case, ran, table, written
from pkgen.scenes import lengths

FPUT = ROOT / "models" / "chains" / "fput.lag"
PARTS = case("parts")


@pytest.fixture
def parts(tmp_path: Path) -> Path:
    path = written(tmp_path, PARTS)
    return path


def test_emission_keeps_loops_whatever_the_size(pkgen, tmp_path: Path) -> None:
    for size in (2, 5_000_000):
        options = ("--runtime", "--no-unroll", "--size", f"N={size}")
        assert pkgen(FPUT, *options, "-o", tmp_path).returncode == 0
        text = (tmp_path / "fput.c").read_text()
        assert "fput_advance" in text and f"p->N = {size};" in text


def test_a_million_members(tmp_path: Path) -> None:
    out = tmp_path / "rows.csv"
    words = [
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
    ]
    ran("run", FPUT, *words, "-o", out)
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


def test_chains_are_run_by_dop853_and_pair_sums_by_gauss(tmp_path: Path) -> None:
    gravity = written(tmp_path, GRAVITY)
    for model, method in ((FPUT, "dop853"), (gravity, "gauss")):
        words = ["--size", "N=300", "--until", "0.5", "--every", "0.5", "--json"]
        done = ran("run", model, *words)
        assert json.loads(done.stdout)["report"]["method"] == method


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
        run = ("run", path, "--until", "200", "--every", "0.5", "--method", *method.split())
        names, found = table(ran(*run).stdout)
        places = [row[1 : names.index("x[1]'")] for row in found]
        gaps = [b - a for row in places for a, b in pairwise(row)]
        assert 0 < min(gaps) < 0.15 and len(found) == 401
