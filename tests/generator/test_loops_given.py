"""Sample blocks, and events that give values, in families: every kernel against the code of the
same model with its members written out."""

import random

import pytest
from loop_harness import Looped, Written
from test_loops import assert_close, assert_kernels, assert_start

from conftest import seeds


def model(r: random.Random) -> str:
    """A chain beside a coordinate X and a state w, with two inputs that a block sets."""
    ends = r.choice(["fixed q[0] = 0, q[N+1] = sin(t)", "free q", "periodic q"])
    delay = r.choice(["", " delay 2"])
    kind = r.choice(["plain", "momenta", "multipliers", "carried"])
    beside, own = {
        "plain": ("", "energy"),
        "momenta": ("observe P = p_q[2]*w", "w"),
        "multipliers": ("constraint tie: q[1] = 0.3*X*q[2] + 0.1", "lambda_tie"),
        "carried": (
            "let x[0] = 0\nlet x[i = 1..N] = x[i-1] + sin(q[i])\n"
            "kinetic sum(x[i]'^2/2, i = 1..N)\nobserve P = p_q[2]",
            "x[N]",
        ),
    }[kind]
    outside = r.choice(["sum(q[i]*q[i]', i = 1..N)", "X'", "w", own, own])
    given = [
        r.choice(
            [
                "q[1] = 0.3",
                "q[N] = q[N]/2 + X",
                "q[i = 2..N-1] = q[i+1] - 0.1*q[i-1]' + sum(q[j], j = 1..N)/i",
            ]
        ),
        r.choice(
            [
                "q[1]' = -0.8*q[1]'",
                "q[i = 2..N-1]' = 0.3*i + q[i-1]*q[i+1]",
                "q[i = 2..2]' = i + q[i+1]",
            ]
        ),
        "X' = w - sum(q[i], i = 1..N)",
        "w = 0",
        "c = 2*c + X",
    ]
    given = r.sample(given, r.randint(1, 5))
    return f"""model chain
size N = 20
param k[i = 1..N] = 1 + i/9
input f
input g
coord q[1..N], X
state w
{ends}
kinetic sum((2 + cos(q[i]))*q[i]'^2/2, i = 1..N) + X'^2
potential sum(k[i]*q[i]^2/2, i = 1..N) + sum((q[i+1] - q[i])^4, i = 1..N-1) + X^2*q[1]
force q[N] = f
force X = g - w
rate w = X - w
start q[i = 1..N] = 0.1*i
{beside}
sample control every k[1]/9{delay}
  set g = g/2 + q[N]' - {outside}
  memory c = 0.1
  set f = g*X - f*c
end
event hit: q[1] - 0.1 rising then {", ".join(given)}
event low: X falling
"""


@pytest.mark.parametrize("seed", seeds(range(12), turning=4))
def test_what_is_given_equals_the_unrolled_code(seed, tmp_path):
    r = random.Random(seed)
    text = model(r)
    loops = Looped(text, tmp_path / "loops")
    inputs = len(loops.equations.inputs)
    for size in r.sample(range(3, 12), 2):
        unrolled, at = Written(text, size, tmp_path / f"n{size}"), loops.at(size)
        assert_start(unrolled, at)
        n_q = at.n - loops.equations.first_order.value({"N": size})
        lengths = {"control_sample": (inputs,), "event": (2,), "sampling": (2, inputs)}
        lengths["hit_reset"] = (n_q + at.n + inputs,)
        for _ in range(3):
            q, v = ([r.uniform(-2, 2) for _ in range(at.n)] for _ in range(2))
            state = r.uniform(0, 3), q, v, [r.uniform(-2, 2) for _ in range(inputs)]
            what = f"{text}N = {size}"
            assert_kernels(unrolled, at, state, what)
            for kernel, counts in lengths.items():
                none = (state[0], None, None, state[3])  # The runtime calls `sampling` so.
                _, expected = unrolled.call(kernel, *state)
                _, found = at.call(kernel, *(none if kernel == "sampling" else state), counts)
                for one, other in zip(expected, found, strict=True):
                    assert_close(one, other, f"{what}: {kernel}", 100.0)
