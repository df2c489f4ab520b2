"""Fixed points of return maps: of a flow as by collocation, with impacts, of a walker."""

import math

import numpy
import pytest
from continued import VAN_DER_POL, found, kinds, loaded

from conftest import ROOT
from pkgen import UsageError

COMPASS = ROOT / "models/contact/compass_gait.lag"
STEP = {"section": "step_a", "close": "b0=a,w0=a',a=b,a'=b'"}
BALL = """
model driven_ball                  # between impacts with a table that shakes
param g = 1
param e = 0.5
param A = 0.3
coord y
kinetic y'^2/2
potential g*y
event hit: y falling then y' = -e*y' + (1 + e)*A
start y = 0, y' = 1
"""


def test_a_return_map_has_the_orbit_of_collocation(tmp_path) -> None:
    """The map between crossings has the period and the multipliers that collocation finds."""
    (orbit,) = found(VAN_DER_POL, tmp_path, "mu", 0.8, 1.2, orbit="start").branches
    (branch,) = found(VAN_DER_POL, tmp_path, "mu", 0.8, 1.2, section="right").branches
    for k in (0, -1):
        a, b = orbit.points[k], branch.points[k]
        assert abs(a.value - b.value) < 1e-9 and abs(a.period - b.period) < 1e-9
        values = sorted(map(abs, b.values))
        assert values[1] == pytest.approx(abs(a.values[0]), abs=1e-7)


def test_a_ball_that_bounces_the_same_again(tmp_path) -> None:
    """v = e v + (1 + e) A, and a flight takes 2 v/g; the multiplier is e."""
    (branch,) = found(BALL, tmp_path, "A", 0.2, 0.6, section="hit").branches
    for p in branch.points:
        v = (1 + 0.5) * p.value / (1 - 0.5)
        assert p.period == pytest.approx(2 * v, abs=1e-8)
        assert max(map(abs, p.values)) == pytest.approx(0.5, abs=1e-6) and p.stable


@pytest.mark.long
def test_the_compass_walks_and_limps(tmp_path) -> None:
    """Goswami, Thuilot and Espiau (1998): on 3 degrees a step takes 0.734 s. Where the period is
    doubled, plain runs take steps that are alike below the slope, and not above it."""
    made = found(COMPASS, tmp_path, "slope", math.radians(2.9), math.radians(4.5), **STEP)
    assert kinds(made) == ["period doubling"]
    near = min(made.branches[0].points, key=lambda p: abs(p.value - math.radians(3)))
    assert abs(near.value - math.radians(3)) < 1e-9 and abs(near.period - 0.734) < 5e-4
    (point,) = made.special
    assert made.branches[1].points[-1].period == pytest.approx(2 * point.period, rel=5e-3)
    model, apart = loaded(COMPASS, tmp_path), []
    for slope in (point.value - math.radians(0.04), point.value + math.radians(0.04)):
        start = made.branches[0].points[-1].start
        for name, value in {**start["set"], "slope": slope}.items():
            model.params[name] = value
        how = {"start": start["start"], "method": "gauss", "rtol": 1e-11, "record": "stride"}
        long, short = (model.run(200, at=event, **how) for event in ("step_a", "step_b"))
        apart.append(abs(abs(long["stride"][-1]) - abs(short["stride"][-1])))
    assert apart[0] < 1e-3 < 1e-2 < apart[1]


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"section": "hits"}, "hit"),
        ({"section": "hit", "close": "z"}, "z"),
        ({"section": "hit", "close": "y=z"}, "z"),
        ({"section": "hit", "orbit": "start"}, "without --orbit|without orbit="),
    ],
)
def test_sections_that_are_not_there_are_refused(more, said, tmp_path) -> None:
    with pytest.raises(UsageError, match=said):
        found(BALL, tmp_path, "A", 0.2, 0.6, **more)


def test_motions_that_do_not_return_are_refused(tmp_path) -> None:
    model = BALL.replace("then y' = -e*y' + (1 + e)*A", "stop").replace("param e = 0.5\n", "")
    with pytest.raises(UsageError, match="does not happen three times"):
        found(model.replace("param A = 0.3\n", ""), tmp_path, "g", 0.5, 1.5, section="hit")


def test_parameters_without_influence_on_a_return_are_refused(tmp_path) -> None:
    model = BALL + "param idle = 1\nobserve twice = 2*idle\n"
    with pytest.raises(UsageError, match="the motion does not depend on it"):
        found(model, tmp_path, "idle", 0.2, 0.6, section="hit")
    assert numpy.isfinite(loaded(BALL, tmp_path).run(1, every=0.5)["y"]).all()
