"""Sizes of terms: what doubles lose of an expression, and no more, against 60 digits by mpmath."""

import random
import sys

import mpmath
import pytest

from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import ONE, Graph, Kind, Symbol
from pkgen.graph.rounding import sizes

EPS = sys.float_info.epsilon
X = [Symbol(Kind.COORDINATE, i) for i in range(3)]
P = Symbol(Kind.PARAMETER, 0)


# Of a calculus g with +, *, powers and functions: the graph's, or mpmath's.
CASES = {
    "cancelling": lambda g, x, y, z, p: g.subtract(
        g.call("sin", g.add(x, p)), g.add(g.multiply(x, y), g.call("sin", p))
    ),
    "sphere": lambda g, x, y, z, p: g.subtract(
        g.add(g.power(x, 2), g.add(g.power(y, 2), g.power(z, 2))), g.power(p, 2)
    ),
    "nested": lambda g, x, y, z, p: g.power(
        g.subtract(g.call("cos", g.multiply(x, y)), g.call("exp", g.multiply(p, g.negate(z)))), 3
    ),
    "quotient": lambda g, x, y, z, p: g.multiply(
        g.subtract(x, y), g.power(g.add(p, g.power(z, 2)), -1)
    ),
    "root": lambda g, x, y, z, p: g.subtract(
        g.call("sqrt", g.add(g.power(x, 2), g.power(y, 2))), g.call("atan2", y, z)
    ),
}


class Digits:
    """The same, by mpmath."""

    add = staticmethod(lambda a, b: a + b)
    subtract = staticmethod(lambda a, b: a - b)
    multiply = staticmethod(lambda a, b: a * b)
    negate = staticmethod(lambda a: -a)
    power = staticmethod(lambda a, n: a**n)

    @staticmethod
    def call(name, *arguments):
        return getattr(mpmath, name)(*arguments)


@pytest.mark.parametrize("case", CASES)
def test_an_expression_is_as_near_as_its_size_says(case):
    """Its arguments half a unit in the last place from what they should be."""
    g, draw = Graph(), random.Random(case)
    symbols = [g.symbol(s) for s in (*X, P)]
    node = CASES[case](g, *symbols)
    (size,) = sizes(g, [node])
    worst = 0.0
    with mpmath.workdps(60):
        for _ in range(300):
            at = [draw.uniform(-3, 3) * 10 ** draw.choice([-8, 0, 0, 1]) for _ in X] + [1.25]
            value, most = evaluate(g, [node, size], dict(zip((*X, P), at, strict=True)))
            moved = [mpmath.mpf(x) * (1 + draw.choice([-1, 1]) * mpmath.mpf(EPS) / 2) for x in at]
            moved[3] = mpmath.mpf(at[3])
            off = abs(CASES[case](Digits, *moved) - mpmath.mpf(value))
            worst = max(worst, float(off / (mpmath.mpf(most) * mpmath.mpf(EPS))))
    assert 0.1 < worst < 2.5, worst


def test_what_no_motion_changes_is_exact():
    """The size of p - 1 beside x is |p - 1|, not |p| + 1; and x^p is of any x."""
    g = Graph()
    x, p = g.symbol(X[0]), g.symbol(P)
    found = sizes(g, [g.subtract(x, g.subtract(p, ONE)), g.call("pow", x, p)])
    assert evaluate(g, found, {X[0]: -2.0, P: 1.5})[0] == 2.5
    assert evaluate(g, found, {X[0]: -2.0, P: 2.0})[1] == 12.0  # |p x^(p-1)| |x| + |x^p|
    assert evaluate(g, found, {X[0]: 0.0, P: 2.0})[1] == 0.0
