"""Bounds of all motions between ends that are given; on constraints; of a run that is stopped."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from fractions import Fraction
from pathlib import Path

import pytest
from test_enclose import enclosed, exact, misses, written

from conftest import run_pkgen

pytest.importorskip("flint")
from mpmath import mp, mpf

SPRING = """model m
param k = 1 in (0, inf)
param j = 2*k
coord x
kinetic x'^2/2
potential j*x^2/4
start x = 0.4, x' = 0.3
"""
ROD = """model m
coord x, y
kinetic (x'^2 + y'^2)/2
potential 9.81*y
constraint rod: x^2 + y^2 = 1
start x = 3/5, y = -4/5, x' = 4/5, y' = 3/5
"""
ANGLE = """model m
coord a
kinetic a'^2/2
potential -9.81*cos(a)
let x = sin(a)
let y = -cos(a)
start a = asin(3/5), a' = 1
"""


def spring(k: Fraction, x: Fraction, t: Fraction) -> Fraction:
    mp.dps = 40
    k, x, t = (mpf(z.numerator) / z.denominator for z in (k, x, t))
    w = mp.sqrt(k)
    return exact(x * mp.cos(w * t) + mpf(3) / 10 * mp.sin(w * t) / w)


@pytest.mark.parametrize("seed", range(3))
def test_all_motions_between_the_ends_are_inside(seed: int, tmp_path: Path) -> None:
    """Of a parameter, of another that follows it, and of a start; and no wider than twice that."""
    rng = random.Random(seed)
    k, x = Fraction(rng.randint(50, 200), 100), Fraction(rng.randint(-50, 50), 100)
    d, e = Fraction(rng.randint(1, 5), 100), Fraction(rng.randint(0, 3), 100)
    options = ["--set", f"k={float(k - d)}..{float(k + d)}"]
    options += ["--start", f"x={float(x - e)}..{float(x + e)}", "--until", 3, "--every", 0.5]
    rows = enclosed(written(tmp_path, SPRING), *options, "--record", "x")
    for row in rows:
        ends = [spring(k + i * d, x + j * e, row["t"]) for i in (-1, 1) for j in (-1, 1)]
        many = (rng.uniform(-1, 1) for _ in range(20))
        inner = [spring(k + Fraction(u) * d, x + Fraction(u) * e, row["t"]) for u in many]
        assert all(misses(row, {"x": y}, Fraction(0)) == [] for y in (*ends, *inner))
        least = max(ends) - min(ends)
        assert 2 * row["radius(x)"] < 2 * least + Fraction(1, 10)
    beyond = [{"x": spring(k, x + e + Fraction(1, 5), row["t"])} for row in rows]
    assert any(misses(*pair, Fraction(0)) for pair in zip(rows, beyond, strict=True))


def test_what_follows_a_wide_parameter_is_no_wider(tmp_path: Path) -> None:
    """Motions of one k are not mixed with those of another: after 20 units of time as narrow as
    without a parameter between, and as they are."""
    options = ["--set", "k=0.999..1.001", "--until", 20, "--every", 20, "--record", "x"]
    widths = [
        enclosed(written(tmp_path, text), *options)[-1]["radius(x)"]
        for text in (SPRING, SPRING.replace("j*x^2/4", "k*x^2/2"))
    ]
    ends = [spring(Fraction(k), Fraction("0.4"), Fraction(20)) for k in ("0.999", "1.001")]
    assert widths[0] == pytest.approx(float(widths[1]), rel=0.1)
    assert abs(ends[1] - ends[0]) / 2 < widths[0] < abs(ends[1] - ends[0])


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (("--set", "k=1.1..0.9"), "LO..HI"),
        (("--start", "x=1..0"), "LO..HI"),
        (("--set", "k=1.."), "LO..HI"),
        (("--set", "k=1..2..3"), "LO..HI"),
        (("--set", "k=-1..1"), "outside its bounds: k"),
        (("--set", "k=-1"), "outside its bounds: k"),
        (("--set", "l=1..2"), "--set l: the model has no such"),
    ],
)
def test_ends_that_are_none(options: tuple[str, ...], word: str, tmp_path: Path) -> None:
    done = run_pkgen("run", written(tmp_path, SPRING), "--enclose", *options)
    assert done.returncode == 2 and word in done.stderr, done.stderr


def test_constraints(tmp_path: Path) -> None:
    """A pendulum by its rod and by its angle: bounds of both have the same motion."""
    options = ("--until", 1.5, "--every", 0.25, "--record", "x,y")
    by_rod = enclosed(written(tmp_path, ROD), *options)
    by_angle = enclosed(written(tmp_path, ANGLE), *options)
    assert len(by_rod) == 7
    for rod, angle in zip(by_rod, by_angle, strict=True):
        for name in ("x", "y"):
            both = rod[f"radius({name})"] + angle[f"radius({name})"]
            assert abs(rod[name] - angle[name]) <= both < 1e-13
    assert abs(by_rod[-1]["x"] - by_rod[0]["x"]) > 0.1


@pytest.mark.parametrize(
    ("start", "what"), [("x=0.6000000000000001", "itself, by 1.2e-16"), ("x'=0.81", "in its rate")]
)
def test_a_start_off_a_constraint_is_refused(start: str, what: str, tmp_path: Path) -> None:
    options = ("--until", 0.1, "--start", start)
    done = run_pkgen("run", written(tmp_path, ROD), "--enclose", *options)
    assert done.returncode == 2 and f"'rod' {what}" in done.stderr, done.stderr


def test_an_even_power_of_a_ball_around_zero(tmp_path: Path) -> None:
    """Arb's own has no value there: the rest of x = 0 had no bounds."""
    model = "model m\ncoord x\nkinetic x'^2/2\npotential x^4/4 + x^2/2\n"
    rows = enclosed(written(tmp_path, model), "--start", "x=-0.1..0.1", "--until", 1, "--every", 1)
    assert 0.05 < rows[-1]["radius(x)"] < 0.2 and abs(rows[-1]["x"]) < 0.01


def test_an_interrupt_keeps_the_rows(tmp_path: Path) -> None:
    model = written(tmp_path, ROD)
    command = [sys.executable, "-m", "pkgen", "run", str(model), "--enclose", "--digits", "40"]
    options = ["--until", "1000", "--every", "0.001", "--json"]
    done = subprocess.Popen(
        command + options, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=dict(os.environ)
    )
    for _ in range(600):  # until it has had 2.5 s of the processor, however busy that is
        ticks = Path(f"/proc/{done.pid}/stat").read_text().rpartition(")")[2].split()[11:13]
        if sum(map(int, ticks)) > 2.5 * os.sysconf("SC_CLK_TCK"):
            break
        time.sleep(0.1)
    done.send_signal(signal.SIGINT)
    out, err = done.communicate(timeout=60)
    assert done.returncode == 130, err
    found = json.loads(out)
    assert found["status"] == "interrupted" and len(found["rows"]) > 3
    assert found["rows"][-1][0] == found["t"] != "1000"
    last = {name: Fraction(x) for name, x in zip(found["columns"], found["rows"][-1], strict=True)}
    assert abs(last["x"] ** 2 + last["y"] ** 2 - 1) < 1e-30
