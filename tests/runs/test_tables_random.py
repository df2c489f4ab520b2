"""Random tables of data: values and slopes against SciPy's interpolators, motions against SciPy
stopped at each knot, which goes on with the polynomial of the next piece."""

import bisect
import math
import random
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline, PchipInterpolator, PPoly

import pkgen
from conftest import seeds

KINDS = ("linear", "spline", "pchip", "hold")
OUTSIDE = ("error", "hold", "linear", "periodic")


class Curve:
    """A table of one variable, made by SciPy."""

    def __init__(self, draw: random.Random, kind: str, outside: str, folder: Path, name: str):
        self.kind, self.outside = kind, outside
        even = draw.random() < 0.3
        gaps = [0.3 if even else draw.uniform(0.05, 0.6) for _ in range(draw.randint(1, 12))]
        self.x = x = np.round(np.cumsum([draw.uniform(-2, 0), *gaps]), 9)
        y = np.round([draw.uniform(-1, 1) for _ in x], 9)
        if outside == "periodic":
            y[-1] = y[0]
        self.text = f'table {name} = "{name}.csv" x, y {kind} {outside}\n'
        rows = "".join(f"{a!r},{b!r}\n" for a, b in zip(x.tolist(), y.tolist(), strict=True))
        (folder / f"{name}.csv").write_text(draw.choice(("", "x,y\n", "# data\n\n")) + rows)
        period = "periodic" if outside == "periodic" else "not-a-knot"
        if kind == "spline":
            self.inside = CubicSpline(x, y, bc_type=period)
        elif kind == "pchip" and outside == "periodic":
            p = x[-1] - x[0]
            x3 = [*(x[:-1] - p), *x, *(x[1:] + p)]
            self.inside = PchipInterpolator(x3, [*y[:-1], *y, *y[1:]])
        elif kind == "pchip":
            self.inside = PchipInterpolator(x, y)
        else:
            slope = np.diff(y) / np.diff(x) if kind == "linear" else 0 * y[:-1]
            self.inside = PPoly([slope, y[:-1]], x)
        self.y, self.period = y, x[-1] - x[0]

    def piece(self, u: float) -> tuple[int, int]:
        """The number of the turn, and of the piece in it: -1 below, len(x) - 1 above."""
        turn = int(np.floor((u - self.x[0]) / self.period)) if self.outside == "periodic" else 0
        place = u - turn * self.period
        if self.outside == "periodic":
            place = max(place, self.x[0])  # below it by rounding
        return turn, bisect.bisect_right(self.x, place) - 1

    def value(self, u: float, d: int = 0, at: tuple[int, int] | None = None) -> float:
        turn, n = self.piece(u) if at is None else at
        u -= turn * self.period
        if 0 <= n < len(self.x) - 1:
            k = bisect.bisect_right(self.inside.x, (self.x[n] + self.x[n + 1]) / 2) - 1
            local = np.poly1d(self.inside.c[:, k])
            return float((local.deriv(d) if d else local)(u - self.inside.x[k]))
        end = 0 if n < 0 else -1
        if self.outside == "error":
            return float(self.y[-1]) if u == self.x[-1] and d == 0 else np.nan
        if self.kind == "hold" or self.outside == "hold":
            return float(self.y[end]) if d == 0 else 0.0
        inner = (0, 0) if n < 0 else (0, len(self.x) - 2)
        slope = self.value(self.x[end], 1, inner)
        return (float(self.y[end] + slope * (u - self.x[end])), slope)[d] if d < 2 else 0.0

    def ends(self, at: tuple[int, int]) -> tuple[float, float]:
        turn, n = at
        last = len(self.x) - 1
        lo = self.x[n] if n >= 0 else -np.inf
        hi = self.x[n + 1] if n < last else np.inf
        return lo + turn * self.period, hi + turn * self.period

    def next(self, at: tuple[int, int], up: bool) -> tuple[int, int]:
        turn, n = at[0], at[1] + (1 if up else -1)
        if self.outside == "periodic" and n in (-1, len(self.x) - 1):
            return (turn - 1, len(self.x) - 2) if n < 0 else (turn + 1, 0)
        return turn, n


@pytest.mark.parametrize("outside", OUTSIDE)
@pytest.mark.parametrize("seed", seeds(range(4), 16, late=[739949011]))
def test_values_and_slopes_are_those_of_scipy(seed: int, outside: str, tmp_path: Path) -> None:
    draw, kind = random.Random(seed), KINDS[seed % 4]
    curve = Curve(draw, kind, outside, tmp_path, "f")
    slope = kind != "hold"
    rate = kind in ("spline", "pchip") and outside != "hold"
    text = f"model m\ncoord x, a, b\n{curve.text}kinetic (x'^2 + a'^2 + b'^2)/2\nforce a = f(x)\n"
    text += "potential -f(x)\n" * slope + "force b = f(x)'\n" * rate
    (tmp_path / "m.lag").write_text(text)
    m = pkgen.load(tmp_path / "m.lag")
    wide = 3 * curve.period
    points = [draw.uniform(curve.x[0] - wide, curve.x[-1] + wide) for _ in range(40)]
    points += [draw.uniform(curve.x[0], curve.x[-1]) for _ in range(40)] + [*curve.x]
    for u in points:
        at = curve.piece(u)
        if outside == "error" and kind != "hold" and u == curve.x[-1]:
            at = (0, at[1] - 1)
        (forward, value, turn) = m.acceleration([u, 0, 0], [2.0, 0, 0])
        assert value == pytest.approx(curve.value(u, 0, at), rel=1e-12, abs=1e-12, nan_ok=True)
        d = curve.value(u, 1, at)
        if u not in curve.x or rate:
            want = d if slope else 0
            assert forward == pytest.approx(want, rel=1e-9, abs=1e-9, nan_ok=True)
        if rate:
            assert turn == pytest.approx(2 * d, rel=1e-9, abs=1e-9, nan_ok=True)


@pytest.mark.parametrize("seed", seeds(range(2), 20))
def test_grids_are_those_of_scipy(seed: int, tmp_path: Path) -> None:
    draw = random.Random(seed)
    bicubic, outside = seed % 2 == 0, draw.choice(("error", "linear"))
    x, y = (np.cumsum([draw.uniform(0.1, 1) for _ in range(draw.randint(4, 7))]) for _ in "xy")
    z = np.array([[draw.uniform(-1, 1) for _ in y] for _ in x])
    rows = [(a, b, z[i, j]) for i, a in enumerate(x) for j, b in enumerate(y)]
    draw.shuffle(rows)
    text = "b,value,a\n" + "".join(f"{b!r},{c!r},{a!r}\n" for a, b, c in np.array(rows).tolist())
    (tmp_path / "f.csv").write_text(text)
    word = "bicubic" if bicubic else "bilinear"
    (tmp_path / "m.lag").write_text(
        f'model m\ncoord x, y, a\ntable f = "f.csv" a, b -> value {word} outside {outside}\n'
        "kinetic (x'^2 + y'^2 + a'^2)/2\npotential -f(x, y)\nforce a = f(x, y)\n"
    )
    m = pkgen.load(tmp_path / "m.lag")

    def scipy(u: float, v: float) -> tuple[float, float, float]:
        if bicubic:
            along = CubicSpline(y, z, axis=1)
            by_x = [CubicSpline(x, along(v, d)) for d in (0, 1)]
            return float(by_x[0](u, 1)), float(by_x[1](u)), float(by_x[0](u))
        i, j = np.searchsorted(x, u) - 1, np.searchsorted(y, v) - 1
        s, r = (u - x[i]) / (x[i + 1] - x[i]), (v - y[j]) / (y[j + 1] - y[j])
        c = z[i : i + 2, j : j + 2]
        value = np.array([1 - s, s]) @ c @ np.array([1 - r, r])
        by_s = (c[1] - c[0]) @ np.array([1 - r, r]) / (x[i + 1] - x[i])
        return float(by_s), float(np.array([1 - s, s]) @ (c[:, 1] - c[:, 0]) / np.diff(y)[j]), value

    for _ in range(60):
        u, v = draw.uniform(x[0], x[-1]), draw.uniform(y[0], y[-1])
        assert m.acceleration([u, v, 0], [0, 0, 0]) == pytest.approx(
            scipy(u, v), rel=1e-9, abs=1e-9
        )
    beyond = m.acceleration([x[-1] + 1, y[0], 0], [0, 0, 0])
    assert np.isnan(beyond).all() == (outside == "error")


def by_scipy(curves, arguments, force, start, until: float) -> np.ndarray:
    """Integrates with each curve on one piece, up to the end of a piece."""
    t, s = 0.0, np.array(start)
    held = [c.piece(a(t, s)) for c, a in zip(curves, arguments, strict=True)]

    def rates(t, s):
        values = [
            [c.value(a(t, s), d, at) for d in (0, 1)]
            for c, a, at in zip(curves, arguments, held, strict=True)
        ]
        return [s[2], s[3], *force(t, s, values)]

    events = [
        lambda t, s, k=k, end=end: (
            arguments[k](t, s) - curves[k].ends(held[k])[end]
            if np.isfinite(curves[k].ends(held[k])[end])
            else 1.0
        )
        for k in range(len(curves))
        for end in (0, 1)
    ]
    for event in events:
        event.terminal = True
    accuracy = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    while t < until:
        beyond = min(t + 1e-7, until)  # off the knot at which it begins
        s = solve_ivp(rates, (t, beyond), s, **accuracy).y[:, -1]
        found = solve_ivp(rates, (beyond, until), s, events=events, max_step=0.02, **accuracy)
        t, s = found.t[-1], found.y[:, -1]
        for k, at in enumerate(found.t_events):
            if len(at):
                held[k // 2] = curves[k // 2].next(held[k // 2], k % 2 == 1)
    return s


@pytest.mark.parametrize("method", ["dop853 rtol 1e-12", "gauss rtol 1e-12", "rk4 step 0.002"])
@pytest.mark.parametrize("seed", seeds(range(300, 303), 30))
def test_motions_are_those_of_scipy_stopped_at_each_knot(seed, method, tmp_path) -> None:
    draw = random.Random(seed)
    curves, terms, arguments = [], [], []
    for k in range(draw.randint(1, 2)):
        kind, outside = draw.choice(KINDS), draw.choice(OUTSIDE[1:])
        curves.append(Curve(draw, kind, outside, tmp_path, f"f{k}"))
        a, b = draw.choice(((1, 0), (0.6, 0.4), (0, 1), (0, 3)))  # of x and t
        arguments.append(lambda t, s, a=a, b=b: a * s[0] + b * t)
        terms.append((f"f{k}({a}*x + {b}*t)", round(draw.uniform(-1.5, 1.5), 3), a))
    potential = [
        (draw.random() < 0.5 and c.kind != "hold" and c.outside != "hold") or c.kind == "linear"
        for c in curves
    ]
    text = "model m\ncoord x, y\n" + "".join(c.text for c in curves)
    text += "kinetic (x'^2 + y'^2)/2\npotential x^2 + y^2 - 0.3*x*y"
    text += "".join(f" + ({w})*{f}" for (f, w, _), p in zip(terms, potential, strict=True) if p)
    text += "\nforce y = -0.1*y'"
    text += "".join(f" + ({w})*{f}" for (f, w, _), p in zip(terms, potential, strict=True) if not p)
    start = [round(draw.uniform(-1, 1), 3) for _ in range(4)]
    names = ("x", "y", "x'", "y'")
    text += "\nstart " + ", ".join(f"{n} = {v}" for n, v in zip(names, start, strict=True))
    text += f"\nscene run\n  until 4\n  method {method}\n  record x, y, x', y'\nend\n"
    (tmp_path / "m.lag").write_text(text)

    def force(t, s, values):
        fx, fy = -2 * s[0] + 0.3 * s[1], -2 * s[1] + 0.3 * s[0] - 0.1 * s[3]
        for (_, w, a), p, (value, slope) in zip(terms, potential, values, strict=True):
            fx -= w * slope * a if p else 0
            fy += 0 if p else w * value
        return fx, fy

    run = pkgen.load(tmp_path / "m.lag", scene="run").run()
    found = [run[n][-1] for n in names]
    wanted = by_scipy(curves, arguments, force, start, 4.0)
    assert found == pytest.approx(wanted, abs=3e-9), text


@pytest.mark.parametrize("method", ["gauss", "dop853", "rk4", "rattle"])
def test_a_constrained_motion_passes_a_knot_where_all_positions_vanish(method, tmp_path) -> None:
    (tmp_path / "k.csv").write_text("x,F\n-90,1\n0,0\n90,3\n")
    (tmp_path / "k.lag").write_text(
        "model k\ntable f = \"k.csv\" x, F linear\ncoord x, y\nkinetic (x'^2 + y'^2)/2\n"
        "constraint tie: x = 2*y + sin(y)\nforce x = f(x)\n"
    )
    m = pkgen.load(tmp_path / "k.lag")
    step = 0.01 if method in ("rk4", "rattle") else None
    for y in (-0.3, -0.47, -0.71, -0.93):
        start = {"x": 2 * y + math.sin(y), "y": y, "x'": 2 * (2 + math.cos(y)), "y'": 2}
        r = m.run(1, every=1, method=method, step=step, start=start)
        assert r["y"][-1] > 0.5
