"""Starts on constraints and off them: in the model and from options by the same rule."""

from __future__ import annotations

import re

import pytest

from conftest import ran, written

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


@pytest.mark.parametrize("text", [EARTH, WHEELS])
def test_rows_of_metres_and_of_radians_compare_by_their_inertia(tmp_path, text):
    ran("run", written(tmp_path, text), "--until", "1")


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


def test_the_nearest_start_on_the_constraints_can_be_pasted(pkgen, tmp_path):
    """And rows that follow from others there do not contradict these."""
    start = "start x = 0.1, z = -0.16, y' = 0.3\n"
    done = pkgen("check", written(tmp_path, BOWL + start))
    assert done.returncode == 1 and "contradicts" not in done.stderr, done.stderr
    near = re.search("the nearest start that holds: (start .*)", done.stderr)
    moved = BOWL + start + near[1] + "\n"
    done = ran("run", written(tmp_path, moved), "--until", "0.1")
