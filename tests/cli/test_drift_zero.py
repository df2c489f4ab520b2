"""Drifts of constants that are 0, and what is lost where a constant is small beside its parts."""

from __future__ import annotations

import json
import math
import random
import re
from pathlib import Path

import numpy
import pytest
from scipy.special import ellipk

from conftest import case, seeds, written
from pkgen.__main__ import main

ORBIT = case("drift_zero_orbit")
EXTREME = case("extreme")
WINDING = "model w\ncoord a\nkinetic a'^2/2\npotential -cos(a)\nstart a = 0, a' = 3\n"


def ran(capsys, tmp_path: Path, model: str, *words: object) -> tuple[dict, str]:
    path = written(tmp_path, model)
    assert main(["run", str(path), "--json", *map(str, words)]) == 0
    said = capsys.readouterr()
    return json.loads(said.out)["report"], said.err


@pytest.mark.parametrize("seed", seeds(range(3), 37))
def test_no_alarm_where_the_vector_is_kept(capsys, tmp_path: Path, seed: int) -> None:
    """Orbits in planes along the axes, next to them, and across, begun anywhere on them."""
    draw = random.Random(seed)
    e, f = draw.uniform(0, 0.8), draw.choice((0.0, math.pi, draw.uniform(0, 6)))
    p = 1 - e * e
    r, w = p / (1 + e * math.cos(f)), 1 / math.sqrt(p)
    q = numpy.array([r * math.cos(f), r * math.sin(f), 0.0])
    v = numpy.array([-w * math.sin(f), w * (e + math.cos(f)), 0.0])
    tilt = draw.choice((0.0, 1e-15, 1e-8, 0.7, math.pi / 2))
    turn = numpy.array(
        [[1, 0, 0], [0, math.cos(tilt), -math.sin(tilt)], [0, math.sin(tilt), math.cos(tilt)]]
    )
    order = draw.sample(range(3), 3)
    start = [float(x) for x in (*(turn @ q)[order], *(turn @ v)[order])]
    method = draw.choice((("dop853", "--rtol", 1e-10), ("gauss6", "--step", 0.02)))
    words = "--until", 60, "--every", 60, "--method", *method
    report, said = ran(capsys, tmp_path, ORBIT.format(*start), *words)
    assert len(report["drifts"]) == 8
    for drift in report["drifts"]:
        assert drift["max"] < 1e-5, drift
    assert "tenth" not in said and "own largest value" not in said


def test_a_vector_that_is_lost_is_told(capsys, tmp_path: Path) -> None:
    start = 0.4, 0.0, 0.0, 0.0, 2.0, 0.0
    words = "--until", 60, "--every", 60, "--method", "rk4", "--step", 0.1
    report, _ = ran(capsys, tmp_path, ORBIT.format(*start), *words)
    drifts = {d["name"]: d for d in report["drifts"]}
    assert drifts["A_y"]["max"] > 1e-3 and drifts["A_y"]["first"] == 0
    assert drifts["A_y"]["scale"] == pytest.approx(drifts["A_x"]["scale"], rel=0.5)
    assert drifts["L_x"]["growth"] == "zero all along"


def test_digits_that_an_energy_loses_are_said(capsys, tmp_path: Path) -> None:
    path = written(tmp_path, EXTREME)
    said = []
    for text in (EXTREME, EXTREME.replace("7.0710695796e-4", "0.5")):
        path.write_text(text, encoding="utf-8")
        assert main(["run", str(path), "--until", "65", "-o", str(tmp_path / "x.csv")]) == 0
        said.append(capsys.readouterr().err)
    assert re.search(r"of its own value -0\.5 that is \d.*e-0[3-5]: digits are lost", said[0])
    assert "digits" not in said[1]


def test_lines_of_what_winds_have_errors_of_their_own(capsys, tmp_path: Path) -> None:
    words = "--until", 2000, "--every", 0.2, "--rtol", 1e-13, "--diagnose", "spectrum"
    report, _ = ran(capsys, tmp_path, WINDING, *words)
    lines = report["diagnostics"]["spectrum"]["coordinates"][0]["lines"]
    rate = 3 * math.pi / 2 / ellipk(4 / 9)  # a' is 3 at the bottom
    for n, line in enumerate(lines[:3], 1):
        assert line["frequency"] == pytest.approx(n * rate, abs=1e-9)
        assert line["error"] < 1e-9


def test_a_large_drift_is_not_called_bounded(capsys, tmp_path: Path) -> None:
    """Verlet's energy of an oscillator comes back, and is off by (h omega)^2/8 of it in between."""
    words = ("--method", "verlet", "--until", 900, "--step")
    drifts = [
        ran(capsys, tmp_path, case("trust_swing"), *words, h)[0]["drifts"] for h in (1.5, 0.1)
    ]
    assert [of[0]["growth"] for of in drifts] == ["off by more than a tenth", "bounded"]
