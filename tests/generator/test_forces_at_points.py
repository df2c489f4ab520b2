"""`force` at a point and `torque` in space: bodies against Kane's sums in NumPy, points against the
same forces along coordinates by SymPy."""

import random

import numpy as np
import pytest
import sympy as sp
from random_states import state_of
from trees_of_bodies import FREEDOMS, KINDS, Motion, random_tree, vector, written

from conftest import seeds
from pkgen.front.check.check import check_text
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Kind, Symbol
from pkgen.middle.derive.derive import derive
from pkgen.source import Source


def equations(text: str):
    model = check_text(Source("loads.lag", text))[0]
    return model, derive(model)


class Load:
    """A drag and a constant force at a point of a body, or a torque on it."""

    def __init__(self, draw: random.Random, links, k: int):
        self.body = draw.randrange(len(links))
        self.name = links[self.body].name
        self.turns = draw.random() < 0.4
        self.at = np.array([draw.uniform(-1, 1) for _ in range(3)])
        self.constant = np.array([draw.uniform(-3, 3) for _ in range(3)])
        self.drag = draw.uniform(0.1, 1)
        if draw.random() < 0.3:
            self.at = links[self.body].com
        self.k = k

    def text(self, draw: random.Random) -> str:
        named = draw.random() < 0.5
        if self.turns:
            value = f"{vector(self.constant)} - {self.drag:.17g}*({self.name}.R*{self.name}.omega)"
            on = f"twist{self.k} at {self.name}" if named else self.name
            return f"torque {on} = {value}\n"
        place = f"{self.name}.point({vector(self.at)})"
        value = f"{vector(self.constant)} - {self.drag:.17g}*{place}'"
        return f"force {f'pull{self.k} at {place}' if named else place} = {value}\n"

    def velocity(self, links, moved) -> np.ndarray:
        R, _, w, v = moved[self.body][:4]
        return w if self.turns else v + np.cross(w, R @ (self.at - links[self.body].com))

    def along(self, links, motion) -> np.ndarray:
        now = motion.passed(motion.rates, False)
        force = self.constant - self.drag * self.velocity(links, now)
        ones = [self.velocity(links, motion.one(speed)) for speed in motion.speeds]
        return np.array(ones) @ force


@pytest.mark.parametrize("seed", seeds(range(3), 57))
def test_random_trees_are_pushed_as_kane_says(seed: int) -> None:
    draw = random.Random(seed)
    kinds = [draw.choice(KINDS) for _ in range(draw.randint(1, 4))]
    if FREEDOMS[kinds[0]] == 0:
        kinds[0] = "spherical"
    links = random_tree(draw, kinds)
    links[0].parent = -1
    loads = [Load(draw, [b for b in links], k) for k in range(draw.randint(1, 4))]
    loads = [x for x in loads if _moves(links, x.body)]
    text = written(links, draw, shuffled=False) + "".join(x.text(draw) for x in loads)
    model, e = equations(text)
    symbols, values, rates = state_of(model, draw)
    motion = Motion(links, values, rates)
    order = motion.order(model)
    found = np.array(evaluate(e.graph, e.acceleration[: len(order)], symbols))[order]
    force = sum((x.along(links, motion) for x in loads), np.zeros(len(order)))
    wanted = motion.accelerations(force=force)
    assert abs(found - wanted).max() < 1e-10 * max(1, abs(wanted).max())
    assert not loads or abs(wanted - motion.accelerations()).max() > 1e-6


def _moves(links, k: int) -> bool:
    while k >= 0:
        if FREEDOMS[links[k].kind]:
            return True
        k = links[k].parent
    return False


GIVEN = {Symbol(Kind.PARAMETER, 0): 0.7} | {Symbol(Kind.INPUT, k): 0.3 + k for k in range(3)}


def _term(draw: random.Random, names) -> str:
    a, b = draw.choice(names), draw.choice(names)
    c = round(draw.uniform(0.2, 2), 2)
    return draw.choice(
        (f"{c}*sin({a})", f"{a}*cos({b})", f"{c}*{a}*{b}", f"exp(-{c}*{a}^2)", f"u*{a}")
    )


@pytest.mark.parametrize("seed", seeds(range(100, 103), 57))
def test_a_force_at_a_point_is_that_along_the_coordinates(seed: int) -> None:
    draw = random.Random(seed)
    names = ["a", "b", "c"][: draw.randint(1, 3)]
    place = [" + ".join(_term(draw, [*names, "t"]) for _ in range(2)) for _ in range(3)]
    pull = [f"{draw.uniform(-1, 1):.3f}*P.{x}' - k*{draw.choice(names)}" for x in "xyz"]
    squares = " + ".join(f"{name}'^2" for name in names)
    head = (
        f"model m\nparam k = 0.7\ninput u\ncoord {', '.join(names)}\n"
        f"kinetic {squares} + a'*sin(a)*{names[-1]}'/3\n"
        f"let P = [{', '.join(place)}]\n"
    )
    tied = draw.choice(("", f"rolling r: a'*cos({names[-1]}) + {names[-1]}' = u\n", ""))
    by_point = head + f"force P = [{', '.join(pull)}]\n" + tied
    forces = [
        f"force {x} = "
        + " + ".join(
            f"({f})*({sp.sstr(sp.diff(sp.sympify(p.replace('^', '**')), x)).replace('**', '^')})"
            for f, p in zip(pull, place, strict=True)
        )
        for x in names
    ]
    rows = []
    for text in (by_point, head + "\n".join(forces) + "\n" + tied):
        model, e = equations(text)
        symbols = state_of(model, random.Random(seed))[0] | GIVEN
        rows.append(evaluate(e.graph, e.acceleration, symbols))
    assert rows[0] == pytest.approx(rows[1], rel=1e-11, abs=1e-12)
    assert max(map(abs, rows[0])) > 1e-3
