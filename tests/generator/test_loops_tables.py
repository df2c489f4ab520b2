"""Tables of data in families: every kernel against the unrolled code of the same model."""

import random

import pytest
from loop_harness import Looped, Written
from test_loops import assert_kernels, assert_start

from conftest import seeds
from pkgen.middle.families.indexed_ir import NotKept as CannotLoop

FORMS = {  # whose forces do not jump
    "spline": ("road", "outside linear"),
    "pchip": ("road", "periodic"),
    "bicubic": ("map", "outside linear"),
}


def model(r: random.Random) -> str:
    """A chain with a table in its potential, its forces and its mass."""
    kind = r.choice(list(FORMS))
    name, outside = FORMS[kind]
    variables = "s, z" if name == "road" else "s, w -> z"
    of = (lambda x: f"{name}({x})") if name == "road" else (lambda x: f"{name}({x}, c[i]/9)")
    ends = r.choice(["fixed q[0] = 0, q[N+1] = sin(t)", "free q", "periodic q"])
    mass = r.choice(["1", f"(3 + {of('i/7')})"])
    return f"""model chain
size N = 20
param c[i = 1..N] = i/3
table {name} = "{name}.csv" {variables} {kind} {outside}
coord q[1..N]
{ends}
kinetic sum({mass}*q[i]'^2/2, i = 1..N)
potential sum(c[i]*{of("q[i]")}, i = 1..N) + sum((q[i+1] - q[i])^4, i = 1..N-1)
force q[i = 1..N] = {of("q[i] - q[i-1]")}*q[i]'
start q[i = 1..N] = 0.1*i
"""


@pytest.mark.parametrize("seed", seeds(range(9), turning=3))
def test_tables_equal_the_unrolled_code(seed, tmp_path, monkeypatch):
    r = random.Random(seed)
    (tmp_path / "road.csv").write_text("s,z\n-2,0\n-1,.3\n0,.1\n1,-.4\n2.5,.2\n4,0\n")
    rows = [f"{x},{y},{r.uniform(-1, 1)}" for x in range(-2, 4) for y in range(4)]
    (tmp_path / "map.csv").write_text("\n".join(["s,w,z", *rows]))
    monkeypatch.chdir(tmp_path)
    text = model(r)
    loops = Looped(text, tmp_path / "loops")
    for size in r.sample(range(3, 16), 2):
        unrolled, at = Written(text, size, tmp_path / f"n{size}"), loops.at(size)
        assert_start(unrolled, at)
        for _ in range(3):
            q, v = ([r.uniform(-3, 4) for _ in range(at.n)] for _ in range(2))
            assert_kernels(unrolled, at, (r.uniform(0, 3), q, v, []), f"{text}N = {size}")


def test_a_force_that_jumps_at_knots_is_written_out(tmp_path, monkeypatch):
    (tmp_path / "road.csv").write_text("s,z\n-2,0\n-1,.3\n0,.1\n4,0\n")
    monkeypatch.chdir(tmp_path)
    text = """model chain
size N = 20
table road = "road.csv" s, z linear outside linear
coord q[1..N]
kinetic sum(q[i]'^2/2, i = 1..N)
potential sum(road(q[i]), i = 1..N)
"""
    with pytest.raises(CannotLoop, match="jumps at knots"):
        Looped(text, tmp_path / "loops")
    assert Looped(text.replace("linear outside", "spline outside"), tmp_path / "loops").equations
