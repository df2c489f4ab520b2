"""Proofs that something varies: never of what an identity makes constant."""

import pytest
from building import model

from pkgen.graph.collect import settled
from pkgen.graph.graph import BIT, VARIABLE, Graph, Kind
from pkgen.graph.normal import Normal
from pkgen.graph.residues import PRIME, Residues, Varying
from pkgen.middle.expand.expand import Expander

RATES, COORDINATES = BIT[Kind.RATE], BIT[Kind.COORDINATE]


def node(text: str) -> tuple[Graph, int]:
    """An expression of x, y, x', y', a as it is built, without like terms found beforehand."""
    x = Expander(
        model(params={"a": 2.385}, coords=("x", "y"), kinetic="x'^2 + y'^2", potential=text),
        (),
    )
    return x.graph, x.scalar(x.model.potential[0])


VARIES = [
    ("x + a", COORDINATES),
    ("sin(x)^2 + 2*cos(x)^2", COORDINATES),
    ("exp(x)*y'", COORDINATES | RATES),
    ("a*x'/y", RATES),
    ("1/(x + y)", COORDINATES),
    ("atan2(x, y) + tan(x)", COORDINATES),
]
CONSTANT = [
    # (a + x)^2 - x^2 - 2 a x
    ("(a + x)^2 - x*(x + 2*a)", COORDINATES),
    ("(sin(x + y)^2 + a)*(1 + y) + cos(y + x)^2*(1 + y) - y - y*a", COORDINATES),
    ("sin(x - y) + sin(y - x) + a", COORDINATES),
    ("cos(2*x - y)*x' - x'*cos(y - 2*x)", VARIABLE),
    ("(x + 1)/(x + 1)^2*(1 + x)", COORDINATES),
    ("x*x' - x'*x + a", RATES),
    ("exp(x*(y + 1)) - exp(x*y + x)", COORDINATES),
    ("tanh(x*(y - 1)) + tanh(x - x*y)", COORDINATES),
]


@pytest.mark.parametrize(("text", "mask"), VARIES)
def test_varies(text, mask):
    g, found = node(text)
    assert Varying(g)(found, mask)


@pytest.mark.parametrize(("text", "mask"), CONSTANT)
def test_no_proof_that_a_constant_varies(text, mask):
    g, found = node(text)
    assert not Varying(g)(found, mask)
    polynomial = Normal(g)(found)
    assert not any(g.depends[base] & mask for monomial in polynomial for base, _ in monomial)


def test_only_what_moves_tells_worlds_apart():
    g, found = node("sin(x)*y'")
    varying = Varying(g)
    assert varying(found, COORDINATES) and varying(found, RATES)
    assert not varying(found, BIT[Kind.TIME])
    g, found = node("sin(x) + a")
    assert not Varying(g)(found, RATES)


def test_what_is_beyond_a_prime_is_no_proof():
    g, found = node("sqrt(x)*x' + a")
    assert not Varying(g)(found, VARIABLE) and not Varying(g).is_nonzero(found)


def test_the_circle_and_the_inverse():
    g, found = node("sin(x)^2")
    residue = Residues(g)
    x = g.args[g.args[found][0]][0]
    assert (residue(found) + residue(g.power(g.call("cos", x), 2))) % PRIME == 1
    assert residue(found) not in (0, 1)
    assert residue(x) * residue(g.power(x, -1)) % PRIME == 1
    assert residue(x) * residue(g.call("reciprocal", x)) % PRIME == 1


def test_settled_is_what_the_normal_form_says():
    g, found = node("(a + x)^2 - x*(x + 2*a)")
    (constant,) = settled(g, [found])
    assert g.depends[found] & VARIABLE
    assert not g.depends[constant] & VARIABLE and g.depends[constant]
