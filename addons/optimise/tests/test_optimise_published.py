"""Optima that others have published, and motions that repeat."""

from __future__ import annotations

import math
from pathlib import Path

import numpy
import pytest
from published import ACROBOT, CART_POLE, GODDARD, SOLVERS, STEERING, WALKER, best

import pkgen

pytestmark = pytest.mark.needs_addon("optimise")


@pytest.mark.long
@pytest.mark.parametrize("solver", SOLVERS)
def test_cart_pole(solver: str, tmp_path: Path) -> None:
    """M. Kelly, SIAM Review 59 (2017) 849, section 6: about 58.8; 58.81 with 40 intervals."""
    end = {"x": 1, "theta": math.pi, "x'": 0, "theta'": 0}
    limits = {"inputs": {"F": (-20, 20)}, "path": {"x": (-2, 2)}}
    wanted = {"integral": "F^2", "end": end, "until": 2, "linear": True}
    found = best(tmp_path, CART_POLE, solver, **wanted, **limits)
    assert found.objective == pytest.approx(58.8711147, abs=1e-6)


@pytest.mark.parametrize("solver", [SOLVERS[0], pytest.param("slsqp", marks=pytest.mark.long)])
def test_steering(solver: str, tmp_path: Path) -> None:
    """E. D. Dolan, J. J. Moré, T. S. Munson, COPS 3.0 (2004), problem 6: 0.554570879."""
    limits = {"inputs": {"s": (-math.pi / 2, math.pi / 2)}, "until": (0.1, 2)}
    end, guess = {"y": 5, "x'": 45, "y'": 0}, {"t": (0.5, 0.7), "s": (1, -1)}
    wanted = {"minimise": "t", "end": end, "guess": guess, "linear": True}
    found = best(tmp_path, STEERING, solver, **wanted, **limits)
    assert found.objective == pytest.approx(0.554570879, abs=4e-8)


def test_goddard(tmp_path: Path) -> None:
    """COPS 3.0, problem 10: a rocket's final height 1.01283, with a singular arc."""
    guess = {"T": (3, 0), "h": (1, 1.01), "v": (0.05, 0), "m": (1, 0.6)}
    wanted = {"maximise": "h", "end": {"m": 0.6}, "guess": guess}
    limits = {"inputs": {"T": (0, 3.5)}, "until": (0.1, 0.3)}
    found = best(tmp_path, GODDARD, "ipopt", **wanted, **limits)
    assert found.objective == pytest.approx(1.01283, abs=5e-6)


@pytest.mark.long
def test_acrobot_swings_up_and_a_finer_grid_agrees(tmp_path: Path) -> None:
    end = {"q1": math.pi, "q2": 0, "q1'": 0, "q2'": 0}
    wanted = {"integral": "u^2", "inputs": {"u": (-20, 20)}, "end": end, "until": 3}
    found = [best(tmp_path, ACROBOT, "ipopt", linear=True, intervals=n, **wanted) for n in (15, 30)]
    run = found[1].run(rtol=1e-11)
    assert [run[name][-1] for name in end] == pytest.approx([*end.values()], abs=1e-6)
    assert found[1].objective == pytest.approx(found[0].objective, rel=3e-4)


def crossed(r: numpy.ndarray, v: numpy.ndarray) -> float:
    return float(r[0] * v[1] - r[1] * v[0])


def masses(p: dict, s: float, n: float, rates: tuple[float, float], foot: str) -> dict:
    """Places and velocities of the walker's masses and of its hip, about the foot s or n."""
    up = {k: numpy.array([math.sin(x), math.cos(x)]) for k, x in (("s", s), ("n", n))}
    along = {k: numpy.array([math.cos(x), -math.sin(x)]) for k, x in (("s", s), ("n", n))}
    rate = dict(zip("sn", rates, strict=True))
    other = "n" if foot == "s" else "s"
    length = p["a"] + p["b"]
    hip = length * up[foot], length * rate[foot] * along[foot]
    return {
        "hip": (p["mH"], *hip),
        foot: (p["m"], p["a"] * up[foot], p["a"] * rate[foot] * along[foot]),
        other: (p["m"], hip[0] - p["b"] * up[other], hip[1] - p["b"] * rate[other] * along[other]),
    }


@pytest.mark.parametrize("solver", [SOLVERS[0], pytest.param("slsqp", marks=pytest.mark.long)])
def test_a_gait_repeats_and_its_impact_keeps_angular_momenta(solver: str, tmp_path: Path) -> None:
    """At the impact that about the new foot is kept, and that of the leg that leaves about the hip
    (A. Goswami et al., Int. J. Robotics Research 17 (1998) 1282)."""
    names = ["s", "n", "s'", "n'"]
    returns = {"s": "n", "n": "s", "s'": "s_rate", "n'": "n_rate"}
    wanted = {"integral": "u^2", "inputs": {"u": (-60, 60)}, "free_start": names, "until": 0.7}
    wanted |= {"end": {"foot": 0, "stride": 0.4}, "periodic": returns}
    guess = {"s": (-0.2, 0.2), "n": (0.2, -0.2), "s'": (1, 1), "n'": (-0.2, -1)}
    found = best(tmp_path, WALKER, solver, linear=True, intervals=12, guess=guess, **wanted)
    model = pkgen.load(tmp_path / "walker.lag")
    start, more = dict(found.start), {"inputs": found.tables(), "rtol": 1e-11}
    for _ in range(2):
        run = model.run(0.7, start=start, **more)
        end = {name: run[name][-1] for name in (*names, "n_rate", "s_rate")}
        start = {name: float(end[column]) for name, column in returns.items()}
        assert start == pytest.approx(found.start, abs=1e-5)
    p, s, n = dict(model.params), end["s"], end["n"]
    before = masses(p, s, n, (end["s'"], end["n'"]), "s")
    after = masses(p, s, n, (end["n_rate"], end["s_rate"]), "n")  # s is the leg that swings now
    foot = before["hip"][1] - (p["a"] + p["b"]) * numpy.array([math.sin(n), math.cos(n)])
    assert foot[1] == pytest.approx(0, abs=1e-7) and foot[0] == pytest.approx(0.4, abs=1e-6)
    about = [
        sum(m * crossed(r - place, v) for m, r, v in of.values())
        for of, place in ((before, foot), (after, numpy.zeros(2)))
    ]
    hip = [of["s"][0] * crossed(of["s"][1] - of["hip"][1], of["s"][2]) for of in (before, after)]
    assert about[0] == pytest.approx(about[1], rel=1e-9)
    assert hip[0] == pytest.approx(hip[1], rel=1e-9)
