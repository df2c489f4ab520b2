"""L of first degree in the rates: the rates against SymPy, which solves Lagrange's equations."""

import random
from pathlib import Path

import pytest
import sympy as sp

from conftest import run_pkgen, seeds
from pkgen.front.check.check import check_text
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Kind, Symbol
from pkgen.middle.derive.derive import derive
from pkgen.middle.derive.first_degree import as_states
from pkgen.source import Source


def term(draw: random.Random, names: list[str]) -> str:
    a, b = draw.choice(names), draw.choice(names)
    c = round(draw.uniform(0.3, 2), 2)
    return draw.choice((f"{c}*{a}*{b}", f"{c}*sin({a})", f"{a}*exp({b}/3)", f"k*{a}^2", f"t*{a}"))


@pytest.mark.parametrize("seed", seeds(range(3), 60))
def test_rates_are_those_of_sympy(seed: int) -> None:
    draw = random.Random(seed)
    pairs = draw.randint(1, 2)
    names = [f"{x}{i}" for i in range(pairs) for x in "qp"]
    forms = [f"2*p{i}*q{i}'" for i in range(pairs)]  # so the form is regular, or nearly so
    for _ in range(draw.randint(0, 4)):
        forms.append(f"({term(draw, names)})*{draw.choice(names)}'/4")
    energy = " + ".join(term(draw, names) for _ in range(3))
    text = f"model m\nparam k = 0.7\ncoord {', '.join(names)}\n"
    text += f"lagrangian {' + '.join(forms)} - ({energy})\n"
    model = as_states(check_text(Source("m.lag", text))[0])
    assert not model.coordinates and [s.name for s in model.states] == names
    e = derive(model)
    t = sp.Symbol("t")
    q = {n: sp.Function(n)(t) for n in names}
    scope = q | {f"{n}_": q[n].diff(t) for n in names} | {"t": t, "k": sp.Float("0.7")}
    lagrangian = sp.sympify(
        text.split("lagrangian ")[1].replace("'", "_").replace("^", "**"), scope
    )
    rates = {n: q[n].diff(t) for n in names}
    equations = [lagrangian.diff(rates[n]).diff(t) - lagrangian.diff(q[n]) for n in names]
    v = sp.symbols(f"v0:{len(names)}")
    place = {n: draw.uniform(-1, 1) for n in names}
    there = {q[n]: x for n, x in place.items()} | {t: 0.4}
    rows = [eq.subs(dict(zip(rates.values(), v, strict=True))).subs(there) for eq in equations]
    wanted = sp.linsolve(rows, *v).args[0]
    values = {Symbol(Kind.STATE, i): place[n] for i, n in enumerate(names)}
    values |= {Symbol(Kind.TIME): 0.4, Symbol(Kind.PARAMETER, 0): 0.7}
    found = evaluate(e.graph, e.state_rates, values)
    assert found == pytest.approx([float(x) for x in wanted], rel=1e-9, abs=1e-9)


def test_an_energy_that_is_zero_has_a_scale(tmp_path: Path) -> None:
    """H of vortices a unit apart is 0, and was said to be off by all of its scale: its rounding."""
    path = tmp_path / "pair.lag"
    path.write_text(
        "model pair\ncoord x, y\nlagrangian y*x' + ln(x^2 + y^2)/2\nstart x = 1\n",
    )
    said = run_pkgen("run", path, "--method", "gauss1", "--step", "0.5", "--until", 6).stderr
    assert "energy kept to" in said and "warning" not in said
