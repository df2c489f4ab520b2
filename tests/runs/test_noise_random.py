"""Noise: the generator, the methods beside their formulas in Python, their orders, and averages
beside closed forms, Lyapunov's equation and an eigenvalue of the Fokker-Planck equation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from noise_by_hand import METHODS, normal, philox, spread
from scipy.linalg import expm, solve_continuous_lyapunov
from scipy.sparse import bmat, diags, identity
from scipy.sparse.linalg import eigs

import pkgen
from conftest import seeds

DUFFING = """model duffing
param c = 0.4
param s = 0.3
coord x
kinetic x'^2/2
potential x^4/4
dissipation c/2*x'^2
force x = cos(2*t)
noise x = s*(1 + x^2 + t)
start x = 1, x' = 0.5
"""
BATH = """model bath
param k = 1 in [0, inf)
param c = 0.5 in [0, inf)
param kT = 1
coord x
kinetic x'^2/2
potential k*x^2/2
dissipation c/2*x'^2
noise x = 2*c*kT
"""


def load(tmp_path: Path, text: str) -> pkgen.Model:
    path = tmp_path / f"{text.split()[1]}.lag"
    path.write_text(text, encoding="utf-8")
    return pkgen.load(path)


def ends(model: pkgen.Model, members: int, until: float, step: float, **how) -> np.ndarray:
    """Returns x and x' of all members at the end."""
    how = {"method": "baoab", "every": until} | how
    r = model.ensemble({"x": np.zeros(members) + how.pop("x", 0.0)}, until, step=step, **how)
    return np.array([r[name].reshape(members, -1)[:, -1] for name in ("x", "x'")])


def test_known_answers_of_philox() -> None:
    pi = [0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344], [0xA4093822, 0x299F31D0]
    for counter, key, answer in (
        ([0] * 4, [0] * 2, "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
        ([0xFFFFFFFF] * 4, [0xFFFFFFFF] * 2, "408f276d 41c83b0e a20bc7c6 6d5451fd"),
        (*pi, "d16cfe09 94fdcceb 5001e420 24126ea1"),
    ):
        found = philox(np.array(counter, np.uint64), np.array(key, np.uint64))
        assert " ".join(f"{int(x):08x}" for x in found) == answer


@pytest.mark.parametrize("method", METHODS)
def test_steps_are_those_of_the_formulas(tmp_path: Path, method: str) -> None:
    """Rows between steps and the last, shorter step have the noise of that step, of its length."""
    model, seed, h = load(tmp_path, DUFFING), 2**40 + 7, 0.25
    r = model.run(2.1, method=method, step=h, every=0.35, seed=seed)
    q, v, step = 1.0, 0.5, METHODS[method]
    drift = lambda t, q: np.cos(2 * t) - q**3  # noqa: E731
    noise = lambda t, q: 0.3 * (1 + q * q + t)  # noqa: E731
    found, k, t = {0.0: (q, v)}, 0, 0.0
    while t < 2.1 - 1e-9:
        for part in (*(row for row in r.t if t + 1e-9 < row < t + h - 1e-9), min(t + h, 2.1)):
            dw = spread(method, 0.4, part - t) * normal(seed, 0, k, 0)
            found[round(float(part), 9)] = step(q, v, t, part - t, drift, 0.4, noise, dw)
        (q, v), t, k = found[round(float(part), 9)], part, k + 1
    rows = np.array([found[round(float(t), 9)] for t in r.t])
    arrived = np.array([r["x"], r["x'"]]).T
    assert arrived == pytest.approx(rows, rel=1e-12, abs=1e-12)
    assert model.run(2.1, method=method, step=h, seed=seed + 1)["x"][-1] != r["x"][-1]


def test_members_have_streams_of_their_own(tmp_path: Path) -> None:
    model, members = load(tmp_path, BATH), np.arange(1, 6)
    q, v = np.zeros(5), np.zeros(5)
    for k in range(4):
        z = spread("baoab", 0.5, 0.5) * normal(3, members, k, 0)
        q, v = METHODS["baoab"](q, v, 0, 0.5, lambda _, q: -q, 0.5, lambda *_: 1.0, z)
    assert ends(model, 5, 2.0, 0.5, seed=3) == pytest.approx(np.array([q, v]), rel=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_strong_order(method: str) -> None:
    """Paths of coarse steps beside those of fine steps with the same increments of W: order 1."""
    c, S, fine, paths, step = 0.4, lambda t, q: 0.3 * (1 + q * q), 2**10, 400, METHODS[method]
    rng, errors = np.random.default_rng(5), []
    unit = spread(method, c, 2 / fine)
    increments = unit * rng.normal(size=(fine, paths))

    def moved(n: int) -> np.ndarray:
        h, many = 2 / n, fine // n
        decay = np.exp(-c * 2 / fine) ** np.arange(many)[::-1] if method == "baoab" else 1
        q, v = np.full(paths, 1.0), np.full(paths, 0.5)
        for k in range(n):
            of = increments[k * many : (k + 1) * many].T * decay
            q, v = step(q, v, k * h, h, lambda t, q: -(q**3), c, S, of.sum(axis=1))
        return np.array([q, v])

    exact = moved(fine)
    for n in (32, 64, 128):
        errors.append(np.sqrt(((moved(n) - exact) ** 2).sum(axis=0).mean()))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx([1, 1], abs=0.15)


@pytest.mark.parametrize("method", METHODS)
def test_weak_order(tmp_path: Path, method: str) -> None:
    """Second moments of an oscillator with noise s (1 + x^2) have linear equations: order 2."""
    model = load(tmp_path, BATH.replace("2*c*kT", "kT/2*(1 + x^2)"))
    moments = [[0, 2, 0, 0], [-1, -0.5, 1, 0], [0.5, -2, -1, 0.5], [0, 0, 0, 0]]
    exact = (expm(np.array(moments) * 2.0) @ [1, 0, 0, 1])[:3]
    errors, n = [], 200_000
    for step in (0.5, 0.25):
        x, v = ends(model, n, 2.0, step, method=method, x=1.0)
        errors.append(np.array([(x * x).mean(), (x * v).mean(), (v * v).mean()]) - exact)
    most = np.argmax(np.abs(errors[0]))
    far, near = np.abs(errors)[:, most]  # noise: 0.002 of each
    assert far > 0.03
    assert 1.4 < np.log2(far / near) < 2.8


@pytest.mark.parametrize("step", [0.25, 1.0, 1.5])
def test_places_of_baoab_do_not_depend_on_the_step(tmp_path: Path, step: float) -> None:
    """<x^2> = kT/k at any step; that of the rates is kT (1 - h^2/4)."""
    n = 40_000
    x, v = ends(load(tmp_path, BATH), n, 24.0, step)
    assert (x**2).mean() == pytest.approx(1, abs=4 * np.sqrt(2 / n))
    assert (v**2).mean() == pytest.approx(1 - step**2 / 4, abs=4 * np.sqrt(2 / n))


EQUIPARTITION = [30_000, pytest.param(1_000_000, marks=pytest.mark.long)]


@pytest.mark.parametrize("n", EQUIPARTITION)
def test_equipartition(tmp_path: Path, n: int) -> None:
    """m <v^2> = k <x^2> = kT, to 4 sigma; the bias of the step, h^2/4, is below 1 sigma."""
    sigma = np.sqrt(2 / n)
    x, v = ends(load(tmp_path, BATH), n, 20.0, 0.04 if n > 500_000 else 0.125)
    assert [(x**2).mean(), (v**2).mean()] == pytest.approx([1, 1], abs=4 * sigma)


def test_diffusion_of_einstein(tmp_path: Path) -> None:
    """<x^2> = 2 D t with D = kT/c: of the exact motion 2 D (t - (1 - exp(-c t))/c + ...)."""
    n, c, t = 20_000, 0.5, 100.0
    model = load(tmp_path, BATH)
    model.params["k"] = 0
    x, _ = ends(model, n, t, 1.0)
    exact = 2 / c * (t - 2 * -np.expm1(-c * t) / c + -np.expm1(-2 * c * t) / (2 * c))
    assert (x**2).mean() == pytest.approx(exact, rel=4 * np.sqrt(2 / n))
    assert exact == pytest.approx(2 / c * t, rel=0.04)


def random_model(seed: int) -> tuple[str, np.ndarray]:
    """Returns a model of linear forces with noise along coordinates and at a point, and the
    stationary covariance of its coordinates and rates."""
    draw = np.random.default_rng(seed)
    n = int(draw.integers(1, 5))
    M, K, C = (np.round(_positive(draw, n, least), 3) for least in (1, 1, 0.8))
    S, at = np.round(draw.uniform(0, 1, n), 3), np.round(draw.normal(size=(3, n)), 3)
    of = np.round(draw.uniform(0, 1, 3), 3) * (draw.uniform(size=3) < 0.7)
    D = np.diag(S) + sum(w * np.outer(row, row) for w, row in zip(of, at, strict=True))

    def form(A: np.ndarray, end: str) -> str:
        pairs = [(i, j) for i in range(n) for j in range(n)]
        return " + ".join(f"({A[i, j] / 2:.6g})*x{i}{end}*x{j}{end}" for i, j in pairs)

    point = ", ".join(" + ".join(f"({w:.6g})*x{i}" for i, w in enumerate(row)) for row in at)
    lines = [f"model random{seed}", "coord " + ", ".join(f"x{i}" for i in range(n))]
    lines += [f"kinetic {form(M, chr(39))}", f"potential {form(K, '')}"]
    lines += [f"dissipation {form(C, chr(39))}", f"let P = [{point}]"]
    lines += [f"noise x{i} = {w:.6g}" for i, w in enumerate(S)]
    lines += [f"noise P = [{', '.join(f'{w:.6g}' for w in of)}]"]
    inverse, zero = np.linalg.inv(M), np.zeros((n, n))
    A = np.block([[zero, np.eye(n)], [-inverse @ K, -inverse @ C]])
    Q = np.block([[zero, zero], [zero, inverse @ D @ inverse]])
    return "\n".join(lines) + "\n", solve_continuous_lyapunov(A, -Q)


def _positive(draw: np.random.Generator, n: int, least: float) -> np.ndarray:
    root = 0.5 * draw.normal(size=(n, n))
    return root @ root.T + least * np.eye(n)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", seeds([1, 2, 3], 37))
def test_covariance_of_random_models(tmp_path: Path, seed: int, method: str) -> None:
    """Averages over time and members beside Lyapunov's equation, to 5 sigma."""
    text, exact = random_model(seed)
    model, members, h = load(tmp_path, text), 400, 0.05
    n = len(model.coordinates)
    names = [*model.coordinates, *model.rates]
    table, every = {"x0": np.zeros(members)}, 0.5
    r = model.ensemble(table, 130.0, method=method, step=h, every=every, seed=seed)
    rows = np.array([r[name].reshape(members, -1)[:, 60:] for name in names])
    each = np.einsum("imt,jmt->mij", rows, rows) / rows.shape[2]
    sigma = each.std(axis=0) / np.sqrt(members)
    bias = 2 * h * h * np.abs(np.diag(exact)).max()
    assert np.abs(each.mean(axis=0) - exact).max() > 0
    assert (np.abs(each.mean(axis=0) - exact) < 5 * sigma + bias).all()
    assert sigma.max() < 0.06 * exact.max() and n == len(exact) // 2


WELL = """model well
param c = 2
coord x
kinetic x'^2/2
potential 8*(x^2 - 1)^2
dissipation c/2*x'^2
noise x = 2*c
start x = -1
"""


def escape_rate(c: float, points: int = 300, many: int = 24) -> float:
    """Returns half the least eigenvalue but 0 of the Klein-Kramers operator in the double well.

    With p = exp(-V/2) psi_0 sum_n a_n(x) psi_n(v), psi_n Hermite functions, the operator is
    da_n/dt = -sqrt(n) D a_(n-1) + sqrt(n+1) D^T a_(n+1) - c n a_n with D = d/dx + V'/2, here on
    grids that are staggered: H. Risken, The Fokker-Planck Equation, Springer 1989, 10.1."""
    grid = np.linspace(-2, 2, points)
    middle, d = (grid[1:] + grid[:-1]) / 2, grid[1] - grid[0]
    V = lambda x: 8 * (x * x - 1) ** 2  # noqa: E731
    up, down = (np.exp((V(x) - V(middle)) / 2) / d for x in (grid[1:], grid[:-1]))
    even = diags([-down, up], [0, 1], (points - 1, points))  # from grid to middle
    up, down = (np.exp((V(middle) - V(x)) / 2) / d for x in (grid[:-1], grid[1:]))
    odd = diags([up, -down], [0, -1], (points, points - 1))  # from middle to grid
    blocks: list[list] = [[None] * many for _ in range(many)]
    for n in range(many):
        blocks[n][n] = -c * n * identity(points - n % 2)
        if n + 1 < many:
            D = odd if n % 2 else even
            blocks[n + 1][n] = -np.sqrt(n + 1) * D
            blocks[n][n + 1] = np.sqrt(n + 1) * D.T
    found = eigs(bmat(blocks, format="csc"), k=3, sigma=1e-5, return_eigenvectors=False)
    return -np.sort(found.real)[-2] / 2


@pytest.mark.long
def test_escape_over_a_barrier(tmp_path: Path) -> None:
    """The rate over 8 kT, of 4,000 crossings of one long motion, is within 5% of the eigenvalue.
    The step takes 1% of the rate, by h^2; the count has 1.6%."""
    rate = escape_rate(2.0)
    assert rate == pytest.approx(escape_rate(2.0, 400, 32), rel=0.005)
    until = 4000 / rate
    r = load(tmp_path, WELL).run(until, method="baoab", step=0.02, every=2.0, record=["x"])
    side = np.sign(r["x"][np.abs(r["x"]) > 0.5])
    assert (np.diff(side) != 0).sum() / until == pytest.approx(rate, rel=0.05)


@pytest.mark.parametrize("method", ["baoab", "stochastic_verlet", "heun"])
def test_an_integral_along_the_motion_has_the_order_of_it(tmp_path: Path, method: str) -> None:
    """An integral is a first-order variable. Without noise the motion has a closed form."""
    text = "model spring\ncoord x\nkinetic x'^2/2\npotential 2*x^2\nstart x = 0.3\n"
    (tmp_path / "spring.lag").write_text(text + "observe right while x > 0\n")
    model = pkgen.load(tmp_path / "spring.lag")
    off = []
    for step in (0.02, 0.01):
        run = model.run(2, method=method, step=step, every=2)
        off.append([run["x"][-1] - 0.3 * np.cos(4), run["right"][-1] - np.pi / 4])
    assert [a / b for a, b in zip(*off, strict=True)] == pytest.approx([4, 4], rel=0.3)
