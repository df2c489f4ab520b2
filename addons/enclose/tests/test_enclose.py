"""Bounds hold: what is known better is inside; with a wrong remainder or start it is not."""

from __future__ import annotations

import csv
import json
import random
from fractions import Fraction
from pathlib import Path

import pytest

from conftest import ROOT, long_but, run_pkgen

flint = pytest.importorskip("flint")
from mpmath import mp, mpf, odefun  # noqa: E402

from pkgen_enclose import enclose, step  # noqa: E402

REFERENCES = json.loads((ROOT / "tests/models/references.json").read_text())
OSCILLATOR = "model m\ncoord x\nkinetic x'^2/2\npotential x^2/2\nstart x = 0.4, x' = 0.3\n"
KEPLER = """model m
coord x, y
kinetic (x'^2 + y'^2)/2
potential -1/sqrt(x^2 + y^2)
start x = 0.5, y' = sqrt(3)
"""


def enclosed(model: Path, *options: object, code: int = 0) -> list[dict[str, Fraction]]:
    done = run_pkgen("run", model, "--enclose", *options)
    assert done.returncode == code, done.stderr
    rows = csv.DictReader(done.stdout.splitlines())
    return [{name: Fraction(x) for name, x in row.items()} for row in rows]


def written(folder: Path, text: str) -> Path:
    (folder / "m.lag").write_text(text)
    return folder / "m.lag"


def misses(row: dict[str, Fraction], known: dict[str, Fraction], slack: Fraction) -> list[str]:
    """The names whose known value, itself known to `slack`, is not within the bounds."""
    return [n for n, x in known.items() if abs(row[n] - x) > row[f"radius({n})"] + slack]


@pytest.mark.parametrize("name", long_but(("bead_on_hoop", "coupled_oscillators"), REFERENCES))
def test_references_of_25_digits_are_inside(name: str) -> None:
    reference = REFERENCES[name]
    coordinates = reference["coords"]
    names = [*coordinates, *(f"{c}'" for c in coordinates)]
    until = reference["t_end"]
    options = ["--until", until, "--every", until]
    for p, value in reference["params"].items():
        options += ["--set", f"{p}={value}"]
    for n, value in zip(names, reference["y0"], strict=True):
        options += ["--start", f"{n}={value}"]
    last = enclosed(ROOT / f"models/{name}.lag", *options)[-1]
    known = dict(zip(names, map(Fraction, reference["y"]), strict=True))
    assert float(last["t"]) == float(until)
    assert misses(last, known, Fraction(1, 10**22)) == []
    for n, x in known.items():
        assert last[f"radius({n})"] < 1e-12
        assert misses(last, {n: x + Fraction(1, 10**11)}, Fraction(0)) == [n]


def test_a_harmonic_motion_is_inside_at_every_row(tmp_path: Path) -> None:
    rows = enclosed(written(tmp_path, OSCILLATOR), "--until", 20, "--every", 0.5, "--digits", 20)
    assert len(rows) == 41
    mp.dps = 45
    for row in rows:
        t = mpf(row["t"].numerator) / row["t"].denominator
        x = mpf(4) / 10 * mp.cos(t) + mpf(3) / 10 * mp.sin(t)
        assert misses(row, {"x": exact(x)}, Fraction(1, 10**38)) == []
        assert row["radius(x)"] < 1e-20


def exact(x: mpf) -> Fraction:
    return Fraction(*map(int, x.as_integer_ratio())) if hasattr(x, "as_integer_ratio") else _of(x)


def _of(x: mpf) -> Fraction:
    sign, man, exponent, _ = x._mpf_
    return (-1) ** sign * Fraction(int(man)) * Fraction(2) ** exponent


def test_an_ellipse_is_inside_at_every_row(tmp_path: Path) -> None:
    """a = 1, e = 1/2: x = e - cos E is turned about, from the perihelion at x = 1 - e."""
    rows = enclosed(written(tmp_path, KEPLER), "--until", 3, "--every", 0.125)
    assert len(rows) == 25
    mp.dps = 40
    for row in rows:
        t = mpf(row["t"].numerator) / row["t"].denominator
        anomaly = mp.findroot(lambda E, t=t: E - mp.sin(E) / 2 - t, t + 0.3)
        x, y = mp.cos(anomaly) - mpf(1) / 2, mp.sqrt(3) / 2 * mp.sin(anomaly)
        assert misses(row, {"x": exact(x), "y": exact(y)}, Fraction(1, 10**33)) == []


def random_model(rng: random.Random) -> tuple[str, object]:
    """A Lagrangian with a mass that varies and a potential of polynomials and waves, and its
    equations derived by hand for mpmath: m x'' = -m'/2 x'^2 - V_x, y'' = -V_y."""
    a, b, c, d, k, s = (Fraction(rng.randint(-9, 9), 10) for _ in range(6))
    text = f"""model m
coord x, y
kinetic (1 + x^2)*x'^2/2 + y'^2/2
potential x^2/2 + y^2/2 + ({a})*x^2*y + ({b})*cos(({k})*x + y) + ({c})*exp(sin(x*y)) + ({d})*atan(x)
start x = {float(s)}, y = 0.3, x' = -0.2, y' = 0.7
"""
    a, b, c, d, k, s = (mpf(z.numerator) / z.denominator for z in (a, b, c, d, k, s))

    def slopes(t: mpf, z: list[mpf]) -> list[mpf]:
        x, y, v, w = z
        wave, bump = -b * mp.sin(k * x + y), c * mp.exp(mp.sin(x * y)) * mp.cos(x * y)
        by_x = x + 2 * a * x * y + k * wave + bump * y + d / (1 + x * x)
        by_y = y + a * x * x + wave + bump * x
        return [v, w, (-x * v * v - by_x) / (1 + x * x), -by_y]

    start = [s, mpf(3) / 10, -mpf(2) / 10, mpf(7) / 10]
    return text, odefun(slopes, 0, start, tol=mpf(10) ** -26)


@pytest.mark.parametrize("seed", range(2))
def test_random_motions_are_inside(seed: int, tmp_path: Path) -> None:
    mp.dps = 30
    text, solution = random_model(random.Random(seed))
    model = written(tmp_path, text)
    names = ["x", "y", "x'", "y'"]
    known = dict(zip(names, map(exact, solution(mpf(1))), strict=True))
    options = ["--until", 1, "--every", 1, "--digits", 18]
    slack = Fraction(1, 10**24)
    row = enclosed(model, *options)[-1]
    assert misses(row, known, slack) == []
    assert all(row[f"radius({n})"] < 1e-17 for n in names)
    other = enclosed(model, *options, "--start", "y=0.3000000000001")[-1]
    assert misses(other, known, slack)


def test_without_its_remainder_a_series_of_low_order_is_not_right(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = written(tmp_path, OSCILLATOR)
    mp.dps = 40
    known = {"x": exact(mpf(4) / 10 * mp.cos(1) + mpf(3) / 10 * mp.sin(1))}
    low = step.step
    monkeypatch.setattr(enclose, "step", lambda flow, now, order, *rest: low(flow, now, 6, *rest))
    monkeypatch.setattr(enclose, "ATTEMPTS", 1)
    found = [_direct(model)]
    monkeypatch.setattr(step, "_tail", lambda part, first: flint.arb(0))
    found.append(_direct(model))
    right, wrong = found
    assert misses(right, known, Fraction(1, 10**30)) == []
    assert misses(wrong, known, Fraction(1, 10**30)) == ["x"]


def _direct(model: Path) -> dict[str, Fraction]:
    """The last row, in this process."""
    import contextlib
    import io

    from pkgen.__main__ import main

    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.suppress(SystemExit):
        main(["run", str(model), "--enclose", "--until", "1", "--every", "1"])
    last = list(csv.DictReader(said.getvalue().splitlines()))[-1]
    return {name: Fraction(x) for name, x in last.items()}


def test_a_run_is_judged(tmp_path: Path) -> None:
    """At 1e-12 a run is off by what its tolerance says, and by more than the bounds are wide."""
    model = ROOT / "models/bead_on_hoop.lag"
    row = enclosed(model, "--until", 10, "--every", 10)[-1]
    off = {}
    for rtol in ("1e-6", "1e-12"):
        done = run_pkgen("run", model, "--until", 10, "--every", 10, "--rtol", rtol)
        x = Fraction(list(csv.DictReader(done.stdout.splitlines()))[-1]["theta"])
        off[rtol] = abs(x - row["theta"])
    assert row["radius(theta)"] < off["1e-12"] < 1e-10 < off["1e-6"]


def test_rotations_and_states(tmp_path: Path) -> None:
    for model in ("bodies/heavy_top_rotation", "bodies/free_body", "bodies/rattleback_reduced"):
        path = ROOT / f"models/{model}.lag"
        options = ("--until", 0.5, "--every", 0.5)
        row = enclosed(path, *options, "--digits", 10)[-1]
        done = run_pkgen("run", path, *options, "--rtol", "1e-13")
        run = list(csv.DictReader(done.stdout.splitlines()))[-1]
        assert set(run) <= set(row)
        for name, x in run.items():
            assert float(row[name]) == pytest.approx(float(x), abs=1e-10), name
