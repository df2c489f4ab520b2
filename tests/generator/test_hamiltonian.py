"""`hamiltonian H`: Hamilton's equations by SymPy, at random places and momenta."""

import random

import pytest
import sympy as sp

import pkgen
from conftest import seeds
from pkgen.front.check.check import check_text
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Kind, Symbol
from pkgen.middle.derive.derive import derive
from pkgen.middle.derive.first_degree import as_states
from pkgen.middle.derive.legendre import in_pairs
from pkgen.source import Source


def of_places(draw: random.Random, names: list[str]) -> str:
    a, b, c = draw.choice(names), draw.choice(names), round(draw.uniform(0.3, 2), 2)
    return draw.choice((f"{c}*{a}*{b}", f"sin({c}*{a})", f"k*{a}^2", f"exp({a}/3)", f"{c}*{a}*t"))


def random_model(draw: random.Random, quadratic: bool) -> tuple[str, str, list[str]]:
    names = ["x", "y", "z"][: draw.randint(1, 3)]
    terms = [f"p_{n}^2*(1 + {of_places(draw, names)}^2)/2" for n in names]
    for _ in range(draw.randint(0, 3)):
        a, b = draw.choice(names), draw.choice(names)
        terms.append(draw.choice((f"p_{a}*({of_places(draw, names)})", f"0.3*p_{a}*p_{b}")))
    terms += [of_places(draw, names) for _ in range(2)]
    if not quadratic:
        n = draw.choice(names)
        terms.append(draw.choice((f"sqrt(1 + p_{n}^2)", f"p_{n}^4/8", f"cos(p_{n})*{n}/5")))
    energy = " + ".join(terms)
    head = f"model m\nparam k = 0.7\ncoord {', '.join(names)}\n"
    starts = ", ".join(f"{n} = 0.1, p_{n} = {draw.uniform(-1, 1):.3f}" for n in names)
    return f"{head}hamiltonian {energy}\nstart {starts}\n", energy, names


@pytest.mark.parametrize("seed", seeds(range(3), 60))
def test_the_motion_is_that_of_hamiltons_equations(seed: int) -> None:
    draw = random.Random(seed)
    quadratic = draw.random() < 0.6
    text, energy, names = random_model(draw, quadratic)
    model = as_states(in_pairs(check_text(Source("m.lag", text))[0]))
    assert bool(model.coordinates) is quadratic
    e = derive(model)
    t = sp.Symbol("t")
    q, p = sp.symbols(names), sp.symbols([f"p_{name}" for name in names])
    H = sp.sympify(
        energy.replace("^", "**"),
        {"t": t, "k": sp.Float("0.7"), **dict(zip(map(str, [*q, *p]), [*q, *p], strict=True))},
    )
    place = {s: draw.uniform(-1, 1) for s in (*q, *p)} | {t: 0.4}
    rates = [H.diff(s) for s in p]
    falls = [-H.diff(s) for s in q]
    numbers = lambda rows: [float(x.subs(place)) for x in rows]  # noqa: E731
    values = {Symbol(Kind.TIME): 0.4, Symbol(Kind.PARAMETER, 0): 0.7}
    if quadratic:
        values |= {Symbol(Kind.COORDINATE, i): place[s] for i, s in enumerate(q)}
        values |= {Symbol(Kind.RATE, i): x for i, x in enumerate(numbers(rates))}
        along = [
            r.diff(t)
            + sum(
                r.diff(a) * b + r.diff(c) * d for a, b, c, d in zip(q, rates, p, falls, strict=True)
            )
            for r in rates
        ]
        found, wanted = [*e.acceleration, *e.momenta], [*along, *p]
    else:
        values |= {Symbol(Kind.STATE, i): place[s] for i, s in enumerate((*q, *p))}
        found, wanted = e.state_rates, [*rates, *falls]
    assert evaluate(e.graph, found, values) == pytest.approx(numbers(wanted), rel=1e-9, abs=1e-9)
    assert evaluate(e.graph, [e.energy], values)[0] == pytest.approx(float(H.subs(place)), rel=1e-9)


@pytest.mark.parametrize("seed", seeds(range(100, 103), 20))
def test_momenta_start_where_they_are_told(seed: int) -> None:
    draw = random.Random(seed)
    text, _, names = random_model(draw, True)
    model = in_pairs(check_text(Source("m.lag", text))[0])
    e = derive(model)
    given = {Symbol(Kind.PARAMETER, 0): 0.7}
    start = evaluate(e.graph, [*e.start_q, *e.start_v], given)
    values = {
        Symbol(k, i % len(names)): x
        for (i, x), k in zip(
            enumerate(start), [Kind.COORDINATE] * len(names) + [Kind.RATE] * len(names), strict=True
        )
    }
    wanted = [
        float(part.split("p_")[1].split("= ")[1])
        for part in text.split("start ")[1].split(", ")[1::2]
    ]
    values |= {Symbol(Kind.TIME): 0.0}
    assert evaluate(e.graph, e.momenta, values | given) == pytest.approx(wanted, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    "kinked, slope",
    [
        ("abs(p_x)/3", (-1 / 3, 1 / 3)),
        ("max(p_x - 0.1, 0)", (0, 1)),
        ("if(p_x > 0.1, 0.3*(p_x - 0.1), 0)", (0, 0.3)),
    ],
)
def test_a_kink_in_a_momentum_is_of_no_degree(kinked: str, slope: tuple[float, float]) -> None:
    """Its second derivative is 0, and it is no part of a quadratic H."""
    text = f"model m\ncoord x\nhamiltonian p_x^2/2 + x^2/2 + {kinked}\nstart x = 1\n"
    e = derive(as_states(in_pairs(check_text(Source("m.lag", text))[0])))
    for p, by in ((-0.8, slope[0]), (0.8, slope[1])):
        values = {Symbol(Kind.STATE, 0): 0.5, Symbol(Kind.STATE, 1): p}
        assert evaluate(e.graph, e.state_rates, values) == pytest.approx([p + by, -0.5])


def test_a_place_that_would_change_the_rates_is_set_by_a_scene(tmp_path) -> None:
    path = tmp_path / "m.lag"
    path.write_text(
        "model m\ncoord x\nhamiltonian p_x^2*(1 + x^2)/2\nstart x = 1, p_x = 1\n"
        "scene far\n  start x = 2\n  until 1\nend\n"
    )
    m = pkgen.load(path)
    for wrong in (lambda: m.run(1, start={"x": 2}), lambda: m.ensemble({"x": [1, 2]}, until=1)):
        with pytest.raises(pkgen.UsageError, match="rates follow from momenta"):
            wrong()
    assert pkgen.load(path, "far").run()["x'"][0] == 5
