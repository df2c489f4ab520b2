"""The method taylor: random motions beside dop853, with kinks, rotations and changes at events; its
order; what it refuses."""

import random

import numpy
import pytest

import pkgen
from conftest import run_pkgen, seeds

TERMS = (
    "sin({a} - {b})", "cos({a})*{b}", "exp({a}/3)", "log(2 + {a}^2)", "sqrt(3 + {a}^2)",
    "tanh({a} + {b})", "atan({a}*{b})", "({a}^2 + 1)^(2/3)", "1/(3 + {a}^2)", "{a}^2*sin(2*t)",
)  # fmt: skip
KINKS = ("abs({a} - 0.2)", "max({a}, {b})*0.3", "min({a}, 0.1)^2*{b}/4")


def drawn(dice: random.Random) -> str:
    """A model of bounded motion, with at least one feature beyond smooth equations."""
    q = [f"q{k}" for k in range(dice.randint(1, 3))]
    kinks = dice.random() < 0.5

    def term(terms=TERMS) -> str:
        text = dice.choice(terms).format(a=dice.choice(q), b=dice.choice(q))
        return f"{dice.uniform(-0.6, 0.6):.3f}*k*{text}"

    kinetic = [f"(2 + cos({dice.choice(q)}))*{x}'^2" for x in q]
    if len(q) > 1:
        kinetic.append(f"0.4*sin({q[-1]})*{q[0]}'*{q[1]}'")
    lines = ["model drawn", "param k = 0.9", f"coord {', '.join(q)}"]
    potential = [f"1.5*{x}^2" for x in q] + [term(), term()]
    potential += [term(KINKS)] if kinks else []
    if not kinks and dice.random() < 0.6:
        lines += ["rotation R", "let w = omega(R)", "start omega(R) = [0.3, -0.9, 0.4]"]
        kinetic.append(f"2*w.x^2 + w.y^2 + 0.7*w.z^2 + 0.1*w.x*{q[0]}'")
        potential.append(f"k*dot(R*[0, 0, 1], [0.3, 0.5, {q[0]}])")
    if dice.random() < 0.5:
        lines.append(f"event down: {q[0]} + 0.3 falling then {q[0]}' = 0.9*{q[0]}' - 0.1")
    if dice.random() < 0.4:
        lines += ["state z", f"rate z = {q[0]}' - z*(1 + {q[-1]}^2)", f"force {q[-1]} = z"]
    lines += [f"kinetic {' + '.join(kinetic)}", f"potential {' + '.join(potential)}"]
    for of in (*q, *(f"{x}'" for x in q)):
        lines.append(f"start {of} = {dice.uniform(-1, 1):.3f}")
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("seed", seeds(range(40), turning=10))
def test_motions_agree_with_dop853(seed, tmp_path):
    dice = random.Random(seed)
    path, rtol = tmp_path / "drawn.lag", 10 ** dice.uniform(-12, -7)
    path.write_text(drawn(dice))
    model = pkgen.load(path)
    found, exact = (
        model.run(until=6, every=0.37, method=method, rtol=limit)
        for method, limit in (("taylor", rtol), ("dop853", 1e-13))
    )
    for name in exact.columns:
        a, b = found[name], exact[name]
        assert numpy.abs(a - b).max() <= 2e3 * rtol * max(1, numpy.abs(b).max()), name


@pytest.mark.parametrize("seed", seeds(range(8), turning=2))
def test_members_in_lanes_are_single_runs(seed, tmp_path):
    """The vectors of members round as numbers do, so that all bits agree."""
    dice = random.Random(seed)
    path, how = tmp_path / "drawn.lag", {"until": 3, "every": 1.1, "method": "taylor"}
    path.write_text(drawn(dice))
    table = {"k": [dice.uniform(0.5, 1.2) for _ in range(37)]}
    table["q0"] = [dice.uniform(-1, 1) for _ in range(37)]
    model = pkgen.load(path)
    found = model.ensemble(table, **how)
    for member in (0, 5, 36):  # one member alone is not in lanes
        alone = model.ensemble({name: x[member : member + 1] for name, x in table.items()}, **how)
        for name in ("t", "q0", "q0'"):
            of = found[name].reshape(37, -1)[member]
            assert numpy.array_equal(of, alone[name].ravel()), (name, member)


@pytest.mark.parametrize("seed", seeds(range(6), turning=2))
def test_derivatives_of_runs(seed, tmp_path):
    path, by = tmp_path / "drawn.lag", ["k", "q0", "q0'"]
    path.write_text(drawn(random.Random(seed)))
    model = pkgen.load(path)
    found, exact = (
        model.run(until=2, every=1, method=method, rtol=1e-11, sensitivity=by).sensitivity
        for method in ("taylor", "dop853")
    )
    for name in by:
        assert found["q0", name] == pytest.approx(exact["q0", name], rel=1e-6, abs=1e-7), name


LINEAR = "model spring\ncoord x\nkinetic x'^2/2\npotential x^2/2\nstart x = 1\n"


@pytest.mark.parametrize(("rtol", "order"), [(1e-2, 5), (1e-4, 8), (1e-10, 19), (1e-15, 27)])
def test_the_order_follows_from_the_tolerance(rtol, order, tmp_path):
    path = tmp_path / "spring.lag"
    path.write_text(LINEAR)
    model = pkgen.load(path)
    a, b = (model.run(until=T, every=T, method="taylor", rtol=rtol) for T in (5, 25))
    more = [b.report[x] - a.report[x] for x in ("evaluations", "steps")]
    assert more[0] / more[1] == pytest.approx(order, abs=0.9)
    assert abs(a["x"][-1] - numpy.cos(5)) <= 30 * rtol


@pytest.mark.parametrize(
    ("more", "why"),
    [
        ("input u\nforce x = u\n", "without constraints, inputs and noise"),
        ("force x = asin(x/9)\n", "only with functions such as sin and exp"),
        ("coord y\nkinetic y'^2/2\nconstraint rod: x^2 + y^2 = 1\n", "without constraints"),
    ],
)
def test_what_has_no_series_is_refused(more, why, tmp_path):
    path = tmp_path / "spring.lag"
    path.write_text(LINEAR + more)
    result = run_pkgen("run", path, "--method", "taylor", "--until", "1")
    assert result.returncode == 4 and why in result.stderr
