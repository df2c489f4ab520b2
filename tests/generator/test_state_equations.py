"""First-order variables: their part in Lagrange's equations, what is proved, their C."""

import random
import re
from pathlib import Path

import pytest
import sympy as sp
from building import Needing
from c_harness import STRICT, run

import pkgen
from conftest import case, seeds
from pkgen.compiler import compile_model
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Kind, Symbol
from pkgen.source import ModelError, Source

# M, V, D and a force depend on the states, their rates on momenta, the energy, t and each other.
TANGLED = case("tangled")
# Beside the coordinate, with no part in what its momentum is.
MAXWELL = case("maxwell")
ALONE = case("alone")
# In L, but in no momentum.
SPRING = case("spring")


def compiled(text: str, **more):
    return compile_model(Source("model.lag", text), **more)


def test_lagranges_equations_with_states() -> None:
    """By SymPy: states are functions of time whose derivatives are their rates."""
    t, r = sp.Symbol("t"), sp.Rational
    q, w, x, y = (sp.Function(name)(t) for name in "qwxy")
    T = (1 + x**2) / 2 * q.diff() ** 2 + q.diff() * w.diff() * sp.cos(y) / 4 + w.diff() ** 2
    V = q**2 * x + w * y
    p = {c: (T - V).diff(c.diff()) for c in (q, w)}
    energy = sum(p[c] * c.diff() for c in (q, w)) - T + V
    rate_x = q.diff() - x + p[q] / 5
    rate_y = sp.sin(q) + energy / 9 + t * rate_x
    applied = {q: -r(2, 3) * x**2 * q.diff(), w: y * rate_x}
    rates = {x.diff(): rate_x, y.diff(): rate_y}
    left = [(p[c].diff(t) - (T - V).diff(c) - applied[c]).subs(rates) for c in (q, w)]
    c = compiled(TANGLED)
    g, draw = c.equations.graph, random.Random(7)
    for _ in range(2):
        values = {
            Symbol(kind, i): draw.uniform(-1, 1)
            for kind in (Kind.COORDINATE, Kind.RATE, Kind.STATE)
            for i in range(2)
        }
        values[Symbol(Kind.TIME)] = draw.uniform(0, 1)
        e = c.equations
        nodes = [*e.acceleration, *e.state_rates, *e.observed]
        aq, aw, ax, ay, early, momentum = evaluate(g, nodes, values)
        here = [(q.diff(t, 2), aq), (w.diff(t, 2), aw)]
        here += [(f.diff(), values[Symbol(Kind.RATE, i)]) for i, f in enumerate((q, w))]
        here += [(f, values[Symbol(Kind.COORDINATE, i)]) for i, f in enumerate((q, w))]
        here += [(f, values[Symbol(Kind.STATE, i)]) for i, f in enumerate((x, y))]
        here += [(t, values[Symbol(Kind.TIME)])]
        exact = [float(sp.sympify(z).subs(here)) for z in (*left, rate_x, rate_y, p[q])]
        assert exact[:2] == pytest.approx([0, 0], abs=1e-12)
        assert [ax, ay, momentum] == pytest.approx(exact[2:], rel=1e-12)
        assert early == pytest.approx(ax + ay * values[Symbol(Kind.COORDINATE, 0)], rel=1e-12)


def without(text: str, *lines: str) -> str:
    """The text without the lines that begin so."""
    return "".join(line for line in text.splitlines(True) if not line.startswith(lines))


ACTION = without(MAXWELL, "force", "rate s", "state s", "param k", "param eta")
FACTS = [
    # text, and which of the facts hold
    (MAXWELL, "mass_constant quadratic autonomous smooth"),
    (ACTION, "mass_constant quadratic autonomous conservative variational smooth"),
    (ACTION + "rate_of t", "mass_constant quadratic conservative variational smooth"),
    (ALONE, "mass_constant quadratic autonomous smooth"),
    (ALONE.replace("(1 - x^2)", "1"), "mass_constant quadratic autonomous affine smooth"),
    (ALONE.replace("(1 - x^2)", "abs(x)"), "mass_constant quadratic autonomous"),
    (MAXWELL.replace("-k*s", "0*s").replace("= L", "= q*(1 [J/m])"), "separable"),
    (TANGLED, "quadratic smooth"),
    (
        without(TANGLED, "dissipation", "force", "rate y") + "rate y = -y\n",
        "quadratic autonomous smooth",
    ),
]


@pytest.mark.parametrize(("text", "holds"), FACTS, ids=range(len(FACTS)))
def test_facts(text: str, holds: str) -> None:
    if text.endswith("rate_of t"):
        text = text.removesuffix("rate_of t").replace("rate S = L", "rate S = L*sin(t/(1 [s]))")
    if holds == "separable":  # a state that is kicked as rates are, and one that is not
        text = without(text, "rate s") + "rate s = (2 [m/s])*cos(q/(1 [m]))\n"
        holds = "mass_constant quadratic separable autonomous conservative variational smooth"
    structure = compiled(text).structure
    names = "mass_constant quadratic separable autonomous conservative variational smooth affine"
    assert [x for x in names.split() if getattr(structure, x)] == [
        x for x in names.split() if x in holds.split()
    ]


def test_influences_count_states_after_coordinates() -> None:
    structure = compiled(MAXWELL).structure
    assert structure.influences == ((0, 1), (0, 1), (0,))
    assert structure.blocks == ((0, 1, 2),)
    assert structure.mass_blocks == ((0,), (1,), (2,))
    assert structure.cyclic == (False,)


@pytest.mark.parametrize("seed", seeds(range(3), 37))
def test_states_that_nothing_reads_are_left_out_of_newtons_equations(seed, tmp_path) -> None:
    """A random graph of who reads whom; the same motion by methods without such equations."""
    draw = random.Random(seed)
    n, lines = draw.randint(1, 5), ["model reads", "coord q"]
    reads = {k: {j for j in range(n) if draw.random() < 0.3} for k in range(n)}
    by_force = {j for j in range(n) if draw.random() < 0.3}
    read = by_force.union(*reads.values())
    lines += [f"state s{k}" for k in range(n)]
    for k in range(n):
        terms = [f"{draw.uniform(-1, 1)!r}*sin(s{j})" for j in reads[k]]
        lines += [f"rate s{k} = " + " + ".join([f"{draw.uniform(-1, 1)!r}*q*q' + cos(q)", *terms])]
    forces = "".join(f" - 0.1*sin(s{j})" for j in by_force)
    lines += ["kinetic (2 + cos(q))*q'^2/2", "potential -cos(q)", f"force q = -0.2*q'{forces}"]
    lines += ["start q = 1.2", *(f"start s{k} = {draw.uniform(-1, 1)!r}" for k in range(n))]
    text = "\n".join(lines) + "\n"
    unread = n - 1 - max(read, default=-1)
    (c,) = (body for name, body in compiled(text).files.items() if name.endswith("_system.c"))
    assert (f".n_unread = {unread}," in c) == (unread > 0) and c.count("n_unread") == (unread > 0)
    path = tmp_path / "reads.lag"
    path.write_text(text)
    model = pkgen.load(str(path))
    one, *others = (
        model.run(until=3, every=0.5, **of)
        for of in (
            {"method": "dop853", "rtol": 1e-12},
            {"method": "gauss4", "step": 0.05},
            {"method": "lobatto4", "step": 0.01},
            {"method": "radau", "rtol": 1e-10},
        )
    )
    for other in others:
        for name in ("q", *(f"s{k}" for k in range(n))):
            assert abs(one[name] - other[name]).max() < 1e-7
            assert abs(one[name][-1] - one[name][0]) > 1e-6


def test_what_nothing_recorded_needs_is_left_out() -> None:
    """The action goes; with it alone recorded the Maxwell element stays, for it moves q."""
    use = Needing(columns=frozenset({"s"}))
    c = compiled(MAXWELL, use=use)
    assert [q.name for q in c.equations.states] == ["s"] and len(c.equations.coordinates) == 1
    assert "S: nothing recorded depends on it" in map(str, c.report.lines)
    use = Needing(columns=frozenset({"S"}))
    assert [q.name for q in compiled(MAXWELL, use=use).equations.states] == ["s", "S"]
    # A state that only reads its model's coordinate needs it; one that does not does without.
    alone = without(MAXWELL, "force").replace("rate s = q'", "rate s = (0.3 [m/s])")
    use = Needing(columns=frozenset({"s"}))
    c = compiled(alone, use=use)
    assert not c.equations.coordinates and c.program.kernel("energy") is None


def test_a_cyclic_coordinate_goes_unless_a_rate_has_it() -> None:
    text = "model m\ncoord r, phi\nstate z\nkinetic (r'^2 + r^2*phi'^2)/2\npotential -1/r + z*r\n"
    text += "rate z = {}\nstart r = 1, phi' = 1.1, z = 0.1\n"
    use = Needing(columns=frozenset({"r", "z"}))
    c = compiled(text.format("-z + phi'/9"), use=use)
    assert [q.name for q in c.equations.coordinates] == ["r"]
    c = compiled(text.format("-z + sin(phi)/9"), use=use)
    assert [q.name for q in c.equations.coordinates] == ["r", "phi"]
    assert "phi kept: it is in the rate of a state" in map(str, c.report.lines)


@pytest.mark.parametrize("text", [TANGLED, MAXWELL, ALONE, SPRING], ids=lambda x: x.split()[1])
def test_strict_c_that_agrees_with_itself(text: str, tmp_path: Path) -> None:
    files = compiled(text, self_test=True).files
    name = text.split()[1]
    for file, content in files.items():
        (tmp_path / file).write_text(content, encoding="utf-8")
    sources = [f"{name}.c", f"{name}_selftest.c"]
    run("gcc", *STRICT, *sources, "-o", "x", "-lm", cwd=tmp_path)
    passed = re.fullmatch(r"(\d+) passed, 0 failed\n", run(tmp_path / "x", cwd=tmp_path))
    assert passed and int(passed[1]) > 200
    include = Path(__file__).parents[2] / "runtime" / "include"
    run("gcc", *STRICT, "-DPK_RUNTIME", f"-I{include}", "-fsyntax-only", sources[0], cwd=tmp_path)
    header = files[f"{name}.h"]
    n, states = (re.search(rf"{name}_{what} = (\d+)", header)[1] for what in ("N", "FIRST_ORDER"))
    assert f".n_first_order = {states}," in files[f"{name}_system.c"]
    first = int(n) - int(states)
    declared = re.search(r"^state (\w+)", text, re.M)[1]
    assert f"{name}_x_{declared} = {first}" in header
    says = " ".join(header.replace("\n *", " ").split())
    assert f"stored in v[i], and its rate g in a[i], for i = {first}" in says
    assert "q[i], whose value may be anything" in says


CLAIMS = [
    ("conserve H = x - log(x) + b*y - a*log(y)", ""),
    ("conserve H = x - log(x) + b*y - b*log(y)", "'H' is not constant: dH/dt ="),
    ("conserve H = x*y'  - x'*y", "is not constant"),
]


@pytest.mark.parametrize(("claim", "said"), CLAIMS)
def test_claims_over_states(claim: str, said: str) -> None:
    text = f"""model lotka
param a = 2/3
param b = 4/3
state x, y
rate x = a*x - b*x*y
rate y = x*y - y
start x = 1, y = 2
{claim}
"""
    if not said:
        (proof,) = compiled(text).structure.claims
        assert proof.outcome == "proved"
        return
    with pytest.raises(ModelError) as caught:
        compiled(text)
    assert said in caught.value.text()


def test_the_energy_is_no_claim_where_a_state_is_in_it() -> None:
    """dh/dt = -dL/dx x' is not zero; with x at rest it is."""
    text = "model m\ncoord q\nstate x\nkinetic q'^2/2\npotential x*q^2/2\nrate x = {}\n"
    text += "start q = 1, x = 2\nconserve H = energy\n"
    compiled(text.format("0*x"))
    with pytest.raises(ModelError) as caught:
        compiled(text.format("-x"))
    assert "is not constant" in caught.value.text()


RING = """\
model ring
size N = 4
state c[1..N]
{}
rate c[1] = c[2] - 2*c[1] + c[0]
rate c[i = 2..N] = c[i+1] - 2*c[i] + c[i-1]
start c[i = 1..N] = i
conserve total = sum(c[i], i = 1..N)
"""


def test_the_ends_of_a_family_of_states() -> None:
    """Nothing is lost round a ring or between walls; where an end is kept at 0 it is."""
    for ends in ("periodic c", "free c"):
        (proof,) = compiled(RING.format(ends)).structure.claims
        assert proof.outcome == "proved"
    with pytest.raises(ModelError) as caught:
        compiled(RING.format("fixed c[0] = 0, c[N+1] = sin(t)"))
    assert "'total' is not constant" in caught.value.text()
    with pytest.raises(ModelError) as caught:
        compiled(RING.format(""))
    assert "c[0] is outside the family" in caught.value.text()


def test_rates_defined_by_themselves() -> None:
    text = "model m\nstate x, y, z\nlet u = y'\nrate x = u + 1\nrate y = 2*z'\nrate z = x'/3\n"
    with pytest.raises(ModelError) as caught:
        compiled(text)
    said = caught.value.text()
    assert "m.lag" not in said and "model.lag:4:1: error" in said
    assert "the rate of 'x' is defined by itself: x' needs y' needs z' needs x'" in said


def test_there_is_no_canonical_form_with_states() -> None:
    with pytest.raises(ModelError) as caught:
        compiled(MAXWELL, canonical=True)
    assert "no canonical form: states have no momenta" in caught.value.text()
