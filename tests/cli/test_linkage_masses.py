"""Linkages in maximal coordinates against angles, whatever their masses and lengths are."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import numpy
import pytest
from linkages import Linkage, linkage

import pkgen
from conftest import ROOT, rows, seeds, written

ADAPTIVE = ("gauss", "dop853", "dopri5", "radau", "gsl_rk8pd", "gsl_msadams")
FIXED = ("rk4", "gauss2", "lobatto3", "radau5", "rattle", "rkmk4")
RTOL = 1e-9
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


def _loaded(folder: Path, text: str) -> pkgen.Model:
    return pkgen.load(written(folder, text))


def _apart(of: Linkage, maximal: pkgen.Result, minimal: pkgen.Result) -> float:
    """The largest difference of an angle at the end."""
    return max(abs(maximal[f"r{k}"][-1] - minimal[rod.angle][-1]) for k, rod in enumerate(of.rods))


# Those from 43 on once found an error.
@pytest.mark.parametrize("seed", seeds([1, 0, 2], 17, [43, 71, 76, 96]))
def test_random_linkages_are_their_angles(tmp_path, seed):
    of = linkage(seed)
    minimal, maximal = _loaded(tmp_path, of.minimal), _loaded(tmp_path, of.maximal)
    exact = minimal.run(of.time, every=of.time / 200, method="dop853", rtol=1e-13)
    flat = _lies_flat(of, exact)
    adaptive = ADAPTIVE if seed > 2 else ADAPTIVE[seed : seed + 1]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for method in adaptive:
            found = _run(maximal, of, flat, method=method, rtol=RTOL)
            if found is None:
                continue
            lost = sys.float_info.epsilon * found.report["condition"]["constraints"]["cond"]
            beside = minimal.run(of.time, every=of.time, method=method, rtol=RTOL)
            allowed = max(100 * RTOL, 10 * _apart_minimal(of, beside, exact), 100 * lost)
            assert _apart(of, found, exact) < allowed, method
        if seed <= 2:
            return
        for method in FIXED:
            step = of.time / 200
            found = _run(maximal, of, flat, method=method, step=step)
            if found is None:
                continue
            beside = minimal.run(of.time, every=of.time, method=method, step=step)
            lost = sys.float_info.epsilon * found.report["condition"]["constraints"]["cond"]
            allowed = 100 * max(_apart_minimal(of, beside, exact), 1e-9, lost)
            assert _apart(of, found, exact) < allowed, method


def _lies_flat(of: Linkage, exact: pkgen.Result) -> bool:
    """Whether the rows of a parallelogram depend on each other at an instant of the motion."""
    sines = [numpy.sin(exact[a] - exact[b]) for a, b in of.sharpest]
    return any((x[1:] * x[:-1] < 0).any() for x in sines)


def _run(model: pkgen.Model, of: Linkage, flat: bool, **how) -> pkgen.Result | None:
    """None where it ends at a place where branches meet."""
    try:
        return model.run(of.time, every=of.time, **how)
    except pkgen.RunError as ended:
        assert flat and "last valid time" in str(ended), how
        return None


def _apart_minimal(of: Linkage, found: pkgen.Result, exact: pkgen.Result) -> float:
    return max(abs(found[rod.angle][-1] - exact[rod.angle][-1]) for rod in of.rods)
