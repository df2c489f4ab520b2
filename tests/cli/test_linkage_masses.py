"""Linkages in maximal coordinates against angles, whatever their masses and lengths are."""

from __future__ import annotations

import pytest

from conftest import ROOT, rows

# The reference values come from the same pendulums in angles.
CASES = [
    ("light_rod", "mr=0.4", 3, "xb", 1.9300871486497477),
    ("light_rod", "mr=0.1", 3, "xb", 1.9171395568094765),
    ("light_rod", "mr=1e-3", 3, "xb", 1.9123629636496637),
    ("dp_cart", "m1=0.01", 2, "x2", -0.2534713358844),
]


@pytest.mark.parametrize("method", ["gauss", "dop853", "dopri5", "radau"])
@pytest.mark.parametrize(("name", "mass", "until", "column", "value"), CASES)
def test_light_bodies_among_heavy_ones(pkgen, name, mass, until, column, value, method):
    words = ("--until", until, "--every", until, "--set", mass, "--method", method)
    model = ROOT / "tests" / "cases" / f"{name}.lag"
    last = rows(pkgen, model, *words)[-1]
    assert last[column] == pytest.approx(value, rel=3e-8)
