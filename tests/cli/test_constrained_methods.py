"""Methods at one step on a constraint, against the angle that takes its place."""

from __future__ import annotations

import math

import pytest

from conftest import case, rows, written

ROD = case("constrained_methods_rod")
ANGLE = case("angle")
# Largest distance from the circle's x, y over a second: a few times what each errs by.
BOUNDS = {"rk4": 2e-6, "gauss4": 3e-13, "lobatto4": 1e-10, "radau5": 3e-9, "rattle4": 6e-7}


@pytest.mark.parametrize("method", BOUNDS)
def test_a_rod_by_a_step_is_its_angle(pkgen, tmp_path, method):
    common = ("--until", "1", "--every", "0.25")
    options = ("--method", method, "--step", "0.01")
    mine = rows(pkgen, written(tmp_path, ROD), *common, *options)
    exact = rows(pkgen, written(tmp_path, ANGLE), *common, "--method", "dop853", "--rtol", "1e-13")
    off = max(
        math.hypot(a["x"] - math.sin(b["a"]), a["y"] - math.cos(b["a"]))
        for a, b in zip(mine, exact, strict=True)
    )
    assert 0 < off < BOUNDS[method]


def test_rows_that_come_to_depend_on_each_other_are_passed(pkgen, tmp_path):
    """A four-bar parallelogram, whose bars lie on a line at t = pi/2, stays one."""
    text = (
        "model bars\ncoord x1, y1, x2, y2\nkinetic (x1'^2 + y1'^2 + x2'^2 + y2'^2)/2\n"
        "constraint a: x1^2 + y1^2 = 1\nconstraint b: (x2 - 2)^2 + y2^2 = 1\n"
        "constraint c: (x2 - x1)^2 + (y2 - y1)^2 = 4\n"
        "start x1 = 0, y1 = 1, x2 = 2, y2 = 1, x1' = 1, x2' = 1\n"
    )
    words = ("--method", "gauss", "--until", "2", "--every", "2")
    last = rows(pkgen, written(tmp_path, text), *words)[-1]
    places = [last[name] for name in ("x1", "y1", "x2", "y2")]
    turned = [math.sin(2), math.cos(2)]
    assert places == pytest.approx([*turned, 2 + turned[0], turned[1]], abs=1e-8)
