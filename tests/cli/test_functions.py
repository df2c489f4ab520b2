"""Every function of the language goes through every stage: checked, explained, claimed, compiled,
tested against itself, integrated by each kind of method, in lanes and in loops."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy import optimize, special

from conftest import ran
from pkgen.compiler import check_model
from pkgen.front.check.names import callable_names
from pkgen.front.read import from_text
from pkgen.functions import VECTOR_FUNCTIONS
from pkgen.source import ModelError


def kepler(M: float, e: float) -> float:
    """E of E - e sin(E) = M, for M between -pi and pi."""
    return float(optimize.brentq(lambda E: E - e * np.sin(E) - M, -4, 4, xtol=1e-15))


# As called with an argument z = t - 1/4 (from -0.25 to 0.75), and what that is.
FORMS = {
    "sin": ("sin(z)", np.sin),
    "cos": ("cos(z)", np.cos),
    "tan": ("tan(z)", np.tan),
    "asin": ("asin(z)", np.arcsin),
    "acos": ("acos(z)", np.arccos),
    "atan": ("atan(z)", np.arctan),
    "atan2": ("atan2(z, 2)", lambda z: np.arctan2(z, 2)),
    "sinh": ("sinh(z)", np.sinh),
    "cosh": ("cosh(z)", np.cosh),
    "tanh": ("tanh(z)", np.tanh),
    "exp": ("exp(z)", np.exp),
    "log": ("log(1 + z)", np.log1p),
    "ln": ("ln(1 + z)", np.log1p),
    "sqrt": ("sqrt(1 + z)", lambda z: np.sqrt(1 + z)),
    "abs": ("abs(z)", np.abs),
    "min": ("min(z, 0.25)", lambda z: np.minimum(z, 0.25)),
    "max": ("max(z, 0.25)", lambda z: np.maximum(z, 0.25)),
    "step": ("step(z)", lambda z: np.heaviside(z, 1)),
    "sign": ("sign(z)", np.sign),
    "floor": ("floor(4*z + 0.0288)", lambda z: np.floor(4 * z + 0.0288)),
    "ceil": ("ceil(4*z + 0.0288)", lambda z: np.ceil(4 * z + 0.0288)),
    "round": ("round(4*z - 0.4712)", lambda z: np.floor(4 * z + 0.0288)),
    "mod": ("mod(z + 0.0072, 0.25)", lambda z: np.mod(z + 0.0072, 0.25)),
    "clamp": ("clamp(z, -0.125, 0.5)", lambda z: np.clip(z, -0.125, 0.5)),
    "ellipk": ("z*ellipk(0.3)", lambda z: z * special.ellipk(0.3)),
    "am": ("am(3*z, 0.7)", lambda z: special.ellipj(3 * z, 0.7)[3]),
    "sn": ("sn(3*z, 0.7)", lambda z: special.ellipj(3 * z, 0.7)[0]),
    "cn": ("cn(3*z, 0.7)", lambda z: special.ellipj(3 * z, 0.7)[1]),
    "dn": ("dn(3*z, 0.7)", lambda z: special.ellipj(3 * z, 0.7)[2]),
    "kepler": ("kepler(2*z, 0.6)", np.vectorize(lambda z: kepler(2 * z, 0.6))),
}
BENDS = [0.125, 0.2428, 0.25, 0.4928, 0.5, 0.7428, 0.75, 0.9928]  # in t
END = 1.0
COUNTED = {"floor", "ceil", "round", "mod"}  # families with these are written out
JUMPING = {"step", "sign", "atan2", *COUNTED}
NO_BALLS = {"ellipk", "am", "sn", "cn", "dn", "kepler"}  # claims of these are proved, not refuted


def test_all_functions_are_here() -> None:
    assert callable_names() - VECTOR_FUNCTIONS.keys() == FORMS.keys()


def integral(f: Callable[[np.ndarray], np.ndarray], ends: list[float]) -> float:
    """Over pieces on which f is smooth."""
    x, w = np.polynomial.legendre.leggauss(40)
    pairs = pairwise(ends)
    return sum((b - a) / 2 * np.dot(w, f((a + b) / 2 + (b - a) / 2 * x)) for a, b in pairs)


@cache
def reached(name: str) -> tuple[float, float]:
    """y and y' at the end, of y'' = f from rest."""
    f = FORMS[name][1]
    pieces = [0.0, *BENDS, END]
    y = integral(lambda t: (END - t) * f(t - 0.25), pieces)
    return y, integral(lambda t: f(t - 0.25), pieces)


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("functions") / "functions.lag"
    lines = ["model functions", "param w = 1", "coord x", "let z = w*x - 0.25", "start x' = 1"]
    kinetic = ["x'^2/2"]
    for name, (form, _) in FORMS.items():
        lines += [f"coord y_{name}", f"force y_{name} = {form}", f"observe o_{name} = {form}"]
        kinetic.append(f"y_{name}'^2/2")
    path.write_text("\n".join([*lines, "kinetic " + " + ".join(kinetic)]) + "\n")
    return path


METHODS = ["gauss --rtol 1e-12", "dop853 --rtol 1e-12", "rk4 --step 0.01"]


@pytest.mark.parametrize("method", METHODS)
def test_a_run_integrates_each(model: Path, tmp_path: Path, method: str) -> None:
    rows = tmp_path / "rows.csv"
    ran("run", model, "--until", END, "--method", *method.split(), "-o", rows)
    found = np.genfromtxt(rows, delimiter=",", names=True, deletechars="")
    for name, (_, f) in FORMS.items():
        y, v = reached(name)
        assert abs(y) > 1e-3 and abs(v) > 1e-3
        assert abs(found[f"y_{name}"][-1] - y) < 2e-8 and abs(found[f"y_{name}'"][-1] - v) < 2e-8
        away = np.min(np.abs(found["t"][:, None] - BENDS), axis=1) > 1e-9
        assert np.allclose(found[f"o_{name}"][away], f(found["t"][away] - 0.25), rtol=0, atol=1e-9)


def test_lanes_compute_each(model: Path, tmp_path: Path) -> None:
    """Members whose argument never changes its form; those of dop853 keep the step."""
    members = tmp_path / "members.csv"
    members.write_text("x,x'\n" + "".join(f"{0.3 + 0.01 * k},0.1\n" for k in range(9)))
    rows = tmp_path / "rows.csv"
    options = ["--method", "dop853", "--step", "0.25", "--ensemble", members, "-o", rows]
    ran("run", model, "--until", END, *options)
    found = np.genfromtxt(rows, delimiter=",", names=True, deletechars="")
    for name, (_, f) in FORMS.items():
        for k in range(9):
            v = integral(lambda t, k=k, f=f: f(0.05 + 0.01 * k + 0.1 * t), [0, END])
            assert abs(found[f"y_{name}'"][k] - v) < 1e-10


def test_loops_compute_each(tmp_path: Path) -> None:
    path = tmp_path / "loops.lag"
    names = [name for name in FORMS if name not in COUNTED]
    forms = " + ".join(f"{k + 1}*{FORMS[name][0]}" for k, name in enumerate(names))
    forms = forms.replace("z", "(i/N*t - 0.25)")
    path.write_text(
        "model loops\nsize N = 60\ncoord q[1..N]\nkinetic sum(q[i]'^2/2, i = 1..N)\n"
        f"force q[i = 1..N] = {forms}\n"
    )
    rows = tmp_path / "rows.csv"
    options = ["--record", "q[60],q[60]'", "--method", "rk4", "--step", "0.00125"]
    ran("run", path, "--until", END, *options, "-o", rows)
    last = [float(x) for x in rows.read_text().splitlines()[-1].split(",")[1:]]
    for k, value in enumerate(last):
        exact = sum((n + 1) * reached(name)[k] for n, name in enumerate(names))
        assert abs(value - exact) < 2e-4 * abs(exact)  # in loops kinks are not located


@pytest.mark.needs_addon("pages")
def test_each_is_on_the_page(model: Path, tmp_path: Path) -> None:
    ran("explain", model, "--canonical", "--html", tmp_path / "page.html")
    assert "heaviside" not in (tmp_path / "page.html").read_text().lower()


def test_each_is_explained_and_tests_itself(model: Path, tmp_path: Path) -> None:
    assert "heaviside" not in ran("explain", model, "--canonical").stdout.lower()
    ran(model, "--self-test", "--canonical", "-o", tmp_path)
    files = ["functions.c", "functions_selftest.c"]
    subprocess.run(["gcc", "-O1", *files, "-o", "self", "-lm"], cwd=tmp_path, check=True)
    subprocess.run([tmp_path / "self"], check=True, capture_output=True)
    assert json.loads(ran("check", model, "--json").stdout)


@pytest.mark.parametrize("name", FORMS)
def test_each_may_stand_in_a_claim(name: str) -> None:
    form = FORMS[name][0]
    text = (
        f"model m\ncoord z, y\nkinetic z'^2/2 + y'^2/2\npotential {form}\nstart z' = 1\n"
        "conserve E = z'^2/2 + {} + y'\n"
    )
    claim = from_text("m.lag", text.format(form))
    if name in JUMPING:
        with pytest.raises(ModelError, match="error:") as said:
            check_model(claim)
        assert "not proved" in said.value.text() or "jumps" in said.value.text()
    else:
        check_model(claim)
    with pytest.raises(ModelError) as said:
        check_model(from_text("m.lag", text.format(f"0.9*{form}")))
    assert "not constant" in said.value.text() or name in JUMPING | NO_BALLS
