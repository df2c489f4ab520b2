"""`body` and `joint`: trees against Newton's and Euler's equations, each kind of joint beside the
same model by hand, names, places."""

from __future__ import annotations

import random

import numpy as np
import pytest
from conftest import long_but
from pkgen.front.check.check import check_text
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Kind, Symbol
from pkgen.middle.derive.derive import derive
from pkgen.source import Source
from trees_of_bodies import FREEDOMS, KINDS, Motion, random_tree, written


def model_of(text: str):
    return check_text(Source("tree.lag", text))[0]


def warnings_of(text: str):
    return check_text(Source("tree.lag", text))[1]


def state_of(model, draw: random.Random) -> tuple[dict, dict, dict]:
    """Values by symbol; values and rates by name, rotations as wholes."""
    symbols, values, rates = {Symbol(Kind.TIME, 0): 0.4}, {}, {}
    for i, c in enumerate(model.coordinates):
        rate = draw.uniform(-2, 2)
        symbols[Symbol(Kind.RATE, i)] = rate
        symbols[Symbol(Kind.COORDINATE, i)] = values[c.name] = draw.uniform(-2, 2)
        rates[c.name] = rate
    numbers = [s.name for s in model.states]
    for r in model.rotations:
        q = np.array([draw.gauss(0, 1) for _ in range(4)])
        values[r.name] = q / np.linalg.norm(q)
        rates[r.name] = np.array([rates[turn] for turn in r.turns])
        for number, x in zip(r.quaternion, values[r.name], strict=True):
            symbols[Symbol(Kind.STATE, numbers.index(number))] = x
    return symbols, values, rates


def compared(links, text: str, draw: random.Random) -> None:
    model = model_of(text)
    e = derive(model)
    n = sum(FREEDOMS[b.kind] for b in links)
    assert len(model.coordinates) == n
    for _ in range(2):
        symbols, values, rates = state_of(model, draw)
        motion = Motion(links, values, rates)
        names = [c.name for c in model.coordinates]
        turns = {r.name: r.turns for r in model.rotations}
        order = [
            names.index(which if isinstance(which, str) else turns[b.rotation][which])
            for b, which in motion.speeds
        ]
        found = np.array(evaluate(e.graph, e.acceleration[:n], symbols))[order]
        wanted = motion.accelerations()
        assert abs(found - wanted).max() < 1e-10 * max(1, abs(wanted).max())
        assert n == 1 or abs(wanted).max() > 1e-3
        (energy,) = evaluate(e.graph, [e.energy], symbols)
        assert energy == pytest.approx(motion.energy(), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("seed", long_but(range(14), range(60)))
def test_random_trees_move_as_newton_and_euler_say(seed):
    draw = random.Random(seed)
    kinds = [draw.choice(KINDS) for _ in range(draw.randint(1, 5))]
    if not any(FREEDOMS[k] for k in kinds):
        kinds.append("revolute")
    links = random_tree(draw, kinds)
    compared(links, written(links, draw), draw)


@pytest.mark.parametrize("kind", [k for k in KINDS if FREEDOMS[k]])
@pytest.mark.parametrize("chained", [False, True])
def test_each_kind_alone_and_on_a_turning_body(kind, chained):
    draw = random.Random(kind + str(chained))
    links = random_tree(draw, ["revolute", kind] if chained else [kind])
    links[-1].parent = len(links) - 2
    compared(links, written(links, draw), draw)
