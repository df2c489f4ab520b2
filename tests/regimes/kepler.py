"""Kepler's problem, mu = a = 1, from the pericentre (K1 to K6), and Arenstorf's orbit (K7)."""

from __future__ import annotations

from functools import cache
from math import pi

import numpy as np

from .prediction import CLOSED, MEASURED, Prediction, slope
from .probe import Probe


def orbit(method: str, e: float, steps: int, orbits: float = 1, every: int = 1) -> np.ndarray:
    """Rows t, x, y, x', y', energy, `steps` steps an orbit."""
    probe = Probe("kepler", method, 2 * pi / steps, set={"e": e})
    return probe.steps(round(steps * orbits), every)


def apsidal_turn(method: str, e: float, steps: int, orbits: int = 20) -> float:
    """Turn of the Laplace vector an orbit, seen once an orbit, near the apocentre."""
    rows = orbit(method, e, steps, orbits)[steps // 2 - 1 :: steps]
    x, y, u, v = rows[:, 1:5].T
    momentum, r = x * v - y * u, np.hypot(x, y)
    angle = np.unwrap(np.arctan2(-u * momentum - y / r, v * momentum - x / r))
    return (angle[-1] - angle[0]) / (len(angle) - 1)


def apsidal_predicted(e: float, h: float) -> float:
    return -pi / 8 * h * h * (4 + e * e) / (1 - e * e) ** 3


def energy_coefficient(e: float) -> float:
    """max |E - E(0)| / h^2 of Verlet, from its modified Hamiltonian H + h^2 (p V'' p / 12 -
    |V'|^2 / 24) (GNI IX.8): p V'' p = (p^2 - 3 p_r^2)/r^3, on the unperturbed ellipse."""
    eccentric = np.linspace(0, pi, 200_001)
    r = 1 - e * np.cos(eccentric)
    p2 = 2 / r - 1
    radial = e * np.sin(eccentric) / r
    g = (p2 - 3 * radial**2) / r**3 / 12 - 1 / r**4 / 24
    return np.abs(g - g[0]).max()


def energy_error(method: str, e: float, steps: int, orbits: float = 1) -> float:
    return np.abs(orbit(method, e, steps, orbits)[:, -1] + 0.5).max()


def steps_for_a_percent(method: str, e: float, guess: int) -> float:
    """The fewest steps an orbit that keep max |dE/E| of the first orbit within 1%."""
    low, high = guess // 2, guess * 2
    while high - low > max(1, guess // 300):
        middle = (low + high) // 2
        low, high = (low, middle) if energy_error(method, e, middle) <= 0.005 else (middle, high)
    return high


def growth(method: str, steps: int, orbits: tuple[int, ...], e: float = 0.3) -> float:
    """Exponent of the position error at whole orbits, over their number."""
    rows = orbit(method, e, steps, orbits[-1], steps)
    error = np.hypot(rows[:, 1] - (1 - e), rows[:, 2])
    return slope(orbits, [error[k - 1] for k in orbits])


def variable_drift(orbits: int) -> float:
    """|dE| of Verlet with h = .05 r^1.5, of the r at the start of each step."""
    probe = Probe("kepler", "verlet", 1.0, set={"e": 0.8})
    q, v = probe.q.copy(), probe.v.copy()
    return probe.lib.misused_variable(probe.p, 0.05, 2 * pi * orbits, q, v)


def reversible_drift(orbits: int) -> float:
    """max |dE| of the reversible variable step that follows the same law, from the same first
    step; some 128 steps make an orbit."""
    probe = Probe("kepler", "adaptive_verlet", 0.05 * 0.2**1.5, set={"e": 0.8})
    return np.abs(probe.steps(128 * orbits)[:, -1] + 0.5).max()


@cache
def momentum_error(plain: bool, steps: int) -> float:
    """Root mean square of L/L(0) - 1 at a hundred times of so many Verlet steps of 2 pi/100."""
    probe = Probe("kepler", "verlet", 2 * pi / 100, set={"e": 0.2})
    q, v = probe.q.copy(), probe.v.copy()
    first = q[0] * v[1] - q[1] * v[0]
    errors = []
    for _ in range(100):
        if plain:
            probe.lib.plain_verlet(probe.p, 2 * pi / 100, steps // 100, q, v)
        else:
            q, v = probe.steps(steps // 100, steps // 100)[-1, 1:5].reshape(2, 2)
        errors.append((q[0] * v[1] - q[1] * v[0]) / first - 1)
    return float(np.sqrt(np.mean(np.square(errors))))


ARENSTORF = 17.0652165601579625588917206249


def closure(method: str, steps: int = 0, tolerance: float = 1e-13) -> float:
    """Distance in (x, y, x', y') between the start and one period later."""
    h = ARENSTORF / steps if steps else 0.0
    probe = Probe("arenstorf", method, h, tolerance=tolerance)
    start = probe.now
    return float(np.linalg.norm((probe.at([ARENSTORF])[0] - start)[1:5]))


H = 2 * pi / 2000

PREDICTIONS = [
    Prediction(
        "K1a", "Kepler, e = .6, verlet, h = 2 pi/2000",
        "apsidal turn an orbit, -(pi/8) h^2 (4 + e^2)/(1 - e^2)^3",
        apsidal_predicted(0.6, H), CLOSED, lambda: apsidal_turn("verlet", 0.6, 2000),
        "gauss1", lambda: apsidal_turn("gauss1", 0.6, 2000),
    ),
    Prediction(
        "K1b", "Kepler, e = .6, gauss1, h = 2 pi/2000", "apsidal turn an orbit, -2 times Verlet's",
        -2 * apsidal_predicted(0.6, H), CLOSED, lambda: apsidal_turn("gauss1", 0.6, 2000),
        "verlet", lambda: apsidal_turn("verlet", 0.6, 2000),
    ),
    *(
        Prediction(
            id, f"Kepler, e = {e}, verlet, {steps:,} steps an orbit",
            "max |dE| / h^2, by its modified Hamiltonian", energy_coefficient(e), CLOSED,
            lambda e=e, n=steps: energy_error("verlet", e, n) / (2 * pi / n) ** 2,
            "yoshida4", lambda e=e, n=steps: energy_error("yoshida4", e, n) / (2 * pi / n) ** 2,
        )
        for id, e, steps in (("K2a", 0.5, 2000), ("K2b", 0.8, 20_000), ("K2c", 0.9, 50_000))
    ),
    *(
        Prediction(
            id, f"Kepler, e = {e}, {method}", "steps an orbit for max |dE/E| = 1%",
            steps, MEASURED, lambda m=method, e=e, n=steps: steps_for_a_percent(m, e, n),
            worse, lambda m=worse, e=e, n=steps: steps_for_a_percent(m, e, n),
        )
        for id, method, e, steps, worse in (
            ("K3a", "verlet", 0.9, 3196, "rk4"), ("K3b", "verlet", 0.99, 329_382, "rk4"),
            ("K3c", "rk4", 0.9, 608, "verlet"), ("K3d", "rk4", 0.99, 31_667, "verlet"),
        )
    ),
    *(
        Prediction(
            id, "Kepler, e = .8, Verlet with h = .05 r^1.5 of each step's start",
            f"max |dE| in {orbits} orbits", predicted, MEASURED,
            lambda n=orbits: variable_drift(n),
            "verlet, as many steps of one length",
            lambda n=orbits: energy_error("verlet", 0.8, 200, n),
        )
        for id, orbits, predicted in (
            ("K4a", 10, 0.0034), ("K4b", 100, 0.0138), ("K4c", 1000, 0.145),
        )
    ),
    Prediction(
        "K4d", "Kepler, e = .8, adaptive_verlet, h = .05 r^1.5, 1000 orbits", "max |dE| stays",
        0.0014318, MEASURED, lambda: reversible_drift(1000),
        "the same of each step's start", lambda: variable_drift(1000),
    ),
    Prediction(
        "K5a", "Kepler, e = .3, verlet, 2000 steps an orbit, 10 to 1000 orbits",
        "the position error grows with the power of t", 1.0, CLOSED,
        lambda: growth("verlet", 2000, (10, 30, 100, 300, 1000)),
        "rk4", lambda: growth("rk4", 200, (100, 200, 400, 800)),
    ),
    Prediction(
        "K5b", "Kepler, e = .3, rk4, 200 steps an orbit, 100 to 800 orbits",
        "the position error grows with the power of t", 2.0, CLOSED,
        lambda: growth("rk4", 200, (100, 200, 400, 800)),
        "verlet", lambda: growth("verlet", 2000, (10, 30, 100, 300, 1000)),
    ),
    Prediction(
        "K6a", "Kepler, e = .2, Verlet without compensated sums, 1e8 steps of 2 pi/100",
        "L/L(0) - 1, root mean square, round-off walks: 7.1e-13 within a factor 3",
        (7.1e-13 / 3, 7.1e-13 * 3), 0, lambda: momentum_error(True, 10**8),
        "verlet", lambda: momentum_error(False, 10**8), long=True,
    ),
    Prediction(
        "K6b", "Kepler, e = .2, verlet, 1e8 steps of 2 pi/100",
        "L/L(0) - 1, root mean square, sums compensated: 6.0e-15 within a factor 3",
        (2e-15, 1.8e-14), 0, lambda: momentum_error(False, 10**8),
        "without compensated sums", lambda: momentum_error(True, 10**8), long=True,
    ),
    Prediction(
        "K7a", "Arenstorf's orbit, dop853, tolerance 1e-13", "closes, but for", 2.1e-10, MEASURED,
        lambda: closure("dop853"),
        "rk4, 6000 steps", lambda: closure("rk4", 6000),
        missed="it closes, to 1.6e-9 in (x, y, x', y') and 1e-11 in (x, y), but what is left is "
        "amplified round-off: with the same relative and other absolute tolerances, 1e-14 to "
        "1e-30, 7e-11 to 6e-10; SciPy's DOP853 leaves 1.2e-9, or 4.2e-10 with a relative tolerance "
        "alone. K7c is the same orbit by gauss.",
    ),
    Prediction(
        "K7b", "Arenstorf's orbit, rk4, 6000 steps", "misses its start by", 2.15, MEASURED,
        lambda: closure("rk4", 6000),
        "dop853", lambda: closure("dop853"),
    ),
    Prediction(
        "K7c", "Arenstorf's orbit, gauss, tolerance 1e-13", "closes but for round-off, amplified",
        (1e-14, 1e-9), 0, lambda: closure("gauss"),
        "dopri5, tolerance 1e-12", lambda: closure("dopri5", tolerance=1e-12),
    ),
]  # fmt: skip
