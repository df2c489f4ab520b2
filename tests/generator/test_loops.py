"""Families as loops: every kernel against the unrolled code of the same model."""

import ctypes
import math
import random

import pytest
from c_harness import MASS, PARAMETER, SIZE
from c_harness import failed as failure
from loop_harness import Looped, Written, looped
from loop_models import MODELS, UNROLLED

from conftest import case
from pkgen.middle.families.indexed_ir import NotKept as CannotLoop

TOLERANCE = 2e-14
VECTORS = {"acceleration": 1, "force": 1, "momenta": 1, "gradient": 1, "canonical": 2}
SCALARS = ("energy", "lagrangian", "kinetic", "potential")


# Members whose unrolled code takes long.
LONG = {"paired": 70, "ring": 70, "wheel": 15, "links": 20}
SHORT = {"fput", "ring", "paired", "gravity", "cart", "links"}  # in make test
CASES = [
    pytest.param(
        name,
        [size for size in sizes if size != LONG.get(name)],
        marks=[] if name in SHORT else pytest.mark.long,
    )
    for name, (_, sizes) in MODELS.items()
]
CASES += [pytest.param(name, [size], marks=pytest.mark.long) for name, size in LONG.items()]


@pytest.mark.parametrize(("name", "sizes"), CASES)
def test_loops_equal_the_unrolled_code(name, sizes, tmp_path):
    text = MODELS[name][0]
    loops = Looped(text, tmp_path / "loops")
    for size in sizes:
        unrolled = Written(text, size, tmp_path / f"n{size}")
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
    # Where a momentum depends on a state the unrolled code has p = v, and under constraints their
    # forces in f.
    e = at.of.equations
    kernels = ("acceleration",) if e.solved or e.bound else VECTORS
    for kernel, count in ((kernel, VECTORS[kernel]) for kernel in kernels):
        failed, expected = unrolled.call(kernel, *state)
        status, found = at.call(
            kernel, *state, (at.n,) * count, ctypes.c_int if kernel == "acceleration" else None
        )
        if kernel == "acceleration":
            assert failed == status == 0, f"{what}: {kernel} failed: {failed}, {status}"
        scale = max(1.0, *map(abs, expected[0]))
        if kernel == "acceleration" and at.of.equations.carried:
            scale *= 1000  # M of relative angles costs the unrolled code digits
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
    e = at.of.equations
    if not e.facts.mass_diagonal or e.solved or e.bound:
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


STEPPED = {
    "fput": MODELS["fput"][0],
    "ring_without_drag": "\n".join(
        line for line in MODELS["ring"][0].splitlines() if not line.startswith("dissipation")
    ),
    "loosely": case("loosely"),
    "ends": MODELS["ends"][0],
    "shaken": case("shaken"),
}
METHODS = {  # kicks, drifts
    "symplectic_euler": ((1.0, 0.0), (1.0,)),
    "verlet": ((0.5, 0.5), (1.0,)),
    "yoshida4": (
        (0.6756035959798288, -0.1756035959798288, -0.1756035959798288, 0.6756035959798288),
        (1.3512071919596576, -1.7024143839193153, 1.3512071919596576),
    ),
}


@pytest.mark.parametrize("name", STEPPED)
def test_fused_steps_equal_kicks_and_drifts_one_by_one(name, tmp_path):
    loops = Looped(STEPPED[name], tmp_path)
    h, t0, steps = 0.05, 0.3, 7
    for size in (1, 2, 3, 5, 64, 65, 127, 129, 700, 1500):
        at = loops.at(size)
        for method, (kick, drift) in METHODS.items():
            generator = random.Random(size)
            q = [generator.uniform(-1, 1) for _ in range(at.n)]
            v = [generator.uniform(-1, 1) for _ in range(at.n)]
            expected = one_by_one(at, kick, drift, t0, h, steps, q, v)
            mine = fused(at, kick, drift, t0, h, steps, q, v)
            for one, other in zip(expected, mine, strict=True):
                assert_close(one, other, f"{name} N = {size} {method}", scale=50.0)


@pytest.mark.parametrize("name", STEPPED)
def test_stages_in_flight_equal_single_steps_to_the_bit(name, tmp_path):
    loops = Looped(STEPPED[name], tmp_path)
    kick, drift = METHODS["symplectic_euler"]
    h, t0, steps = 0.0625, 0.5, 37  # sums of them are exact
    for size in (1, 63, 1000, 1018, 1031, 3000):
        at = loops.at(size)
        generator = random.Random(size)
        q, v = ([generator.uniform(-0.5, 0.5) for _ in range(at.n)] for _ in range(2))
        together = fused(at, kick, drift, t0, h, steps, q, v)
        for k in range(steps):
            q, v = fused(at, kick, drift, t0 + k * h, h, 1, q, v)
        assert any(abs(x) > 0.01 for x in q) and all(map(math.isfinite, q))
        assert together == (q, v), f"{name} N = {size}"


def one_by_one(at, kick, drift, t, h, steps, q, v):
    q, v = list(q), list(v)
    for k in range(steps):
        done = 0.0
        for i, kappa in enumerate(kick):
            status, (a,) = at.call(
                "acceleration", t + (k + done) * h, q, v, (), (at.n,), ctypes.c_int
            )
            assert status == 0
            v = [x + kappa * h * y for x, y in zip(v, a, strict=True)]
            if i < len(drift):
                q = [x + drift[i] * h * y for x, y in zip(q, v, strict=True)]
                done += drift[i]
    return q, v


def fused(at, kick, drift, t, h, steps, q, v):
    real = ctypes.c_double
    arrays = [(real * len(x))(*x) for x in (kick, drift, q, v)]
    at.of.function("advance")(
        ctypes.byref(at.params),
        len(drift),
        arrays[0],
        arrays[1],
        real(t),
        real(h),
        ctypes.c_ulong(steps),
        arrays[2],
        arrays[3],
    )
    return list(arrays[2]), list(arrays[3])


def test_angles_beyond_the_inline_sine_are_as_good(tmp_path):
    text = (
        "model rotors\nsize N = 5\ncoord x[1..N]\nkinetic sum(x[i]'^2/2, i = 1..N)\n"
        "potential sum(-cos(x[i]), i = 1..N)\n"
    )
    at = Looped(text, tmp_path).at(100)
    q = [1e15 + 4096.0 * i if i % 3 else 0.1 * i for i in range(100)]
    _, (found,) = at.call("acceleration", 0.2, q, [0.3] * 100, [], (100,), ctypes.c_int)
    assert_close([-math.sin(x) for x in q], found, "acceleration")
    expected = sum(-math.cos(x) for x in q) + 100 * 0.3**2 / 2
    energy, _ = at.call("energy", 0.2, q, [0.3] * 100, [], (), ctypes.c_double)
    assert_close([expected], [energy], "energy", scale=10.0)


def test_sizes_too_small_and_parameters_out_of_bounds_are_refused(tmp_path):
    at = Looped(MODELS["paired"][0], tmp_path).at(5)
    member = [p.name for p in at.of.equations.parameters].index("m")
    at.params.m[3] = -1.0
    assert at.prepare() == failure(PARAMETER, member)
    at.params.m[3] = float("nan")
    assert at.prepare() == failure(PARAMETER, member)
    at.params.m[3] = 0.7
    assert at.prepare() == 0
    at.params.N = 0
    assert at.prepare() == failure(SIZE)
    assert at.of.function("block_size", ctypes.c_size_t)(ctypes.byref(at.params)) == 0


def test_a_mass_that_is_not_positive_is_reported_with_its_coordinate(tmp_path):
    at = Looped(MODELS["loose"][0], tmp_path / "a").at(80)
    at.params.w = -40.0  # 1 + w i/N
    assert at.prepare() == 0
    status, _ = at.call("acceleration", 0.0, [0.1] * 80, [0.0] * 80, (), (80,), ctypes.c_int)
    assert status == failure(MASS, 1)  # i = 2: 1 - 40*2/80 = 0
    banded = Looped(MODELS["beam"][0], tmp_path / "b").at(6)
    banded.params.r = -3.0
    assert banded.prepare() == failure(PARAMETER, 0)  # out of its bounds


DRAGGED = """model dragged
size N = 5
const c = {c}
coord q[1..N]
free q
kinetic sum(q[i]'^2/2, i = 1..N)
potential sum((q[i+1] - q[i])^2/2, i = 0..N)
{force}
"""


@pytest.mark.parametrize(
    "force",
    ["dissipation sum(c*q[i]'^2/2, i = 1..N)", "force q[i = 1..N] = -c*q[i]'", "force q[2] = c*t"],
)
def test_forces_that_are_zero_leave_the_energy_constant(force):
    for c in (0, 0.1):
        facts = looped(DRAGGED.format(c=c, force=force)).facts
        assert facts.conservative == facts.variational == (c == 0)


def test_more_members_than_are_computed_at_a_time_with_an_end_that_moves(tmp_path):
    """Members are computed 512 at a time, and three more for the terms that reach so far."""
    text = (
        "model driven\nsize N = 600\ncoord q[1..N]\nfixed q[0] = sin(t), q[N+1] = 0\n"
        "kinetic sum(q[i]'^2/2, i = 1..N) + sum((q[i]' + q[i+1]')^2/9, i = 0..N)\n"
        "potential sum((q[i] - q[i-3])^2/2, i = 4..N) + sum((q[i] - q[i-1])^2/2, i = 1..N)\n"
    )
    at, dice, t = Looped(text, tmp_path).at(600), random.Random(7), 0.7
    q = [dice.uniform(-1, 1) for _ in range(600)]
    _, (found,) = at.call("force", t, q, [0.1] * 600, (), (600,))
    expected = [0.0] * 600
    for far in (3, 1):
        for i in range(far - (far == 1), 600):
            pull = q[i] - (q[i - far] if i >= far else math.sin(t))
            expected[i] -= pull
            if i >= far:
                expected[i - far] += pull
    expected[0] += math.sin(t) * 2 / 9  # the end's acceleration
    assert_close(expected, found, "force")
