"""Random models with forces C v: masses that couple, frames, fields, drags. What is true is SciPy's
DOP853 and expm on equations written down by hand here."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import pkgen as api
from conftest import seeds, written

UNTIL = 1.5
CONSTANT = {"verlet": 2, "mclachlan4": 4, "blanes_moan4": 4, "kahan_li6": 6, "blanes_moan6": 6}
ANY = {"boris": 2, "boris4": 4, "boris6": 6}


class Drawn:
    """M a = -k q^3 - sin(P q) P + A cos t + C v (1 + s cos(q1 - t)), in a frame that turns by W."""

    def __init__(self, seed: int, varies: bool = False, pushed: bool = True):
        draw = np.random.default_rng(seed)
        n = self.n = int(draw.integers(2, 5))
        root = np.eye(n) + 0.15 * draw.normal(size=(n, n))
        self.M = np.round(root @ root.T, 3)
        self.k, self.P, self.A = (pushed * np.round(draw.uniform(0.3, 1, n), 3) for _ in range(3))
        field = np.round(draw.normal(size=(n, n)), 3)
        self.G = field - field.T
        self.d = np.round(0.5 * draw.normal(size=n), 3) * (seed % 3 > 0)
        turn = np.round(0.4 * draw.normal(size=(n, n)), 3)
        self.W = (turn - turn.T) * (seed % 2)
        self.s = 0.5 * varies
        self.start = np.round(draw.normal(size=2 * n), 3)

    @property
    def drag(self) -> np.ndarray:
        return self.G - np.outer(self.d, self.d)

    @property
    def turned(self) -> np.ndarray:
        return self.W.T @ self.M - self.M @ self.W

    def slope(self, t: float, y: np.ndarray) -> np.ndarray:
        q, v = np.split(y, 2)
        f = self.W.T @ self.M @ self.W @ q + self.turned @ v - self.k * q**3
        f += -np.sin(self.P @ q) * self.P + self.A * np.cos(t)
        f += (1 + self.s * np.cos(q[0] - t)) * self.drag @ v
        return np.concatenate([v, np.linalg.solve(self.M, f)])

    def text(self) -> str:
        def times(row: np.ndarray, of: str) -> str:
            return " + ".join(f"({c:.17g})*x{j + 1}{of}" for j, c in enumerate(row))

        names = range(self.n)
        lines = ["model drawn", "coord " + ", ".join(f"x{i + 1}" for i in names)]
        rates = [f"(x{i + 1}' + {times(self.W[i], '')})" for i in names]
        pairs = (f"({self.M[i, j]:.17g})*{rates[i]}*{rates[j]}/2" for i in names for j in names)
        lines += ["kinetic " + " + ".join(pairs)]
        lines += ["potential -cos(" + times(self.P, "") + ")"]
        if self.s == 0:  # by L and D, and where C varies as a force
            lines += ["dissipation (" + times(self.d, "'") + ")^2/2"]
            lines += [f"lagrangian x{i + 1}*({times(np.triu(self.G)[i], chr(39))})" for i in names]
        for i in names:
            force = f"{self.A[i]:.17g}*cos(t) - {self.k[i]:.17g}*x{i + 1}^3"
            if self.s:
                force += f" + (1 + {self.s}*cos(x1 - t))*({times(self.drag[i], chr(39))})"
            lines += [f"force x{i + 1} = {force}"]
        q, v = np.split(self.start, 2)
        lines += [f"start x{i + 1} = {q[i]}, x{i + 1}' = {v[i]}" for i in names]
        return "\n".join([*lines, ""])

    def model(self, folder: Path) -> api.Model:
        path = written(folder, self.text())
        return api.load(path)


def end(model: api.Model, method: str, step: float, n: int) -> np.ndarray:
    rows = model.run(UNTIL, method=method, step=step, every=UNTIL)
    return np.array([rows[name][-1] for name in rows.columns[1 : 2 * n + 1]])


@pytest.mark.parametrize("varies", [False, True])
@pytest.mark.parametrize("seed", seeds([1, 2, 3], 2))
def test_orders(tmp_path: Path, seed: int, varies: bool) -> None:
    drawn = Drawn(seed, varies)
    model = drawn.model(tmp_path)
    by = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
    true = solve_ivp(drawn.slope, (0, UNTIL), drawn.start, **by).y[:, -1]
    gauss = end(model, "gauss8", 0.05, drawn.n)
    assert abs(gauss - true).max() < 1e-11  # both say the same
    for method, order in (ANY if varies else CONSTANT | ANY).items():
        steps = {2: (40, 80), 4: (16, 32), 6: (12, 20)}[order]
        coarse, fine = (abs(end(model, method, UNTIL / k, drawn.n) - true).max() for k in steps)
        slope = np.log(coarse / fine) / np.log(steps[1] / steps[0])
        assert fine > 1e-12 and abs(slope - order) < 0.5, (method, coarse, fine)
    if varies:
        with pytest.raises((api.UsageError, api.RunError), match=r"linear (drag|in them)"):
            end(model, "verlet", 0.1, drawn.n)


@pytest.mark.parametrize("seed", seeds([1, 2, 5], 2))
def test_one_step_is_exact_where_nothing_pushes(tmp_path: Path, seed: int) -> None:
    drawn = Drawn(seed, pushed=False)
    drawn.W *= 0
    model = drawn.model(tmp_path)
    n = drawn.n
    flow = np.zeros((2 * n, 2 * n))
    flow[:n, n:] = np.eye(n)
    flow[n:, n:] = np.linalg.solve(drawn.M, drawn.drag)
    true = expm(UNTIL * flow) @ drawn.start
    for method in CONSTANT:
        assert abs(end(model, method, UNTIL, n) - true).max() < 1e-11, method
    assert abs(end(model, "boris6", UNTIL, n) - true).max() > 1e-6
