"""What checks and the derivation refuse, each with its place."""

import re
import time

import pytest
from building import links, model

from pkgen import limits
from pkgen.middle.derive.derive import derive
from pkgen.source import ModelError

MASS_AND_FORCE = frozenset({"mass", "force"})
OK = dict(coords=("x",), kinetic="x'^2")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (dict(coords=("x", "y"), kinetic="x'^2", potential="y"), "'y' has no inertia"),
        (dict(coords=("x",), kinetic="x'", potential="x"), "'x' has no inertia"),
        (dict(coords=("x",), kinetic="(x' + x)^2 - x'^2"), "'x' has no inertia"),
        (
            dict(
                coords=("x", "y"),
                kinetic="x'^2 + y'^2*((1 + sin(x))^2 - 1 - 2*sin(x) - sin(x)^2)",
            ),
            "'y' has no inertia",
        ),
        # Only a sum of them has inertia; a product of rates has, though M is indefinite.
        (dict(coords=("x", "y"), kinetic="(x' + y')^2"), "'y' has no inertia of its own"),
        (
            dict(coords=("x", "y", "z"), kinetic="(x' + y' + z')^2"),
            "'y' has no inertia of its own",
        ),
        (
            dict(
                sizes={"N": 25},
                coords=("q[1..N]",),
                kinetic="sum(cos(q[i])*q[i]', i = 1..N)^2 + q[1]'^2",
            ),
            "'q[3]' has no inertia of its own",
        ),
        (OK | dict(potential="x/0"), "division by zero"),
        (OK | dict(potential="x/(1 - 1)"), "division by zero"),
        (OK | dict(potential="0^(-2)*x"), "division by zero"),
        (OK | dict(potential="x*sqrt(1 - 2)"), "sqrt has no real value here"),
        (OK | dict(potential="x*log(0)"), "log has no real value here"),
        (
            OK | dict(potential="x*(-8)^(1/3)"),
            "a negative number to a power that is no integer is not real",
        ),
        (OK | dict(potential="x^9999"), "an exponent beyond 1000"),
        # Constants that only unrolling, or a product, makes too large; the C would have an inf.
        (OK | dict(potential="sum(9^(9^i)*x, i = 1..3)"), "too large for a double at i = 3"),
        (OK | dict(potential="sum(exp(i*400)*x, i = 1..3)"), "too large for a double at i = 2"),
        (OK | dict(potential="1e200*1e200*x"), "this constant is too large for a double"),
        (OK | dict(potential="m*1e200*1e200*x", params={"m": 1}), "too large for a double"),
        (OK | dict(potential="x*(1e308 + 1e308)"), "this constant is too large for a double"),
        (OK | dict(potential="1e-200*1e-200*x"), "too small for a double"),
        (OK | dict(potential="sum(log(exp(i) - 5)*x, i = 1..2)"), "has no real value at i = 1"),
        (OK | dict(potential="(-2)^x"), "a negative number to a power that varies"),
        (OK | dict(potential="0^x"), "zero to a power that varies"),
        (OK | dict(potential="x''"), "x'' is an acceleration: expressions"),
        (OK | dict(potential="[x, 1, 2]"), "is a vector, potential needs a number"),
        (
            OK | dict(potential="dot([x, 1], [1, 2, 3])"),
            "a vector has three components, this has 2",
        ),
        (OK | dict(potential="x/[1, 2, 3]"), "division by the vector [1, 2, 3]"),
        (OK | dict(potential="nothing*x"), "unknown name 'nothing'"),
        (
            OK | dict(potential="sum(sum(x, j = 1..2000), i = 1..2000)"),
            "too large once its families and sums",
        ),
        (OK | dict(starts={"x": "x"}), "'x' is a coordinate: a start cannot use it"),
        (
            dict(coords=("q[1..3]",), kinetic="q[4]'^2"),
            "q[4] is outside the family: there is q[1..3]",
        ),
        (
            dict(sizes={"N": 9000}, coords=("q[1..N]",), kinetic="sum(q[i]'^2, i = 1..N)"),
            "9,000 coordinates",
        ),
    ],
)
def test_refused_with_its_place(given, message):
    with pytest.raises(ModelError) as caught:
        derive(model(**given))
    (found,) = caught.value.diagnostics
    assert message in found.message
    assert re.match(r"test\.lag:[2-9]:\d+: error: ", caught.value.text())


def test_constants_that_are_zero_or_large_stay():
    """Nothing is lost in cos(pi) + 1, nor in 1e300."""
    derive(model(coords=("x",), kinetic="x'^2", potential="(cos(pi) + 1)*x + 1e300*x^2"))


def test_every_coordinate_without_inertia_is_named():
    with pytest.raises(ModelError) as caught:
        derive(model(coords=("x", "y", "z"), kinetic="y'^2", potential="x*z"))
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
        derive(model(**(OK | dict(potential="x*((9^9)^99)^99"))), MASS_AND_FORCE)
    assert time.perf_counter() - start < 1
