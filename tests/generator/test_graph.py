"""The expression graph: what its constructors simplify, and what they must leave alone."""

from fractions import Fraction as F
from itertools import pairwise

import pytest

from pkgen.graph.count import operations
from pkgen.graph.graph import BIT, MINUS_ONE, ONE, ZERO, Graph, Kind, Op, Symbol, TooLarge
from pkgen.middle.analyze.sympy_bridge import to_sympy


class World:
    def __init__(self) -> None:
        self.g = Graph()
        symbol = lambda kind, i: self.g.symbol(Symbol(kind, i))  # noqa: E731
        self.a, self.b, self.c = (symbol(Kind.PARAMETER, i) for i in range(3))
        self.x, self.y, self.z = (symbol(Kind.COORDINATE, i) for i in range(3))
        self.v, self.w = (symbol(Kind.RATE, i) for i in range(2))

    def n(self, value: object) -> int:
        return self.g.number(F(value))


@pytest.fixture
def world() -> World:
    return World()


def test_nodes_are_shared_and_sorted_topologically(world):
    g = world.g
    assert g.add(world.x, world.y) == g.add(world.y, world.x)
    assert g.multiply(world.x, world.y) == g.multiply(world.y, world.x)
    g.call("sin", g.multiply(world.a, g.add(world.x, g.power(world.y, 3))))
    assert all(a < node for node in range(len(g)) for a in g.args[node])


def test_numbers_fold_exactly_and_only_while_small(world):
    g, n = world.g, world.n
    assert g.add(n("1/3"), n("1/6")) == n("1/2")
    assert g.multiply(n("2/3"), n("3/2")) == ONE
    assert g.power(n("2/3"), -3) == n("27/8")
    huge = g.power(n(10), 100)
    assert g.op[huge] is Op.NUMBER
    assert g.op[g.multiply(huge, huge)] is not Op.NUMBER
    assert g.op[g.power(n(9), 10**9)] is Op.POWER


def test_neutral_elements(world):
    g, x = world.g, world.x
    assert g.add(x, ZERO) == g.multiply(x, ONE) == g.power(x, 1) == x
    assert g.multiply(x, ZERO) == g.subtract(x, x) == ZERO
    assert g.power(x, 0) == g.divide(x, x) == ONE
    assert g.negate(g.negate(x)) == x
    assert g.args[g.negate(x)] == (MINUS_ONE, x)


def test_parameter_coefficients_add_up(world):
    g, a, b, x = world.g, world.a, world.b, world.x
    left = g.add(g.multiply(a, x), g.multiply(b, x))
    assert left == g.multiply(g.add(a, b), x)
    assert operations(g, [left]) == 1
    # Inside a sum too, and with the product built in another order.
    sum_ = g.add(g.multiply(a, g.multiply(x, world.y)), g.multiply(b, world.y))
    again = g.add(sum_, g.multiply(g.multiply(world.y, b), x))
    expected = g.add(g.multiply(g.add(a, b), g.multiply(x, world.y)), g.multiply(b, world.y))
    assert again == expected
    # But not what varies: x*y + x*z stays as it is written.
    assert g.op[g.add(g.multiply(x, world.y), g.multiply(x, world.z))] is Op.ADD


def test_like_terms_cancel_through_a_common_scale(world):
    g, a, x, y = world.g, world.a, world.x, world.y
    scaled = g.multiply(a, g.add(x, y))
    assert g.subtract(scaled, g.multiply(a, y)) == g.multiply(a, x)


def test_repeated_terms_are_not_lost(world):
    """(x + y) + (x + z), whose terms repeat, minus x + y must be x + z."""
    g, x, y, z = world.g, world.x, world.y, world.z
    double = g.add(g.add(x, y), g.add(x, z))
    (left, right) = to_sympy(g, [g.subtract(double, g.add(x, y)), g.add(x, z)], _sympy_symbol)
    assert (left - right).expand() == 0


def _sympy_symbol(symbol: Symbol):
    import sympy

    return sympy.Symbol(f"{symbol.kind}_{symbol.index}")


def test_powers_merge(world):
    g, x, y = world.g, world.x, world.y
    assert g.multiply(g.power(x, 2), g.power(x, -5)) == g.power(x, -3)
    assert g.power(g.power(x, 2), 3) == g.power(x, 6)
    assert g.power(g.multiply(x, y), 2) != g.multiply(x, y)
    assert g.divide(g.power(g.multiply(x, y), 2), g.multiply(x, y)) == g.multiply(x, y)
    assert g.power(g.divide(x, y), -1) == g.divide(y, x)


def test_roots(world):
    g, n, x, a = world.g, world.n, world.x, world.a
    root = g.call("sqrt", x)
    assert g.power(x, F(1, 2)) == root
    assert g.multiply(root, root) == g.power(root, 2) == x
    assert g.multiply(root, g.power(x, -2)) == g.power(x, F(-3, 2))
    assert g.call("sqrt", n("9/4")) == n("3/2")
    assert g.power(n("9/4"), F(-3, 2)) == n("8/27")
    assert g.call("sqrt", g.multiply(n(8), a)) == g.multiply(
        n(2), g.call("sqrt", g.multiply(n(2), a))
    )
    # |x| is not x.
    assert g.call("sqrt", g.power(x, 2)) != x
    assert g.power(g.power(x, 2), F(1, 2)) != x


def test_reciprocal_keeps_its_zero(world):
    g, x = world.g, world.x
    r = g.call("reciprocal", x)
    assert g.multiply(x, r) != ONE  # it is 0 at 0
    assert g.multiply(g.power(x, 2), r) == x
    assert g.multiply(g.power(x, -1), r) == g.power(x, -2)


@pytest.mark.parametrize("scaled", [False, True])
@pytest.mark.parametrize("extra", [False, True])
def test_pythagoras_through_products(world, scaled, extra):
    """l cos (m l cos) + l sin (m l sin) = m l^2, also with another factor in each."""
    g, x, length, m = world.g, world.x, world.a, world.b
    c, s = g.call("cos", x), g.call("sin", x)
    if scaled:
        left, right = g.multiply(length, c), g.multiply(length, s)
        terms = [g.multiply(t, g.multiply(m, t)) for t in (left, right)]
        expected = g.multiply(m, g.power(length, 2))
    else:
        terms = [g.power(c, 2), g.power(s, 2)]
        expected = ONE
    if extra:
        terms = [g.multiply(world.v, g.multiply(t, world.y)) for t in terms]
        expected = g.multiply(expected, g.multiply(world.v, world.y))
    assert g.add(*terms) == g.add(*reversed(terms)) == expected
    assert g.add(terms[0], g.multiply(g.number(2), terms[1])) != expected


def test_one_minus_a_square(world):
    g, x = world.g, world.x
    c2, s2 = g.power(g.call("cos", x), 2), g.power(g.call("sin", x), 2)
    assert g.subtract(ONE, s2) == c2
    assert g.subtract(c2, ONE) == g.negate(s2)


@pytest.mark.parametrize("function", ["sin", "tan", "asin", "atan", "sinh", "tanh", "sign"])
def test_odd_functions(world, function):
    g, x, a = world.g, world.x, world.a
    assert g.call(function, g.negate(x)) == g.negate(g.call(function, x))
    forward, backward = g.subtract(x, a), g.subtract(a, x)
    assert g.call(function, backward) == g.negate(g.call(function, forward))


@pytest.mark.parametrize("function", ["cos", "cosh", "abs"])
def test_even_functions(world, function):
    g, x, y = world.g, world.x, world.y
    assert g.call(function, g.negate(x)) == g.call(function, x)
    assert g.call(function, g.subtract(x, y)) == g.call(function, g.subtract(y, x))
    assert g.call(function, g.add(x, y)) != g.call(function, g.subtract(x, y))


def test_what_a_node_depends_on(world):
    g = world.g
    node = g.multiply(world.a, g.call("sin", g.add(world.x, world.v)))
    assert g.depends[node] == BIT[Kind.PARAMETER] | BIT[Kind.COORDINATE] | BIT[Kind.RATE]
    assert g.is_constant(g.power(world.a, 2)) and not g.is_constant(node)


def test_a_deep_chain_needs_no_recursion():
    g = Graph()
    node = g.symbol(Symbol(Kind.COORDINATE))
    for i in range(50_000):
        node = g.call("sin", g.add(node, g.symbol(Symbol(Kind.COORDINATE, i % 7))))
    assert operations(g, [node]) == 100_000


def test_the_limit():
    g = Graph(limit=100)
    with pytest.raises(TooLarge):
        for i in range(200):
            g.symbol(Symbol(Kind.COORDINATE, i))


def test_random_expressions_keep_their_value():
    """Every rule at once, against plain arithmetic without any."""
    import math
    import random

    from pkgen.graph.evaluate import evaluate

    draw = random.Random(2385)
    checked = 0
    for _ in range(300):
        w = World()
        g = w.g
        leaves = [w.a, w.b, w.x, w.y, w.v]
        values = {g.data[leaf]: draw.uniform(0.4, 1.9) for leaf in leaves}
        pool = [(leaf, values[g.data[leaf]]) for leaf in leaves]
        for node, value in list(pool):
            pool.append((g.call("sin", node), math.sin(value)))
            pool.append((g.call("cos", node), math.cos(value)))
        for _ in range(25):
            (m, i), (n, j) = draw.choice(pool), draw.choice(pool)
            number = F(draw.choice([-3, -2, -1, 1, 2, 3]), draw.choice([1, 2]))
            kind = draw.randrange(6)
            if kind == 0:
                pool.append((g.add(m, n), i + j))
            elif kind == 1:
                pool.append((g.subtract(m, n), i - j))
            elif kind in (2, 3):
                pool.append((g.multiply(m, n), i * j))
            elif kind == 4:
                pool.append((g.multiply(g.number(number), m), float(number) * i))
            elif abs(i) > 0.1 and abs(i) < 10:
                e = draw.choice([-2, -1, 2, 3])
                pool.append((g.power(m, e), i**e))
        ours = evaluate(g, [m for m, _ in pool], values)
        for a, (_, b) in zip(ours, pool, strict=True):
            if abs(b) < 1e6:
                assert math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-9)
                checked += 1
    assert checked > 8_000


def test_the_same_calls_give_the_same_numbers():
    def build() -> list[object]:
        w = World()
        node = w.x
        for leaf, other in pairwise([w.x, w.y, w.z, w.v, w.w, w.a]):
            node = w.g.add(w.g.multiply(node, leaf), w.g.call("sin", other))
        return list(zip(w.g.op, w.g.args, w.g.data, strict=True))

    assert build() == build()
