"""What `pkgen stability` says of one point: its class, and motions that leave."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from stability_asker import PENDULUM, asker, point, start

from pkgen.analysis.stability.ask import Asker


@pytest.fixture(scope="module")
def pendulum() -> Asker:
    return asker(PENDULUM)


def test_classes(pendulum: Asker) -> None:
    swing = start(pendulum, 1.0)
    assert point(swing, "verlet", 0.5).kind == "bounded"
    assert point(swing, "gauss2", 0.5).kind == "bounded"
    assert point(swing, "rk4", 0.5).kind == "drifting"
    assert point(swing, "euler", 0.1).kind == "growing"
    assert point(swing, "verlet", 2.3).kind == "growing"
    assert point(swing, "verlet", 2.5).kind == "growing"  # wanders up and down, high above
    # At y = 1.9 the energy of a start with a rate rises up to tenfold, and comes back.
    beat = point(start(pendulum, 0.0, 1e-3), "verlet", 1.9)
    assert beat.kind == "bounded" and 2 < beat.rise < 5
    fixed = replace(swing.settings, iteration="fixed")
    failed = point(swing.with_settings(fixed), "gauss1", 4.0)
    assert (failed.kind, failed.status) == ("not converged", "PK_NO_CONVERGENCE")


# At resonance the energy rises as t^2/8.
DRIVEN = "model driven\ncoord x\nkinetic x'^2/2\npotential x^2/2 - x*cos(t)\nstart x = 0\n"


def test_the_motion_is_known_for_as_long_as_a_point() -> None:
    driven = asker(DRIVEN, until=10.0)
    long = point(driven, "gauss4", 0.5)  # 200 steps, ten times `until`
    assert long.steps * 0.5 >= 100 and long.kind == "bounded"
    assert point(driven, "euler", 0.5).kind != "bounded"


def leaves(text: str, until: float = 10.0) -> bool:
    return asker(text, until=until).motion().leaves


def test_motions_that_leave(pendulum: Asker) -> None:
    line = "model m\ncoord x\nkinetic x'^2/2\npotential {}\nstart x = {}, x' = {}\n"
    assert leaves(line.format("-x^2/2", 1, 0))
    assert leaves(line.format("9.81*x", 1, 3))
    assert leaves(line.format("exp(-x^2)", 0.1, 0))  # a free flight in the end
    assert not leaves(DRIVEN, 100.0)  # it is compared with
    assert not leaves(line.format("x^2/2", 1, 0))
    assert leaves(line.format("x^2/2", 1, 0), 0.5)  # not back yet
    assert not pendulum.motion().leaves
    assert not start(pendulum, 0.0, 2.1).motion().leaves  # over the top, round and round
    hill = asker(line.format("-x^2/2", 1, 0), until=10.0)
    assert point(hill, "rk4", 0.5).kind == "not judged"
    assert point(hill, "gauss1", 2.5).kind == "wrong branch"  # the method's own all the same


def test_a_wrong_branch_upright(pendulum: Asker) -> None:
    # L14: the midpoint rule from rest upright has one solution for h omega <= 2 and three above.
    upright = start(pendulum, math.pi - 1e-9)
    assert point(upright, "gauss1", 1.99).kind == "bounded"
    for h in (2.01, 6.0):
        lost = point(upright, "gauss1", h)
        assert (lost.kind, lost.status) == ("wrong branch", "PK_AMBIGUOUS_STEP")
    assert point(upright, "gauss2", 2.01).kind != "wrong branch"


def test_what_grows_without_bound_is_not_finite() -> None:
    linear = asker("model spring\ncoord x\nkinetic x'^2/2\npotential x^2/2\nstart x = 1\n")
    grown = linear.with_settings(replace(linear.settings, until=5000.0))
    assert point(grown, "verlet", 2.2).kind == "not finite"
    assert point(grown, "verlet", 1.8).kind == "bounded"


def test_stable_at_999_growing_at_1001(pendulum: Asker) -> None:
    hanging = pendulum.at(pendulum.rest().equilibria[0])
    for method, y in (("verlet", 2.0), ("yoshida4", 1.5734019474), ("rk4", math.sqrt(8))):
        below, above = (
            hanging.near(method=method, h=y * x, mode=-1, amplitude=1e-6, count=4000)
            for x in (0.999, 1.001)
        )
        assert below.growth < 300 and below.status == "PK_DONE", method
        assert not above.growth < 1000, method
