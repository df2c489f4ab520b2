"""Derivatives: every rule against differences, both directions against each other."""

import math
import random
from itertools import pairwise

import pytest

from pkgen.functions import FUNCTIONS
from pkgen.graph.differentiate import Columns, Forward, gradient
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import BIT, ONE, ZERO, Graph, Kind, Symbol

COORDINATE = BIT[Kind.COORDINATE]


def variables(g: Graph, count: int) -> list[int]:
    return [g.symbol(Symbol(Kind.COORDINATE, i)) for i in range(count)]


@pytest.mark.parametrize("name", list(FUNCTIONS))
def test_rule_against_differences(name):
    g = Graph()
    x = variables(g, FUNCTIONS[name].arity)
    node = g.call(name, *x)
    found = gradient(g, node, COORDINATE)
    at = [0.4385, 0.7215, 0.3155]
    h = 1e-5
    for i, symbol in enumerate(x):
        values = {Symbol(Kind.COORDINATE, k): at[k] for k in range(len(x))}
        side = []
        for sign in (1, -1):
            moved = values | {Symbol(Kind.COORDINATE, i): at[i] + sign * h}
            side += evaluate(g, [node], moved)
        numeric = (side[0] - side[1]) / (2 * h)
        (exact,) = evaluate(g, [found.get(symbol, ZERO)], values)
        if FUNCTIONS[name].arguments[i] == FUNCTIONS[name].still:
            assert exact == 0 and abs(numeric) > 1e-3  # models may not let it move
            continue
        assert math.isclose(exact, numeric, rel_tol=1e-8, abs_tol=1e-8), (name, i)
        smooth = FUNCTIONS[name].smooth and (name != "select" or i == 1)
        assert not smooth or abs(exact) > 1e-3


@pytest.mark.parametrize("name", ["sqrt", "abs", "norm"])
def test_derivative_zero_at_zero(name):
    g = Graph()
    x, y = variables(g, 2)
    node = {
        "sqrt": g.call("sqrt", x),
        "abs": g.call("abs", x),
        "norm": g.call("sqrt", g.add(g.power(x, 2), g.power(y, 2))),
    }[name]
    d = gradient(g, node, COORDINATE)[x]
    at = {Symbol(Kind.COORDINATE, 0): 0.0, Symbol(Kind.COORDINATE, 1): 0.0}
    assert evaluate(g, [d], at) == [0.0]
    # Not because it is zero everywhere.
    assert evaluate(g, [d], at | {Symbol(Kind.COORDINATE, 0): 0.5})[0] > 0.1


def random_node(g: Graph, x: list[int], draw: random.Random) -> int:
    pool = list(x)
    for _ in range(30):
        a, b = draw.choice(pool), draw.choice(pool)
        made = [
            g.add(a, b),
            g.multiply(a, b),
            g.call("sin", a),
            g.call("exp", g.call("cos", b)),
            g.power(g.add(g.power(a, 2), ONE), -1),
        ]
        pool.append(draw.choice(made))
    return pool[-1]


def test_forward_columns_and_reverse_agree():
    draw = random.Random(7301)
    nonzero = 0
    for _ in range(30):
        g = Graph()
        x = variables(g, 4)
        node = random_node(g, x, draw)
        back = gradient(g, node, COORDINATE)
        columns = Columns(g, [node], COORDINATE)
        seeds = [draw.uniform(-1, 1) for _ in x]
        values = {Symbol(Kind.COORDINATE, i): draw.uniform(-0.9, 0.9) for i in range(4)}
        rates = {s: g.symbol(Symbol(Kind.RATE, i)) for i, s in enumerate(x)}
        along = Forward(g, COORDINATE, rates.__getitem__)(node)
        values |= {Symbol(Kind.RATE, i): s for i, s in enumerate(seeds)}
        reverse = evaluate(g, [back.get(s, ZERO) for s in x], values)
        forward = evaluate(g, [columns.column(s).get(node, ZERO) for s in x], values)
        (product,) = evaluate(g, [along], values)
        for a, b in zip(reverse, forward, strict=True):
            assert math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-9)
            nonzero += abs(a) > 1e-3
        dot = sum(a * s for a, s in zip(reverse, seeds, strict=True))
        assert math.isclose(product, dot, rel_tol=1e-9, abs_tol=1e-9)
    assert nonzero > 40


def test_columns_visit_only_what_is_influenced():
    g = Graph()
    x = variables(g, 50)
    chain = [g.call("sin", g.multiply(a, b)) for a, b in pairwise(x)]
    columns = Columns(g, chain, COORDINATE)
    assert len(columns.column(x[20])) == 5


def test_a_reverse_sweep_costs_a_multiple_of_the_expression():
    g = Graph()
    x = variables(g, 200)
    node = ONE
    for symbol in x:
        node = g.add(g.call("sin", g.multiply(node, symbol)), ONE)
    before = len(g)
    gradient(g, node, COORDINATE)
    assert len(g) < 5 * before
