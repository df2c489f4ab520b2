"""The double pendulum (D) and two coupled oscillators (O)."""

from __future__ import annotations

from math import log, pi, sqrt

import numpy as np

from .prediction import BOUNDARY, MEASURED, Prediction
from .probe import Probe
from .shown import around, listed

UNIT = {"m1": 1.0, "m2": 1.0, "l1": 1.0, "l2": 1.0, "g": 9.81}


def at_rest(*angles: float) -> dict[str, float]:
    start = {f"theta{i + 1}": a for i, a in enumerate(angles)}
    return start | {f"theta{i + 1}'": 0.0 for i in range(len(angles))}


def mode(sign: int) -> float:
    """Frequency of the double pendulum's modes: omega^2 = (2 -+ sqrt 2) g/l."""
    return sqrt((2 - sign * sqrt(2)) * 9.81)


SMALL = (
    'pkgen run ../../../models/double_pendulum.lag --start theta1=1e-5 --start "theta2={}" '
    '--start "theta1\'=0" --start "theta2\'=0" --method {} --until {} --every {}'
)
# Of what swings at one frequency, by recurrence of three samples.
FREQUENCY = "acos(sum({0}[1:-1]*({0}[2:] + {0}[:-2]))/(2*sum({0}[1:-1]**2)))/{1}"


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


OF_THE_FLOW = (
    "a mean over 1e5 s of the growth that belongs to the start; no worse method has been run for "
    "so long"
)

PREDICTIONS = [
    *(
        listed(
            id, f"double pendulum, {text} mode, gauss", "frequency", mode(sign), 1e-8,
            SMALL.format(f"{sign}*sqrt(2)*1e-5", "gauss", 400, 0.1),
            FREQUENCY.format("theta1", 0.1), "--method rk4 --step 0.05",
        )
        for id, text, sign in (("D1a", "slow", 1), ("D1b", "fast", -1))
    ),
    listed(
        "D1c", "double pendulum, rk4", "limit 2 sqrt 2 / omega of the fast mode",
        2 * sqrt(2) / mode(-1), BOUNDARY,
        f"for h in {around(2 * sqrt(2) / mode(-1))}; do "
        + SMALL.format("-1*sqrt(2)*1e-5", "rk4 --step $h", "1500*$h", "$h") + "; done",
        "edge of h: not max(abs(theta1[-200:])) < 1e-5", "--method rk3",
    ),
    *(
        listed(
            id, f"double pendulum from rest at {text}, gauss, 1e5 s",
            "largest Lyapunov exponent, per second", predicted, 0.05,
            SMALL.replace("1e-5", start.split()[0]).format(start.split()[1], "gauss", 1e5, 1e4)
            + " --diagnose lyapunov", 'abs(report["diagnostics"]["lyapunov"]["exponent"])',
            "--start theta1={} --start theta2={}".format(*other.split()), long=True,
            no_method=OF_THE_FLOW,
        )
        for id, text, start, predicted, other in (
            ("D2a", "pi/2, pi/2", "pi/2 pi/2", 0.926, "2 2"),
            ("D2b", "2, 2", "2 2", 1.343, "3 3"),
            ("D2c", "3, 3", "3 3", 1.005, "2 2"),
            ("D2d", ".5, .5", "0.5 0.5", (1e-9, 1e-3), "pi/2 pi/2"),
        )
    ),
    Prediction(
        "D3a", "double pendulum from rest at pi/2 (+ .001 k), pi/2, gauss1, h = .001",
        "reversal is lost near ln(1/eps)/lambda, lambda = .926: median of seven starts",
        log(2**52) / 0.926, MEASURED,
        lambda: reversal_lost("gauss1", 0.001),
        "rk4, h = .01", lambda: reversal_lost("rk4", 0.01), long=True,
    ),
    listed(
        "D3b", "double pendulum from rest at .3, .3, gauss1, h = .001, to 60 s",
        "a regular orbit returns to its start but for", (1e-18, 1e-14), 0,
        SMALL.replace("1e-5", "0.3").format("0.3", "gauss1 --step 0.001", 60, 60)
        + " --diagnose reversal", 'report["diagnostics"]["reversal"]["times"][-1][1]',
        "--method rk4 --step 0.01",
    ),
    *(
        listed(
            id, f"two coupled masses, {method}", says, at, BOUNDARY,
            f"for h in {around(at)}; do pkgen run two_masses.lag --start x1=1 --start x2=-0.5 "
            f"--method {method} --step $h --until 1500*$h --every 1500*$h; done",
            f"edge of h: not energy[-1] < {grown}", f"--method {worse}",
        )
        for id, method, says, at, grown, worse in (
            ("O1a", "verlet", "limit 2 / sqrt(1 + 2 k_c)", sqrt(2), 1e6, "rk4"),
            ("O1b", "rk4", "limit 2 sqrt 2 / sqrt(1 + 2 k_c)", 2.0, 1.13, "verlet"),
        )
    ),
    listed(
        "O1c", "two coupled masses, gauss", "beat 2 pi/(sqrt 2 - 1)", 2 * pi / (sqrt(2) - 1), 1e-8,
        "pkgen run two_masses.lag --method gauss --until 400 --every 0.1",
        f"2*pi/({FREQUENCY.format('(x1 - x2)', 0.1)} - {FREQUENCY.format('(x1 + x2)', 0.1)})",
        "--method verlet --step 0.1",
    ),
]  # fmt: skip
