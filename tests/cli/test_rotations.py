"""`rotation` at the command line: rows, options, members, reductions, what is refused."""

from __future__ import annotations

import math

from conftest import case, written

THROWN = case("thrown")


def test_rows_are_in_the_order_of_the_model(pkgen, tmp_path):
    path = written(tmp_path, THROWN)
    done = pkgen("run", path, "--until", "1", "--every", "1")
    header = done.stdout.splitlines()[0]
    assert header == ("t,x,R.w,R.x,R.y,R.z,z,x',omega(R).x,omega(R).y,omega(R).z,z',energy")
    record = pkgen("run", path, "--until", "1", "--every", "1", "--record", "R,omega(R).z,z'")
    assert record.stdout.splitlines()[0] == "t,R.w,R.x,R.y,R.z,omega(R).z,z'"
    assert done.stdout.splitlines()[1].startswith(f"0,0,{math.cos(0.15)!r},")
