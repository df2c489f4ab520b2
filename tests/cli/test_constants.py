"""What a user sees of claims, invariants and the page of `explain --html`."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest
import sympy
from conftest import ROOT
from pkgen.back.facts import facts, found_by_symmetry, invariants
from pkgen.compiler import compile_model
from pkgen.equations import Invariant, Symmetries
from pkgen.explain import mathml
from pkgen.explain.explain import constants_text, proofs_record
from pkgen.explain.html import SceneShown, html, scene_section
from pkgen.middle.analyze.sympy_bridge import plain
from pkgen.source import Source

TOP = ROOT / "models/heavy_top.lag"
FALSE = """\
model swing
coord a
kinetic a'^2/2
potential -cos(a)
conserve fast = a'^2           # it is not
conserve h = energy
conserve odd = sqrt(-1 - a'^2)
start a = 1
"""
HELIX = """\
model helix
param m = 2 [kg] in (0, inf)
param lambda_0 = 0.5 [1/m]
param K = 3 [N/m]
coord r [m], phi [rad], z [m]
kinetic m/2*(r'^2 + r^2*phi'^2 + z'^2)
potential K*r^2*(1 + cos(phi - lambda_0*z)/3)
observe h = energy
start r = 1, phi' = 1
"""


@pytest.mark.parametrize("command", [["run"], []])
def test_a_false_claim_is_an_error_of_the_model(pkgen, tmp_path: Path, command) -> None:
    path = tmp_path / "swing.lag"
    path.write_text(FALSE)
    done = pkgen(*command, path, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (1, "") and not (tmp_path / "swing.c").exists()
    first, second = done.stderr.split("swing.lag:")[1:]
    assert first.startswith("5:1: error: 'fast' is not constant: dfast/dt = ")
    assert "    5 | conserve fast = a'^2" in first and "      | ^^^^" in first
    assert "help: to watch it, say 'observe fast'" in first
    assert second.startswith("7:1: error: that 'odd' is constant is not proved: ")


def test_as_json(pkgen, tmp_path: Path) -> None:
    path = tmp_path / "swing.lag"
    path.write_text(FALSE)
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
        {
            "name": "lambda_0*p_phi + p_z",
            "by": "symmetry",
            "generator": "lambda_0 d/dphi + d/dz",
        },
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


@pytest.mark.parametrize(
    ("kinetic", "said"),
    [
        ("(2 + sin(t))*a'^2", "diagonal, depends on t"),
        ("(2 + sin(t*a))*a'^2", "diagonal, depends on the coordinates and t"),
        ("(2 + u^2)*a'^2", "diagonal, depends on the inputs"),
        ("(2 + cos(a))*a'^2", "diagonal, depends on the coordinates"),
    ],
)
def test_what_a_mass_matrix_varies_with(kinetic: str, said: str) -> None:
    text = f"model m\ncoord a\ninput u\nkinetic {kinetic}\npotential sin(t)*a\n"
    made = compile_model(Source("m.lag", text), kernels=frozenset({"mass"}))
    assert dict(facts(made.equations, made.structure))["mass matrix"] == said


def test_explain_as_json_has_structure_and_claims(pkgen) -> None:
    record = json.loads(pkgen("explain", TOP, "--json").stdout)
    assert record["structure"]["mass_blocks"] == [[0, 2], [1]]
    assert record["structure"]["singular"] == ["sin(theta)"]
    assert [(c["name"], c["outcome"]) for c in record["claims"]] == [("p_axis", "proved")]


def test_the_header_of_the_c_lists_them(pkgen, tmp_path: Path) -> None:
    path = tmp_path / "helix.lag"
    path.write_text(HELIX)
    assert pkgen(path, cwd=tmp_path).returncode == 0
    text = (tmp_path / "helix.h").read_text()
    assert " *   lambda_0*p_phi + p_z: symmetry lambda_0 d/dphi + d/dz\n" in text
    assert " *   definite: not proved; M may be singular where r vanishes\n" in text


def test_blocks_apart_are_named() -> None:
    text = "model apart\ncoord a, b, c\nkinetic (a'^2 + b'^2 + c'^2)/2\n"
    made = compile_model(Source("apart.lag", text + "potential cos(a - c) + cos(b)\n"))
    rows = dict(facts(made.equations, made.structure))
    assert rows["blocks"] == "{a, c}, {b} do not influence each other"


# -- the page --------------------------------------------------------------------------------------


def equations(page: str) -> list[ElementTree.Element]:
    """Each is well-formed."""
    return [ElementTree.fromstring(x) for x in re.findall(r"<math.*?</math>", page, re.DOTALL)]


def letters(element: ElementTree.Element) -> str:
    return "".join(element.itertext()).replace(mathml.INVISIBLE_TIMES, "")


@pytest.mark.parametrize("model", ["models/heavy_top.lag", "models/chains/fput.lag"])
def test_the_page_is_whole_and_loads_nothing(pkgen, tmp_path: Path, model: str) -> None:
    done = pkgen("explain", ROOT / model, "--html", tmp_path / "page.html")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    page = (tmp_path / "page.html").read_text()
    assert not re.search(r"https?:|src=|<script|<link|@import|url\(|&amp;\w+;", page)
    assert len(equations(page)) >= 5
    assert "Searched: " in page and "Operations of each kernel" in page


def test_what_the_page_shows(helix) -> None:
    page = html(helix)
    shown = [letters(x) for x in equations(page)]
    assert "V=r2(Kcos(λ0z-φ)3+K)" in shown
    assert shown[3].startswith("m000mr2000mr¨φ¨z¨=")
    assert "λ0pφ+pz" in shown
    assert "symmetry<br>generator lambda_0 d/dphi + d/dz" in page


def test_large_expressions_are_told_by_their_size() -> None:
    x = " + ".join(f"cos({k}*a)^{k}*sin(b*{k})" for k in range(1, 60))
    page = html(
        compile_model(
            Source("m.lag", f"model m\ncoord a, b\nkinetic a'^2 + b'^2\npotential {x}\n"),
            kernels=frozenset({"force"}),
            symmetric=True,
        )
    )
    assert "operations)</mtext>" in page


def test_names() -> None:
    def said(text: str) -> str:
        return letters(ElementTree.fromstring(mathml.name(text)))

    assert said("theta1'") == "θ˙1" and said("p_Omega") == "pΩ" and said("x''") == "x¨"
    assert said("E_") == "E_" and said("_x") == "_x" and said("T12_a'") == "T˙12a"
    assert (
        said("q[i+1]") == "qi+1" and said("M[q[i], phi]") == "Mqi,φ" and said("k_wall") == "kwall"
    )


def test_expressions_are_in_the_words_of_the_language() -> None:
    x, y, z = sympy.symbols("x y z")
    expr = sympy.E + sympy.Abs(x) ** 2 * sympy.Max(x, y, z) - sympy.Min(x, z)
    assert plain(expr) == "abs(x)^2*max(x, max(y, z)) - min(x, z) + exp(1)"
    step = sympy.Heaviside(x - y, 1)
    assert plain(step) == "step(x - y)"
    assert letters(ElementTree.fromstring(mathml.expression(step))) == "step(x-y)"


def test_entities_are_characters() -> None:
    assert letters(ElementTree.fromstring(mathml.expression(2 * sympy.pi))) == "2π"


def test_the_section_of_a_scene() -> None:
    shown = SceneShown(
        "nod<ding", "theta alone", ("phi is cyclic",), {"force": 16, "mass": 8}, {"force": 5}
    )
    text = "".join(scene_section(shown))
    assert "nod&lt;ding" in text and "<li>phi is cyclic</li>" in text
    rows = re.findall(r"<td.*?>(.*?)</td>", text)
    assert rows == ["force", "16", "5", "mass", "8", "not there"]


def test_scenes_have_their_place_in_the_page(helix) -> None:
    page = html(helix, [SceneShown("nodding", "", (), {}, {})])
    assert "<h2>Scene nodding</h2>" in page and "It needs all of the model." in page
