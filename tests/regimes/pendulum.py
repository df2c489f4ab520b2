"""Pendulum, bead on a hoop, Foucault's pendulum (P)."""

from __future__ import annotations

from math import atan2, degrees, pi, radians, sin, sqrt

import mpmath as mp
import numpy as np

from .prediction import BOUNDARY, CLOSED, Prediction, boundary
from .probe import Probe


def period(model: str, start: dict, guess: float, name: str, **more) -> float:
    """Four times the first passage of `name` through zero, found by Newton's iteration with a run
    to each time."""

    def at(t: float) -> tuple[float, float]:
        probe = Probe(model, "gauss", start=start, tolerance=1e-14, **more)
        where = probe.names.index(name)
        row = probe.at([t])[0]
        return row[1 + where], row[1 + where + probe.n]

    t = guess / 4
    for _ in range(20):
        q, v = at(t)
        t -= q / v
        if abs(q / v) < 1e-13 * t:
            break
    return 4 * t


def verlet_period(model: str, start: dict, h: float, **more) -> float:
    """The same by Verlet's steps and straight lines between: a method that is worse."""
    rows = Probe(model, "verlet", h, start=start, **more).steps(int(40 / h))
    k = int(np.argmax(rows[:, 1] < 0))
    t, q = rows[:, 0], rows[:, 1]
    return 4 * (t[k - 1] + (t[k] - t[k - 1]) * q[k - 1] / (q[k - 1] - q[k]))


def pendulum_ratio(amplitude: float) -> float:
    """T / T_small = 2 K / pi, of modulus sin(amplitude/2)."""
    with mp.workdps(30):  # near 180 degrees the integral is badly conditioned
        return float(2 * mp.ellipk(mp.sin(mp.radians(mp.mpf(str(amplitude))) / 2) ** 2) / mp.pi)


def pendulum_period(amplitude: float) -> float:
    start = {"theta": radians(amplitude), "theta'": 0.0}
    return period("pendulum", start, 2 * pi * pendulum_ratio(amplitude), "theta") / (2 * pi)


def action(method: str, m: float, rows: int = 4000, h: float = 0.0) -> float:
    """The integral of theta' dtheta over a swing, / 2 pi: of theta'^2 over t, by the trapezoidal
    rule, which is spectrally accurate for a periodic function."""
    duration = float(4 * mp.ellipk(m))
    start = {"theta": 2 * float(mp.asin(mp.sqrt(m))), "theta'": 0.0}
    times = duration * np.arange(1, rows + 1) / rows
    out = Probe("pendulum", method, h, start=start).at(times)
    return duration * float(np.mean(out[:, 2] ** 2)) / (2 * pi)


def action_closed(m: float) -> float:
    return float(8 / mp.pi * (mp.ellipe(m) - (1 - m) * mp.ellipk(m)))


def hoop_growth(method: str, rate: float, h: float = 0.0) -> float:
    """How far a displacement of 1e-6 goes in time 400."""
    start = {"theta": 1e-6}
    probe = Probe("hoop", method, h, set={"Omega": rate}, start=start)
    return np.abs(probe.at(np.linspace(1, 400, 400))[:, 1]).max() / 1e-6


def hoop_boundary(g: float = 9.81) -> float:
    """Below the critical rate the bottom is a centre, above it a saddle."""

    def grows(rate: float) -> bool:
        probe = Probe("hoop", "gauss", set={"Omega": rate, "g": g}, start={"theta": 1e-6})
        return np.abs(probe.at(np.linspace(1, 200, 200))[:, 1]).max() > 1e-4

    return boundary(sqrt(9.81), grows, bits=8)


def hoop_period(amplitude: float) -> float:
    """At the critical rate theta'^2/2 = U(amplitude) - U(theta), U = g/R (1 - cos theta)^2/2."""
    a, g = mp.mpf(amplitude), mp.mpf("9.81")

    def slowness(w):  # theta = a cos w takes the root's end away
        x, c = a * mp.cos(w), mp.cos(a)
        fall = 2 * mp.sin(a * mp.sin(w / 2) ** 2) * mp.sin((a + x) / 2)  # cos x - cos a
        return a * mp.sin(w) / mp.sqrt(g * fall * (2 - c - mp.cos(x)))

    return float(4 * mp.quad(slowness, [0, mp.pi / 2]))


FOUCAULT = 360 / 86164.0905 * 3600 * sin(radians(48.8462))


def foucault_rate(method: str, h: float = 0.0) -> float:
    """Degrees an hour by which the plane of swing turns to the right: of the long axis, over
    400 swings, from the second moments of each tenth."""
    probe = Probe("foucault", method, h, set={"latitude": radians(48.8462)}, start={"y'": -0.0})
    swing = 2 * pi * sqrt(67 / 9.81)
    rows = probe.at(np.arange(1, 400 * 20 + 1) * swing / 20)
    angles, times = [], []
    for part in np.split(rows, 10):
        x, y = part[:, 1], part[:, 2]
        angles.append(0.5 * atan2(2 * np.mean(x * y), np.mean(x * x) - np.mean(y * y)))
        times.append(part[:, 0].mean())
    return -degrees(float(np.polyfit(times, np.unwrap(np.array(angles), period=pi), 1)[0])) * 3600


PREDICTIONS = [
    *(
        Prediction(
            id, f"pendulum, {angle} degrees, gauss", "period over that of small swings, 2 K/pi",
            pendulum_ratio(angle), 1e-9, lambda a=angle: pendulum_period(a),
            "verlet, h = .1",
            lambda a=angle: verlet_period("pendulum", {"theta": radians(a)}, 0.1) / (2 * pi),
        )
        for id, angle in (("P1a", 90), ("P1b", 170), ("P1c", 179), ("P1d", 179.9))
    ),
    Prediction(
        "P2a", "pendulum, m = k^2 = .5, gauss", "action (8/pi)(E - (1 - m) K)",
        action_closed(0.5), 1e-9, lambda: action("gauss", 0.5),
        "verlet, h = .1", lambda: action("verlet", 0.5, h=0.1, rows=400),
    ),
    Prediction(
        "P2b", "pendulum, m = .5, gauss", "frequency pi/(2 K)",
        float(mp.pi / 2 / mp.ellipk(0.5)), 1e-9, lambda: 1 / pendulum_period(90),
        "verlet, h = .1",
        lambda: 2 * pi / verlet_period("pendulum", {"theta": pi / 2}, 0.1),
    ),
    Prediction(
        "P2c", "pendulum, m = 1 - 1e-4, gauss", "action at the separatrix, 8/pi",
        8 / pi, CLOSED, lambda: action("gauss", 1 - 1e-4),
        "euler, h = .02", lambda: action("euler", 1 - 1e-4, h=0.02),
    ),
    Prediction(
        "P3a", "bead on a hoop, R = 1, gauss", "the bottom is unstable from Omega = sqrt(g/R)",
        sqrt(9.81), BOUNDARY, hoop_boundary,
        "g = 9.78", lambda: hoop_boundary(9.78),
        no_method="the frequency goes to 0 there: of so slow a motion Euler's method with h = .1 "
        "has the boundary too",
    ),
    *(
        Prediction(
            id, f"bead on a hoop at the critical rate, amplitude {amplitude}, gauss",
            "period, by quadrature", hoop_period(amplitude), 1e-8,
            lambda a=amplitude: period("hoop", {"theta": a}, hoop_period(a), "theta"),
            "verlet, h = .1",
            lambda a=amplitude: verlet_period("hoop", {"theta": a}, 0.1),
        )
        for id, amplitude in (("P3b", 0.1), ("P3c", 0.5))
    ),
    Prediction(
        "P5", "Foucault's pendulum, 67 m, at 48.8462 degrees, gauss",
        "the plane turns by so many degrees an hour", FOUCAULT, 1e-6,
        lambda: foucault_rate("gauss"),
        "rk4, h = 1 s", lambda: foucault_rate("rk4", 1.0),
    ),
]  # fmt: skip
