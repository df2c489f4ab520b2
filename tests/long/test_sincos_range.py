"""The inline sine and cosine over their whole range: every float, and doubles by the hundred
thousand against mpmath, in each variant.

`make test-long`; with PKGEN_UPDATE=1 the figures are written to docs/dev/long-runs.md.
"""

import re
import sys
from functools import cache
from pathlib import Path

import numpy
import pytest
from page import write_section

from conftest import ROOT

sys.path += [str(ROOT / "tests" / "generator"), str(ROOT / "tools")]
import minimax
from sincos_harness import VARIANTS, Exact, arguments, build

pytestmark = pytest.mark.long

BOUND = 1.5
COUNT = 100_000
TITLE = "The inline sine and cosine"
INTRODUCTION = f"""\
Largest error of `pk/sincos.h` in units in the last place of the result, and where. In float every
argument from 2^-40 to the limit of the reduction, against libm in double. In double, against
mpmath, arguments of all sizes, beyond the limit too, and next to multiples of pi/2 and of pi/4,
with those to which doubles come nearest. `make test-long` demands at most
{BOUND}, of both compilers, without and with fused multiply-add, contraction off and on.

| variant | arguments | sine | at | cosine | at |
|---|---|---|---|---|---|
"""


@pytest.fixture(scope="module")
def page():
    lines: list[str] = []
    yield lines
    write_section(TITLE, INTRODUCTION + "\n".join(lines))


@cache
def doubles(limit: float) -> tuple[numpy.ndarray, Exact]:
    x = arguments("double", limit, COUNT, seed=9871)
    return x, Exact(x, "double")


@pytest.mark.parametrize("scalar", minimax.DEGREES)
def test_coefficients_are_those_of_the_exchange_algorithm(scalar: str) -> None:
    text = (ROOT / "runtime" / "include" / "pk" / "sincos.h").read_text()
    there = {float.fromhex(x) for x in re.findall(r"PK_C\((0x[^)]*)\)", text)}
    bits, *degrees = minimax.DEGREES[scalar]
    for target, degree in zip(minimax.TARGETS, degrees, strict=True):
        coefficients, before, after = minimax.polynomial(target, bits, degree)
        assert {abs(c) for c in coefficients} <= there
        assert 0 < before <= after < 0.1


@pytest.mark.parametrize("variant", VARIANTS, ids="-".join)
def test_whole_range(variant: tuple[str, ...], page: list[str], tmp_path: Path) -> None:
    pair = build(tmp_path, *variant)
    if pair.scalar == "float":
        count, worst, at = pair.every_float(step=1)
    else:
        x, exact = doubles(pair.limit)
        errors = exact.errors(pair(x))
        count, worst = len(x), [float(e.max()) for e in errors]
        at = [float(x[numpy.argmax(e)]) for e in errors]
    cells = " | ".join(f"{w:.3f} | {float(a).hex()}" for w, a in zip(worst, at, strict=True))
    page.append(f"| {' '.join(variant)} | {count:,} | {cells} |")
    assert count > 3 * COUNT
    assert min(worst) > 0.5 and max(worst) <= BOUND
