"""Sample blocks on random linear systems with two controllers, beside matrix exponentials from one
sample to the next: periods, offsets, delays, memory, saturation, quantisation, and rows between."""

from __future__ import annotations

from fractions import Fraction
from math import floor
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import pkgen
from conftest import seeds

UNTIL = Fraction(2)
PERIODS = [Fraction(x, 1000) for x in (50, 100, 70, 125, 30)]
METHODS = {
    "dop853": {"rtol": 1e-12},
    "gauss": {"rtol": 1e-12},
    "dopri5": {"rtol": 1e-12},
    "radau": {"rtol": 1e-12},
    "rk4": {"step": 0.0009},
    "gauss6": {"step": 0.02},
    "yoshida8": {"step": 0.01},
}
# The functions of a block's expressions; `if` is a word of Python.
MEANING = {
    "clamp": lambda x, a, b: min(max(x, a), b),
    "round": lambda x: floor(x + 0.5),
    "iff": lambda c, a, b: a if c else b,
    "abs": abs,
}


class Drawn:
    """A system x'' = -K x - C x' + B u + c m, and two blocks that see x, x', u, t and memory m."""

    def __init__(self, seed: int, damped: bool):
        draw = np.random.default_rng(seed)
        self.n = n = int(draw.integers(1, 4))
        root = draw.normal(size=(n, n))
        self.K = np.round(root @ root.T, 3)
        root = 0.5 * draw.normal(size=(n, n))
        self.C = np.round(root @ root.T, 3) * damped
        self.B = np.round(draw.normal(size=(n, 3)), 3)  # of u1, u2, and of a memory cell
        self.q, self.v = np.round(draw.normal(size=(2, n)), 3)
        self.every = Fraction(int(draw.integers(7, 60)), 500)
        self.blocks = [self._block(draw, k) for k in (1, 2)]
        if seed % 4 == 0:  # both at the same times, in order
            self.blocks[1]["T"] = 2 * self.blocks[0]["T"]
            self.blocks[1]["T0"] = self.blocks[0]["T0"]

    def _block(self, draw: np.random.Generator, k: int) -> dict:
        names = [f"x{i}" for i in range(self.n)]
        seen = [*names, *(f"{x}'" for x in names), "u1", "u2", f"m{k}"]

        def mix() -> str:
            picked = draw.choice(len(seen), size=3, replace=False)
            return " + ".join(f"({draw.normal():.3f})*{seen[i]}" for i in picked)

        T = PERIODS[int(draw.integers(len(PERIODS)))]
        set_u = [
            f"clamp({mix()}, -0.8, 1.1)",
            f"round(4*({mix()}))/4 - w*e",
            f"if(abs(e) > 0.5, w, -{mix()}*t)",
            f"w - 0.3*e + 0.1*u{k}",
        ][int(draw.integers(4))]
        set_m = [f"0.8*m{k} + {float(T)}*e", f"if(m{k} == 2, 0, m{k} + 1)", f"m{k}/2 + u{k}*w"]
        steps = [("let", "e", mix()), ("let", "w", f"clamp(e, -1, 1)*{draw.normal():.3f}")]
        steps += [("set", f"u{k}", set_u)]
        steps.insert(int(draw.integers(2, 4)), ("set", f"m{k}", set_m[int(draw.integers(3))]))
        T0 = [Fraction(0), Fraction(13, 1000), T / 2][int(draw.integers(3))]
        begin = (
            round(float(draw.normal()), 3)
            if "==" not in dict((s[1], s[2]) for s in steps)[f"m{k}"]
            else 0
        )
        return {
            "k": k, "T": T, "T0": T0, "delay": int(draw.integers(0, 4)), "steps": steps,
            "begin": begin,
        }  # fmt: skip

    def text(self) -> str:
        n = self.n
        xs = [f"x{i}" for i in range(n)]

        def row(row: np.ndarray, names: list[str]) -> str:
            return " + ".join(f"({c:.17g})*{x}" for c, x in zip(row, names, strict=True))

        lines = ["model drawn", f"coord {', '.join(xs)}", "input u1, u2"]
        lines += ["kinetic (" + " + ".join(f"{x}'^2" for x in xs) + ")/2"]
        rows = []
        for i in range(n):
            force = row(-self.K[i], xs)
            if self.C.any():
                force += " + " + row(-self.C[i], [f"{x}'" for x in xs])
            rows.append((i, force))
        for b in self.blocks:
            delay = f" delay {b['delay']}" if b["delay"] else ""
            offset = f" offset {float(b['T0'])}" if b["T0"] else ""
            lines += [f"sample block{b['k']} every {float(b['T'])}{offset}{delay}"]
            lines += [f"  memory m{b['k']} = {b['begin']}"]
            lines += [f"  {word} {name} = {value}" for word, name, value in b["steps"]]
            lines += ["end"]
        inputs = ["u1", "u2", "m1"]
        lines += [f"force x{i} = {force} + {row(self.B[i], inputs)}" for i, force in rows]
        lines += [f"start x{i} = {self.q[i]}, x{i}' = {self.v[i]}" for i in range(n)]
        return "\n".join(lines) + "\n"

    def rows(self) -> np.ndarray:
        """t, x, x', u1, u2, m1, m2 at the rows."""
        n = self.n
        z = np.concatenate([self.q, self.v])
        u = {"u1": 0.0, "u2": 0.0} | {f"m{b['k']}": float(b["begin"]) for b in self.blocks}
        waiting = {b["k"]: [0.0] * b["delay"] for b in self.blocks}
        A = np.zeros((2 * n + 3, 2 * n + 3))
        A[:n, n : 2 * n] = np.eye(n)
        A[n : 2 * n, :n], A[n : 2 * n, n : 2 * n], A[n : 2 * n, 2 * n :] = -self.K, -self.C, self.B
        times = {UNTIL} | {k * self.every for k in range(int(UNTIL / self.every) + 1)}
        samples: dict[Fraction, list[dict]] = {}
        for b in self.blocks:
            t = b["T0"]
            while t <= UNTIL:
                samples.setdefault(t, []).append(b)
                t += b["T"]
        found, now = [], Fraction(0)
        for t in sorted(times | samples.keys()):
            whole = np.concatenate([z, [u["u1"], u["u2"], u["m1"]]])
            z = (expm(A * float(t - now)) @ whole)[: 2 * n]
            now = t
            for b in samples.get(t, ()):
                self._sample(b, float(t), z, u, waiting[b["k"]])
            if t in times:
                found.append([float(t), *z, u["u1"], u["u2"], u["m1"], u["m2"]])
        return np.array(found)

    def _sample(self, b: dict, t: float, z: np.ndarray, u: dict, waiting: list[float]) -> None:
        own = f"u{b['k']}"
        known = MEANING | u | {"t": t}
        for i in range(self.n):
            known |= {f"x{i}": z[i], f"x{i}_": z[self.n + i]}
        if waiting:
            known[own] = waiting[-1]
        for _, name, value in b["steps"]:
            known[name] = eval(value.replace("'", "_").replace("if(", "iff("), {}, known)
        u[f"m{b['k']}"] = known[f"m{b['k']}"]
        waiting.append(known[own])
        u[own] = waiting.pop(0)


@pytest.mark.parametrize("seed", seeds(range(28), turning=4))
def test_random_controllers(seed: int, tmp_path: Path) -> None:
    method = list(METHODS)[seed % len(METHODS)]
    drawn = Drawn(seed, damped=method != "yoshida8")
    path = tmp_path / "drawn.lag"
    path.write_text(drawn.text(), encoding="utf-8")
    xs = [f"x{i}" for i in range(drawn.n)]
    columns = [*xs, *(f"{x}'" for x in xs), "u1", "u2", "m1", "m2"]
    m = pkgen.load(path)
    r = m.run(
        float(UNTIL), method=method, every=float(drawn.every), record=columns, **METHODS[method]
    )
    expected = drawn.rows()
    rows = np.array([r.t, *(r[c] for c in columns)]).T
    assert rows.shape == expected.shape
    off = np.abs(rows - expected) / (1 + np.abs(expected))
    assert off.max() < 3e-9, (method, np.unravel_index(off.argmax(), off.shape), path.read_text())
    assert np.abs(expected[:, -4:]).max(axis=0).min() > 0  # no cell and no input sleeps
