"""Splitting on random models: forces C v of masses that couple, frames, fields and drags, and stiff
springs that are named fast; of limits and resonances of multiple steps. What is true is dop853."""

from __future__ import annotations

import json
import random
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import pkgen as api
from conftest import case, ran, run_pkgen, seeds, written

UNTIL = 1.5
CONSTANT = {"verlet": 2, "mclachlan4": 4, "blanes_moan4": 4, "kahan_li6": 6, "blanes_moan6": 6}
ANY = {"boris": 2, "boris4": 4, "boris6": 6}
FAST = {"respa": 2, "respa4": 4}
STEPS = {2: (40, 80), 4: (16, 32), 6: (12, 20)}


def times(row: np.ndarray, of: str = "") -> str:
    return " + ".join(f"({c:.17g})*x{j}{of}" for j, c in enumerate(row))


def drawn(seed: int, kind: str) -> tuple[str, np.ndarray]:
    """M a = -k q^3 - sin(P q) P + A cos t + C v, in a frame that turns by W, and M. C may vary;
    nothing but C may push; and instead of C v there may be fast springs."""
    draw = np.random.default_rng(seed)
    n = int(draw.integers(2, 4 if kind == "fast" else 5))
    root = np.eye(n) + 0.15 * draw.normal(size=(n, n))
    M = np.round(root @ root.T, 3)
    k, P, A = ((kind != "free") * np.round(draw.uniform(0.3, 1, n), 3) for _ in range(3))
    field, turn = np.round(draw.normal(size=(2, n, n)), 3)
    G, d = field - field.T, np.round(0.5 * draw.normal(size=n), 3) * (seed % 3 > 0)
    W = 0.4 * (turn - turn.T) * (seed % 2) * (kind in ("constant", "varies"))
    q, v = np.round(draw.normal(size=(2, n)), 3)
    rates = [f"(x{i}' + {times(W[i])})" for i in range(n)]
    text = f"model drawn\ncoord {', '.join(f'x{i}' for i in range(n))}\n"
    for i in range(n):
        text += "".join(f"kinetic ({M[i, j]})*{rates[i]}*{rates[j]}/2\n" for j in range(n))
    text += f"potential -cos({times(P)})\n"
    if kind in ("constant", "free"):  # by L and D, and where C varies as a force
        text += f"dissipation ({times(d, chr(39))})^2/2\n"
        upper = np.triu(G)
        text += "".join(f"lagrangian x{i}*({times(upper[i], chr(39))})\n" for i in range(n))
    if kind == "fast":
        stiff = np.round(draw.uniform(100, 400, n), 1)
        text += f"let springs = {times(stiff / 2, '^2')} + {times(stiff / 4, '^4')}\n"
        text += "fast springs\npotential springs\n"
        q = 0.1 * q
    for i in range(n):
        text += f"force x{i} = {A[i]}*cos(t) - {k[i]}*x{i}^3"
        if kind == "varies":
            text += f" + (1 + 0.5*cos(x0 - t))*({times((G - np.outer(d, d))[i], chr(39))})"
        text += f"\nstart x{i} = {q[i]}, x{i}' = {v[i]}\n"
    return text, M


def end(model: api.Model, method: str, until: float = UNTIL, **how: object) -> np.ndarray:
    rows = model.run(until, method=method, every=until, **how)
    return np.array([rows[name][-1] for name in (*model.coordinates, *model.rates)])


@pytest.mark.parametrize("kind", ["constant", "varies", "fast"])
@pytest.mark.parametrize("seed", seeds([1, 2, 3], 2))
def test_orders(tmp_path: Path, seed: int, kind: str) -> None:
    model = api.load(written(tmp_path, drawn(seed, kind)[0]))
    true = end(model, "dop853", rtol=1e-13)
    assert abs(end(model, "gauss8", step=0.05) - true).max() < 1e-11  # both say the same
    methods = {"constant": CONSTANT | ANY, "varies": ANY, "fast": FAST}[kind]
    for method, order in methods.items():
        steps = (75, 150) if kind == "fast" else STEPS[order]
        coarse, fine = (abs(end(model, method, step=UNTIL / k) - true).max() for k in steps)
        slope = np.log(coarse / fine) / np.log(steps[1] / steps[0])
        assert fine > 1e-13 and abs(slope - order) < 0.7, (method, coarse, fine)
    if kind == "varies":
        with pytest.raises((api.UsageError, api.RunError), match=r"linear (drag|in them)"):
            end(model, "verlet", step=0.1)


@pytest.mark.parametrize("seed", seeds([1, 2, 5], 2))
def test_one_step_is_exact_where_nothing_pushes(tmp_path: Path, seed: int) -> None:
    model = api.load(written(tmp_path, drawn(seed, "free")[0]))
    true = end(model, "dop853", rtol=1e-13)
    for method in CONSTANT:
        assert abs(end(model, method, step=UNTIL) - true).max() < 1e-11, method
    assert abs(end(model, "boris6", step=UNTIL) - true).max() > 1e-10


@pytest.mark.parametrize("seed", seeds([1, 2, 3], 2))
def test_inner_steps_and_the_form(tmp_path: Path, seed: int) -> None:
    text, M = drawn(seed, "fast")
    model, n = api.load(written(tmp_path, text)), len(M)
    # An inner step as long as the step is Verlet's.
    same = end(model, "respa", step=0.02, max_step=0.02)
    assert same == pytest.approx(end(model, "verlet", step=0.02), rel=1e-11)
    # In few steps that Verlet does not survive, with all that is fast well resolved.
    true = end(model, "dop853", rtol=1e-13)
    assert abs(end(model, "respa", step=0.1, max_step=0.002) - true).max() < 0.1
    with suppress(api.RunError):
        assert abs(end(model, "verlet", step=0.1) - true).max() > 0.1

    def after(y: np.ndarray) -> np.ndarray:
        start = dict(zip((*model.coordinates, *model.rates), map(float, y), strict=True))
        return end(model, "respa", 0.05, step=0.05, start=start)

    begin, d = model.start, 1e-5 * np.eye(2 * n)
    flow = np.array([(after(begin + x) - after(begin - x)) / 2e-5 for x in d]).T
    form = np.block([[np.zeros((n, n)), M], [-M, np.zeros((n, n))]])
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
