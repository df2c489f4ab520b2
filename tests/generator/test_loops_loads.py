"""Forces at points of families: every kernel against the unrolled code of the same model."""

import random

import pytest
from loop_harness import Looped, Written
from test_loops import assert_kernels, assert_start

from conftest import seeds


def model(r: random.Random) -> str:
    """Points of three families, or along a chain of links, with forces of several kinds."""
    chain = r.random() < 0.4
    if chain:
        coords = "coord a[1..N]"
        points = "let P[0] = [0, 0, 0]\nlet P[i = 1..N] = P[i-1] + [cos(a[i]), sin(a[i]), 0]"
        energy = "kinetic sum(dot(P[i]', P[i]')/2 + a[i]'^2/8, i = 1..N)"
    else:
        ends = r.choice(["fixed x[0] = sin(t), x[N+1] = 2", "free x", "periodic x"])
        coords = f"coord a[1..N], x[1..N], y[1..N]\n{ends}"
        points = "let P[i = 1..N] = [x[i] + 0.2*cos(a[i]), y[i] + 0.2*sin(a[i])*x[i], 0.1*a[i]^2]"
        energy = "kinetic sum((x[i]'^2 + y[i]'^2 + a[i]'^2)/2, i = 1..N)"
        energy += "\npotential sum((x[i] - x[i-1])^2/2, i = 2..N)"
    kinds = [
        "force drag[i = 1..N] at P[i] = -0.3*P[i]'",
        "force P[i = 1..N] = [t, i/N, -1] - 0.2*P[i]",
        "force push at P[N] = [sin(t), 0.5, 1]",
        "force P[2] = [1, t^2, 0] - P[2]'",
        "force wind[i = 2..N] at P[i] = norm(P[i]')*P[i]",
        "force flow[i = 1..N] at P[i] = [sum(a[k]^2, k = 1..N), 0, 0]",
    ]
    loads = "\n".join(r.sample(kinds, r.randint(1, 3)))
    return f"""model loaded
size N = 20
{coords}
{points}
{energy}
potential sum(cos(a[i]), i = 1..N)
{loads}
"""


@pytest.mark.parametrize("seed", seeds(range(9), turning=3))
def test_loads_equal_the_unrolled_code(seed, tmp_path):
    r = random.Random(seed)
    text = model(r)
    loops = Looped(text, tmp_path / "loops")
    for size in r.sample(range(3, 9), 2):
        unrolled, at = Written(text, size, tmp_path / f"n{size}"), loops.at(size)
        assert_start(unrolled, at)
        for _ in range(3):
            q, v = ([r.uniform(-1, 1) for _ in range(at.n)] for _ in range(2))
            assert_kernels(unrolled, at, (r.uniform(0, 3), q, v, []), f"{text}N = {size}")
