"""Pendulum, bead on a hoop, Foucault's pendulum, double pendulum, two oscillators (P, D, O)."""

from __future__ import annotations

from functools import cache
from math import atan2, cos, degrees, log, pi, radians, sin, sqrt

import mpmath as mp
import numpy as np
from prediction import BOUNDARY, CLOSED, MEASURED, Prediction, boundary
from probe import Failed, Probe


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
    return float(2 * mp.ellipk(mp.sin(mp.radians(amplitude) / 2) ** 2) / mp.pi)


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


def hoop_boundary(g: float) -> float:
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


def foucault_rate(method: str, h: float = 0.0, latitude: float = 48.8462) -> float:
    """Degrees an hour by which the plane of swing turns to the right: of the long axis, over
    400 swings, from the second moments of each tenth."""
    probe = Probe(
        "foucault", method, h, set={"latitude": radians(latitude)}, start={"y'": -0.0}
    )
    swing = 2 * pi * sqrt(67 / 9.81)
    rows = probe.at(np.arange(1, 400 * 50 + 1) * swing / 50)
    angles, times = [], []
    for part in np.split(rows, 10):
        x, y = part[:, 1], part[:, 2]
        angles.append(0.5 * atan2(2 * np.mean(x * y), np.mean(x * x) - np.mean(y * y)))
        times.append(part[:, 0].mean())
    return -degrees(float(np.polyfit(times, np.unwrap(np.array(angles), period=pi), 1)[0])) * 3600


# --- the double pendulum -----------------------------------------------------------------

UNIT = {"m1": 1.0, "m2": 1.0, "l1": 1.0, "l2": 1.0, "g": 9.81}


def at_rest(*angles: float) -> dict[str, float]:
    start = {f"theta{i + 1}": a for i, a in enumerate(angles)}
    return start | {f"theta{i + 1}'": 0.0 for i in range(len(angles))}


def mode(sign: int) -> tuple[float, dict[str, float]]:
    """Frequency and shape of the double pendulum's modes: omega^2 = (2 -+ sqrt 2) g/l."""
    return sqrt((2 - sign * sqrt(2)) * 9.81), at_rest(1e-5, sign * sqrt(2) * 1e-5)


def frequency(model: str, start: dict, names: tuple[str, float, str, float], h: float) -> float:
    """Of one mode, seen in a combination of two coordinates, by recurrence of three samples."""
    probe = Probe(model, "gauss", start=start)
    rows = probe.at(np.arange(1, 4000) * h)
    a, ca, b, cb = names
    x = ca * rows[:, 1 + probe.names.index(a)] + cb * rows[:, 1 + probe.names.index(b)]
    return float(np.arccos((x[1:-1] @ (x[2:] + x[:-2])) / (2 * x[1:-1] @ x[1:-1])) / h)


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
    """The first time, in steps of 1 s, from which the way back ends further than .1 off."""
    return next(
        (t for t in range(5, 80) if reversal_error(method, (pi / 2, pi / 2), t, h) > 0.1), 80
    )


def coupled(method: str, predicted: float) -> float:
    """Limit of two masses on springs; the fast mode has frequency sqrt(1 + 2 k_c)."""

    def grows(h: float) -> bool:
        probe = Probe("two_masses", method, h, start={"x1": 1.0, "x2": -0.5})
        energy = probe.steps(1500, 1500, strict=False)
        return not len(energy) or energy[-1, -1] > (1e6 if method == "verlet" else 1.13)

    return boundary(predicted, grows)


def beat(coupling: float) -> float:
    """One mass displaced: it is at rest in the middle again after a whole beat; from the
    envelope's first return, x1^2 + (x1'/mean frequency)^2 largest."""
    probe = Probe("two_masses", "gauss", set={"kc": coupling}, start={"x1": 1.0, "x2": 0.0})
    rows = probe.at(np.arange(1, 40_000) * 0.01)
    slow, fast = rows[:, 1] + rows[:, 2], rows[:, 1] - rows[:, 2]
    h = 0.01
    angles = [
        np.arccos((x[1:-1] @ (x[2:] + x[:-2])) / (2 * x[1:-1] @ x[1:-1])) / h for x in (slow, fast)
    ]
    return float(2 * pi / (angles[1] - angles[0]))


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
        "m = .98", lambda: action("gauss", 0.98),
    ),
    Prediction(
        "P3a", "bead on a hoop, R = 1, gauss", "the bottom is unstable from Omega = sqrt(g/R)",
        sqrt(9.81), BOUNDARY, lambda: hoop_boundary(9.81),
        "g = 9.78", lambda: hoop_boundary(9.78),
    ),
    *(
        Prediction(
            id, f"bead on a hoop at the critical rate, amplitude {amplitude}, gauss",
            "period, by quadrature", hoop_period(amplitude), 1e-8,
            lambda a=amplitude: period("hoop", {"theta": a}, hoop_period(a), "theta"),
            "amplitude 1% larger",
            lambda a=amplitude: period("hoop", {"theta": 1.01 * a}, hoop_period(a), "theta"),
        )
        for id, amplitude in (("P3b", 0.1), ("P3c", 0.5))
    ),
    Prediction(
        "P5", "Foucault's pendulum, 67 m, at 48.8462 degrees, gauss",
        "the plane turns by so many degrees an hour", FOUCAULT, 1e-6,
        lambda: foucault_rate("gauss"),
        "rk4, h = 1 s, at 49 degrees", lambda: foucault_rate("rk4", 1.0, 49.0),
    ),
    *(
        Prediction(
            id, f"double pendulum, {text} mode, gauss", "frequency", mode(sign)[0], 1e-8,
            lambda s=sign: frequency(
                "double_pendulum", mode(s)[1], ("theta1", 1.0, "theta2", 0.0), 0.1
            ),
            "at amplitude .3",
            lambda s=sign: frequency(
                "double_pendulum", at_rest(0.3, 0.3 * s * sqrt(2)), ("theta1", 1.0, "theta2", 0.0),
                0.1,
            ),
        )
        for id, text, sign in (("D1a", "slow", 1), ("D1b", "fast", -1))
    ),
    Prediction(
        "D1c", "double pendulum, rk4", "limit 2 sqrt 2 / omega of the fast mode",
        2 * sqrt(2) / mode(-1)[0], BOUNDARY,
        lambda: double_limit("rk4", 2 * sqrt(2) / mode(-1)[0]),
        "dopri5", lambda: double_limit("dopri5", 2 * sqrt(2) / mode(-1)[0]),
    ),
    Prediction(
        "D3a", "double pendulum from rest at pi/2, pi/2, gauss1, h = .001",
        "reversal is lost (1e-3 off) near ln(1/eps)/lambda, lambda = .926", log(2**52) / 0.926,
        MEASURED,
        lambda: reversal_lost("gauss1", 0.001),
        "rk4, h = .01", lambda: reversal_lost("rk4", 0.01), long=True,
    ),
    Prediction(
        "D3b", "double pendulum from rest at .1, .1, gauss1, h = .001, to 60 s",
        "a regular orbit returns to its start but for", (1e-18, 1e-14), 0,
        lambda: reversal_error("gauss1", (0.1, 0.1), 60, 0.001),
        "rk4, h = .01", lambda: reversal_error("rk4", (0.1, 0.1), 60, 0.01),
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
        lambda: beat(0.5), "k_c = .51", lambda: beat(0.51),
    ),
]  # fmt: skip
