"""A function of the language is one row: erf, added to the table alone, passes every stage.

Its values are compared with those of Python, its motion with that of SciPy.
"""

from __future__ import annotations

import re
import subprocess
import sys
from math import erf, exp, pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from conftest import case

WITH_ERF = '''
import math, sys
from fractions import Fraction
from pkgen.functions import FUNCTIONS, Function
from pkgen.functions.interval import UNIT

def slope(g, n, x):
    """2/sqrt(pi) exp(-x^2)"""
    root = g.call("sqrt", g.pi())
    bell = g.call("exp", g.negate(g.power(x, 2)))
    return (g.multiply(g.divide(g.number(2), root), bell),)

FUNCTIONS["erf"] = Function(
    real=math.erf,
    array=lambda np, x: np.vectorize(math.erf)(x),
    exact=lambda x: Fraction(0) if x == 0 else None,
    derivative=slope,
    parity="odd",
    interval=lambda x: UNIT,
    ball=lambda b, x: b.slope(b.mp.erf, x, 2),
    like_argument=True,
    short=6,
)
from pkgen.__main__ import main
sys.exit(main(sys.argv[1:]))
'''

MODEL = case("well")


@pytest.fixture
def pkgen_with_erf(tmp_path: Path):
    (tmp_path / "with_erf.py").write_text(WITH_ERF)
    (tmp_path / "well.lag").write_text(MODEL)

    def run(*args: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "with_erf.py", *map(str, args)]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)

    return run


def test_without_the_row_it_is_no_function(pkgen, tmp_path: Path) -> None:
    (tmp_path / "well.lag").write_text(MODEL)
    done = pkgen("check", tmp_path / "well.lag")
    assert done.returncode == 1 and "unknown function 'erf'" in done.stderr


def test_it_is_checked_proved_explained_and_compiled(pkgen_with_erf, tmp_path: Path) -> None:
    checked = pkgen_with_erf("check", "well.lag")
    assert checked.returncode == 0, checked.stderr
    explained = pkgen_with_erf("explain", "well.lag")
    assert explained.returncode == 0 and "erf(" in explained.stdout, explained.stderr
    emitted = pkgen_with_erf("well.lag", "-o", "out")
    assert emitted.returncode == 0, emitted.stderr
    assert re.search(r"[^_]\berf\(", (tmp_path / "out" / "well.c").read_text())


@pytest.mark.needs_addon("pages")
def test_it_is_on_the_page(pkgen_with_erf, tmp_path: Path) -> None:
    page = pkgen_with_erf("explain", "well.lag", "--html", "well.html")
    assert page.returncode == 0, page.stderr


def test_claims_are_proved_and_refuted(pkgen_with_erf, tmp_path: Path) -> None:
    assert "whole" in pkgen_with_erf("explain", "well.lag").stdout
    text = MODEL.replace("conserve whole", "conserve along = m*x'\nconserve whole")
    (tmp_path / "well.lag").write_text(text)
    done = pkgen_with_erf("check", "well.lag")
    assert done.returncode == 1 and "'along' is not constant" in done.stderr


def rates(_, z: np.ndarray) -> list[float]:
    x, y, *v = z
    a, b = erf(x / 0.5), erf(y / 0.5)
    slope_x, slope_y = (2 / sqrt(pi) * exp(-((u / 0.5) ** 2)) / 0.5 for u in (x, y))
    return [*v, -2 * (2 * a - b) * slope_x, 2 * a * slope_y]


def test_its_motion_is_that_of_its_force(pkgen_with_erf, tmp_path: Path) -> None:
    """Against SciPy's."""
    done = pkgen_with_erf("run", "well.lag", "--until", 1, "--rtol", "1e-12", "-o", "rows.csv")
    assert done.returncode == 0, done.stderr
    rows = np.genfromtxt(tmp_path / "rows.csv", delimiter=",", names=True, deletechars="")
    by = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
    z = solve_ivp(rates, (0, 1), [0.2, 0.1, 0.3, 0.0], **by).y[:, -1]
    assert abs(z[0]) > 0.1 and abs(rows["x"][-1] - z[0]) < 1e-10
    assert abs(rows["s"][-1] - erf(rows["x"][-1] / 0.5)) < 1e-12
