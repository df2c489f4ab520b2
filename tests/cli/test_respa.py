"""Impulse multiple time stepping: orders, the form, inner steps and resonances, refusals."""

from __future__ import annotations

import json
import random
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import pkgen as api
from conftest import case, ran, run_pkgen, seeds, written

UNTIL = 1.0


class Drawn:
    """M a = -(K + f) q - sin(P q) P + A cos t, whose springs K are stiff and named fast."""

    def __init__(self, seed: int):
        draw = np.random.default_rng(seed)
        n = self.n = int(draw.integers(2, 4))
        root = np.eye(n) + 0.2 * draw.normal(size=(n, n))
        self.M = np.round(root @ root.T, 3)
        self.P, self.A = (np.round(draw.uniform(0.5, 1.5, n), 3) for _ in range(2))
        self.k = np.round(draw.uniform(100, 400, n), 1)
        self.start = np.round(draw.normal(size=2 * n) * np.repeat([0.1, 1], n), 3)

    def slope(self, t: float, y: np.ndarray) -> np.ndarray:
        q, v = np.split(y, 2)
        f = -self.k * q - q**3 * self.k - np.sin(self.P @ q) * self.P + self.A * np.cos(t)
        return np.concatenate([v, np.linalg.solve(self.M, f)])

    def model(self, folder: Path) -> api.Model:
        names = range(self.n)
        pairs = (f"{self.M[i, j]:.17g}*x{i}'*x{j}'/2" for i in names for j in names)
        springs = " + ".join(f"{self.k[i]}*(x{i}^2/2 + x{i}^4/4)" for i in names)
        lines = ["model drawn", "coord " + ", ".join(f"x{i}" for i in names)]
        lines += [f"let springs = {springs}", "fast springs", "kinetic " + " + ".join(pairs)]
        swing = " + ".join(f"{self.P[i]}*x{i}" for i in names)
        lines += [f"potential springs - cos({swing})"]
        q, v = np.split(self.start, 2)
        for i in names:
            lines += [f"force x{i} = {self.A[i]}*cos(t)", f"start x{i} = {q[i]}, x{i}' = {v[i]}"]
        (folder / "drawn.lag").write_text("\n".join([*lines, ""]))
        return api.load(folder / "drawn.lag")


def end(model: api.Model, method: str, step: float, n: int, **more: object) -> np.ndarray:
    rows = model.run(UNTIL, method=method, step=step, every=UNTIL, **more)
    return np.array([rows[name][-1] for name in rows.columns[1 : 2 * n + 1]])


@pytest.mark.parametrize("seed", seeds([1, 2, 3], 2))
def test_orders_and_the_form(tmp_path: Path, seed: int) -> None:
    drawn = Drawn(seed)
    model, n = drawn.model(tmp_path), drawn.n
    by = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
    true = solve_ivp(drawn.slope, (0, UNTIL), drawn.start, **by).y[:, -1]
    for method, order in (("respa", 2), ("respa4", 4)):
        coarse, fine = (abs(end(model, method, h, n) - true).max() for h in (0.02, 0.01))
        assert fine > 1e-11 and 0.6 < coarse / fine / 2**order < 1.6, (method, coarse, fine)
    # An inner step as long as the step is Verlet's.
    same = end(model, "respa", 0.02, n, max_step=0.02)
    assert same == pytest.approx(end(model, "verlet", 0.02, n), rel=1e-11)
    # In few steps that Verlet does not survive, with all that is fast well resolved.
    assert abs(end(model, "respa", 0.1, n, max_step=0.002) - true).max() < 0.1
    with suppress(api.RunError):
        assert abs(end(model, "verlet", 0.1, n) - true).max() > 0.1

    def after(y: np.ndarray) -> np.ndarray:
        start = {f"x{i}{p}": y[n * (p == "'") + i] for i in range(n) for p in ("", "'")}
        rows = model.run(0.05, method="respa", step=0.05, every=0.05, start=start)
        return np.array([rows[name][-1] for name in rows.columns[1 : 2 * n + 1]])

    d = 1e-5 * np.eye(2 * n)
    flow = np.array([(after(drawn.start + x) - after(drawn.start - x)) / 2e-5 for x in d]).T
    form = np.block([[np.zeros((n, n)), drawn.M], [-drawn.M, np.zeros((n, n))]])
    assert abs(flow.T @ form @ flow - form).max() < 1e-7 and abs(flow - np.eye(2 * n)).max() > 0.05


SPRING = case("tuned")


def test_a_kick_in_tune_grows(tmp_path: Path) -> None:
    """Near h w = pi the map of kick, exact turn, kick has |trace| > 2: by hand."""
    path = written(tmp_path, SPRING)
    model = api.load(path)
    for y in (2.6, 3.10, 3.2, 6.2, 6.5):
        h = y / 20
        kick = np.array([[1, 0], [-h / 2, 1]])
        turn = np.array([[np.cos(y), np.sin(y) / 20], [-20 * np.sin(y), np.cos(y)]])
        grows = abs(np.trace(kick @ turn @ kick)) > 2 + 1e-9
        rows = model.run(3000 * h, method="respa", step=h, max_step=h / 200, every=h)
        assert (abs(rows["x"]).max() > 3) == grows, y
    done = run_pkgen("run", path, "--scene", "a", "--diagnose", "lyapunov")
    assert done.returncode != 0 and "have no derivatives here" in done.stderr
    for command in (("run", path, "--scene", "a"), ("explain", path)):
        ran(*command, cwd=tmp_path)


@pytest.mark.needs_addon("pages")
def test_the_fast_part_has_its_page(write, tmp_path: Path) -> None:
    done = run_pkgen("explain", write(SPRING), "--html", tmp_path / "e.html")
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_its_limit_is_predicted(tmp_path: Path, seed: int) -> None:
    """Beside the trace of half a kick, ten short Verlet steps, half a kick, on two springs."""
    w = random.Random(seed).uniform(8, 30)
    path = written(tmp_path, SPRING.replace("w = 20", f"w = {w!r}"))
    words = ("--methods", "respa", "--quick", "--points", "4x3", "--until", "20")
    done = run_pkgen("stability", path, *words, "--json", "-o", tmp_path)
    (limit,) = (p for p in json.loads(done.stdout)["predictions"] if p["kind"] == "limit")

    def trace(h: float) -> float:
        kick, short = np.array([[1, 0], [-h / 2, 1]]), h / 10
        half = np.array([[1, 0], [-(w**2) * short / 2, 1]])
        inner = half @ np.array([[1, short], [0, 1]]) @ half
        return np.trace(kick @ np.linalg.matrix_power(inner, 10) @ kick)

    steps = np.arange(2.5, 3.5, 1e-5) / w
    first = next(h for h in steps if abs(trace(h)) > 2 + 1e-12)
    assert limit["h"] == pytest.approx(first, rel=1e-3)
    assert limit["measured"] == pytest.approx(first, rel=1e-3)
