"""Starts on constraints and off them: in the model and from options by the same rule."""

from __future__ import annotations

import re

import pytest

from conftest import ran, written

UNITS = "kinetic (1 [kg])/2*x'^2 + (1 [kg*m^2])/2*(a'^2 + b'^2)\n"
SUM = "model sum_\ncoord x [m], a [rad], b [rad]\n" + UNITS + "constraint c: a + b = 0.5\n"
ROLL = "model roll\ncoord x, a, b\nkinetic (x'^2 + a'^2 + b'^2)/2\nrolling c: a' + b' = 0\n"
CART = """\
model cart
coord X, x, y
kinetic 1000*X'^2/2 + (x'^2 + y'^2)/2
constraint rod: (x - X)^2 + y^2 = 1
"""
TINY = """\
model tiny
param l = 1e-8 [m]
coord x, y [m]
kinetic (1e-18 [kg])/2*(x'^2 + y'^2)
constraint rod: x^2 + y^2 = l^2
"""
BODY = """\
model body
coord x, a
rotation R
kinetic (x'^2 + a'^2 + dot(omega(R), omega(R)))/2
constraint c: (R*[1, 0, 0]).y = a
"""
FAR = """\
model far
param A = 300
param B = 412.3
param C = 509.8934104300623
coord x, y
kinetic (x'^2 + y'^2)/2
potential y
constraint c: (A + x)^2 + (B + y)^2 = C^2
"""
TIMED = """\
model timed
coord x, y
kinetic (x'^2 + y'^2)/2
rolling c: x' + y' = 1000.1*sin(0.3 + t) - 295.5497586821
"""
PLAIN = "model plain\ncoord x, y\nkinetic (x'^2 + y'^2)/2\n"
SLOPE = PLAIN + "constraint c: y = 0.3 + 1e-10*x\n"
CIRCLE = PLAIN + "constraint c: x^2 + y^2 = 1\n"
# A start on the constraints; others, and by how much they are off: None where they are not.
STARTS = [
    (SUM, {"a": 0.5}, {"x": 1e9, "a": 0.1}, "-0.4"),
    (SUM, {"a": 0.5}, {"x": 1e5, "a": 0.4995}, "-0.0005"),
    (SUM, {"a": 0.5}, {"x": 1e9, "a": 0.5 + 1e-9}, None),
    (ROLL, {}, {"x'": 1e6, "a'": 0.005}, "0.005"),
    (ROLL, {}, {"x'": 1e6, "a'": 1e-11}, None),
    (CART, {"x": 1}, {"X": 100, "x": 100, "y": -1.00002}, "4e-05"),
    (CART, {"x": 1}, {"X": 100, "x": 100.6, "y": -0.8}, None),
    (TINY, {"x": 1e-8}, {"x": 3e-8}, "8e-16"),
    (TINY, {"x": 1e-8}, {"x": 1.00001e-8}, "e-21"),
    (TINY, {"x": 1e-8}, {"x": 0.6e-8, "y": 0.8e-8}, None),
    (TINY, {"x": 1e-8}, {"x'": 3e-8}, "6e-16"),
    (BODY, {}, {"x": 1e4, "a": 1e-6}, "-1e-06"),
    (FAR, {}, {}, None),
    (FAR, {}, {"x": 0.001}, "0.6"),
    (TIMED, {}, {}, None),
    (TIMED, {}, {"x'": 1e-3}, "0.001"),
    (SLOPE, {"y": 0.3}, {"x": 1e-3, "y": 0.3}, None),
    (CIRCLE, {"x": 1}, {"x": 0.6, "y": 0.800000003}, None),
    (CIRCLE, {"x": 1}, {"x": 0.6, "y": 0.80000003}, "4.8e-08"),
]


@pytest.mark.parametrize("where", ["in the model", "from options"])
@pytest.mark.parametrize(("text", "right", "start", "off"), STARTS)
def test_a_start_is_on_the_constraints_or_refused(pkgen, tmp_path, where, text, right, start, off):
    options, given = [], right | start
    if where == "from options":
        options = [o for name, x in start.items() for o in ("--start", f"{name}={x!r}")]
        given = right
    text += "".join(f"start {name} = {x!r}\n" for name, x in given.items())
    done = pkgen("run", written(tmp_path, text), "--until", "0.001", *options)
    if off is None:
        assert done.returncode == 0, done.stderr
    else:
        assert done.returncode == (4 if options else 1), done.stderr
        assert "the start breaks " in done.stderr and off in done.stderr, done.stderr


EARTH = """\
model earth
param m = 1 [kg]
param R = 1.5e11 [m]
coord a [rad], x, y [m]
kinetic m/2*(x'^2 + y'^2 + R^2*a'^2)
constraint p: x = R*a
constraint q: x + y = R*a
"""
WHEELS = """\
model wheels
param m = 1e-20 [kg]
param a = 1e-10 [m]
coord x [m], th, ph [rad]
kinetic m/2*(x'^2 + a^2*(th'^2 + ph'^2))
rolling r: x' = a*th'
rolling s: x' = 2*a*ph'
"""
NEARLY = PLAIN + "param k = 1e-8\nconstraint a: x = 0\nconstraint b: k*y + x = 0\n"


@pytest.mark.parametrize("text", [EARTH, WHEELS])
def test_rows_of_metres_and_of_radians_compare_by_their_inertia(tmp_path, text):
    ran("run", written(tmp_path, text), "--until", "1")


@pytest.mark.parametrize(("k", "code"), [("1e-5", 0), ("1e-9", 4)])
def test_rows_that_inertia_alone_makes_one_are_told_so(pkgen, tmp_path, k, code):
    """In another unit of y they are as far apart as x and y."""
    done = pkgen("run", written(tmp_path, NEARLY + "potential y\n"), "--until", "1")
    assert done.returncode == 4 and "beside a the multiplier of b loses" in done.stderr
    done = pkgen("run", written(tmp_path, NEARLY.replace("1e-8", "1e-5")), "--set", f"k={k}")
    assert done.returncode == code, done.stderr
    assert code == 0 or "beside a the multiplier of b loses" in done.stderr


BOWL = """\
model bowl
param W = 2
coord x, y, z
rotation Q
let n = [x, y, z]/0.19
let w = Q*omega(Q)
kinetic dot([x', y', z'], [x', y', z'])/2 + 2e-5*dot(w, w)
potential 9.81*z
constraint bowl: x^2 + y^2 + z^2 = 0.19^2
rolling noslip: [x', y', z'] + cross(w, n)/100 = cross([0, 0, W], [x, y, z] + n/100)
"""
DISK = """\
model disk
coord x, a
kinetic (x'^2 + a'^2)/2
rolling c: [x', 0, 0] + cross([0, a', 0], [0, 0, -1]) = [0, cos(a)^2 + sin(a)^2 - 1, 0]
start x' = 1, a' = 1
"""


def test_the_nearest_start_on_the_constraints_can_be_pasted(pkgen, tmp_path):
    """And rows that follow from others there do not contradict these."""
    start = "start x = 0.1, z = -0.16, y' = 0.3\n"
    done = pkgen("check", written(tmp_path, BOWL + start))
    assert done.returncode == 1 and "contradicts" not in done.stderr, done.stderr
    near = re.search("the nearest start that holds: (start .*)", done.stderr)
    moved = BOWL + start + near[1] + "\n"
    done = ran("run", written(tmp_path, moved), "--until", "0.1")


def test_a_row_that_vanishes_is_left_out_and_said(tmp_path):
    done = ran("run", written(tmp_path, DISK), "--until", "1", "--every", "1")
    assert "'c.z' is 0 = 0 at every motion: it is left out" in done.stderr
