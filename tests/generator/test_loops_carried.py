"""Values carried along the members of a family: every kernel against the unrolled code, of random
chains; time and code of a long one."""

from __future__ import annotations

import ctypes
import random
import time

import pytest
from c_harness import MASS
from c_harness import failed as failure
from carried_models import links
from conftest import long_but
from loop_harness import Looped, Unrolled
from pkgen.compiler import compile_model
from pkgen.source import Source

KERNELS = {"force": 1, "momenta": 1, "gradient": 1, "canonical": 2, "acceleration": 1}
SCALARS = ("energy", "lagrangian", "kinetic", "potential")
PENDULUM = """\
model pendulum
size N = 20
param m[i = 1..N] = 1 + 0.1*cos(i) in [0, inf)
param l[i = 1..N] = 1 + 0.05*sin(i)
param g = 9.81
coord theta[1..N]
let x[0] = 0
let y[0] = 0
let x[i = 1..N] = x[i-1] + l[i]*sin(theta[i])
let y[i = 1..N] = y[i-1] - l[i]*cos(theta[i])
kinetic   sum(m[i]/2*(x[i]'^2 + y[i]'^2), i = 1..N)
potential sum(m[i]*g*y[i], i = 1..N)
start theta[i = 1..N] = 0.1*i
"""


@pytest.mark.parametrize("seed", long_but({44}, range(60)))
def test_chains_equal_the_unrolled_code(seed: int, tmp_path) -> None:
    text, dice = links(random.Random(seed)), random.Random(seed)
    loops = Looped(text, tmp_path / "loops")
    assert loops.equations.carried
    for size in (2, 3, 6):
        written, at = Unrolled(text, size, tmp_path / f"n{size}"), loops.at(size)
        q, v = ([dice.uniform(-1, 1) for _ in range(at.n)] for _ in range(2))
        u = [dice.uniform(-1, 1) for _ in written.program.equations.inputs]
        state = (dice.uniform(0, 3), q, v, u)
        for kernel, count in KERNELS.items():
            whole = kernel == "acceleration"
            failed, expected = written.call(kernel, *state)
            status, found = at.call(
                kernel, *state, (at.n,) * count, ctypes.c_int if whole else None
            )
            assert not whole or failed == status == 0, text
            for one, other in zip(expected, found, strict=True):
                scale = max(1.0, *map(abs, one))
                assert other == pytest.approx(one, rel=0, abs=1e-12 * scale), f"{kernel}\n{text}"
        for kernel in SCALARS:
            expected, _ = written.call(kernel, *state)
            found, _ = at.call(kernel, *state, (), ctypes.c_double)
            assert found == pytest.approx(expected, rel=1e-12), f"{kernel}\n{text}"
        _, (expected,) = written.call("observe", *state)
        _, (found,) = at.call("observe", *state, (len(expected),))
        assert found == pytest.approx(expected, rel=1e-11), text


def test_a_link_without_mass_is_named(tmp_path) -> None:
    at = Looped(PENDULUM, tmp_path).at(30)
    for last in (29, 12):
        at.params.m[29] = 1
        at.params.m[last] = 0
        at.prepare()
        q, v = [0.3] * 30, [0.1] * 30
        status, _ = at.call("acceleration", 0, q, v, (), (30,), ctypes.c_int)
        # Within the chain a point without mass still has the inertia of what hangs there.
        assert status == (failure(MASS, 29) if last == 29 else 0)


def test_a_thousand_links_are_quick_and_small() -> None:
    begun = time.process_time()
    made = compile_model(Source("m.lag", PENDULUM), sizes={"N": 1000})
    assert made.looped and time.process_time() - begun < 2
    assert sum(map(len, made.files.values())) < 200_000
    few = compile_model(Source("m.lag", PENDULUM), sizes={"N": 30})
    assert len(few.files["pendulum.c"]) == pytest.approx(len(made.files["pendulum.c"]), abs=20)
