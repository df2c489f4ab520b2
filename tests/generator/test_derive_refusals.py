"""What the derivation refuses, each with its place."""

from __future__ import annotations

import time

import pytest
from building import HERE, links, model

from pkgen import limits
from pkgen.middle.derive.derive import derive
from pkgen.source import ModelError

MASS_AND_FORCE = frozenset({"mass", "force"})
OK = dict(coords=("x",), kinetic="D(x)**2")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (dict(coords=("x", "y"), kinetic="D(x)**2", potential="y"), "'y' has no inertia"),
        (dict(coords=("x",), kinetic="D(x)", potential="x"), "'x' has no inertia"),
        (dict(coords=("x",), kinetic="(D(x) + x)**2 - D(x)**2"), "'x' has no inertia"),
        (
            dict(
                coords=("x", "y"),
                kinetic="D(x)**2 + D(y)**2*((1 + sin(x))**2 - 1 - 2*sin(x) - sin(x)**2)",
            ),
            "'y' has no inertia",
        ),
        # Only a sum of them has inertia; a product of rates has, though M is indefinite.
        (dict(coords=("x", "y"), kinetic="(D(x) + D(y))**2"), "'y' has no inertia of its own"),
        (
            dict(coords=("x", "y", "z"), kinetic="(D(x) + D(y) + D(z))**2"),
            "'y' has no inertia of its own",
        ),
        (
            dict(
                sizes={"N": 25},
                coords=("q[1..N]",),
                kinetic="S('i', 1, N, cos(q[i])*D(q[i]))**2 + D(q[1])**2",
            ),
            "'q[3]' has no inertia of its own",
        ),
        (OK | dict(potential="x/0"), "division by zero"),
        (OK | dict(potential="x/(1 - 1)"), "division by zero"),
        (OK | dict(potential="0**(-2)*x"), "division by zero"),
        (OK | dict(potential="x*sqrt(1 - 2)"), "the square root of a negative number"),
        (OK | dict(potential="x*log(0)"), "the logarithm of a number that is not positive"),
        (OK | dict(potential="x*(-8)**(1/3)"), "a negative number has no real power"),
        (OK | dict(potential="x**9999"), "an exponent beyond 1,000"),
        # Constants that only unrolling, or a product, makes too large; the C would have an inf.
        (OK | dict(potential="S('i', 1, 3, 9**(9**i)*x)"), "too large for a double at i = 3"),
        (OK | dict(potential="S('i', 1, 3, exp(i*400)*x)"), "too large for a double at i = 2"),
        (OK | dict(potential="1e200*1e200*x"), "this constant is too large for a double"),
        (OK | dict(potential="m*1e200*1e200*x", params={"m": 1}), "too large for a double"),
        (OK | dict(potential="x*(1e308 + 1e308)"), "this constant is too large for a double"),
        (OK | dict(potential="1e-200*1e-200*x"), "too small for a double"),
        (OK | dict(potential="S('i', 1, 2, log(exp(i) - 5)*x)"), "has no real value at i = 1"),
        (OK | dict(potential="(-2)**x"), "a negative number to a power that varies"),
        (OK | dict(potential="0**x"), "zero to a power that varies"),
        (OK | dict(potential="D(D(x))"), "an acceleration cannot be used here"),
        (OK | dict(potential="[x, 1, 2]"), "a vector where a single value is needed"),
        (OK | dict(potential="dot([x, 1], [1, 2, 3])"), "dot takes vectors"),
        (OK | dict(potential="x/[1, 2, 3]"), "vectors are multiplied by dot or cross"),
        (OK | dict(potential="nothing*x"), "unknown name 'nothing'"),
        (
            OK | dict(potential="S('i', 1, 2000, S('j', 1, 2000, x))"),
            "too large once its families and sums",
        ),
        (OK | dict(starts={"x": "x"}), "an initial value may use parameters and numbers only"),
        (dict(coords=("q[1..3]",), kinetic="D(q[4])**2"), "'q[4]' is outside 1..3"),
        (
            dict(sizes={"N": 9000}, coords=("q[1..N]",), kinetic="S('i', 1, N, D(q[i])**2)"),
            "9,000 coordinates",
        ),
    ],
)
def test_refused_with_its_place(given, message):
    with pytest.raises(ModelError) as caught:
        derive(model(**given))
    (found,) = caught.value.diagnostics
    assert message in found.message
    assert found.span == HERE
    assert caught.value.text().startswith("test.lag:1:1: error: ")


def test_constants_that_are_zero_or_large_stay():
    """Nothing is lost in cos(pi) + 1, nor in 1e300."""
    derive(model(coords=("x",), kinetic="D(x)**2", potential="(cos(pi) + 1)*x + 1e300*x**2"))


def test_every_coordinate_without_inertia_is_named():
    with pytest.raises(ModelError) as caught:
        derive(model(coords=("x", "y", "z"), kinetic="D(y)**2", potential="x*z"))
    assert len(caught.value.diagnostics) == 2


def test_the_limit_on_nodes(monkeypatch):
    monkeypatch.setattr(limits, "UNROLLED", 500)
    with pytest.raises(ModelError) as caught:
        derive(links(10))
    assert "too large once" in caught.value.diagnostics[0].message


def test_a_huge_tower_ends_at_once():
    """((9^9)^99)^99 is never computed."""
    start = time.perf_counter()
    with pytest.raises(ModelError):
        derive(model(**(OK | dict(potential="x*((9**9)**99)**99"))), MASS_AND_FORCE)
    assert time.perf_counter() - start < 1
