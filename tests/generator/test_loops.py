"""Families as loops: every kernel against the unrolled code of the same model."""

from __future__ import annotations

import ctypes
import random

import pytest
from loop_harness import Looped, Unrolled, looped
from loop_models import MODELS, UNROLLED
from pkgen.middle.loops import Unrolled as CannotLoop

TOLERANCE = 2e-14
VECTORS = {"acceleration": 1, "force": 1, "momenta": 1, "gradient": 1, "canonical": 2}
SCALARS = ("energy", "lagrangian", "kinetic", "potential")


@pytest.mark.parametrize("name", MODELS)
def test_loops_equal_the_unrolled_code(name, tmp_path):
    text, sizes = MODELS[name]
    loops = Looped(text, tmp_path / "loops")
    for size in sizes:
        unrolled = Unrolled(text, size, tmp_path / f"n{size}")
        at = loops.at(size)
        assert at.n == len(unrolled.program.equations.coordinates)
        generator = random.Random(2385 + size)
        assert_start(unrolled, at)
        for _ in range(5):
            state = (
                generator.uniform(0, 3),
                [generator.uniform(-1, 1) for _ in range(at.n)],
                [generator.uniform(-1, 1) for _ in range(at.n)],
                [generator.uniform(-1, 1) for _ in unrolled.program.equations.inputs],
            )
            assert_kernels(unrolled, at, state, f"{name} N = {size}")


def assert_start(unrolled, at):
    n = at.n
    q, v = (ctypes.c_double * n)(), (ctypes.c_double * n)()
    unrolled.function("start", None)(unrolled.params, q, v)
    mine = at.start()
    assert_close(list(q), mine[0], "start q")
    assert_close(list(v), mine[1], "start v")


def assert_kernels(unrolled, at, state, what):
    for kernel, count in VECTORS.items():
        failed, expected = unrolled.call(kernel, *state)
        status, found = at.call(
            kernel, *state, (at.n,) * count, ctypes.c_int if kernel == "acceleration" else None
        )
        if kernel == "acceleration":
            assert failed == status == 0, f"{what}: {kernel} failed: {failed}, {status}"
        scale = max(1.0, *map(abs, expected[0]))
        for one, other in zip(expected, found, strict=True):
            assert_close(one, other, f"{what}: {kernel}", scale)
    for kernel in SCALARS:
        if unrolled.program.kernel(kernel) is None:
            continue
        expected, _ = unrolled.call(kernel, *state)
        found, _ = at.call(kernel, *state, (), ctypes.c_double)
        assert_close([expected], [found], f"{what}: {kernel}", at.n)
    if unrolled.program.kernel("observe") is not None:
        _, (expected,) = unrolled.call("observe", *state)
        _, (found,) = at.call("observe", *state, (len(expected),))
        assert_close(expected, found, f"{what}: observe", at.n)
    assert_mass(unrolled, at, state, what)


def assert_mass(unrolled, at, state, what):
    """The band, or the diagonal, has what M has; where M is diagonal all of it."""
    if not at.of.equations.facts.mass_diagonal:
        return
    n = at.n
    _, (whole,) = unrolled.call("mass", *state)
    _, (diagonal,) = at.call("mass", *state, (at.mass_size(),))
    assert len(diagonal) == n
    assert_close([whole[i * n + i] for i in range(n)], diagonal, f"{what}: mass")


def assert_close(expected, found, what, scale=1.0):
    for i, (a, b) in enumerate(zip(expected, found, strict=True)):
        assert abs(a - b) <= TOLERANCE * max(scale, abs(a)), f"{what}[{i}]: {a!r}, {b!r}"


@pytest.mark.parametrize("name", UNROLLED)
def test_what_cannot_loop_says_why(name):
    text, reason = UNROLLED[name]
    with pytest.raises(CannotLoop) as raised:
        looped(text)
    assert reason in str(raised.value)
