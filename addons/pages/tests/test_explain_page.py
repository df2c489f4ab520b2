"""The page of `explain --html`: what is typeset, how, and that it is whole and loads nothing."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
import sympy
from sympy.simplify.fu import TR10i

from conftest import ROOT, case
from pkgen.compiler import compile_model
from pkgen.front.read import read
from pkgen.middle.analyze.sympy_bridge import plain, text
from pkgen.source import Source
from pkgen_pages.explain import mathml
from pkgen_pages.explain.html import SceneShown, fragment, html, scene_section
from pkgen_pages.explain.prose import Prose
from pkgen_pages.explain.shortest import shortest
from pkgen_pages.explain.style import style
from pkgen_pages.explain.typeset import Typesetter
from pkgen_pages.explain.written import Written

MODELS = sorted((ROOT / "models").rglob("*.lag"))
HELIX = case("explain_html_helix")


def formulas(page: str) -> list[ElementTree.Element]:
    """Each is well-formed."""
    return [ElementTree.fromstring(x) for x in re.findall(r"<math.*?</math>", page, re.DOTALL)]


def lines(page: str) -> list[str]:
    """The letters of the equations, a line each."""
    found = re.findall(r'<div class="equation".*?</div>', page, re.DOTALL)
    return ["".join(letters(x) for x in formulas(line)) for line in found]


def letters(element: ElementTree.Element) -> str:
    return re.sub("[\u2061\u2062]", "", "".join(element.itertext()))


def made(text: str) -> str:
    return fragment(compile_model(Source("m.lag", text), symmetric=True))


@pytest.fixture(scope="module")
def helix():
    return compile_model(Source("helix.lag", HELIX), symmetric=True)


# -- the page --------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["models/heavy_top.lag", "models/chains/fput.lag"])
def test_the_page_is_whole_and_loads_nothing(pkgen, tmp_path: Path, model: str) -> None:
    done = pkgen("explain", ROOT / model, "--html", tmp_path / "page.html")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    page = (tmp_path / "page.html").read_text()
    assert not re.search(r"https?:|src=|<script|<link|@import|url\((?!data:)|&amp;\w+;", page)
    assert len(formulas(page)) >= 5 and page.count("url(data:") == 1
    assert "Searched: " in page and "Operations of each kernel" in page


def test_a_fragment_is_for_another_page(helix) -> None:
    part = fragment(helix, level=3)
    assert part.startswith('<div class="explained">') and "<h2" not in part and "<h3>" in part
    assert not re.search(r"<html|<style|\bstyle=|\bid=|<script|\bon\w+=", part)
    assert part.count("<div") == part.count("</div>")
    assert all(rule.startswith((".explained", "@font-face")) for rule in rules(style()))


def rules(css: str) -> list[str]:
    css = re.sub(r"url\([^)]*\)", "", css)  # the font, in which each letter would be a start
    return [x.strip() for x in re.findall(r"([^{}]+)\{", css)]


def test_names_that_are_html_stay_text() -> None:
    page = made(
        "model m  # <b>&\nparam a = 1  # <script>x</script>\ncoord x  # 'q\"\nkinetic a*x'^2\n"
    )
    assert "<script" not in page and "&lt;script&gt;" in page and "<b>" not in page


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_each_model_has_its_page(path: Path) -> None:
    page = fragment(compile_model(read(path), symmetric=True))
    assert formulas(page) and "<mtext></mtext>" not in page
    for element in formulas(page):
        check(element)


def check(element: ElementTree.Element) -> None:
    """As MathML Core has it: no hyphens, no elements of one child too many."""
    count = {"mfrac": 2, "msup": 2, "msub": 2, "msubsup": 3, "mover": 2, "munderover": 3}
    for part in element.iter():
        assert len(part) == count.get(part.tag, len(part)), part.tag
        assert part.tag == "mtext" or "-" not in (part.text or ""), part.text


def test_what_the_page_shows(helix) -> None:
    shown = lines(html(helix))
    assert "V=Kr2(1+cos(φ−λ0z)3)" in shown
    assert "mr2φ¨=13Kr2sin(φ−λ0z)−2mrr˙φ˙" in shown and "mz¨=−13λ0Kr2sin(φ−λ0z)" in shown
    table = [letters(x) for x in formulas(html(helix))]
    assert "λ0pφ+pz" in table and "λ0∂∂φ" in table and "+∂∂z" in table


def test_large_expressions_are_told_by_their_size() -> None:
    x = " + ".join(f"cos({k}*a)^{k}*sin(b*{k})*exp(sin({k}*a))*tanh({k}*a)" for k in range(1, 60))
    page = html(
        compile_model(
            Source("m.lag", f"model m\ncoord a, b\nkinetic a'^2 + b'^2\npotential {x}\n"),
            kernels=frozenset({"force"}),
            symmetric=True,
        )
    )
    assert "operations, written out" in page


def test_the_section_of_a_scene(helix) -> None:
    shown = SceneShown(
        "nod<ding", "theta alone", ("phi is cyclic",), {"force": 1600, "mass": 8}, {"force": 5}
    )
    text = "".join(scene_section(shown, Prose(Written(helix.model), {"phi"})))
    assert (
        "nod&lt;ding" in text and "<li><math><mrow><mi>φ</mi></mrow></math> is cyclic</li>" in text
    )
    assert re.findall(r"<td.*?>(.*?)</td>", text) == ["force", "1,600", "5"]
    assert "Not called, so not there: mass." in text


def test_scenes_have_their_place_in_the_page(helix) -> None:
    page = html(helix, [SceneShown("nodding", "", (), {}, {})])
    assert "<h2>Scene nodding</h2>" in page and "It needs all of the model." in page


# -- names and expressions -------------------------------------------------------------------------


def test_names() -> None:
    def said(text: str, **options) -> str:
        return letters(ElementTree.fromstring(mathml.row(mathml.name(text, **options))))

    assert said("theta1'") == "θ˙1" and said("p_Omega") == "pΩ" and said("x''") == "x¨"
    assert said("E_") == "E_" and said("_x") == "_x" and said("T12_a'") == "T˙12a"
    assert (
        said("q[i+1]") == "qi+1" and said("M[q[i], phi]") == "Mqi,φ" and said("k_wall") == "kwall"
    )
    assert said("falls_on_the_spot") == "falls\u00a0on\u00a0the\u00a0spot"
    assert said("omega(R).x'") == "ω˙R,x" and said("omega(R).x'", lone="R") == "ω˙x"
    assert said("p_R.x") == "pR,x" and said("R.w") == "Rw"
    assert said("n", bold=True) == "𝐧" and said("omega", bold=True) == "𝛚"


def test_expressions_are_in_the_words_of_the_language() -> None:
    x, y, z = sympy.symbols("x y z")
    expr = sympy.E + sympy.Abs(x) ** 2 * sympy.Max(x, y, z) - sympy.Min(x, z)
    assert plain(expr) == "abs(x)^2*max(x, max(y, z)) - min(x, z) + exp(1)"
    step = sympy.Heaviside(x - y, 1)
    assert plain(step) == "step(x - y)"


def test_expressions_are_written_as_by_hand() -> None:
    names = ["m1", "m2", "g", "length", "theta", "phi", "theta'", "t"]
    m1, m2, g, _, theta, phi, rate, t = sympy.symbols(names)
    typeset = Typesetter({n: k for k, n in enumerate(names)}, frozenset(names[:4]))

    def said(expr) -> str:
        return letters(ElementTree.fromstring(typeset(sympy.sympify(expr))))

    assert said(sympy.sin(theta) * g * m1) == "m1gsinθ"
    assert said(m1 * rate**2 / 2) == "12m1θ˙2"
    assert said(-m1 - m2) == "−m1−m2" and said(-(m1 + m2) * g) == "−(m1+m2)g"
    assert said(m1 - m2) == "m1−m2" and said(m2 - m1) == "m2−m1" and said(1 - g**2) == "1−g2"
    assert said(sympy.cos(theta) ** 2) == "cos2θ" and said(sympy.cos(theta - phi)) == "cos(θ−φ)"
    assert said(sympy.Rational(981, 100)) == "9.81" and said(sympy.Rational(1, 3)) == "13"
    assert said(sympy.Rational(1, 10**9)) == "10−9"
    assert said(sympy.exp(-t)) == "e−t" and said(sympy.Abs(t)) == "|t|"
    assert said(sympy.Heaviside(theta - phi, 1)) == "step(θ−φ)" and said(2 * sympy.pi) == "2π"
    squared = ElementTree.fromstring(typeset(rate**2))  # the square stands beside the dot
    assert squared.find("msup/mrow/mover") is not None or squared.find("msup/mover") is not None
    indexed = ElementTree.fromstring(typeset(m1**2))
    assert indexed.find("msubsup") is not None


def test_the_shortest_form() -> None:
    a, b, m, n, k = sympy.symbols("a b m n k")
    typeset = Typesetter({}, frozenset("mnk"))

    def short(expr):
        return shortest(expr, frozenset("mnk"), typeset)

    sums = sympy.cos(a) * sympy.cos(b) + sympy.sin(a) * sympy.sin(b)
    assert short(m * k * sums) == m * k * sympy.cos(a - b)
    assert short(m * k**2 * a + n * k**2 * a) == k**2 * a * (m + n)
    assert short(sympy.sqrt(a**2 / 4 + b**2 / 4)) == sympy.sqrt(a**2 + b**2) / 2


# -- what the author wrote, rotations, names for what is long -------------------------------------


def test_vectors_are_as_written() -> None:
    shown = lines(made(case("body")))
    assert "(x˙,y˙,z˙)+R(𝐰×𝐫)=(0,0,0)" in shown and "𝐫=−a(R−1(0,0,1))" in shown
    assert "𝐰=𝛚" in shown and "mx¨=λfoot,x" in shown
    assert "ω˙y=λfoot,x(aRxzRzx−aRxxRzz)+λfoot,y(aRyzRzx−aRyxRzz)" in shown
    assert "R˙w=−12ωxRx−12ωyRy−12ωzRz" in shown and "0=z˙z" in shown  # foot z


def test_what_is_long_has_names() -> None:
    long = " + ".join(f"sqrt(1 + a^2*{k} + b^2)*cos({k}*a + b)" for k in range(1, 9))
    page = made(f"model m\ncoord a, b\nkinetic a'^2 + b'^2\npotential ({long})*exp(({long})/9)\n")
    assert '<div class="where"><p>where</p>' in page and "operations, written out" not in page
    named = [x.split("=")[0] for x in lines(page) if re.match(r"[A-Z]=", x)][2:]
    assert len(named) == len({*named}) > 1 and not {*named} & {"T", "V", "L", "E", "R"}


def test_units_and_bounds() -> None:
    page = made(
        "model m\nparam k = 2 [N/m] in (0, inf)\n"
        "param d = 0.25 [1/s] in [0, 1)\nparam w = 0.5 [kg*m^2/s]\n"
        "coord x [m]\nkinetic (1 [kg])*x'^2/2\npotential k/2*x^2\n"
    )
    text = [letters(x) for x in formulas(page)]
    assert "2N/m" in text and ">0" in text and "0.25s⁻¹" in text and "[0,1)" in text
    assert "0.5kg\u2009m²/s" in text


@pytest.mark.parametrize(("potential", "combined"), [("x^2*y^2", 0), ("sin(x)*cos(y)", 1)])
def test_only_sines_are_combined(potential: str, combined: int, monkeypatch) -> None:
    """The multipliers of two rods, all polynomials, took 17 s."""
    calls = []
    module = sys.modules[TR10i.__module__]  # sympy.simplify has a function of its name
    monkeypatch.setattr(module, "TR10i", lambda expr: calls.append(expr) or expr)
    model = f"model m\ncoord x, y\nkinetic (x'^2 + y'^2)/2\npotential {potential}\n"
    equations = compile_model(Source("m.lag", model)).equations
    assert "y" in text(equations, equations.force[0], 80)
    assert bool(calls) == bool(combined)
