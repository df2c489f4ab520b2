"""Closed forms beside a model, `exact x = EXPR`: what is true passes, what is wrong is caught."""

import random
import re
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import pkgen
from conftest import ROOT, ran, run_pkgen
from pkgen.compiler import check_model
from pkgen.front.read import from_text
from pkgen.source import ModelError

t = sp.Symbol("t", real=True)


def oscillator(draw: random.Random) -> tuple[list[str], dict[str, sp.Expr]]:
    """A damped or undamped oscillator, solved by SymPy."""
    w, c, x0, v0 = (sp.Rational(draw.randint(1, 30), 10) for _ in range(4))
    c = c / 10 if draw.random() < 0.6 else 0 * c
    x = sp.Function("x")
    ode = sp.Eq(x(t).diff(t, 2) + c * x(t).diff(t) + w**2 * x(t), 0)
    found = sp.dsolve(ode, ics={x(0): x0, x(t).diff(t).subs(t, 0): v0}).rhs
    lines = ["coord x", "kinetic x'^2/2", f"potential ({w})^2*x^2/2", f"force x = -({c})*x'"]
    return [*lines, f"start x = {x0}, x' = {v0}"], {"x": found}


def thrown(draw: random.Random) -> tuple[list[str], dict[str, sp.Expr]]:
    """Thrown in a plane, coordinates coupled by the mass matrix."""
    g, u, v, k = (sp.Rational(draw.randint(1, 90), 10) for _ in range(4))
    lines = [
        "coord x, s",
        f"kinetic x'^2/2 + (s' + ({k})*x')^2/2",
        f"potential ({g})*(s + ({k})*x)",
    ]
    forms = {"x": u * t, "s": v * t - g * t**2 / 2}
    return [*lines, f"start x' = {u}, s' = {v}"], forms


def decay(draw: random.Random) -> tuple[list[str], dict[str, sp.Expr]]:
    """A chain of two decays."""
    a = sp.Rational(draw.randint(1, 20), 10)
    b, n = a + sp.Rational(draw.randint(1, 20), 10), draw.randint(1, 9)
    lines = ["state n, d", f"rate n = -({a})*n", f"rate d = ({a})*n - ({b})*d", f"start n = {n}"]
    return lines, {
        "n": n * sp.exp(-a * t),
        "d": n * a / (b - a) * (sp.exp(-a * t) - sp.exp(-b * t)),
    }


def text(lines: list[str], forms: dict[str, sp.Expr]) -> str:
    said = [f"exact {name} = {sp.sstr(form).replace('**', '^')}" for name, form in forms.items()]
    return "\n".join(["model m", *lines, *said]) + "\n"


@pytest.mark.parametrize("seed", range(30))
def test_true_forms_pass_and_wrong_ones_are_caught(seed: int) -> None:
    draw = random.Random(seed)
    lines, forms = (oscillator, thrown, decay)[seed % 3](draw)
    check_model(from_text("m.lag", text(lines, forms)))
    name = draw.choice([*forms])
    form, off = forms[name], sp.Rational(draw.choice([1001, 999]), 1000)
    wrong = {
        "value": form * off if form.subs(t, 0) != 0 else form + off,
        "rate": form + t / 1000,
        "later": form + t**3 / 1000,
        "pace": form.subs(t, t * off),
    }
    for kind, other in wrong.items():
        with pytest.raises(ModelError) as said:
            check_model(from_text("m.lag", text(lines, forms | {name: other})))
        shown = said.value.text()
        line = f"m.lag:{len(lines) + 2 + [*forms].index(name)}:7: error: "
        # A pair of coupled quantities may be wrong in the equation of either of them.
        assert shown.startswith((line, "m.lag:")) and "closed form" in shown, (kind, shown)
        assert kind != "value" or f"error: {name} starts at " in shown


MODEL = """model e
param w = 2 [1/s]
param x0 = 0.5 [m]
coord x [m]
state s [m]
kinetic (1 [kg])*x'^2/2
potential (1 [kg])*w^2*x^2/2
rate s = -w*s
start x = x0, s = 2*x0
exact x = x0*cos(w*t), s = 2*x0*exp(-w*t)
observe v = x'
exact v = -w*x0*sin(w*t)
scene a
  set w = 3
  until 5
  method rk4 step 0.05
  record x, error(x), error(s), error(v), error(x)' every 1
  expect error(x) = x - x0*cos(w*t) within 1e-15
  expect error(s) = 0 within 1e-3
end
scene b
  start x = 0.1
  exact x = (0.1 [m])*cos(w*t)
  until 1
  record x, error(x) every 1
end
"""
CHAIN = """model chain
size N = 40
coord q[1..N]
fixed q[0] = 0, q[N+1] = 0
kinetic sum(q[i]'^2/2, i = 1..N)
potential sum((q[i+1] - q[i])^2/2, i = 0..N)
start q[i = 1..N] = sin(pi*i/(N+1))
exact q[i = 1..N] = sin(pi*i/(N+1))*cos(2*sin(pi/(2*(N+1)))*t)
observe off = sum(error(q[i])^2, i = 1..N)
"""


def table(*arguments: object, path: Path) -> np.ndarray:
    rows = path / "rows.csv"
    ran("run", *arguments, "-o", rows)
    return np.genfromtxt(rows, delimiter=",", names=True, deletechars="")


def test_columns_of_a_run(tmp_path: Path) -> None:
    path = tmp_path / "e.lag"
    path.write_text(MODEL)
    found = table(path, "--scene", "a", path=tmp_path)
    at = found["t"]
    assert np.allclose(found["error(x)"], found["x"] - np.cos(3 * at) / 2, atol=1e-15, rtol=0)
    assert 1e-6 < np.abs(found["error(x)"]).max() < 1e-3  # of rk4
    assert 1e-8 < np.abs(found["error(v)"]).max() < 1e-3
    assert np.allclose(found["error(x)'"], found["error(v)"], atol=1e-14)
    options = ["--until", 2, "--every", 0.5, "--record", "x,error(x),error(s)", "--set", "x0=3"]
    found = table(path, *options, "--rtol", "1e-12", path=tmp_path)
    assert np.abs(found["error(x)"]).max() < 1e-10 and found["x"][0] == 3
    found = table(path, *options, "--start", "x=4", path=tmp_path)
    assert found["error(x)"][0] == 1  # the closed form is that of x0
    assert np.abs(table(path, "--scene", "b", path=tmp_path)["error(x)"]).max() < 1e-12


def test_closed_forms_of_a_model_in_python(tmp_path: Path) -> None:
    path, at = tmp_path / "e.lag", np.linspace(0, 2, 5)
    path.write_text(MODEL)
    m = pkgen.load(path)
    assert np.allclose(m.exact(at)["s"], np.exp(-2 * at)) and m.exact(0.0)["x"].shape == ()
    m.params["w"] = "5 [1/s]"
    assert np.allclose(m.exact(at)["v"], -2.5 * np.sin(5 * at))
    a, b = pkgen.load(path, "a"), pkgen.load(path, "b")
    assert np.allclose(a.exact(at)["x"], 0.5 * np.cos(3 * at)) and [*b.exact(0)] == ["x"]
    r = a.run()
    assert np.allclose(a.exact(r["t"])["x"] + r["error(x)"], r["x"], atol=1e-15)
    with pytest.raises(pkgen.UsageError):
        m.exact("soon")


def test_families(tmp_path: Path) -> None:
    """A family in a loop; the error of a member, and a sum of them."""
    path = tmp_path / "chain.lag"
    path.write_text(CHAIN)
    options = ["--until", 20, "--every", 1, "--rtol", "1e-12", "--record", "off,q[7],error(q[7])"]
    found = table(path, *options, path=tmp_path)
    w, at = 2 * np.sin(np.pi / 82), found["t"]
    exact = np.sin(np.pi * 7 / 41) * np.cos(w * at)
    assert np.allclose(found["error(q[7])"], found["q[7]"] - exact, atol=1e-15)
    assert found["off"].max() < 1e-18
    m = pkgen.load(path, sizes={"N": 50})
    assert np.allclose(m.exact([0.0, 3.0])["q[50]"][0], np.sin(np.pi * 50 / 51))
    for wrong in ("error(q[0])", "error(q)", "error(off)"):
        done = run_pkgen("run", path, "--record", wrong)
        assert done.returncode in (1, 2) and wrong[:9] in done.stderr and "^" in done.stderr
    # Wrong, it is caught up to 200 members; one of an approximation is tried at the start alone.
    wrong = CHAIN.replace("2*sin(pi/(2*(N+1)))", "pi/(N+1)")
    with pytest.raises(ModelError, match=r"closed form of q.* does not follow"):
        check_model(from_text("m.lag", wrong))
    check_model(from_text("m.lag", wrong.replace("N = 40", "N = 201")))
    check_model(from_text("m.lag", wrong.replace("*t)", "*t) within 0.01")))
    with pytest.raises(ModelError, match=r"q\[1\] starts at 0.07.*, and its closed form at 0.09"):
        off = wrong.replace("*t)", "*t) + 0.02 within 0.01")
        check_model(from_text("m.lag", off))


def test_c_is_the_same(tmp_path: Path) -> None:
    """With and without closed forms, apart from the hash of the text."""
    for text in (MODEL, CHAIN):
        files = []
        for k, said in enumerate((text, re.sub(r"(?m)^exact .*\n", "", text))):
            path = tmp_path / str(k) / "m.lag"
            path.parent.mkdir(exist_ok=True)
            path.write_text(re.sub(r"(?ms)^(scene|observe off) .*", "", said))
            ran(path, "-o", path.parent)
            files.append([x.read_text() for x in sorted(path.parent.glob("*.[ch]"))])
        hashes = re.compile(r"\b[0-9a-f]{64}\b")
        assert files[0] and [hashes.sub("", x) for x in files[0]] == [
            hashes.sub("", x) for x in files[1]
        ]


HEAD = """model b
param w = 2
coord x, y
state s
let r = [x, y, 0]
rate s = -s
kinetic x'^2/2 + y'^2/2
potential w^2*dot(r, r)/2
conserve E = energy
start x = 1
"""
WRONG = {
    "exact x = y": "'y' is a coordinate: a closed form cannot use it",
    "exact x = s*t": "'s' is a state: a closed form cannot use it",
    "exact z = t": "unknown coordinate",
    "exact w = 2": "'w' is a parameter: a closed form is for",
    "exact r = t": "'r' has no closed form",
    "exact E = 3": "E starts at 2, and its closed form at 3",
    "let m = t*w\nexact x = m": "'m' is a definition: a closed form cannot use it",
    "exact x[1] = t": "'x' is not a family",
    "exact x = cos(w*t), x = cos(w*t)": "'x' has its closed form already",
    "exact x = cos(w*t) within -1": "it cannot be negative",
    "exact x = log(t)": "x starts at 1, and its closed form at nan",
    "exact x = cos(w*t)\nobserve e = error(y)": "y has no closed form here",
    "observe e = error(x)\nexact x = cos(w*t)": "x has no closed form here",
    "observe e = error(x + y)": "x + y has no closed form here",
    "observe g = x^2\nexact x = cos(w*t), g = 1": "closed form of g does not follow",
    "exact x = cos(w*t)\nscene a\nstart x = 2\nuntil 1\nexpect error(x) < 1\nend": "no closed",
    "scene a\nexact x = 2\nswarm k = 1..3\nstart x = k\nend": "the members of a swarm start diff",
    "scene a\nexact x = cos(3*t)\nuntil 1\nrecord x every 1\nend": "does not follow",
    "scene a\nhold x = cos(w*t)\nexact x = 1\nuntil 1\nrecord y every 1\nend": "does not follow",
    "exact": "the form is: exact x = EXPRESSION of t",
    "exact x": "the form is: exact x = EXPRESSION of t",
}


@pytest.mark.parametrize("said", WRONG)
def test_what_is_refused(said: str, tmp_path: Path) -> None:
    path = tmp_path / "b.lag"
    path.write_text(HEAD + said + "\n")
    done = run_pkgen("check", path)
    assert done.returncode == 1 and WRONG[said] in done.stderr and "b.lag:1" in done.stderr
    assert "^" in done.stderr


def test_what_passes() -> None:
    """Words as names, Hamiltonians, constraints, L of first degree, held coordinates."""
    for text in (
        "coord exact\nkinetic exact'^2/2\npotential exact^2/2\nstart exact = 1\n"
        "observe error = exact\nexact exact = cos(t)",
        "coord x\nhamiltonian p_x^2/2 + x^2/2\nstart x = 1\nexact x = cos(t)",
        "coord x\nhamiltonian sqrt(1 + p_x^2) - x\nexact x = sqrt(1 + t^2) - 1",
        "coord x, y\nlagrangian x*y' - x^2/2 - y^2/2\nstart x = 1\nexact x = cos(t), y = sin(t)",
        "coord x, y\nkinetic x'^2/2 + y'^2/2\nconstraint c: x^2 + y^2 = 1\nstart x = 1, y' = 1\n"
        "exact x = cos(t), y = sin(t)",
    ):
        check_model(from_text("m.lag", f"model m\n{text}\n"))
        wrong = text.replace("cos(t)", "cos(t) + t^3/9")
        if wrong != text:
            with pytest.raises(ModelError, match="does not follow from the motion"):
                check_model(from_text("m.lag", f"model m\n{wrong}\n"))


def test_the_error_in_the_docs(tmp_path: Path) -> None:
    page = (ROOT / "docs/language.md").read_text()
    text = next(x for x in re.findall(r"```lag\n(.*?)```", page, re.S) if "wide_swings" in x)
    path = tmp_path / "wide_swings.lag"
    path.write_text(text)
    for scene in ("swings", "turns"):
        assert "expected: 1 of 1 met" in ran("run", path, "--scene", scene).stderr
    path.write_text(text.replace("ellipk(m), m)", "ellipk(m), m^2)"))
    assert run_pkgen("check", path.name, cwd=tmp_path).stderr in page
