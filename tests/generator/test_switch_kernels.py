"""Switches of the equations: which there are, and what the kernels are with their sides given."""

import ctypes
import itertools
import random

import pytest
from c_harness import Loaded, read_text

from conftest import case
from pkgen.back.c import render
from pkgen.front.check import check
from pkgen.middle.analyze import analyze
from pkgen.middle.derive import derive
from pkgen.source import Source

KINKS = case("kinks")
NAMES = ["x", "x - y", "x'", "c - sin(t)"]


def loaded(tmp_path) -> Loaded:
    _, program = read_text(KINKS)
    return Loaded(program, tmp_path)


def expected(sides: tuple[int, ...], k: float, c: float, t: float, x, y, v) -> list[float]:
    """The accelerations, branch by branch."""
    import math

    values = [x, x - y, v, c - math.sin(t)]
    on = [(s or (1 if value >= 0 else -1)) > 0 for s, value in zip(sides, values, strict=True)]
    low = y if on[1] else x
    a_x = -k * (1 if on[0] else -1) - (0 if on[1] else k * low)
    a_x += -c * v * (v if on[2] else -v) + (c if on[3] else math.sin(t)) + (0 if on[0] else 1)
    return [a_x, -(k * low if on[1] else 0) - (y if on[0] else 0)]


def test_there_is_one_for_each_argument(tmp_path) -> None:
    equations, program = read_text(KINKS)
    assert sorted(s.quantity.name for s in equations.switches) == sorted(NAMES)
    assert program.structure.switched and not program.structure.smooth
    model, _ = check.check_text(
        Source(
            "m.lag",
            "model m\nparam c = 1\ncoord x\nkinetic x'^2/2\n"
            "force x = abs(c)\nobserve up = step(x)\n",
        )
    )
    found = derive.derive(model)
    assert not found.switches and analyze.analyze(found).smooth  # nothing that moves
    smooth = render.render(read_text("model m\ncoord x\nkinetic x'^2/2\n")[1])
    assert not any("side_" in text or "switching" in text for text in smooth.values())


def test_kernels_are_smooth_on_each_side(tmp_path) -> None:
    c = loaded(tmp_path)
    names = [s.quantity.name for s in c.program.equations.switches]
    order = [names.index(name) for name in NAMES]
    rng = random.Random(7)
    first = len(c.params) - len(NAMES)
    lanes = c.function("lanes", ctypes.c_ulonglong)
    members = c.function("members", ctypes.c_ulonglong)
    for sides in itertools.product((0, 1, -1), repeat=4):
        t, x, y, v = (rng.uniform(-2, 2) for _ in range(4))
        for place, side in zip(order, sides, strict=True):
            c.params[first + place] = side
        wanted = expected(sides, 1.3, 0.4, t, x, y, v)
        q, rates = [x, y], [v, 0.1]
        assert c.call("acceleration", t, q, rates)[1][0] == pytest.approx(wanted, abs=1e-14)
        given = c.call("canonical", t, q, rates)[1][1]
        assert given == pytest.approx(wanted, abs=1e-14)
        side_by_side = [(ctypes.c_double * 16)(*([z[0]] * 8 + [z[1]] * 8)) for z in (q, rates)]
        times, found = (ctypes.c_double * 8)(*[t] * 8), (ctypes.c_double * 16)()
        u = (ctypes.c_double * 8)()
        lanes(c.params, times, *side_by_side, u, found)
        assert [found[3], found[11]] == pytest.approx(wanted, abs=1e-14)
        each = (ctypes.c_double * (8 * len(c.params)))(*[p for p in c.params for _ in range(8)])
        members(each, times, *side_by_side, u, found)
        assert [found[5], found[13]] == pytest.approx(wanted, abs=1e-14)
    values = c.call("switching", t, q, rates)[1][0]
    by_hand = {"x": x, "x - y": x - y, "x'": v}
    for name, value in by_hand.items():
        assert values[names.index(name)] == pytest.approx(value)
