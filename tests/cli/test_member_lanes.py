"""Members whose steps are made side by side are what they are alone, to the bit: random members of
models of every kind, by methods of every family, with and without events, stops and switches."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import pkgen
from conftest import case, written

PENDULUM = case("twice")
LATTICE = case("lattice")
BALL = case("ball")
STEPS = case("stairs")
BEAD = case("bead")
DRIVEN = case("member_lanes_driven")
TOP = case("member_lanes_top")
FALL = case("member_lanes_fall")
FREE = PENDULUM.replace("event flip: b - 2 rising stop\n", "")  # without events that are asked
FIXED, LOOSE = {"step": 0.02}, {"rtol": 1e-7}
TWO = {"x": (-0.5, 0.5), "y": (-0.4, 0.4), "x'": (-0.4, 0.4), "y'": (-0.3, 0.3)}
DRAG = LATTICE + "dissipation (x' - 2*y')^2/8\n"
CASES = {
    "drag": (DRAG, TWO, FIXED, "yoshida4", None),
    "no events": (FREE, {"a": (-2, 2), "b": (-2, 2), "m2": (0.5, 2)}, LOOSE, "dop853", None),
    "dopri5": (FREE, {"a": (-2, 2), "b'": (-3, 3)}, LOOSE, "dopri5", None),
    "events": (PENDULUM, {"a": (-2, 2), "b": (-2, 2), "m2": (0.5, 2)}, FIXED, "rk4", "low"),
    "two events": (PENDULUM, {"a": (-1, 1), "b'": (-2, 2)}, FIXED, "rk3", "twin"),
    "dense events": (PENDULUM, {"a": (-2, 2), "b'": (-3, 3)}, LOOSE, "dop853", "low"),
    "section": (LATTICE, {**TWO, "e": (0.5, 1.2)}, FIXED, "yoshida4", "section"),
    "verlet": (LATTICE, TWO, FIXED, "verlet", "far"),
    "switches": (BALL, {"x": (0.1, 1), "y": (-1, 1), "k": (50, 400)}, FIXED, "rk4", "top"),
    "adaptive switches": (BALL, {"x": (0.1, 1), "y'": (-1, 1)}, LOOSE, "dopri5", "top"),
    "impulses": (STEPS, {"x": (0, 0.9), "x'": (-2, 2), "height": (0.2, 3)}, FIXED, "rk4", "middle"),
    "constraints": (BEAD, {"x'": (0.5, 4), "g": (5, 10)}, FIXED, "rk4", "bottom"),
    "adaptive constraints": (BEAD, {"x'": (0.5, 4)}, LOOSE, "dop853", None),
    "rotations": (TOP, {"g": (0.2, 3), "omega(R).x": (0.1, 3)}, FIXED, "rk4", "level"),
    "adaptive rotations": (TOP, {"g": (0.2, 3)}, LOOSE, "dop853", "level"),
    "poles": (FALL, {"x": (0.3, 2), "x'": (-0.3, 0.3), "k": (0.1, 2)}, FIXED, "rk4", "across"),
    "states": (DRIVEN, {"x": (-1, 1), "z": (-1, 1), "c": (0, 0.5)}, LOOSE, "dopri5", None),
    "states, events": (DRIVEN, {"x": (-1, 1), "c": (0, 0.5)}, FIXED, "rk4", "through"),
}


def rows(call: Callable[..., object], *given: object, **how: object) -> object:
    """Of a motion that ends as far as it goes."""
    try:
        return call(*given, **how)
    except pkgen.RunError as error:
        return error.result


MEMBERS = 75  # more than the lanes of a block, and no multiple of theirs


@pytest.mark.parametrize("name", CASES)
def test_members_are_what_they_are_alone(name: str, tmp_path: Path) -> None:
    text, ranges, steps, method, at = CASES[name]
    path = written(tmp_path, text + ("start y = -1\n" if text is BEAD else ""))
    rng = np.random.default_rng(2385)
    table = {of: rng.uniform(*span, MEMBERS) for of, span in ranges.items()}
    # Steps are no part of the rows' distance.
    options = {
        "until": 4.03,
        "method": method,
        "every": 0.25,
        **steps,
        **({"at": at} if at else {}),
    }
    model = pkgen.load(path)
    together = rows(model.ensemble, table, threads=2, **options)
    seen = 0
    for i in range(0, MEMBERS, 3):
        member = {of: float(column[i]) for of, column in table.items()}
        for of in [of for of in member if of in model.params]:
            model.params[of] = member.pop(of)
        alone = rows(model.run, start=member, **options)
        mine = together.member == i + 1
        assert np.array_equal(together.t[mine], alone.t)
        for column in alone:
            assert np.array_equal(together[column][mine], alone[column], equal_nan=True), column
        seen += len(alone)
    assert seen > MEMBERS
