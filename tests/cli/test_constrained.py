"""`constraint` and `rolling` at the command line: what is kept, ended, tied and refused."""

from __future__ import annotations

import re

from conftest import ROOT, ran, written


def test_where_constraints_come_to_depend_on_each_other_the_run_ends(pkgen, tmp_path):
    """A point on a plane that is lowered onto the top of a sphere: there both say the same."""
    path = written(
        tmp_path,
        "model pinched\ncoord x, y, z\nkinetic (x'^2 + y'^2 + z'^2)/2\n"
        "constraint sphere: x^2 + y^2 + z^2 = 1\nconstraint plane: z = t\n"
        "start x = 1, z' = 1, y' = 0.5\n",
    )
    for method in ("gauss", "dop853", "rk4", "rattle"):
        options = () if method in ("gauss", "dop853") else ("--step", "0.001")
        done = pkgen("run", path, "--until", "3", "--method", method, *options)
        assert done.returncode == 4, method
        valid = re.search(r"last valid time ([0-9.]+)", done.stderr)
        assert 0.9 < float(valid[1]) <= 1.001, done.stderr
        if method in ("gauss", "rk4"):
            assert re.search(
                "the constraints cannot be fulfilled here: (plane depends on sphere|"
                "at t = (1|1.0000[0-9]+|0.9999[0-9]+) plane ends or depends on others, "
                "and behind it the branch of the motion cannot)",
                done.stderr,
            )


def test_a_turning_point_of_all_rates_but_a_spin():
    """The row of the pivots hardly has the fast spin, and is rounded by it: no failure."""
    path = ROOT / "models" / "constrained" / "gimbals.lag"
    ran("run", path, "--scene", "nutates", "--set", "turn=0")
