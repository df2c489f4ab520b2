"""Starts on constraints and off them: in the model and from options by the same rule."""

from __future__ import annotations

import re

from conftest import case, ran, written

BOWL = case("bowl")


def test_the_nearest_start_on_the_constraints_can_be_pasted(pkgen, tmp_path):
    """And rows that follow from others there do not contradict these."""
    start = "start x = 0.1, z = -0.16, y' = 0.3\n"
    done = pkgen("check", written(tmp_path, BOWL + start))
    assert done.returncode == 1 and "contradicts" not in done.stderr, done.stderr
    near = re.search("the nearest start that holds: (start .*)", done.stderr)
    moved = BOWL + start + near[1] + "\n"
    done = ran("run", written(tmp_path, moved), "--until", "0.1")
