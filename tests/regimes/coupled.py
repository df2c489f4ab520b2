"""The double pendulum (D) and two coupled oscillators (O)."""

from __future__ import annotations

import json
import subprocess
import sys
from functools import cache
from math import log, pi, sqrt

import numpy as np

from .prediction import BOUNDARY, MEASURED, Prediction, boundary
from .probe import Probe, model_path

UNIT = {"m1": 1.0, "m2": 1.0, "l1": 1.0, "l2": 1.0, "g": 9.81}


def at_rest(*angles: float) -> dict[str, float]:
    start = {f"theta{i + 1}": a for i, a in enumerate(angles)}
    return start | {f"theta{i + 1}'": 0.0 for i in range(len(angles))}


def mode(sign: int) -> tuple[float, dict[str, float]]:
    """Frequency and shape of the double pendulum's modes: omega^2 = (2 -+ sqrt 2) g/l."""
    return sqrt((2 - sign * sqrt(2)) * 9.81), at_rest(1e-5, sign * sqrt(2) * 1e-5)


def frequency(sign: int, method: str = "gauss", h: float = 0.0) -> float:
    """Of one mode, by recurrence of three samples of the first angle."""
    rows = Probe("double_pendulum", method, h, start=mode(sign)[1]).at(np.arange(1, 4000) * 0.1)
    x = rows[:, 1]
    return float(np.arccos((x[1:-1] @ (x[2:] + x[:-2])) / (2 * x[1:-1] @ x[1:-1])) / 0.1)


def double_limit(method: str, predicted: float) -> float:
    """The fast mode of amplitude 1e-5 grows or shrinks; past the limit it grows until the
    nonlinear motion takes over, and never overflows."""
    start = mode(-1)[1]

    def grows(h: float) -> bool:
        probe = Probe("double_pendulum", method, h, start=start, fixed=True)
        rows = probe.steps(1500, strict=False)
        return len(rows) < 1500 or np.abs(rows[-200:, 1]).max() > 1e-5

    return boundary(predicted, grows)


def reversal_error(method: str, angles: tuple[float, float], until: float, h: float) -> float:
    """Distance from the start of what ran to `until`, and back with its rates reversed."""
    there = Probe("double_pendulum", method, h, start=at_rest(*angles))
    row = there.steps(round(until / h), round(until / h))[-1]
    turned = {"theta1": row[1], "theta2": row[2], "theta1'": -row[3], "theta2'": -row[4]}
    back = Probe("double_pendulum", method, h, start=turned)
    end = back.steps(round(until / h), round(until / h))[-1]
    return float(np.linalg.norm(end[1:5] - np.array([*angles, 0, 0])))


def reversal_lost(method: str, h: float) -> float:
    """Median over seven neighbouring starts of the time, in steps of 2 s, from which the way back
    ends further than .1 off: growth differs from one stretch of a chaotic orbit to the next."""
    times = [
        next(t for t in range(6, 90, 2) if reversal_error(method, (angle, pi / 2), t, h) > 0.1)
        for angle in pi / 2 + 1e-3 * np.arange(7)
    ]
    return float(np.median(times))


def coupled(method: str, predicted: float) -> float:
    """Limit of two masses on springs; the fast mode has frequency sqrt(1 + 2 k_c)."""

    def grows(h: float) -> bool:
        probe = Probe("two_masses", method, h, start={"x1": 1.0, "x2": -0.5})
        energy = probe.steps(1500, 1500, strict=False)
        return not len(energy) or energy[-1, -1] > (1e6 if method == "verlet" else 1.13)

    return boundary(predicted, grows)


def beat(method: str = "gauss", h: float = 0.0) -> float:
    """One mass displaced: it is at rest in the middle again after a whole beat; from the
    envelope's first return, x1^2 + (x1'/mean frequency)^2 largest."""
    probe = Probe("two_masses", method, h, start={"x1": 1.0, "x2": 0.0})
    rows = probe.at(np.arange(1, 40_000) * 0.01)
    slow, fast = rows[:, 1] + rows[:, 2], rows[:, 1] - rows[:, 2]
    h = 0.01
    angles = [
        np.arccos((x[1:-1] @ (x[2:] + x[:-2])) / (2 * x[1:-1] @ x[1:-1])) / h for x in (slow, fast)
    ]
    return float(2 * pi / (angles[1] - angles[0]))


@cache
def lyapunov(angles: tuple[float, float], until: float = 1e5) -> float:
    """Largest exponent from rest, by the variational equations of `pkgen run`."""
    start = [f"--start={name}={value}" for name, value in at_rest(*angles).items()]
    command = [sys.executable, "-m", "pkgen", "run", model_path("double_pendulum"), *start]
    command += ["--until", until, "--every", until / 10, "--diagnose", "lyapunov", "--json"]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True)
    return abs(json.loads(done.stdout)["report"]["diagnostics"]["lyapunov"]["exponent"])


OF_THE_FLOW = (
    "a mean over 1e5 s of the growth that belongs to the start; no worse method has been run for "
    "so long"
)

PREDICTIONS = [
    *(
        Prediction(
            id, f"double pendulum, {text} mode, gauss", "frequency", mode(sign)[0], 1e-8,
            lambda s=sign: frequency(s),
            "rk4, h = .05", lambda s=sign: frequency(s, "rk4", 0.05),
        )
        for id, text, sign in (("D1a", "slow", 1), ("D1b", "fast", -1))
    ),
    Prediction(
        "D1c", "double pendulum, rk4", "limit 2 sqrt 2 / omega of the fast mode",
        2 * sqrt(2) / mode(-1)[0], BOUNDARY,
        lambda: double_limit("rk4", 2 * sqrt(2) / mode(-1)[0]),
        "dopri5", lambda: double_limit("dopri5", 2 * sqrt(2) / mode(-1)[0]),
    ),
    *(
        Prediction(
            id, f"double pendulum from rest at {text}, gauss, 1e5 s",
            "largest Lyapunov exponent, per second", predicted, 0.05,
            lambda a=angles: lyapunov(a),
            worse, lambda a=other: lyapunov(a), long=True, no_method=OF_THE_FLOW,
        )
        for id, text, angles, predicted, worse, other in (
            ("D2a", "pi/2, pi/2", (pi / 2, pi / 2), 0.926, "2, 2", (2.0, 2.0)),
            ("D2b", "2, 2", (2.0, 2.0), 1.343, "3, 3", (3.0, 3.0)),
            ("D2c", "3, 3", (3.0, 3.0), 1.005, "2, 2", (2.0, 2.0)),
            ("D2d", ".5, .5", (0.5, 0.5), (1e-9, 1e-3), "pi/2, pi/2", (pi / 2, pi / 2)),
        )
    ),
    Prediction(
        "D3a", "double pendulum from rest at pi/2 (+ .001 k), pi/2, gauss1, h = .001",
        "reversal is lost near ln(1/eps)/lambda, lambda = .926: median of seven starts",
        log(2**52) / 0.926, MEASURED,
        lambda: reversal_lost("gauss1", 0.001),
        "rk4, h = .01", lambda: reversal_lost("rk4", 0.01), long=True,
    ),
    Prediction(
        "D3b", "double pendulum from rest at .3, .3, gauss1, h = .001, to 60 s",
        "a regular orbit returns to its start but for", (1e-18, 1e-14), 0,
        lambda: reversal_error("gauss1", (0.3, 0.3), 60, 0.001),
        "rk4, h = .01", lambda: reversal_error("rk4", (0.3, 0.3), 60, 0.01),
    ),
    Prediction(
        "O1a", "two coupled masses, verlet", "limit 2 / sqrt(1 + 2 k_c)", sqrt(2), BOUNDARY,
        lambda: coupled("verlet", sqrt(2)), "rk4", lambda: coupled("rk4", sqrt(2)),
    ),
    Prediction(
        "O1b", "two coupled masses, rk4", "limit 2 sqrt 2 / sqrt(1 + 2 k_c)", 2.0, BOUNDARY,
        lambda: coupled("rk4", 2.0), "verlet", lambda: coupled("verlet", 2.0),
    ),
    Prediction(
        "O1c", "two coupled masses, gauss", "beat 2 pi/(sqrt 2 - 1)", 2 * pi / (sqrt(2) - 1), 1e-8,
        beat, "verlet, h = .1", lambda: beat("verlet", 0.1),
    ),
]  # fmt: skip
