"""What a user sees of claims, invariants in text and JSON."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from conftest import ROOT, case, ran, written
from pkgen.back.facts import found_by_symmetry, invariants
from pkgen.compiler import compile_model
from pkgen.explain.explain import constants_text, proofs_record
from pkgen.middle.structure import Invariant, Symmetries
from pkgen.source import Source

TOP = ROOT / "models/heavy_top.lag"
FALSE = case("swing")
HELIX = case("helix")


def test_as_json(pkgen, tmp_path: Path) -> None:
    path = written(tmp_path, FALSE)
    done = pkgen("check", path, "--json")
    found = json.loads(done.stdout)["diagnostics"]
    assert done.returncode == 1 and [d["line"] for d in found] == [5, 7]


@pytest.fixture(scope="module")
def helix():
    return compile_model(Source("helix.lag", HELIX), symmetric=True)


def test_explain_shows_how_each_is_proved(helix) -> None:
    rows = invariants(helix.equations, helix.structure)
    text = constants_text(rows, helix.structure.symmetries)
    assert "  lambda_0*p_phi + p_z  symmetry lambda_0 d/dphi + d/dz\n" in text
    assert proofs_record(helix.structure)["invariants"] == [
        {"name": "energy", "by": "time shift", "generator": "d/dt"},
        {"name": "lambda_0*p_phi + p_z", "by": "symmetry", "generator": "lambda_0 d/dphi + d/dz"},
    ]


def test_that_nothing_was_searched_is_said(helix) -> None:
    text = constants_text([], Symmetries(helix.equations.graph, (), "", ()))
    assert "searched: no symmetries, for the model is too large" in text


def test_long_sums_are_cut_and_it_says_where_they_are_whole(helix) -> None:
    name = " + ".join(f"p_q[{i}]" for i in range(12))
    graph = helix.equations.graph
    long = Symmetries(graph, (), "all", (Invariant(name, "symmetry", name, (), 0),))
    text = constants_text(found_by_symmetry(long), long)
    assert "p_q[0] + ... + p_q[11] (12 terms)  symmetry" in text
    assert text.endswith("\n  (long sums are whole in --json)")
    assert "--json" not in constants_text([], replace(long, invariants=()))


def test_explain_as_json_has_structure_and_claims(pkgen) -> None:
    record = json.loads(pkgen("explain", TOP, "--json").stdout)
    assert record["structure"]["mass_blocks"] == [[0, 2], [1]]
    assert record["structure"]["singular"] == ["sin(theta)"]
    assert [(c["name"], c["outcome"]) for c in record["claims"]] == [("p_axis", "proved")]


def test_the_header_of_the_c_lists_them(pkgen, tmp_path: Path) -> None:
    path = written(tmp_path, HELIX)
    assert pkgen(path, "--runtime", cwd=tmp_path).returncode == 0
    text = (tmp_path / "helix.h").read_text()
    assert "lambda_0*p_phi + p_z: symmetry lambda_0 d/dphi + d/dz" in text.replace("\n * ", " ")
    assert " *   definite: not proved; M may be singular where r vanishes\n" in text


def test_a_constant_that_is_zero_is_judged_by_what_it_is_made_of() -> None:
    """The cart starts at rest: its momentum is 0, a sum of terms that are not."""
    model = ROOT / "tests/models/written/spherical_pendulum_cart.lag"
    rest = ["--start", "X'=0", "--start", "phi'=0", "--until", "1", "--json"]
    drifts = json.loads(ran("run", model, *rest).stdout)["report"]["drifts"]
    scales = {d["name"]: d["scale"] for d in drifts}
    assert scales["energy"] > 1 and 0.01 < scales["px"] < 10
