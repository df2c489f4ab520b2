"""Closed forms beside a model, `exact x = EXPR`: what is true passes, what is wrong is caught."""

import random

import numpy as np
import pytest
import sympy as sp

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
    lines = ["coord x, s", f"kinetic x'^2/2 + (s' + ({k})*x')^2/2", f"potential ({g})*(s + ({k})*x)"]
    forms = {"x": u * t, "s": v * t - g * t**2 / 2}
    return [*lines, f"start x' = {u}, s' = {v}"], forms


def decay(draw: random.Random) -> tuple[list[str], dict[str, sp.Expr]]:
    """A chain of two decays."""
    a = sp.Rational(draw.randint(1, 20), 10)
    b, n = a + sp.Rational(draw.randint(1, 20), 10), draw.randint(1, 9)
    lines = ["state n, d", f"rate n = -({a})*n", f"rate d = ({a})*n - ({b})*d", f"start n = {n}"]
    return lines, {"n": n * sp.exp(-a * t), "d": n * a / (b - a) * (sp.exp(-a * t) - sp.exp(-b * t))}


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


def test_numbers_of_a_run() -> None:
    assert np.isfinite(1)
