"""Switches of families kept as loops: which, over which members, with which sides; and what is
refused."""

import ctypes
import math
import random
from itertools import pairwise
from pathlib import Path

import pytest
from loop_harness import Looped, looped

from conftest import case
from pkgen.compiler import compile_model
from pkgen.source import Source

HEAD = case("loops_switches_m")


def over(switch) -> list[str]:
    return ["..".join(at.text() for at in r).replace(" ", "") for r in switch.ranges]


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ("force x[i = 1..N] = -c*sign(x[i]')\n", [("x[i]'", ["1..N"])]),
        # Nothing moves at a fixed end, and nothing apart at a free one: no switch is there.
        ("force y[i = 1..N] = sign(x[i-1]')\n", [("x[i]'", ["1..N-1"])]),
        ("force y[i = 1..N] = sign(x[i-1])\n", [("x[i]", ["1..N-1"])]),
        ("force y[i = 1..N] = step(x[i+1] - x[i])\n", [("x[i+1] - x[i]", ["1..N-1"])]),
        ("force x[i = 1..N] = step(y[i-1] - c)\n", [("y[i] - c", ["0..N-1"])]),
        # One for an argument, from whichever member it is seen, whatever is in front of it.
        (
            "force x[i = 1..N-1] = sign(x[i+1] - x[i])\n"
            "force y[i = 2..N] = step(2*x[i-1] - 2*x[i])\n",
            [("x[i] - x[i+1]", ["1..N-1"])],
        ),
        # Of what bends with it too, but not of what bends alone.
        ("force x[i = 1..N] = abs(x[i]')*sign(x[i])\n", [("x[i]", ["1..N"])]),
        ("force x[i = 1..N] = -x[i]'*abs(x[i]')\n", []),
        # Of a member, of a scalar coordinate, of a state, of t alone or with the index.
        ("force x[3] = -sign(x[3]')\n", [("x[i]'", ["3..3"])]),
        ("force X = -sign(X')\n", [("X'", [""])]),
        ("force X = step(u[2])\n", [("u[i]", ["2..2"])]),
        ("force x[i = 1..N] = step(t - w[i])\n", [("t - w[i]", ["1..N"])]),
        ("force x[i = 1..N] = step(t - 3)*w[i]\n", [("t - 3", [""])]),
        # Parameters and the index alone: a constant.
        ("force x[i = 1..N] = step(w[i] - 1)\n", []),
        # Within totals.
        ("force X = -cos(sum(step(x[i] - X), i = 1..N))\n", [("x[i] - X", ["1..N"])]),
    ],
)
def test_which(more: str, expected: list) -> None:
    e = looped(HEAD + more)
    assert [(x.name, over(x)) for x in e.switches] == expected
    assert e.facts.switched == (bool(expected) and "abs" not in more)


@pytest.mark.parametrize(
    ("more", "why"),
    [
        ("potential sum(step(x[i]), i = 1..N)\n", "L jumps at a step"),
        (
            "force x[i = 1..N] = sum(sign(x[j] - x[i]), j = 1..N)\n",
            "a force or a rate jumps in a sum over pairs",
        ),
    ],
)
def test_refused(more: str, why: str) -> None:
    compiled = compile_model(Source("m.lag", HEAD + more))
    assert compiled.equations.dense and why in str(compiled.equations.unrolled)


FRICTION = HEAD.replace("N = 20", "N = 5") + (
    "force y[i = 1..N] = -c*sign(y[i]' - y[i-1]') + abs(y[i]' - y[i-1]')/9\n"
    "force X = step(x[2] - X)\n"
)


def test_values_and_sides(tmp_path: Path) -> None:
    """A kernel has the side that it is given, whatever the argument; 0 leaves it as it is."""
    loops = Looped(FRICTION, tmp_path)
    for size in (5, 9):
        at = loops.at(size)
        count = loops.function("switch_count", ctypes.c_size_t)(ctypes.byref(at.params))
        assert count == size + 1
        dice = random.Random(size)
        q, v = ([dice.uniform(-1, 1) for _ in range(at.n)] for _ in range(2))
        y, t = v[size : 2 * size], 0.7
        slips = [b - a for a, b in pairwise([math.cos(t), *y])]
        _, [values] = at.call("switching", t, q, v, [], (count,))
        sign = 1 if values[0] * slips[0] > 0 else -1
        assert values[:size] == pytest.approx([sign * x for x in slips], abs=1e-15)
        assert abs(values[size]) == pytest.approx(abs(q[1] - q[2 * size]), abs=1e-15)
        _, [plain] = at.call("force", t, q, v, [], (at.n,))
        for side in (1, -1, 0):
            for k in range(count):
                at.params.side_[k] = side
            _, [force] = at.call("force", t, q, v, [], (at.n,))
            for i, slip in enumerate(slips):
                own = sign * side if side else math.copysign(1, slip)
                expected = -2 * own + own * slip / 9
                assert force[size + i] == pytest.approx(expected, abs=1e-14)
            above = (
                side * math.copysign(1, values[size] * (q[1] - q[2 * size])) or q[1] - q[2 * size]
            )
            assert force[2 * size] == (above > 0)
        assert force == plain


def test_a_place_at_rest_beyond_a_free_end(tmp_path: Path) -> None:
    """sign(0) is 0 there, not a side's."""
    text = HEAD + "force y[i = 1..N] = sign(x[i+1]' - x[i]')\n"
    at = Looped(text, tmp_path).at(4)
    for k in range(3):
        at.params.side_[k] = 1
    _, [force] = at.call("force", 0.0, [0.0] * at.n, [0.0] * at.n, [], (at.n,))
    assert force[4:8] == [1, 1, 1, 0] or force[4:8] == [-1, -1, -1, 0]
