"""Normal forms: equal means equal, the value stays, and the work is bounded."""

import math
import random

import pytest
from building import model

from pkgen.graph import policies
from pkgen.graph.collect import fewest, settled
from pkgen.graph.count import operations
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import ZERO, Graph, Kind, Symbol
from pkgen.graph.normal import Normal, squares_merged
from pkgen.middle.derive.derive import derive


@pytest.fixture
def world():
    g = Graph()
    return g, *(g.symbol(Symbol(Kind.COORDINATE, i)) for i in range(3))


def some_node(g: Graph, leaves: list[int], draw: random.Random) -> int:
    pool = [*leaves, *(g.call(f, x) for x in leaves for f in ("sin", "cos"))]
    pool.append(g.call("sqrt", g.add(g.power(leaves[0], 2), g.number(2))))
    for _ in range(14):
        a, b = draw.choice(pool), draw.choice(pool)
        pool.append(draw.choice([g.add(a, b), g.multiply(a, b), g.power(a, 2), g.subtract(a, b)]))
    return g.add(pool[-1], g.multiply(pool[-2], pool[-3]))


def test_every_form_has_the_same_value():
    draw = random.Random(9127)
    shortened = 0
    for _ in range(80):
        g = Graph()
        x = [g.symbol(Symbol(Kind.COORDINATE, i)) for i in range(3)]
        node = some_node(g, x, draw)
        canonical, open_ = Normal(g), Normal(g, canonical=False)
        polynomials = [(canonical, canonical(node)), (open_, open_(node))]
        if any(polynomial is None for _, polynomial in polynomials):
            continue
        forms = [normal.plain(polynomial) for normal, polynomial in polynomials]
        forms.append(open_.plain(squares_merged(g, polynomials[1][1])))
        forms += fewest(g, [node])
        shortened += operations(g, forms[-1:]) < operations(g, [node])
        values = {Symbol(Kind.COORDINATE, i): draw.uniform(0.3, 1.1) for i in range(3)}
        first, *rest = evaluate(g, [node, *forms], values)
        for other in rest:
            assert math.isclose(first, other, rel_tol=1e-8, abs_tol=1e-8)
    assert shortened > 5


def test_identities(world):
    g, x, y, _ = world
    s, c = g.call("sin", x), g.call("cos", x)
    fourth = g.subtract(g.power(s, 4), g.power(g.subtract(g.number(1), g.power(c, 2)), 2))
    nested = g.subtract(g.power(g.add(s, y), 2), g.power(g.add(y, s), 2))
    crossed = g.subtract(
        g.power(g.add(s, g.multiply(y, c)), 2),
        g.sum(
            [
                g.power(s, 2),
                g.multiply(g.number(2), g.product([s, y, c])),
                g.multiply(g.power(y, 2), g.power(c, 2)),
            ]
        ),
    )
    root = g.call("sqrt", g.add(g.power(x, 2), g.power(y, 2)))
    square = g.subtract(g.power(root, 4), g.power(g.add(g.power(y, 2), g.power(x, 2)), 2))
    for node in (fourth, nested, crossed, square):
        assert Normal(g)(node) == {}
    assert crossed != ZERO  # the graph alone does not see this one
    assert settled(g, [crossed]) == [ZERO]
    assert Normal(g)(g.add(crossed, x)) != {}


def test_the_work_is_bounded(world):
    g, x, y, z = world
    base = g.sum([g.number(1), x, y, z, g.call("sin", x), g.call("exp", y)])
    assert Normal(g)(g.power(base, 40)) is None
    tower = g.number(9)
    for _ in range(6):
        tower = g.power(tower, 99)
    assert Normal(g)(g.multiply(tower, x)) is None
    doubling = g.number(10**100)
    for _ in range(40):
        doubling = g.multiply(doubling, doubling)
    assert Normal(g)(g.multiply(doubling, x)) is None


def test_no_digits_are_lost_by_rewriting():
    """sin^2 does not turn into 1 - cos^2, nor (a - b)^4 into a polynomial."""
    e = derive(
        model(
            params={"m": 1.3, "k": 2.1},
            coords=("theta", "phi", "r"),
            kinetic="m/2*(r'^2 + r^2*theta'^2 + r^2*sin(theta)^2*phi'^2)",
            potential="k*(r - theta)^4 + k*(1 - cos(theta))^3",
        )
    )
    at = {Symbol(Kind.COORDINATE, i): x for i, x in enumerate((1e-9, 0.4, 1e-9 + 1e-13))}
    at |= {Symbol(Kind.RATE, i): 0.0 for i in range(3)}
    at |= {Symbol(Kind.PARAMETER, 0): 1.3, Symbol(Kind.PARAMETER, 1): 2.1}
    (inertia, force) = evaluate(e.graph, [e.mass[1][1], e.force[2]], at)
    stretch = (1e-9 + 1e-13) - 1e-9
    assert math.isclose(inertia, 1.3 * (1e-9 + 1e-13) ** 2 * math.sin(1e-9) ** 2, rel_tol=1e-12)
    assert math.isclose(force, -4 * 2.1 * stretch**3, rel_tol=1e-12)


@pytest.mark.parametrize("policy", [policies.shared, policies.shifts])
def test_a_sum_to_a_power_stays_closed_unless_rates_are_in_it(world, policy):
    g, x, y, _ = world
    v = g.symbol(Symbol(Kind.RATE, 0))
    difference = g.subtract(g.call("cos", x), y)
    moving = g.add(v, g.call("sin", x))
    closed = policy(g, [g.multiply(g.power(difference, 3), g.power(moving, 2))])
    assert closed == {difference}
