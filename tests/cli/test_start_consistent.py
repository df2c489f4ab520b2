"""`start consistent`: the start on the constraints that is nearest in the metric of M."""

import json
import random
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from scipy import optimize

import pkgen
from conftest import ROOT, ran, run_pkgen
from pkgen.compiler import check_model
from pkgen.front.read import from_text

# Each model: coordinates, T, constraints (A - B) of positions, and of rates; t is the time.
Q, V = sp.symbols("a b c"), sp.symbols("a_ b_ c_")
t = sp.Symbol("t")


def quadratic(draw: random.Random) -> sp.Expr:
    """A positive definite T with constant M."""
    root = sp.Matrix(3, 3, lambda i, j: sp.Rational(draw.randint(-9, 9), 9) + 2 * (i == j))
    rates = sp.Matrix(V)
    return sp.expand((rates.T * root.T * root * rates)[0] / 2)


def surface(draw: random.Random) -> tuple:
    a, b, c = (sp.Rational(draw.randint(4, 20), 9) for _ in range(3))
    x, y, z = Q
    tilt = sp.Rational(draw.randint(-3, 3), 9)
    wall = a * x**2 + b * y**2 + c * z**2 + tilt * x * y - (1 + sp.Rational(1, 5) * t)
    return quadratic(draw), [wall], [], [draw.uniform(-0.9, 0.9) for _ in Q]


def curve(draw: random.Random) -> tuple:
    x, y, z = Q
    k = sp.Rational(draw.randint(1, 9), 9)
    rows = [x**2 + y**2 + z**2 - 1, z - k * x * y - k / 5]
    return quadratic(draw), rows, [], [draw.uniform(0.2, 0.9) for _ in Q]


def four_bar(draw: random.Random) -> tuple:
    """A crank a, a coupler b and a rocker c, by their angles; M depends on them."""
    bars = [sp.Rational(draw.randint(9, 12), 10) for _ in range(3)]
    base = sp.Rational(draw.randint(10, 14), 10)
    a, b, c = Q
    u, v, w = V
    T = (bars[0] * u) ** 2 / 6 + (bars[2] * w) ** 2 / 6
    T += (
        (bars[0] * u) ** 2 + (bars[1] * v) ** 2 / 3 + bars[0] * bars[1] * u * v * sp.cos(a - b)
    ) / 2
    rows = [
        bars[0] * sp.cos(a) + bars[1] * sp.cos(b) - base - bars[2] * sp.cos(c),
        bars[0] * sp.sin(a) + bars[1] * sp.sin(b) - bars[2] * sp.sin(c),
    ]
    return sp.expand(T), rows, [], [draw.uniform(0.9, 1.5), draw.uniform(-0.3, 0.3), 1.5]


def blade(draw: random.Random) -> tuple:
    """A blade that slides along its angle c, its mass beside it."""
    c = Q[2]
    u, v, w = V
    off = sp.Rational(draw.randint(1, 9), 10)
    T = 2 * (u**2 + v**2) / 2 + 2 * off * w * (v * sp.cos(c) - u * sp.sin(c)) + w**2
    return T, [], [u * sp.sin(c) - v * sp.cos(c) - t], [draw.uniform(-2, 2) for _ in Q]


def on_a_disk(draw: random.Random) -> tuple:
    """A constraint of positions and a rolling one."""
    a, b, c = Q
    u, v, w = V
    rolls = u * sp.sin(c) - v * sp.cos(c) - sp.Rational(1, 4) * w
    return quadratic(draw), [a**2 + b**2 - 1], [rolls], [draw.uniform(0.2, 0.9) for _ in Q]


def lag(x: sp.Expr) -> str:
    return re.sub(r"\b([abc])_", r"\1'", sp.sstr(x).replace("**", "^"))


def written(T: sp.Expr, places: list, rates: list, q0: list, v0: list, how: str) -> str:
    lines = ["model m", "coord a, b, c", f"kinetic {lag(T)}"]
    lines += [f"constraint p{k}: {lag(row)} = 0" for k, row in enumerate(places)]
    lines += [f"rolling r{k}: {lag(row)} = 0" for k, row in enumerate(rates)]
    given = [f"{s} = {x!r}" for s, x in zip(Q, q0, strict=True)]
    given += [f"{s}' = {x!r}" for s, x in zip(Q, v0, strict=True)]
    return "\n".join([*lines, "start " + ", ".join(given), *how.split("|")]) + "\n"


def expected(T: sp.Expr, places: list, rates: list, q0: list, v0: list) -> tuple:
    """By SciPy's minimisation, and Newton's method for its Lagrange equations; the rates by
    linear algebra."""
    M = sp.lambdify([Q], sp.hessian(T, V))
    metric = np.array(M(q0), float)
    phi = sp.lambdify([Q], [row.subs(t, 0) for row in places])
    slope = sp.Matrix([[row.diff(s) for s in Q] for row in places]) if places else sp.zeros(0, 3)
    J = sp.lambdify([Q], slope.subs(t, 0))
    q = np.array(q0)
    if places:
        rule = {"type": "eq", "fun": lambda q: np.array(phi(q), float)}
        start = q
        found = optimize.minimize(
            lambda q: (q - start) @ metric @ (q - start), start, constraints=rule, tol=1e-10
        )

        def lagrange(z: np.ndarray) -> np.ndarray:
            rows = np.array(J(z[:3]), float).reshape(-1, 3)
            return np.concatenate([metric @ (z[:3] - start) + rows.T @ z[3:], phi(z[:3])])

        rows = np.array(J(found.x), float).reshape(-1, 3)
        multipliers = np.linalg.lstsq(rows.T, -metric @ (found.x - start), rcond=None)[0]
        q = optimize.root(lagrange, [*found.x, *multipliers], tol=1e-14).x[:3]
        assert np.abs(q - found.x).max() < 1e-4
    pairs = [*zip(Q, V, strict=True)]
    every = [row.diff(t) + sum(row.diff(s) * r for s, r in pairs) for row in places] + rates
    at = dict(zip(Q, map(float, q), strict=True)) | {t: 0}
    A = np.array([[float(row.diff(r).subs(at)) for r in V] for row in every])
    off = np.array([float(row.subs(at).subs(dict(zip(V, v0, strict=True)))) for row in every])
    W = np.linalg.solve(np.array(M(q), float), A.T)
    return q, np.array(v0) - W @ np.linalg.solve(A @ W, off)


KINDS = [surface, curve, four_bar, blade, on_a_disk]


@pytest.mark.parametrize("seed", range(15))
def test_against_a_minimisation(seed: int, tmp_path: Path) -> None:
    draw = random.Random(seed)
    T, places, rates, q0 = KINDS[seed % 5](draw)
    v0 = [draw.uniform(-2, 2) for _ in Q]
    path = tmp_path / "m.lag"
    path.write_text(written(T, places, rates, q0, v0, "start consistent"))
    q, v = expected(T, places, rates, q0, v0)
    found = pkgen.load(path).start
    assert np.abs(found[:3] - q).max() < 1e-9 and np.abs(found[3:] - v).max() < 1e-9
    assert np.abs(found - [*q0, *v0]).max() > 1e-3


ROD = """model rod
param l = 2
param m = 3
coord x, y
kinetic x'^2/2 + m*y'^2/2
potential 9.81*y
constraint rod: x^2 + y^2 = l^2
"""
GIVEN = "start x = 1, y = -1, x' = 1, y' = 1\n"


def nearest(length: float, m: float, x0: float, y0: float) -> np.ndarray:
    """The nearest point of a circle, from a fine search and its refinement."""

    def far(a: float) -> float:
        return (length * np.cos(a) - x0) ** 2 + m * (length * np.sin(a) - y0) ** 2

    a = min(np.linspace(-np.pi, np.pi, 2001), key=far)
    a = optimize.brentq(
        lambda a: optimize.approx_fprime([a], lambda z: far(z[0]))[0], a - 0.01, a + 0.01
    )
    return length * np.array([np.cos(a), np.sin(a)])


def test_a_run_says_and_records_it(tmp_path: Path) -> None:
    path, rows = tmp_path / "rod.lag", tmp_path / "rows.csv"
    path.write_text(ROD + GIVEN + "start consistent\n")
    done = ran("run", path, "--until", 1, "--every", 1, "-o", rows)
    first = np.genfromtxt(rows, delimiter=",", names=True)[0]
    assert abs(first["x"] ** 2 + first["y"] ** 2 - 4) < 1e-14
    assert np.allclose([first["x"], first["y"]], nearest(2, 3, 1, -1), atol=1e-6)
    shown = f"run: start: x = {first['x']:.12g}, y = {first['y']:.12g}, x' = "
    assert shown in done.stderr
    record = json.loads(next(tmp_path.glob("rows*.json")).read_text())["report"]["start"]
    assert [*record] == ["x", "y", "x'", "y'"] and record["y"] == first["y"]
    # Parameters and starts of a run are those of the start that is found.
    m = pkgen.load(path)
    m.params["l"] = 3
    assert np.allclose(m.start[:2], nearest(3, 3, 1, -1), atol=1e-6)
    r = m.run(1, start={"x": 2.5}, every=1)
    assert np.allclose([r["x"][0], r["y"][0]], nearest(3, 3, 2.5, -1), atol=1e-6)
    assert "start: x = " in r.messages and abs(r["x"][-1] ** 2 + r["y"][-1] ** 2 - 9) < 1e-13


def test_states_are_said_too(tmp_path: Path) -> None:
    """A state and an integral have a start, behind the rates."""
    path = tmp_path / "rod.lag"
    more = "state s\nrate s = x\nobserve turned = integral(x*y' - y*x')\nstart s = 3\n"
    path.write_text(ROD + more + GIVEN + "start consistent\n")
    assert "s = 3, turned = 0\n" in ran("run", path, "--until", 1).stderr
    start = pkgen.load(path).run(1).report["start"]
    assert [*start] == ["x", "y", "x'", "y'", "s", "turned"]


def test_of_a_scene_and_without(tmp_path: Path) -> None:
    """A scene asks for it; without it the error names it, and a start that holds stays."""
    path = tmp_path / "rod.lag"
    scene = "scene {}\nstart {}\nuntil 1\nrecord x every 1\nexpect x = {} within 1e-6 at 0\nend\n"
    scenes = scene.format("a", "consistent", nearest(2, 3, 0, -2)[0])
    scenes += scene.format("b", "x = 2, y = 0, y' = 0.5\nstart consistent", 2)
    path.write_text(ROD + "start y = -2\n" + scenes)
    for name in "ab":
        assert "expected: 1 of 1 met" in ran("run", path, "--scene", name).stderr
    path.write_text(ROD + GIVEN)
    done = run_pkgen("check", path)
    assert done.returncode == 1 and "; or say: start consistent" in done.stderr
    assert "rod.lag:7:1: error: the start breaks the constraint 'rod'" in done.stderr


def test_far_starts_and_slow_ones(tmp_path: Path) -> None:
    """From far outside, where the constraint bends more than the distance is long, and from near
    the centre of the circle."""
    path = tmp_path / "rod.lag"
    for x0, y0 in ((9.0, 5.0), (-30.0, 1.0), (0.02, 0.01), (0.0, -40.0), (1.9, 0.0)):
        path.write_text(ROD + f"start x = {x0}, y = {y0}\nstart consistent\n")
        assert np.allclose(pkgen.load(path).start[:2], nearest(2, 3, x0, y0), atol=1e-5), (x0, y0)


def test_a_program_does_it_too(tmp_path: Path) -> None:
    path = tmp_path / "rod.lag"
    path.write_text(ROD + GIVEN + "start consistent\n")
    ran("build", path, "-o", tmp_path / "rod")
    done = subprocess.run(
        [tmp_path / "rod", "--until", "1", "--every", "1"],
        capture_output=True,
        text=True,
        check=True,
    )
    first = [float(x) for x in done.stdout.splitlines()[1].split(",")]
    assert np.allclose(first[1:3], nearest(2, 3, 1, -1), atol=1e-6)


REFUSED = {
    "coord x\nkinetic x'^2/2\nstart consistent": "there is no constraint: every start is",
    "coord x\nkinetic x'^2/2\nstart x": "'x' has no value here",
    "coord x\nrotation R\nkinetic x'^2/2 + dot(omega(R), omega(R))/2\nconstraint c: x = 1\n"
    "start consistent": "'start consistent' does not turn rotations",
    "coord x, y\nkinetic x'^2/2 + y'^2/2\nconstraint c: x^2 + y^2 + 1 = 0\nstart x = 1\n"
    "start consistent": "no start that satisfies the constraints is found near the given values",
    "coord x, y\nkinetic x'^2/2 + y'^2/2\nconstraint c: x*y = 1\nstart consistent": "no start",
}


@pytest.mark.parametrize("said", REFUSED)
def test_what_is_refused(said: str, tmp_path: Path) -> None:
    path = tmp_path / "m.lag"
    path.write_text(f"model m\n{said}\n")
    done = run_pkgen("check", path)
    assert done.returncode == 1 and REFUSED[said] in done.stderr and "^" in done.stderr


def test_what_a_run_refuses(tmp_path: Path) -> None:
    path, members = tmp_path / "rod.lag", tmp_path / "members.csv"
    path.write_text(ROD + GIVEN + "start consistent\n")
    members.write_text("x\n1\n2\n")
    done = run_pkgen("run", path, "--until", 1, "--ensemble", members)
    assert done.returncode == 2 and "rod.lag:9:1: 'start consistent' is for one run" in done.stderr
    done = run_pkgen("run", path, "--until", 1, "--start", "x=0", "--start", "y=0")
    assert done.returncode == 4 and "the constraints cannot be fulfilled here" in done.stderr
    m = pkgen.load(path)
    m.params["l"] = 2
    with pytest.raises(pkgen.RunError, match="cannot be fulfilled here"):
        m.run(1, start={"x": 0, "y": 0})


def test_words_and_families(tmp_path: Path) -> None:
    """A coordinate may be called so; a family is written out; rows that follow are left out."""
    for text in (
        "coord consistent\nkinetic consistent'^2/2\nstart consistent = 1",
        "coord consistent, y\nkinetic consistent'^2/2 + y'^2/2\nconstraint c: consistent = y\n"
        "start consistent = 1\nstart consistent",
    ):
        check_model(from_text("m.lag", f"model m\n{text}\n"))
    path = tmp_path / "chain.lag"
    path.write_text(
        "model chain\nsize N = 40\ncoord x[1..N], y[1..N]\n"
        "fixed x[0] = 0, y[0] = 0\n"
        "kinetic sum(x[i]'^2/2 + y[i]'^2/2, i = 1..N)\npotential 9.81*sum(y[i], i = 1..N)\n"
        "constraint rod[i = 1..N]: (x[i] - x[i-1])^2 + (y[i] - y[i-1])^2 = 0.01\n"
        "start x[i = 1..N] = 0.09*i\nstart consistent\n"
    )
    start = pkgen.load(path).start
    assert np.allclose(start[:40], 0.1 * np.arange(1, 41), atol=1e-12)
    path.write_text(
        ROD + "constraint again: 2*x^2 + 2*y^2 = 2*l^2\n" + GIVEN + "start consistent\n"
    )
    assert np.allclose(pkgen.load(path).start[:2], nearest(2, 3, 1, -1), atol=1e-6)
    ran("run", path, "--until", 1)


def test_the_example_of_the_docs(tmp_path: Path) -> None:
    page = (ROOT / "docs/language.md").read_text()
    path = tmp_path / "held_by_a_rod.lag"
    path.write_text(next(x for x in re.findall(r"```lag\n(.*?)```", page, re.S) if "held_by" in x))
    said = ran("run", path, "--scene", "swings").stderr
    assert "expected: 2 of 2 met" in said
    assert next(line for line in said.splitlines() if "start:" in line) in page
