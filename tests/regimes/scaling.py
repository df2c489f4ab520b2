"""How errors scale with step, tolerance and eccentricity (A7 to A12)."""

from __future__ import annotations

from math import cos, sin

import numpy as np

from .kepler import energy_error as kepler_error
from .kepler import orbit
from .modified import AMPLITUDE, swing
from .prediction import CLOSED, ORDER, Prediction, slope
from .probe import Probe


def drift_power(method: str) -> float:
    """Of h, in the rate at which a pendulum's energy drifts: from rest to rest, 50 swings."""
    rates, steps = [], (20, 28, 40, 56)
    period = swing(sin(AMPLITUDE / 2))[0]
    for n in steps:
        start = {"theta": AMPLITUDE, "theta'": 0.0}
        rows = Probe("pendulum", method, period / n, start=start, fixed=True).steps(50 * n, n)
        rates.append(abs(rows[-1, -1] - rows[9, -1]))
    return slope([1 / n for n in steps], rates)


def tolerance_power(method: str) -> float:
    """Of the tolerance, in the drift of a pendulum's energy over 300."""
    tolerances, drifts = [10.0**-k for k in (5, 6, 7, 8, 9)], []
    for tolerance in tolerances:
        start = {"theta": AMPLITUDE, "theta'": 0.0}
        probe = Probe("pendulum", method, start=start, tolerance=tolerance)
        drifts.append(abs(probe.at([300.0])[0, -1] + cos(AMPLITUDE)))
    return slope(tolerances, drifts)


def pericentre_power(method: str) -> float:
    """Of 1 - e, in max |dE| of Kepler at a step far below it."""
    ends = ((0.96, 40_000), (0.98, 120_000), (0.99, 400_000))
    errors = [kepler_error(method, e, n) * n**2 / (1 + 2 * e) for e, n in ends]
    return slope([1 - e for e, _ in ends], errors)


def apsidal_power(method: str) -> float:
    """Of h, in the turn of Kepler's ellipse, e = .3."""
    turns, steps = [], (60, 80, 120, 160)
    for n in steps:
        x, y, u, v = orbit(method, 0.3, n, 40)[n // 2 - 1 :: n, 1:5].T
        momentum, r = x * v - y * u, np.hypot(x, y)
        angle = np.unwrap(np.arctan2(-u * momentum - y / r, v * momentum - x / r))
        turns.append(abs(angle[-1] - angle[0]))
    return slope([1 / n for n in steps], turns)


def kink_power(method: str) -> float:
    """Of h, in the error of the rate after a throw at 3 m/s that passes the kink of the drag at its
    apex: the largest of sixteen phases of the grid."""
    errors, steps, start = [], (0.1, 0.05, 0.025, 0.0125), {"y'": 3.0}
    for h in steps:
        worst = 0.0
        for phase in range(16):
            end = 0.5 + phase * h / 16
            row = Probe("drag", method, end / round(end / h), start=start).at([end])[0]
            exact = Probe("drag", "dop853", start=start, tolerance=1e-15).at([end])[0]
            worst = max(worst, abs(row[2] - exact[2]))
        errors.append(worst)
    return slope(steps, errors)


def stiff_power(method: str) -> float:
    """Of h, in the error of a rate that friction of rate 1e6 holds to sin t, at t = 1."""
    errors, steps = [], (8, 12, 16, 24, 32)
    for n in steps:
        row = Probe("follow", method, 1 / n).at([1.0])[0]
        errors.append(abs(row[2] - sin(1)))
    return slope([1 / n for n in steps], errors)


def angular_momentum(method: str) -> float:
    rows = Probe("quartic_plane", method, 0.1).steps(100_000, 10)
    x, y, u, v = rows[:, 1:5].T
    return float(np.abs((x * v - y * u) / 0.6 - 1).max())


PREDICTIONS = [
    Prediction(
        "A7", "central force -r^3, yoshida4, h = .1, 1e5 steps",
        "kicks along r and drifts along v keep L: but for round-off its relative change is",
        (1e-17, 1e-13), 0, lambda: angular_momentum("yoshida4"),
        "rk4", lambda: angular_momentum("rk4"), own=True,
    ),
    Prediction(
        "A8", "pendulum from rest at 1.2, rk4",
        "reversible motion: the drift of E goes with h^5, not with the method's h^4",
        5.0, ORDER, lambda: drift_power("rk4"), "euler", lambda: drift_power("euler"), own=True,
    ),
    Prediction(
        "A9", "pendulum from rest at 1.2, dopri5",
        "the drift of E goes with the power of the tolerance", 1.0, ORDER,
        lambda: tolerance_power("dopri5"),
        "gauss", lambda: tolerance_power("gauss"), own=True,
    ),
    Prediction(
        "A10", "Kepler, verlet, e = .96 to .99",
        "max |dE| goes with (1 + 2 e) and the power of 1 - e", -4.0, CLOSED,
        lambda: pericentre_power("verlet"), "rk4", lambda: pericentre_power("rk4"), own=True,
    ),
    Prediction(
        "A11", "Kepler, e = .3, yoshida4", "the apsidal turn goes with the power of h", 4.0,
        ORDER, lambda: apsidal_power("yoshida4"),
        "verlet", lambda: apsidal_power("verlet"), own=True,
    ),
    Prediction(
        "A12", "ball in air through its apex, rk4",
        "across the kink of |v| v the error goes with h^3, not h^4", 3.0, ORDER,
        lambda: kink_power("rk4"), "euler", lambda: kink_power("euler"), own=True,
    ),
    *(
        Prediction(
            id, f"q' held to sin t by friction 1e6, {method}", says, power, ORDER,
            lambda m=method: stiff_power(m), worse, lambda m=worse: stiff_power(m), own=True,
        )
        for id, method, says, power, worse in (
            ("A15a", "gauss2", "order 4 falls to s = 2, R(inf) being 1", 2.0, "gauss3"),
            ("A15b", "gauss3", "order 6 falls to s + 1 = 4, R(inf) being -1", 4.0, "gauss2"),
            ("A15c", "radau5", "order 5 falls to s = 3, error h^s / lambda", 3.0, "gauss3"),
        )
    ),
]  # fmt: skip
