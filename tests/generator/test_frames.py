"""Chains of turns, differentiated as frames, beside the same chains in pieces too short for that;
accelerations by pushing L down its graph beside M a = f."""

import math
import random

import numpy as np
import pytest

from conftest import seeds
from pkgen.compiler import compile_model
from pkgen.front.check.check import check_text
from pkgen.graph.differentiate import Columns, Forward, gradient
from pkgen.graph.evaluate import evaluate
from pkgen.graph.frames import DEEP
from pkgen.graph.graph import BIT, ONE, ZERO, Kind, Symbol
from pkgen.graph.pushed import pushed
from pkgen.middle import motion
from pkgen.middle.derive.derive import derive
from pkgen.middle.quantities import symbols
from pkgen.source import Source

AXES = ["[0, 0, 1]", "[0, 1, 0]", "[1, 0, 0]", "[1, 2, 2]", "[0, 3, -4]", "[a, b, 1]"]
HEAD = "model tree\nparam a = 0.4\nparam b = -0.7\nparam m = 1.3 in (0, inf)\n"


def equations(text: str, *kernels: str):
    return derive(check_text(Source("tree.lag", text))[0], frozenset(kernels) or None)


def angle(draw: random.Random, k: int) -> str:
    """Of turn k of a chain: its coordinate, more or less."""
    other = f"q{draw.randint(1, k)}"
    forms = [f"q{k}"] * 4
    forms += [f"q{k} + {other}", f"2*q{k}", f"q{k} + a*t", f"q{k}*{other}", f"sin(q{k})", "0.3"]
    return draw.choice(forms)


def tree(draw: random.Random, links: int, whole: bool, arm: bool = False) -> str:
    """Links, each on a random earlier one. Where chains are not `whole`, a vector is turned by two
    of their turns at a time. An `arm` is one chain, each turn by a coordinate of its own."""
    text = HEAD + "".join(f"coord q{k}\n" for k in range(1, links + 1))
    chains: list[list[str]] = [[]]
    text += "let w0 = [0, 0, 0]\nlet p0 = [0, 0, 0]\n"
    for k in range(1, links + 1):
        on = k - 1 if arm else draw.randint(max(0, k - 2), k - 1)
        axis, turn = draw.choice(AXES), f"q{k}" if arm else angle(draw, k)
        before = chains[on]
        chain = [*before, f"rot({axis}, {turn})"]
        chains.append(chain)
        arm = f"[{draw.uniform(-1, 1):.2f}, {draw.uniform(-1, 1):.2f}, 0.5]"
        unit, rate = f"({axis}/norm({axis}))", "0" if turn == "0.3" else f"({turn})'"
        text += turned(f"n{k}", before, unit, whole) + turned(f"d{k}", chain, arm, whole)
        text += f"let w{k} = w{on} + {rate}*n{k}\nlet p{k} = p{on} + d{k}\n"
        text += f"kinetic m/2*dot(p{k}', p{k}') + {k}/10*dot(w{k}, w{k}) + q{k}'^2/20\n"
        text += f"potential 9.81*m*p{k}.z + q{k}^2\n"
    return text


def turned(name: str, chain: list[str], vector: str, whole: bool) -> str:
    if whole:
        return f"let {name} = {'*'.join([*chain, vector])}\n"
    text = f"let {name}_in = {vector}\n"
    at = f"{name}_in"
    for k in reversed(range(0, len(chain), 2)):
        text += f"let {name}_{k} = {'*'.join([*chain[k : k + 2], at])}\n"
        at = f"{name}_{k}"
    return text + f"let {name} = {at}\n"


def state(draw: random.Random, n: int) -> dict[Symbol, float]:
    values = {Symbol(Kind.PARAMETER, i): x for i, x in enumerate((0.4, -0.7, 1.3))}
    values[Symbol(Kind.TIME, 0)] = draw.uniform(0, 3)
    for kind in (Kind.COORDINATE, Kind.RATE):
        values |= {Symbol(kind, i): draw.uniform(-2, 2) for i in range(n)}
    return values


def kernels(e) -> list:
    rows = [e.momenta, e.pdot, e.force, e.acceleration, (e.energy,)]
    return [*rows, *e.mass, *e.p_q, *e.pdot_q, *e.pdot_v]


def pivots(of) -> list:
    return [pivot for pivot, _ in of.pivots]


@pytest.mark.parametrize("seed", seeds(range(3), 9))
def test_whole_chains_are_their_pieces(seed):
    """Two roads through differentiation: w x c, torques; and the product rule alone."""
    draw = random.Random(seed)
    links = draw.randint(DEEP, 6)
    whole, pieces = (
        equations(tree(random.Random(100 + seed), links, whole)) for whole in (True, False)
    )
    deep = tree(random.Random(100 + seed), links, True).count("rot(") > 4 * links
    assert not pieces.graph.frames.all and (whole.graph.frames.entries or not deep)
    for _ in range(3):
        values = state(draw, links)
        for a, b in zip(kernels(whole), kernels(pieces), strict=True):
            left = np.array(evaluate(whole.graph, a, values))
            right = np.array(evaluate(pieces.graph, b, values))
            scale = max(1, abs(right).max(initial=0))
            assert abs(left - right).max(initial=0) < 1e-9 * scale
        # Of whatever order of elimination: the determinant.
        both = [np.prod(evaluate(e.graph, pivots(e), values)) for e in (whole, pieces)]
        assert math.isclose(*both, rel_tol=1e-8) and both[0] > 0


@pytest.mark.parametrize("seed", seeds(range(3), 9))
def test_pushing_solves_for_the_accelerations(seed):
    draw = random.Random(seed)
    links = draw.randint(2, 9)
    e = equations(tree(draw, links, True))
    g = e.graph
    found = pushed(g, e.written, symbols(g, Kind.RATE, links), e.force)
    assert found is not None
    for _ in range(3):
        values = state(draw, links)
        M = np.array([evaluate(g, row, values) for row in e.mass])
        f = np.array(evaluate(g, e.force, values))
        a = np.array(evaluate(g, found.accelerations, values))
        assert abs(M @ a - f).max() < 1e-9 * max(1, abs(f).max()) and abs(f).max() > 1e-3
        d = evaluate(g, pivots(found), values)
        assert min(d) > 0 and math.isclose(np.prod(d), np.linalg.det(M), rel_tol=1e-8)


@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_of_many_links_that_no_kernel_has_m_of(seed, monkeypatch):
    """The accelerations by L alone; M, which proofs read, and f are those of all kernels."""
    draw = random.Random(200 + seed)
    links = draw.randint(22, 26)
    text = tree(draw, links, True, arm=True)
    read = equations(text, "mass", "force")
    monkeypatch.setattr(motion, "_looped", lambda n: 10**9)  # as of twice as many
    monkeypatch.setattr(motion, "solve", None)
    e = equations(text, "acceleration")
    for _ in range(2):
        values = state(draw, links)
        M, same = (np.array([evaluate(x.graph, row, values) for row in x.mass]) for x in (e, read))
        f, again = (np.array(evaluate(x.graph, x.force, values)) for x in (e, read))
        a = np.array(evaluate(e.graph, e.acceleration, values))
        assert abs(M - same).max() < 1e-10 * abs(M).max()
        assert abs(f - again).max() < 1e-9 * abs(f).max()
        assert abs(M @ a - f).max() < 1e-8 * abs(f).max() and abs(f).max() > 1
        d = evaluate(e.graph, pivots(e), values)
        assert min(d) > 0 and math.isclose(np.prod(d), np.linalg.det(M), rel_tol=1e-6)


def test_a_pivot_that_cancels_is_small_beside_its_size():
    """Where the middle one of three axes has turned the outer ones into line."""
    text = HEAD + "".join(f"coord q{k}\n" for k in (1, 2, 3, 4))
    chain = ["rot([0, 0, 1], q1)", "rot([0, 1, 0], q2)", "rot([0, 0, 1], q3)"]
    axes = ["[0, 0, 1]", f"{chain[0]}*[0, 1, 0]", f"{chain[0]}*{chain[1]}*[0, 0, 1]"]
    text += f"let w = q1'*{axes[0]} + q2'*{axes[1]} + q3'*{axes[2]}\n"
    text += "kinetic m*dot(w, w) + (q4' + q3')^2\npotential q2^2\n"
    e = equations(text)
    g = e.graph
    found = pushed(g, e.written, symbols(g, Kind.RATE, 4), e.force)
    values = state(random.Random(1), 4)

    def least() -> float:
        pairs = (evaluate(g, pair, values) for pair in found.pivots)
        return min(pivot / size for pivot, size in pairs)

    assert 1e-3 < least() < 1.1
    values[Symbol(Kind.COORDINATE, 1)] = 1e-9
    assert abs(least()) < 1e-15


def test_parameters_in_axes_and_fixed_angles_are_no_constants_of_derivatives_by_them():
    chain = "rot([0, 0, 1], q1)*rot([a, b, 1], q2)*rot([1, 0, 0], a)*rot([0, 1, 0], q3)"
    text = HEAD + "coord q1\ncoord q2\ncoord q3\n" + f"let d = {chain}*[1, 2, 3]\n"
    text += "kinetic q1'^2 + q2'^2 + q3'^2\npotential m*(d.x + d.y*d.z)\n"
    e = equations(text)
    g, by, mask = e.graph, Symbol(Kind.PARAMETER, 0), BIT[Kind.PARAMETER]
    assert g.frames.entries
    values = state(random.Random(3), 3)
    moved = [values | {by: values[by] + h} for h in (1e-5, -1e-5)]
    up, down = (evaluate(g, [e.potential], v)[0] for v in moved)
    slope = (up - down) / 2e-5
    symbol = g.symbol(by)
    ways = [
        gradient(g, e.potential, mask)[symbol],
        Columns(g, [e.potential], mask).column(symbol)[e.potential],
        Forward(g, mask, lambda node: ONE if node == symbol else ZERO)(e.potential),
    ]
    assert abs(slope) > 0.1
    assert evaluate(g, ways, values) == pytest.approx([slope] * 3, rel=1e-8)


def test_masses_may_depend_on_a_state():
    """What a pivot is small beside is then a function of the state too."""
    links = range(1, 15)
    text = "model arm\nstate s [1]\nrate s = -0.3*s\nstart s = 1\n"
    text += "".join(f"coord q{k}\n" for k in links) + "let p0 = [0, 0, 0]\n"
    chain = ""
    for k in links:
        chain += f"rot({AXES[k % 3]}, q{k})*"
        text += f"let p{k} = p{k - 1} + {chain}[0.1, 0, 0.3]\n"
        text += f"kinetic (1 + s^2)/2*dot(p{k}', p{k}') + q{k}'^2/10\npotential 9.81*p{k}.z\n"
    made = compile_model(Source("arm.lag", text), kernels=frozenset({"acceleration"}))
    known = made.program.equations.pivots
    g = made.program.equations.graph
    sizes = [size for _, size in known if g.depends[size] & BIT[Kind.RATE]]
    assert len(sizes) == 14 and not any(g.depends[x] & BIT[Kind.STATE] for x in sizes)
