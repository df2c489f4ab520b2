"""Values with a bound of their rounding: the true value is inside, and the bound is small."""

from fractions import Fraction

import pytest
from building import links

from pkgen.functions import FUNCTIONS
from pkgen.functions.elliptic import ELLIPTIC
from pkgen.graph.balls import Ball, Balls
from pkgen.graph.differentiate import reachable
from pkgen.graph.graph import Graph, Kind, Symbol
from pkgen.middle.derive.derive import derive
from pkgen.middle.points.samples import accelerations

X, Y = Symbol(Kind.COORDINATE, 0), Symbol(Kind.COORDINATE, 1)
COARSE, FINE = Balls(24), Balls(300)


def at(balls, node_of, x, y, rad=0):
    g = Graph()
    node = node_of(g, g.symbol(X), g.symbol(Y))
    values = {s: Ball(balls.number(v).mid, balls.mp.mpf(rad)) for s, v in ((X, x), (Y, y))}
    return balls.values(g, [node], values)[0]


def call(name):
    return lambda g, x, y: g.call(name, *(x, y)[: FUNCTIONS[name].arity])


CASES = {name: call(name) for name in FUNCTIONS if name not in ELLIPTIC} | {
    "select": lambda g, x, y: g.call("select", g.call("step", x), x, y),
    "sum": lambda g, x, y: g.add(x, y),
    "difference": lambda g, x, y: g.subtract(g.multiply(x, y), g.multiply(g.power(y, 2), x)),
    "product": lambda g, x, y: g.multiply(x, g.multiply(x, y)),
    "quotient": lambda g, x, y: g.divide(x, y),
    "power": lambda g, x, y: g.power(x, -7),
    "root": lambda g, x, y: g.power(x, Fraction(5, 3)),
    "pi": lambda g, x, y: g.multiply(x, g.symbol(Symbol(Kind.PI))),
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("rad", [0, 2**-10, 2**-7])
def test_the_true_value_is_inside(name, rad):
    """Of 24 bits, or anything within 1/128, against 300 bits; numbers that 24 bits hold."""
    points = [Fraction(k, 64) for k in (7, 23, 40, 61)]
    for x in points:
        for y in (points[2], points[0]):
            ball = at(COARSE, CASES[name], x, y, rad)
            for dx in (0, rad, -rad):
                for dy in (0, rad, -rad):
                    exact = at(FINE, CASES[name], x + Fraction(dx), y + Fraction(dy)).mid
                    assert abs(exact - FINE.mp.mpf(ball.mid)) <= FINE.mp.mpf(ball.rad)
            assert ball.rad <= (1e-4 + 2e3 * rad) * (1 + abs(ball.mid))


@pytest.mark.parametrize(
    ("node", "x", "y"),
    [
        (call("step"), 0, 0),
        (call("sign"), 0, 0),
        (call("log"), 0, 0),
        (call("sqrt"), -1, 0),
        (call("asin"), 1, 0),
        (call("atan2"), 0, -1),  # at the cut
        (lambda g, x, y: g.call("exp", g.power(x, 2)), 10**6, 0),
        (lambda g, x, y: g.call("sin", g.power(x, 2)), 10**6, 0),
        (lambda g, x, y: g.divide(y, x), 0, 1),
    ],
)
def test_where_it_cannot_be_said_there_is_no_value(node, x, y):
    assert at(COARSE, node, Fraction(x), Fraction(y), 1e-6) is None


def test_accelerations_have_a_bound_too():
    """M a = f of a chain of links, by 200 bits against 400; and coarsely, with radii."""
    e = derive(links(4), frozenset({"force", "mass"}))
    symbols = {
        e.graph.data[n]
        for n in reachable(e.graph, [*sum(e.mass, ()), *e.force])
        if not e.graph.args[n]
    }
    symbols = {s for s in symbols if isinstance(s, Symbol)}
    state = {s: Fraction(k + 3, 8) for k, s in enumerate(sorted(symbols))}

    def solved(balls, rad=0):
        values = {s: Ball(balls.number(x).mid, balls.mp.mpf(rad)) for s, x in state.items()}
        return accelerations(e, e.graph, balls, values)

    coarse, wide, fine = solved(Balls(100)), solved(Balls(100), 2**-20), solved(Balls(400))
    for s, exact in fine.items():
        for ball in (coarse[s], wide[s]):
            assert abs(exact.mid - FINE.mp.mpf(ball.mid)) <= FINE.mp.mpf(ball.rad)
        assert abs(exact.mid) > 1e-2 and coarse[s].rad < 1e-24 and 2**-20 < wide[s].rad < 1e-2
    assert len(fine) == 4 and solved(Balls(100), 1) is None  # M may be singular there
