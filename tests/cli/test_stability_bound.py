"""`pkgen stability` of models with rotations and constraints: scales beside independent figures."""

from __future__ import annotations

import cmath
import math
import random
from collections.abc import Callable

import pytest
from scipy.optimize import brentq
from stability_asker import asker, mapped

from conftest import ROOT, case, seeds


def first(off: Callable[[float], float]) -> float:
    """The least y at which four steps of a motion exp(i t) are off by half of what it covers."""
    low = next(0.01 * k for k in range(1, 1000) if off(0.01 * (k + 1)) >= 1)
    return brentq(lambda y: off(y) - 1, low, low + 0.01, xtol=1e-14)


def rk4(y: float) -> float:
    z = 1j * y
    return abs((1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24) ** 4 - cmath.exp(4 * z))


# By what the midpoint rule and Verlet turn too little or too far: a sixth of a turn.
RK4 = first(rk4)
MIDPOINT = first(lambda y: 4 * (y - 2 * math.atan(y / 2)) * 3 / math.pi)
VERLET = first(lambda y: 4 * (2 * math.asin(min(y / 2, 1)) - y) * 3 / math.pi)
ON_GROUP = 2.0  # of a body that turns, lie_midpoint's pole
BOUND = (
    "bodies/free_body",
    "bodies/heavy_top_rotation",
    "constrained/pendulum_rod",
    "constrained/chaplygin_sleigh",
    "constrained/rolling_disk",
    "constrained/gimbals",
)

TOP = case("stability_bound_top")
ANGLE = case("stability_bound_angle")
ROD = case("stability_bound_rod")
SWIVEL = case("stability_bound_swivel")


FEW = ("--points", "4x2")


def scales(found: dict) -> dict[str, dict]:
    return {p["method"]: p for p in found["predictions"] if p["kind"] == "local"}


@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_random_symmetric_tops(tmp_path, seed: int) -> None:
    """In the body omega goes round at (I3 - I1)/I1 w3, the quaternion by half of |omega|; methods
    on the group see the body turn itself."""
    r = random.Random(seed)
    I1, I3 = r.uniform(0.5, 2), r.uniform(0.5, 2)
    w1, w3 = r.uniform(0.2, 2), r.uniform(1, 4)
    top = TOP.format(I1=I1, I3=I3, w1=w1, w3=w3)
    found = mapped(tmp_path, top, *FEW, "--methods", "rk4,lie_midpoint")
    nutation, turn = abs(I3 - I1) / I1 * w3, math.hypot(w1, w3)
    told = scales(found)
    assert told["rk4"]["h"] == pytest.approx(RK4 / max(nutation, turn / 2), rel=1e-6)
    assert told["lie_midpoint"]["h"] == pytest.approx(
        min(ON_GROUP / turn, MIDPOINT / nutation), rel=1e-6
    )
    for p in told.values():
        assert 0.5 < p["measured"] / p["h"] < 2, p
    assert not any("predicted" in miss["text"] for miss in found["misses"])


@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_random_pendulums_of_rods(seed: int) -> None:
    """A small swing of one by x, y and of a body on an arm goes at the rate of one by its angle."""
    r = random.Random(seed)
    of = {"l": r.uniform(0.2, 3), "g": r.uniform(1, 20), "a": 0.01}
    rates = {
        text: max(m.rate for m in asker(text.format(**of), until=10).rates() if not m.on_group)
        for text in (ANGLE, ROD, SWIVEL)
    }
    assert rates[ANGLE] == pytest.approx(math.sqrt(of["g"] / of["l"]), rel=1e-4)
    assert rates[ROD] == pytest.approx(rates[ANGLE], rel=0.01)
    # Its own inertia, 1, beside l^2.
    slower = math.sqrt(of["l"] ** 2 / (of["l"] ** 2 + 1))
    assert rates[SWIVEL] == pytest.approx(rates[ANGLE] * slower, rel=0.01)


@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_random_starts_are_put_onto_constraints(tmp_path, seed: int) -> None:
    """Rows scale the start's coordinates, which leaves the rod, and come back to it."""
    r = random.Random(seed)
    rod = ROD.format(l=r.uniform(0.2, 3), g=r.uniform(1, 20), a=r.uniform(0.2, 2))
    found = mapped(tmp_path, rod, *FEW, "--methods", "rk4,rattle")
    assert found["varied"]["name"] == "amplitude"
    assert all(row["motion"] == "PK_DONE" for row in found["rows"])
    told = scales(found)
    assert set(told) == {"rk4", "rattle"}
    for p in told.values():
        assert 0.5 < p["measured"] / p["h"] < 2, p
    assert told["rk4"]["h"] / told["rattle"]["h"] == pytest.approx(RK4 / VERLET, rel=1e-6)
    assert {p["kind"] for p in found["points"]} & {"bounded", "drifting"}


@pytest.mark.parametrize("name", BOUND)
def test_models_shipped_have_a_scale_that_holds(tmp_path, name: str) -> None:
    text = (ROOT / f"models/{name}.lag").read_text()
    found = mapped(tmp_path, text, *FEW, "--methods", "rk4,lobatto3")
    for p in scales(found).values():
        assert 0.5 < p["measured"] / p["h"] < 2, p
    assert len(scales(found)) == 2
    assert any("resonances, cycles and ghosts are not sought" in x for x in found["remarks"])


def test_methods_that_a_model_refuses_are_named(tmp_path) -> None:
    text = (ROOT / "models/constrained/rolling_disk.lag").read_text()
    found = mapped(tmp_path, text, *FEW, "--methods", "rk4,rattle,verlet")
    assert {p["method"] for p in found["points"]} == {"rk4"}
    assert any("rattle is refused" in said for said in found["remarks"])
    assert any("verlet is refused" in said for said in found["remarks"])


def test_what_leaves_the_constraints_is_told(tmp_path) -> None:
    rod = ROD.format(l=1, g=1, a=1)
    found = mapped(tmp_path, rod, *FEW, "--methods", "rk4", "--steps", "0.1..20")
    kinds = [p["kind"] for p in found["points"]]
    assert "off constraints" in kinds and kinds.count("off constraints") < len(kinds)
