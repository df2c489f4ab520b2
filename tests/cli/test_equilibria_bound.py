"""Equilibria with rotations and constraints, their modes, and limits there: beside the same systems
in coordinates of their own, which have neither."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest
from stability_asker import asker, mapped

from conftest import case, seeds
from pkgen.analysis.chart.chart import methods
from pkgen.analysis.linear.rest import Rest
from pkgen.analysis.stability import measure
from pkgen.analysis.stability.ask import Asker
from pkgen.analysis.stability.method import StepMap
from pkgen.analysis.stability.predict import limit

ANGLE = case("equilibria_bound_angle")
ROD = case("equilibria_bound_rod")
SPHERE = case("equilibria_bound_sphere")
# A point of mass 1 at -l on the axis of a body without inertia of its own but what is next to none.
PIVOT = case("equilibria_bound_pivot")
WIRE = case("equilibria_bound_wire")
BEAD = case("equilibria_bound_bead")
# Steady circles: r is at rest, phi goes on with the momentum of the start.
CONE = case("equilibria_bound_cone")
BOWL = case("equilibria_bound_bowl")
FREE = case("equilibria_bound_free")


def rates(rest: Rest) -> list[list[tuple[float, float]]]:
    """Of each equilibrium what grows and turns, without what is neutral."""
    return [sorted((m.growth, m.frequency) for m in e.modes if m.rate > 0) for e in rest.equilibria]


def twice(of: list[list[tuple[float, float]]]) -> list[list[tuple[float, float]]]:
    """The same across."""
    return [sorted([*one, *one]) for one in of]


def same(a: list, b: list) -> None:
    assert len(a) == len(b) > 0
    for one, other in zip(a, b, strict=True):
        assert len(one) == len(other) > 0
        for x, y in zip(one, other, strict=True):
            assert x == pytest.approx(y, rel=1e-7, abs=1e-7)


@pytest.mark.parametrize("seed", seeds([1, 0, 2], 2))
def test_random_pendulums_rest_as_one_of_an_angle(seed: int) -> None:
    r = random.Random(seed)
    of = {"l": 10 ** r.uniform(-6, 3), "g": r.uniform(1, 20)}
    known = asker(ANGLE.format(**of)).rest()
    found = {x: asker(x.format(**of)).rest() for x in (ROD, SPHERE, PIVOT)}
    scale = math.sqrt(of["g"] / of["l"])
    unit = [[(g / scale, f / scale) for g, f in one] for one in rates(known)]
    for text, rest in found.items():
        own = [[(g / scale, f / scale) for g, f in one] for one in rates(rest)]
        same(own, unit if text == ROD else twice(unit))
        assert [e.energy for e in rest.equilibria] == pytest.approx(
            [e.energy for e in known.equilibria], rel=1e-9
        )
    ends = [e.q for e in found[ROD].equilibria]
    assert ends == [pytest.approx((0, k * of["l"]), abs=1e-9 * of["l"]) for k in (-1, 1)]
    # Only where it turns about the vertical is there a continuum.
    assert [[e.nullity for e in rest.equilibria] for rest in found.values()] == [
        [0, 0],
        [0, 0],
        [1, 1],
    ]


@pytest.mark.parametrize("seed", seeds([1, 0, 2], 2))
def test_random_beads_on_wires_rest_as_one_of_a_coordinate(seed: int) -> None:
    r = random.Random(seed)
    of = {k: round(r.uniform(*span), 3) for k, span in WELLS.items()}
    known, found = asker(WIRE.format(**of)).rest(), asker(BEAD.format(**of)).rest()
    same(rates(found), rates(known))
    assert len(known.equilibria) == 3
    assert [e.q[0] for e in found.equilibria] == pytest.approx([e.q[0] for e in known.equilibria])


WELLS = {"a": (0.3, 2), "b": (1, 3), "c": (-0.2, 0.2), "x": (0.2, 0.6)}


@pytest.mark.parametrize("seed", seeds([1, 0, 2], 2))
def test_what_goes_round_keeps_its_momentum(seed: int) -> None:
    r = random.Random(seed)
    of = {"k": r.uniform(0.3, 2), "r": r.uniform(0.5, 2), "w": r.uniform(1, 4)}
    known, found = asker(CONE.format(**of)).rest(), asker(BOWL.format(**of)).rest()
    # r^3 = (r^2 phi')^2/(g k); -r is the same circle, and the wall of the bowl ends at no r.
    at = ((of["r"] ** 2 * of["w"]) ** 2 / 9.81 / of["k"]) ** (1 / 3)
    here = [e for e in found.equilibria if e.q[0] > 0]
    there = [e for e in known.equilibria if e.q[0] > 0]
    assert [e.q[0] for e in here] == [pytest.approx(at)] == [e.q[0] for e in there]
    assert here[0].v[2] == pytest.approx(there[0].v[1])
    same(
        rates(replace(found, equilibria=tuple(here))),
        rates(replace(known, equilibria=tuple(there))),
    )


def test_a_free_body_rests_anywhere() -> None:
    for a in (1.0, 1.7):
        (e,) = asker(FREE.format(a=a)).rest().equilibria
        assert e.nullity == 3 and e.verdict == "one of a continuum" and not e.stable
        assert e.v[:3] == (0, 0, 0) and all(m.rate == 0 for m in e.modes)


def test_a_degenerate_place_is_no_continuum() -> None:
    text = (
        "model flat\ncoord x, y\nkinetic (x'^2 + y'^2)/2\npotential y\nstart x = 0.5, y = 0.0625\n"
    )
    (e,) = asker(text + "constraint wire: y = x^4\n").rest().equilibria
    assert e.nullity == 0 and e.verdict == "not decided by the linear terms"


@pytest.mark.parametrize("text", [ROD, SPHERE, PIVOT])
@pytest.mark.parametrize("method", ["rk4", "rattle"])
def test_limits_are_those_of_the_angle_and_are_met(text: str, method: str) -> None:
    of = {"l": 0.7, "g": 9.81}
    chosen = next(m for m in methods(None) if m.name == method)
    here: Asker = asker(text.format(**of))
    rest = here.rest()
    told = limit(StepMap(chosen, here, bound=True), 0, rest.equilibria[0])
    measured = measure.measured(here, rest, told, 0.3 * of["l"], 1e-6, bound=True)
    y = {"rk4": math.sqrt(8), "rattle": 2.0}[method]
    assert told.h == pytest.approx(y / math.sqrt(of["g"] / of["l"]), rel=1e-9)
    assert measured.h == pytest.approx(told.h, rel=0.01)


def test_a_map_is_about_the_equilibrium_that_a_start_at_rest_swings_about(tmp_path) -> None:
    words = ("--points", "6x3", "--methods", "rk4,rattle,gauss1")
    found = mapped(tmp_path, ROD.format(l=1, g=9.81), *words)
    assert found["varied"]["name"] == "amplitude" and found["primary"] == 0
    told = {(p["method"], p["kind"]): p for p in found["predictions"]}
    for key in (("rk4", "limit"), ("rattle", "limit"), ("gauss1", "branch")):
        assert told[key]["measured"] == pytest.approx(told[key]["h"], rel=0.01)
    # What a map shows: points of small motions grow beyond the limit, and below it they do not.
    small = [p for p in found["points"] if p["x"] == 0.5 and p["method"] == "rattle"]
    bound = told["rattle", "limit"]["h"]
    assert all((p["kind"] == "bounded") == (p["h"] < bound) for p in small)
    assert any("found 2, sought from 101" in said for said in found["remarks"])
    assert any("with constraints resonances, cycles" in said for said in found["remarks"])


def test_a_continuum_is_named(tmp_path) -> None:
    words = ("--points", "3x2", "--methods", "rk4", "--until", "20")
    found = mapped(tmp_path, PIVOT.format(l=1, g=9.81), *words)
    assert any("equilibria 1, 2 are each one of a continuum" in said for said in found["remarks"])
    assert any("R all around" in said for said in found["remarks"])
    assert [e["nullity"] for e in found["equilibria"]] == [1, 1]
