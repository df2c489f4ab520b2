"""Expressions lose the coordinates and attitudes that they only seem to depend on, and keep their
values."""

import math
import random
import re

import pytest

from conftest import case, seeds
from pkgen.equations import Attitude
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Graph, Kind, Node, Op, Symbol
from pkgen.graph.residues import Residues
from pkgen.middle.attitudes import rotated
from pkgen.middle.dependence import without_attitudes, without_coordinates

N = 4
SATELLITE = case("satellite_wheels")


class Drawn:
    def __init__(self, seed: int):
        self.g, self.draw = Graph(), random.Random(seed)
        self.q = [self.g.symbol(Symbol(Kind.COORDINATE, i)) for i in range(N)]
        self.v = [self.g.symbol(Symbol(Kind.RATE, i)) for i in range(N)]
        self.quaternion = tuple(self.g.symbol(Symbol(Kind.STATE, k)) for k in range(4))

    def one(self, which: Node) -> Node:
        """1, of a coordinate, as derivations come by it."""
        g = self.g
        cos, sin = g.call("cos", which), g.call("sin", which)
        return g.add(g.multiply(cos, cos), g.multiply(sin, sin))

    def tree(self, leaves: list[Node], depth: int) -> Node:
        g, draw = self.g, self.draw
        if not depth:
            return draw.choice(leaves)
        a, b = (self.tree(leaves, depth - 1) for _ in range(2))
        kind = draw.choice(["add", "multiply", "sin", "power", "hidden", "divided"])
        if kind == "sin":
            return g.call(draw.choice(["sin", "cos"]), a)
        if kind == "power":
            return g.power(g.add(g.number(3), g.power(a, 2)), draw.choice([-1, 2]))
        if kind == "hidden":
            return g.multiply(self.one(draw.choice(self.q)), a)
        if kind == "divided":  # which means nothing where the coordinate is 0
            by = draw.choice(self.q)
            return g.multiply(
                g.power(by, -1), g.add(g.multiply(by, a), g.multiply(by, g.call("cos", b)))
            )
        return getattr(g, kind)(a, b)


@pytest.mark.parametrize("seed", seeds(range(3), 37))
def test_values_are_kept_and_what_is_hidden_goes(seed: int) -> None:
    x = Drawn(seed)
    seen = x.draw.sample(range(N), 2)
    leaves = [*(x.q[i] for i in seen), *x.v]
    nodes = [x.tree(leaves, 4) for _ in range(6)]
    made = without_coordinates(x.g, nodes, N)
    for _ in range(5):
        at = {
            Symbol(k, i): x.draw.uniform(-2, 2)
            for k in (Kind.COORDINATE, Kind.RATE)
            for i in range(N)
        }
        before, after = evaluate(x.g, nodes, at), evaluate(x.g, made, at)
        assert before == pytest.approx(after, rel=1e-9, abs=1e-9)
    hidden = [
        (i, node) for i in set(range(N)) - {*seen} for node in made if i in indices(x.g, node)
    ]
    assert all(divides(x.g, node, x.q[i]) for i, node in hidden)


def divides(g: Graph, node: Node, by: Node) -> bool:
    if g.op[node] is Op.POWER and by in g.args[node]:
        return True
    return any(divides(g, a, by) for a in g.args[node])


def indices(g: Graph, node: Node) -> set[int]:
    found, stack, known = set(), [node], set()
    while stack:
        n = stack.pop()
        if n in known:
            continue
        known.add(n)
        stack += g.args[n]
        if isinstance(g.data[n], Symbol) and g.data[n].kind is Kind.COORDINATE:
            found.add(g.data[n].index)
    return found


@pytest.mark.parametrize("seed", seeds(range(3), 17))
def test_lengths_of_turned_vectors_have_no_attitude(seed: int) -> None:
    """|R a|^2 + v.(R b), of vectors a and b: the first is |a|^2, the second stays."""
    x = Drawn(seed)
    g, attitude = x.g, Attitude(0, 0)
    a = tuple(x.tree([*x.q, *x.v], 2) for _ in range(3))
    turned = rotated(g, x.quaternion, a)
    length = g.sum(g.power(c, 2) for c in turned)
    nodes = [length, turned[0], g.add(length, turned[1])]
    made = without_attitudes(g, nodes, (attitude,))
    plain = Residues(g)
    assert plain(made[0]) == plain(g.sum(g.power(c, 2) for c in a)) and made[1] == nodes[1]
    for _ in range(5):
        q = [x.draw.gauss(0, 1) for _ in range(4)]
        size = math.sqrt(sum(c * c for c in q))
        at = {Symbol(Kind.STATE, k): c / size for k, c in enumerate(q)}
        at |= {
            Symbol(k, i): x.draw.uniform(-2, 2)
            for k in (Kind.COORDINATE, Kind.RATE)
            for i in range(N)
        }
        before, after = evaluate(g, nodes, at), evaluate(g, made, at)
        assert before == pytest.approx(after, rel=1e-9)


def test_the_mass_of_a_satellite_is_a_sum(pkgen, tmp_path) -> None:
    path = tmp_path / "satellite.lag"
    path.write_text(SATELLITE)
    text = pkgen("explain", path).stdout
    assert "M[b_x, b_x] = M + m\n" in text and "M[b_y, b_x]" not in text.replace(" = 0", "")
    assert "f[s] = u\n" in text and not re.search(r"f\[omega.*sin|M\[.*(sin|cos)\(s\)", text)
