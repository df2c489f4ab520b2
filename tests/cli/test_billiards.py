"""Lyapunov exponents of motions with impacts, beside closed forms, the literature and a map of
billiards that is independent of the program."""

from __future__ import annotations

import math
import random
from pathlib import Path

import pytest

from conftest import ROOT, diagnosed, run_pkgen

WALL = "contact {}: {} >= 0 restitution 1\n"
SQUARE = "".join(WALL.format(n, g) for n, g in (("left", "x"), ("right", "1 - x"), ("low", "y")))
SQUARE += WALL.format("high", "1 - y")
FREE = "model m\ncoord x, y\nkinetic (x'^2 + y'^2)/2\n"
START = "start x = {:.17g}, y = {:.17g}, x' = {:.17g}, y' = {:.17g}\n"
DISCS = list[tuple[float, float, float]]


def exponent(tmp_path: Path, text: str, until: float, *options: str) -> dict:
    path = tmp_path / "m.lag"
    path.write_text(text)
    end = f"{until!r}"
    options = options or ("--method", "gauss")
    return diagnosed(tmp_path, path, "lyapunov", "--until", end, "--every", end, *options)[0][
        "lyapunov"
    ]


def billiard(discs: DISCS, until: float, angle: float = 1.0) -> float:
    """The exponent of a flight at speed 1 in the unit square among discs: the time average of the
    curvature of a front, which is 1/(1/B + t) in flight and gains 2/(R cos) at a disc (Ya. G.
    Sinai, Russ. Math. Surv. 25:2 (1970) 137)."""
    x, y, u, v, b, t, grown = 0.02, 0.5, math.cos(angle), math.sin(angle), 1.0, 0.0, 0.0
    while t < until:
        s, of = min((((u > 0) - x) / u, 0), (((v > 0) - y) / v, 1), key=lambda found: found[0])
        for disc in discs:
            dx, dy = x - disc[0], y - disc[1]
            along = dx * u + dy * v
            root = along**2 - dx**2 - dy**2 + disc[2] ** 2
            if along < 0 < root and -along - math.sqrt(root) < s:
                s, of = -along - math.sqrt(root), disc
        grown += math.log1p(b * s)
        b, t, x, y = b / (1 + b * s), t + s, x + u * s, y + v * s
        if of == 0:
            u = -u
        elif of == 1:
            v = -v
        else:
            nx, ny = (x - of[0]) / of[2], (y - of[1]) / of[2]
            cosine = -(u * nx + v * ny)
            b, u, v = b + 2 / (of[2] * cosine), u + 2 * cosine * nx, v + 2 * cosine * ny
            u, v = u / math.hypot(u, v), v / math.hypot(u, v)
    return grown / t


def among(discs: DISCS) -> str:
    rows = [WALL.format(f"d{k}", f"(x - {a})^2 + (y - {b})^2 - {r}^2") for k, (a, b, r) in
            enumerate(discs)]  # fmt: skip
    return FREE + SQUARE + "".join(rows) + START.format(0.02, 0.5, math.cos(1), math.sin(1))


@pytest.mark.parametrize("seed", range(3))
def test_discs_in_a_square_at_random(tmp_path: Path, seed: int) -> None:
    rnd = random.Random(seed)
    discs: DISCS = []
    while len(discs) <= seed:
        r = round(rnd.uniform(0.1, 0.2), 3)
        a, b = (round(rnd.uniform(r + 0.05, 0.95 - r), 3) for _ in range(2))
        if all(math.hypot(a - c, b - d) > r + s + 0.01 for c, d, s in discs):
            discs.append((a, b, r))
    found = exponent(tmp_path, among(discs), 600)
    assert found["motion"] == "chaotic" and found["error"] < 0.08 * found["exponent"]
    assert found["exponent"] == pytest.approx(billiard(discs, 2e4), abs=4.5 * found["error"])


def test_the_sinai_billiard(tmp_path: Path) -> None:
    # P. Dahlqvist, Nonlinearity 10 (1997) 159: of the map from disc to disc for small R; a flight
    # takes (1 - pi R^2)/(2 R) in the mean.
    r, zeta3 = 0.1, 1.2020569031595943
    of_map = -2 * math.log(r) + 1 - 4 * math.log(2) + 27 * zeta3 / (2 * math.pi**2)
    expected = of_map * 2 * r / (1 - math.pi * r * r)
    assert billiard([(0.5, 0.5, r)], 1e5) == pytest.approx(expected, rel=0.03)
    found = exponent(tmp_path, among([(0.5, 0.5, r)]), 2000)
    assert found["motion"] == "chaotic" and found["error"] < 0.08 * expected
    assert found["exponent"] == pytest.approx(expected, abs=4.5 * found["error"])


def test_the_stadium(tmp_path: Path) -> None:
    # .43 for half circles of radius 1 and straight parts of 2: G. Benettin, J.-M. Strelcyn, Phys.
    # Rev. A 17 (1978) 773. Here the wall has kinks besides.
    wall = WALL.format("wall", "1 - max(abs(x) - 1, 0)^2 - y^2")
    found = exponent(tmp_path, FREE + wall + START.format(0.3, 0.1, math.cos(1), math.sin(1)), 2000)
    assert found["motion"] == "chaotic" and found["exponent"] == pytest.approx(0.43, rel=0.12)


TWO = FREE + WALL.format("a", "x^2 + y^2 - 1") + WALL.format("b", "(x - 3)^2 + y^2 - 1")
TENT = FREE + "event tick: x - 1 rising then x = 0, y = 1.9*min(y, 1 - y)\n"
HALF = math.log(0.5)


@pytest.mark.parametrize(
    "text, until, expected, tolerance",
    [
        # To and fro between two discs: the trace of a flight of 1 and a mirror of -1/2 is 4.
        (TWO + START.format(1.5, 0, 1, 0), 500, math.log(2 + math.sqrt(3)), 1e-6),
        (TENT + START.format(0.5, 0.3, 1, 0), 500, math.log(1.9), 1e-6),
        # Regular ones, of which displacements grow like t at most.
        ("model m\ncoord y\nkinetic y'^2/2\npotential y\n" + WALL.format("w", "y") + "start y = 1",
         1000, 0, 0.005),
        (FREE + SQUARE + START.format(0.4, 0.1, math.cos(1), math.sin(1)), 1000, 0, 0.005),
        (FREE + WALL.format("w", "1 - x^2 - y^2") + START.format(0.4, 0.1, 1, 0.7), 1000, 0, 0.005),
        # A ball on a shaken plate, by the period 1 of both: the determinant of its map is e^2, and
        # its trace is small enough for two complex factors of the size e = 1/2.
        ((ROOT / "tests/regimes/models/shaken_plate.lag").read_text(), 300, HALF, 0.01),
    ],
    ids=["two_discs", "tent", "ball", "square", "circle", "shaken_plate"],
)  # fmt: skip
def test_closed_forms(
    tmp_path: Path, text: str, until: float, expected: float, tolerance: float
) -> None:
    for method in ("gauss", "dop853"):
        found = exponent(tmp_path, text, until, "--method", method)
        assert found["exponent"] == pytest.approx(expected, abs=tolerance), method
        assert found["motion"] == ("chaotic" if expected > 0 else "regular")
        assert found["time"] == pytest.approx(until)


BALL = "model m\ncoord y\nkinetic y'^2/2\npotential y\nstart y = 1\n"


@pytest.mark.parametrize(
    "text, code, says",
    [
        (BALL + "contact w: y >= 0 restitution 0.5", 2, "contact w stays closed from t = 4.24264"),
        ("model m\ncoord x\nkinetic x'^2/2\nstart x' = 1\ncontact w: 1 - x >= 0", 2, "become one"),
        (BALL + "friction y = 0.1", 1, "--diagnose knows no friction"),
        (
            FREE + "constraint c: x = y\nstart x' = 1, y' = 1\n"
            "event gone: x - 1 rising\nmode held: constraint c off at gone",
            1,
            "--diagnose knows no modes",
        ),
        (
            FREE + "constraint c: x = y\nstart x' = 1, y' = 1\ncontact w: 1 - x >= 0 restitution 1",
            2,
            "the model has constraints",
        ),
    ],
    ids=["at_rest", "one", "friction", "mode", "constraint"],
)
def test_refused(tmp_path: Path, text: str, code: int, says: str) -> None:
    (tmp_path / "m.lag").write_text(text + "\n")
    end = ("--until", "10", "--every", "1", "--method", "gauss")
    done = run_pkgen("run", tmp_path / "m.lag", *end, "--diagnose", "lyapunov", cwd=tmp_path)
    assert done.returncode == code and says in done.stderr, done.stderr
