"""The inline sine and cosine: at most 1.5 units in the last place, for every finite argument."""

import re
from functools import cache

import mpmath
import numpy
import pytest
from c_harness import ROOT
from sincos_harness import TYPES, VARIANTS, Exact, arguments, build, targets

BOUND = 1.5
COUNT = 1500


@pytest.fixture(scope="module", params=VARIANTS, ids="-".join)
def pair(request, tmp_path_factory):
    return build(tmp_path_factory.mktemp("pair"), *request.param)


@cache
def cases(scalar: str, limit: float) -> tuple[numpy.ndarray, Exact]:
    x = arguments(scalar, limit, COUNT)
    return x, Exact(x, scalar)


def test_errors_against_mpmath(pair):
    x, exact = cases(pair.scalar, pair.limit)
    for name, error in zip(("sin", "cos"), exact.errors(pair(x)), strict=True):
        worst = int(numpy.argmax(error))
        print(f"{name}: {error[worst]:.3f} units at {float(x[worst])!r}, of {len(x)} arguments")
        assert 0.5 < error[worst] <= BOUND


def test_most_floats(pair):
    if pair.scalar != "float":
        pytest.skip("floats are few enough")
    count, worst, at = pair.every_float(step=499)
    print(f"{count} floats: {worst} units at {at}")
    assert count > 500_000
    assert 0.5 < max(worst) <= BOUND


def test_lanes_give_the_same_bits_or_say_that_they_do_not(pair):
    x = arguments(pair.scalar, pair.limit, COUNT)
    x = numpy.concatenate([x, numpy.array([numpy.nan, numpy.inf, -numpy.inf], dtype=x.dtype)])
    s, c, bad = pair.in_lanes(x)
    assert numpy.array_equal(bad, ~(numpy.abs(x) <= pair.limit))
    assert 100 < bad.sum() < len(x) / 2
    for found, expected in zip((s, c), pair(x), strict=True):
        assert found[~bad].tobytes() == expected[~bad].tobytes()


def test_what_is_not_finite_gives_nan_and_zeros_keep_their_sign(pair):
    x = numpy.array([numpy.nan, numpy.inf, -numpy.inf, 0.0, -0.0], dtype=TYPES[pair.scalar][0])
    s, c = pair(x)
    assert numpy.isnan(s[:3]).all() and numpy.isnan(c[:3]).all()
    assert list(s[3:]) == [0, 0] and list(numpy.signbit(s[3:])) == [False, True]
    assert list(c[3:]) == [1, 1]


def test_subnormals_are_their_own_sine(pair):
    real = TYPES[pair.scalar][0]
    x = numpy.finfo(real).smallest_subnormal * numpy.array([1, 3, 2385, -7], dtype=real)
    s, c = pair(x)
    assert (x != 0).all() and s.tobytes() == x.tobytes() and (c == 1).all()


@pytest.mark.parametrize("scalar", TYPES)
@pytest.mark.parametrize("target", targets())
def test_a_reduction_in_two_parts_would_fail(scalar, target, tmp_path):
    """The bound is tight enough to see that the last part counts."""
    source = (ROOT / "runtime/include/pk/sincos.h").read_text()
    last = "P3" if target != "plain" else "P4"
    broken = re.sub(rf"(#define PK_SINCOS_{last}) .*", r"\1 PK_C(0.0)", source)
    assert broken != source
    include = tmp_path / "pk"
    include.mkdir()
    (include / "sincos.h").write_text(broken)
    worse = build(tmp_path, "gcc", target, "off", scalar, include=tmp_path)
    x, exact = cases(scalar, worse.limit)
    assert max(e.max() for e in exact.errors(worse(x))) > 10


def parts(scalar: str, has_fma: bool) -> list[float]:
    """P1, P2, ... as the header has them."""
    text = (ROOT / "runtime/include/pk/sincos.h").read_text()
    text = text[text.index("#ifdef PK_FLOAT") : text.index("/* The polynomials")]
    in_float, in_double = text.split("#else\n#define PK_SINCOS_MAX")
    with_fma, without = (in_float if scalar == "float" else in_double).split("#else")[:2]
    found = re.findall(r"_P\d PK_C\((.*)\)", with_fma if has_fma else without)
    return [float.fromhex(x) for x in found]


@pytest.mark.parametrize("has_fma", [True, False])
@pytest.mark.parametrize("scalar", TYPES)
def test_the_parts_of_pi_are_those_of_pi(scalar, has_fma):
    """They sum to pi/2, and k times each but the first (without fma) and the last is exact."""
    bits, k_bits = {"double": (53, 20), "float": (24, 10)}[scalar]
    values = parts(scalar, has_fma)
    assert len(values) == (3 if has_fma else 4)
    with mpmath.workprec(300):
        rest = abs(sum(map(mpmath.mpf, values)) - mpmath.pi / 2)
        assert 0 < rest < mpmath.mpf(values[-1]) * mpmath.mpf(2) ** (1 - bits)
    for value in values[1:-1] if has_fma else values[:-1]:
        numerator, _ = value.as_integer_ratio()
        while numerator % 2 == 0:
            numerator //= 2
        assert numerator.bit_length() <= bits - k_bits
