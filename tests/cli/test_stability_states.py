"""`pkgen stability` of first-order models: what it predicts against closed forms and runs."""

from __future__ import annotations

import math
import random
from pathlib import Path

import pytest
from scipy.optimize import brentq
from stability_asker import PENDULUM, asker, mapped, point, start

from conftest import ROOT, seeds

# The limit of u' = lambda u on the negative real axis: 1 + z + z^2/2 + z^3/6 + z^4/24 = 1.
RK4_REAL = 2.785293563405282


FEW = ("--points", "3x2", "--methods")


def limits(made: dict) -> dict[str, dict]:
    return {p["method"]: p for p in made["predictions"] if p["kind"] == "limit"}


def test_logistic(tmp_path: Path) -> None:
    """x = 1 attracts at the rate 1, x = 0 repels."""
    text = "model logistic\nstate x\nrate x = x*(1 - x)\nstart x = 0.5\n"
    made = mapped(tmp_path, text, *FEW, "rk4,gauss1")
    places = {round(e["v"][0], 12): e["verdict"] for e in made["equilibria"]}
    assert places == {0.0: "unstable", 1.0: "stable"}
    found = limits(made)
    assert found["rk4"]["h"] == pytest.approx(RK4_REAL, rel=1e-6)
    assert found["rk4"]["measured"] == pytest.approx(RK4_REAL, rel=0.01)
    assert found["gauss1"]["h"] is None and found["gauss1"]["measured"] is None


@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_random_spirals(tmp_path: Path, seed: int) -> None:
    """Of x' = -a x + b y + cubic, y' = -b x - c y + cubic at the origin: rk4's polynomial on the
    eigenvalues says where it stops to contract; measured within 1%."""
    draw = random.Random(seed)
    a, c = (10 ** draw.uniform(-1, 1) for _ in range(2))
    b = 10 ** draw.uniform(-1, 1)
    cubic = draw.uniform(-1, 1)
    text = (
        f"model spiral\nstate x, y\nrate x = -{a!r}*x + {b!r}*y + {cubic!r}*x*y^2\n"
        f"rate y = -{b!r}*x - {c!r}*y - {cubic!r}*y*x^2\nstart x = 0.1, y = -0.05\n"
    )
    made = mapped(tmp_path, text, *FEW, "rk4", "--until", "40")
    half, product = -(a + c) / 2, a * c + b * b
    root = complex(half * half - product) ** 0.5
    lambdas = (half + root, half - root)

    def grown(h: float) -> float:
        return max(abs(sum((h * x) ** k / math.factorial(k) for k in range(5))) for x in lambdas)

    beyond = next(h for h in (1e-3 * k for k in range(1, 10**6)) if grown(h) > 1)
    exact = brentq(lambda h: grown(h) - 1, max(beyond - 1e-3, 1e-9), beyond, xtol=1e-14)
    found = limits(made)["rk4"]
    assert found["h"] == pytest.approx(exact, rel=1e-6)
    assert found["measured"] == pytest.approx(exact, rel=0.01)


def test_lorenz(tmp_path: Path) -> None:
    """Three equilibria, none of them stable: along the chaotic motion there is a scale."""
    text = (
        "model lorenz\nstate x, y, z\nrate x = 10*(y - x)\nrate y = x*(28 - z) - y\n"
        "rate z = x*y - 8/3*z\nstart x = 1, y = 1, z = 1\n"
    )
    made = mapped(tmp_path, text, *FEW, "rk4", "--until", "5")
    r = math.sqrt(72)
    places = sorted(tuple(round(x, 9) for x in e["v"]) for e in made["equilibria"])
    assert places == sorted(
        tuple(round(x, 9) for x in e) for e in ((0, 0, 0), (r, r, 27), (-r, -r, 27))
    )
    (scale,) = [p for p in made["predictions"] if p["kind"] == "local"]
    assert not scale["sharp"] and 0.5 <= scale["measured"] / scale["h"] <= 2


def test_an_integral_decides_nothing(tmp_path: Path) -> None:
    """The action of an oscillator is no place to rest, and the map is that without it."""
    oscillator = "model bob\ncoord x\nkinetic x'^2/2\npotential 1 - cos(x)\nstart x = 0.5\n"
    action = oscillator.replace("coord x\n", "coord x\nstate S\n") + "rate S = L\n"
    without = mapped(tmp_path, oscillator, *FEW, "rk4,gauss1", "--steps", "0.2..1.8")
    made = mapped(tmp_path, action, *FEW, "rk4,gauss1", "--steps", "0.2..1.8")
    assert [p["h"] for p in made["predictions"]] == [p["h"] for p in without["predictions"]]
    assert [p["kind"] for p in made["points"]] == [p["kind"] for p in without["points"]]


def test_a_limit_beyond_which_growth_is_slow(tmp_path: Path) -> None:
    """Euler's method on a weakly damped oscillation: |1 + h lambda|^2 = 1 - 2 c h + w^2 h^2."""
    c, w = 0.03, 1.0
    text = (
        f"model slow\nstate x, y\nrate x = y\nrate y = -{w**2!r}*x - {2 * c!r}*y\n"
        "start x = 0.1, y = 0\n"
    )
    found = limits(mapped(tmp_path, text, *FEW, "euler", "--until", "40"))["euler"]
    assert found["h"] == pytest.approx(2 * c / w**2, rel=1e-6)
    assert found["measured"] == pytest.approx(found["h"], rel=0.01)


@pytest.mark.parametrize(("name", "places"), [("vortex_pair", []), ("lotka_volterra", [[1, 1]])])
def test_what_is_no_equilibrium(name: str, places: list) -> None:
    """Vortices rest at infinity alone; log x has no value at x = 0."""
    text = (ROOT / f"tests/regimes/models/{name}.lag").read_text(encoding="utf-8")
    assert [[round(x, 9) for x in e.v] for e in asker(text).rest().equilibria] == places


def test_a_motion_at_rest_has_points() -> None:
    assert point(start(asker(PENDULUM), 0.0), "rk4", 0.1).kind == "bounded"
