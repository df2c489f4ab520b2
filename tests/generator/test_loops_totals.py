"""Sums inside expressions and rates of states: every kernel against the unrolled code."""

import ctypes
import math
import random

import pytest
from loop_harness import Looped, Written, looped
from test_loops import assert_kernels, assert_start
from total_models import RATES, TOTALS

from pkgen.back.c.families.lower import lower_families
from pkgen.middle.families.indexed_ir import NotKept as CannotLoop
from pkgen.source import ModelError

CASES = TOTALS | RATES


@pytest.mark.parametrize("name", CASES)
def test_totals_equal_the_unrolled_code(name, tmp_path):
    text, sizes = CASES[name]
    loops = Looped(text, tmp_path / "loops")
    for size in sizes:
        written, at, dice = Written(text, size, tmp_path / f"n{size}"), loops.at(size), None
        dice = random.Random(size)
        assert at.n == len(written.program.equations.coordinates)
        at.restless = True
        assert_start(written, at)
        for _ in range(4):
            q, v = ([dice.uniform(-1, 1) for _ in range(at.n)] for _ in range(2))
            u = [dice.uniform(-1, 1) for _ in written.program.equations.inputs]
            assert_kernels(written, at, (dice.uniform(0, 3), q, v, u), f"{name} N = {size}")


FLAT = "model m\nsize N = 20\nparam m[i = 1..N] = i in (0, inf)\ncoord q[1..N], X\n"
FLAT += "kinetic sum(q[i]'^2/2, i = 1..N) + X'^2\n"
U = "state u[1..N]\nrate u[i = 1..N] = -u[i]\n"
PAIRS = "sum(cos(q[i] - q[j]), i = 1..N-1, j = i+1..N)"


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("potential log(sum(q[i], i = 1..N))", ["sum(q[k], k = 1..N)"]),
        ("potential 1/sum(q[i]^2 + X, i = 2..N)", ["sum(X + q[k]^2, k = 2..N)"]),
        ("potential sqrt(X - sum(m[i], i = 1..N))", ["X - sum(m[k], k = 1..N)"]),
        ("potential 1/(X + sum(1/q[i], i = 1..N))", ["X + sum(1/q[k], k = 1..N)", "q[i]"]),
        ("potential sum(1/(q[i] - q[1]), i = 2..N)", ["q[i] - q[1]"]),
        (f"force X = X/{PAIRS}", ["sum(cos(q[k] - q[l]), k = 1..N-1, l = k+1..N)"]),
        ("input p\nforce X = 1/sum(p*m[i], i = 1..N)", ["sum(p*m[k], k = 1..N)"]),
        (f"{U}force X = X/u[2]'", ["u[2]'"]),
        # What cannot vanish, or rests.
        ("potential log(1 + sum(q[i]^2, i = 1..N)) + sqrt(2 + sum(m[i]*q[i]^2, i = 1..N))", []),
        ("potential sum(q[i]^2, i = 1..N)/sum(m[i]^3, i = 1..N)", []),
    ],
)
def test_where_totals_vanish(statement, expected):
    found = [singularity.name for singularity in looped(FLAT + statement + "\n").singularities]
    assert found == expected


def test_a_total_that_vanishes_is_computed_where_it_is_watched(tmp_path):
    text = FLAT + "potential log(sum(m[i]*q[i], i = 1..N)) + 1/sum(cos(q[i] - X), i = 2..N)\n"
    at = Looped(text, tmp_path).at(4)
    count = at.of.function("singularity_count", ctypes.c_size_t)(ctypes.byref(at.params))
    for shift in (0.0, 0.3):  # not as it was before
        q = [0.1 + shift, 0.2, -0.3, 0.5 * shift, 0.7]
        _, (found,) = at.call("singularity", 0, q, [0.0] * 5, (), (count,))
        here = sum((i + 1) * x for i, x in enumerate(q[:4]))
        near = sum(math.cos(x - q[4]) for x in q[1:4])
        assert sorted(found) == pytest.approx(sorted([here, near]), rel=1e-14)


def test_pivots_know_the_totals_of_their_own_state(tmp_path):
    at = Looped(TOTALS["hung"][0], tmp_path, ("-O0",)).at(4)
    count = at.of.function("singularity_count", ctypes.c_size_t)(ctypes.byref(at.params))
    q, v = ([math.cos(k * i) for i in range(at.n)] for k in (2, 3))
    found = []
    for restless in (False, True):
        at.call("acceleration", 0.3, q, v, (), (at.n,), ctypes.c_int)
        at.restless = restless
        found.append(at.call("singularity", 0.3, q, v, (), (count,))[1])
    assert found[0] == found[1] and any(x not in (0, 1) for x in found[0])


@pytest.mark.parametrize(
    ("statement", "true", "false"),
    [
        ("potential cos(sum(q[i], i = 1..N))", "conservative separable smooth", "affine"),
        ("potential sum(q[i], i = 1..N)^2*t", "separable", "conservative autonomous"),
        ("potential cos(sum(q[i]*sin(t), i = 1..N))", "separable", "conservative autonomous"),
        ("potential X*cos(sum(m[i]*sin(t), i = 1..N))", "separable", "conservative autonomous"),
        ("force X = sum(abs(q[i])^3, i = 1..N)^2", "separable", "smooth"),
        ("potential sum(abs(q[i])^3, i = 1..N)^2", "conservative", "smooth"),
        ("kinetic X'^2*cos(sum(q[i], i = 1..N))", "conservative", "separable mass_constant"),
        ("kinetic X'^2*sum(m[i], i = 1..N)^2", "conservative separable mass_constant", ""),
        (f"{U}potential sum(u[i], i = 1..N)^2*X", "", "conservative separable affine"),
        ("force X = -sum(q[i]', i = 1..N)^2", "autonomous", "conservative separable linear_drag"),
        ("dissipation sum(q[i]', i = 1..N)^2", "autonomous", "conservative separable variational"),
        ("force X = sum(q[i], i = 1..N)^3", "separable", "conservative variational"),
        (f"{U}force X = u[1]'", "autonomous", "separable conservative affine"),
        ("potential sum(cos(q[i] - q[1]), i = 1..N)", "conservative separable", "affine"),
    ],
)
def test_facts_of_totals(statement, true, false):
    facts = looped(FLAT + statement + "\n").facts
    assert all(getattr(facts, name) for name in true.split()), facts
    assert not any(getattr(facts, name) for name in false.split()), facts


def test_no_fused_steps_where_members_feel_a_total():
    for potential, fused in (("sum(q[i]^2, i = 1..N)", True), ("sum(q[i], i = 1..N)^2", False)):
        e = looped(FLAT.replace(", X", "").replace(" + X'^2", "") + f"potential {potential}\n")
        assert e.facts.separable
        assert lower_families(e).context["stepper"] == fused


def test_sums_that_are_the_same_for_all_members_count_once():
    """Not for each, up to the limit of terms; and so are they computed."""
    start = "start q[i = 1..N] = sin(i) - sum({}, j = 1..N)/N\n"
    text = FLAT.replace("N = 20", "N = 1000000").replace("m[i = 1..N] = i", "m[i = 1..3] = i")
    [made] = looped(text + start.format("sin(j)")).starts
    assert len(made.before) == 1 and not made.each
    [made] = looped(text.replace("1000000", "1000") + start.format("sin(i*j)")).starts
    assert len(made.each) == 1 and not made.before
    with pytest.raises(ModelError) as raised:
        looped(text + start.format("sin(i*j)"))
    assert "terms in nested sums" in raised.value.diagnostics[0].message


@pytest.mark.parametrize(
    ("statement", "reason"),
    [
        ("kinetic sum(q[i]', i = 1..N)^2", "M would be dense"),
        ("kinetic sum((q[i]' - q[1]')^2, i = 1..N)", "M would be dense"),
        ("potential cos(sum(cos(sum(q[j] - q[i], j = 1..N)), i = 1..N))", "depends on the index"),
        ("constraint c: X = cos(sum(q[i], i = 1..N))", "inside a function"),
        ("state w, z\nrate w = z'\nrate z = X + w'", "in a circle"),
    ],
)
def test_what_totals_cannot_be(statement, reason):
    with pytest.raises(CannotLoop) as raised:
        looped(FLAT + statement + "\n")
    assert reason in str(raised.value)
