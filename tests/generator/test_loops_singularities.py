"""Singularities of families kept as loops: which, over which members, and their values."""

import ctypes
import random

import numpy as np
import pytest
from loop_harness import Looped, looped

from conftest import case
from pkgen.front.check import check
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Kind, Symbol
from pkgen.middle.derive.derive import derive
from pkgen.source import Source

CHART, MOTION = True, False
HEAD = case("loops_singularities_m")
FLAT = "sum(x[i]'^2/2 + y[i]'^2/2, i = 1..N) + s'^2/2"


def written(potential: str = "0", kinetic: str = FLAT, more: str = "") -> str:
    return f"{HEAD}kinetic {kinetic}\npotential {potential}\n{more}"


def over(singularity) -> str:
    """The range of its members: '1..N-1', of pairs '1..N-1, m+1..N', of a single value ''."""
    ends = zip(singularity.over[::2], singularity.over[1::2], strict=True)
    return ", ".join(f"{a.text()}..{b.text()}" for a, b in ends).replace(" ", "").replace(",", ", ")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        # Once for a body, whichever of its members the row belongs to.
        (written("sum(-k/(x[i+1] - x[i]), i = 1..N-1)"), [("x[i+1] - x[i]", MOTION, "1..N-1")]),
        (
            written("sum(-k/norm([x[i+1] - x[i], y[i+1] - y[i], 0]), i = 1..N-1)"),
            [("(x[i+1] - x[i])^2 + (y[i+1] - y[i])^2", MOTION, "1..N-1")],
        ),
        (
            written("sum(-k/norm([x[j] - x[i], 0, 0]), i = 1..N-1, j = i+1..N)"),
            [("x[j] - x[i]", MOTION, "1..N-1, m+1..N")],
        ),
        (
            written("sum(asin(x[i+1] - x[i-1]), i = 2..N-1)"),
            [("1 - (x[i+2] - x[i])^2", MOTION, "1..N-2")],
        ),
        (written("sum(log(x[i] - e*i), i = 1..N)"), [("x[i] - e*i", MOTION, "1..N")]),
        (written("sum(x[i]^m[i], i = 1..N)"), [("x[i]", MOTION, "1..N")]),
        (
            written("sum(k/cos(x[i])/y[i], i = 2..N)"),
            [("cos(x[i])", MOTION, "2..N"), ("y[i]", MOTION, "2..N")],
        ),
        # Single members, a coordinate beside the families, the time.
        (
            written("-1/x[1] - 1/(x[N] - x[N-1])"),
            [("x[1]", MOTION, ""), ("x[N] - x[N-1]", MOTION, "")],
        ),
        (written("sum(-y[i]/s, i = 1..N)"), [("s", MOTION, "")]),
        (written("sum(-1/(s - x[i]), i = 1..N)"), [("s - x[i]", MOTION, "1..N")]),
        (written("sum(y[i]/(t - i), i = 1..N)"), [("t - i", MOTION, "1..N")]),
        # Forces, and the time in an end that is given.
        (written(more="force x[i = 1..N] = 1/(y[i] - e)\n"), [("y[i] - e", MOTION, "1..N")]),
        (
            written("sum((x[i+1] - x[i])^2, i = 0..N)", more="fixed x[0] = 1/t, x[N+1] = 0\n"),
            [("t", MOTION, "")],
        ),
        # M.
        (
            written(kinetic="sum(x[i]'^2/2 + x[i]^2*y[i]'^2/2, i = 1..N) + s'^2/2"),
            [("x[i]", CHART, "1..N")],
        ),
        (
            written("1/s", kinetic="sum(x[i]'^2/2 + y[i]'^2/2, i = 1..N) + s'^2*s^2/2"),
            [("s", CHART, "")],
        ),
        # What is proved never to vanish, or does not move.
        (written("sum(x[i]^2/2/m[i]/i/e, i = 1..N)"), []),
        (written("sum(-k/sqrt(k + (x[i+1] - x[i])^2), i = 1..N-1)"), []),
        (written("sum(cos(x[i]) + exp(x[i]) + 1/cosh(y[i]), i = 1..N)"), []),
        (written(kinetic=f"{FLAT} + sum(x[i]^2*y[i]'^2/2, i = 1..N-1)"), []),
        (written(kinetic=f"{FLAT} + sum(x[i]^2*s'^2/2, i = 1..N)"), []),
        (written(kinetic=f"{FLAT} + sum(x[i]'*x[i+1]'/3, i = 1..N-1)"), []),
    ],
)
def test_which(text, expected):
    e = looped(text)
    found = [
        (singularity.name, singularity.use == "COORDINATES", over(singularity))
        for singularity in e.singularities
    ]
    assert found == expected and not e.pivots


@pytest.mark.parametrize(
    "kinetic",
    [
        f"{FLAT} + sum(x[i]'*y[i]'*cos(x[i]), i = 1..N)",
        "sum(x[i]'^2, i = 1..N) + sum(x[i]^2*y[i]'^2, i = 1..N-1) + sum(y[i]'^2, i = 2..N) + s'^2",
        "sum(x[i]'^2/2 + y[i]'^2/2 + x[i]^2*s'^2/2, i = 1..N)",
    ],
)
def test_pivots_of_m_where_they_are_no_expression(kinetic):
    assert looped(written(kinetic=kinetic)).pivots


# A singularity of each kind beside the pivots of a band.
ALL = case("all")
# M is diagonal, and of y[N] another sum than of the rest.
UNEVEN = case("loops_singularities_uneven")


def unrolled(text: str, size: int):
    model, _ = check.check_text(Source("model.lag", text), {"N": size})
    e = derive(model)
    fixed: dict[Symbol, float] = {}
    for k, slot in enumerate(e.parameters):
        fixed[Symbol(Kind.PARAMETER, k)] = evaluate(e.graph, [slot.default], fixed)[0]
    return e, fixed


def state_of(e, generator: random.Random, size: int, far: bool):
    q = [generator.uniform(-1, 1) for _ in e.coordinates]
    q[size] += 3e9 * far  # a[0]: beyond the inline sine
    v = [generator.uniform(-1, 1) for _ in e.coordinates]
    values = {Symbol(Kind.COORDINATE, i): x for i, x in enumerate(q)} | {Symbol(Kind.TIME): 0.3}
    return q, v, values | {Symbol(Kind.RATE, i): x for i, x in enumerate(v)}


@pytest.mark.parametrize(("text", "sizes"), [(ALL, (3, 4, 9)), (UNEVEN, (2, 9))])
def test_values(text, sizes, tmp_path):
    loops = Looped(text, tmp_path, ("-O0",))
    generator = random.Random(2385)
    for size in sizes:
        e, fixed = unrolled(text, size)
        at, n = loops.at(size), len(e.coordinates)
        count = loops.function("singularity_count", ctypes.c_size_t)(ctypes.byref(at.params))
        for far in (False, text is ALL):
            q, v, values = state_of(e, generator, size, far)
            _, (found,) = at.call("singularity", 0.3, q, v, [], (count,))
            # The pivots first: their product is the determinant, in whatever order M is factored.
            entries = evaluate(e.graph, [x for row in e.mass for x in row], fixed | values)
            whole = np.linalg.det(np.array(entries).reshape(n, n))
            assert min(found[:n]) > 0 and np.prod(found[:n]) == pytest.approx(whole, rel=1e-12)
            nodes = [
                singularity.node
                for singularity in e.singularities
                if singularity.use != "COORDINATES"
            ]
            expected = evaluate(e.graph, nodes, fixed | values)
            # Of an expression and its negative either may be the singularity.
            rest = {f"{abs(x):.9g}" for x in found[n:]}
            assert rest == {f"{abs(x):.9g}" for x in expected}
            assert len(rest) > 3 * size if text is ALL else not rest


def test_the_pivot_of_a_coordinate_that_has_no_inertia_is_0(tmp_path):
    """Behind it is the diagonal of M."""
    text = (
        "model bare\nsize N = 5\ncoord q[1..N]\n"
        "kinetic sum(q[i]^2*q[i]'^2/2, i = 1..N) + 0.1*q[1]'*q[2]'\n"
    )
    at = Looped(text, tmp_path).at(5)
    q = [1.0, 2.0, 3.0, 0.0, 5.0]
    _, (found,) = at.call("singularity", 0.0, q, [0.0] * 5, (), (5,))
    assert found == pytest.approx([1, 4 - 0.01, 9, 0, 25], abs=1e-14)
