"""Pendulum, bead on a hoop, Foucault's pendulum (P)."""

from math import atan2, degrees, pi, radians, sin, sqrt

import mpmath as mp
import numpy as np

from .prediction import BOUNDARY, CLOSED, Prediction
from .probe import Probe
from .shown import around, listed


def pendulum_ratio(amplitude: float) -> float:
    """T / T_small = 2 K / pi, of modulus sin(amplitude/2)."""
    with mp.workdps(30):  # near 180 degrees the integral is badly conditioned
        return float(2 * mp.ellipk(mp.sin(mp.radians(mp.mpf(str(amplitude))) / 2) ** 2) / mp.pi)


def action_closed(m: float) -> float:
    return float(8 / mp.pi * (mp.ellipe(m) - (1 - m) * mp.ellipk(m)))


def hoop_period(amplitude: float) -> float:
    """At the critical rate theta'^2/2 = U(amplitude) - U(theta), U = g/R (1 - cos theta)^2/2."""
    a, g = mp.mpf(amplitude), mp.mpf("9.81")

    def slowness(w):  # theta = a cos w takes the root's end away
        x, c = a * mp.cos(w), mp.cos(a)
        fall = 2 * mp.sin(a * mp.sin(w / 2) ** 2) * mp.sin((a + x) / 2)  # cos x - cos a
        return a * mp.sin(w) / mp.sqrt(g * fall * (2 - c - mp.cos(x)))

    return float(4 * mp.quad(slowness, [0, mp.pi / 2]))


PENDULUM = (
    'pkgen run ../../../models/pendulums/pendulum.lag --set g=1 --set "amplitude={} [deg]" '
    "--method gauss --until 10"
)


def swing(m: float) -> str:
    """From rest to rest, seen a thousand times."""
    start, period = 2 * float(mp.asin(mp.sqrt(m))), float(4 * mp.ellipk(m))
    return (
        f"pkgen run pendulum.lag --start theta={start:.12g} --method gauss --until {period:.12g} "
        f"--every {period:.12g}/1000"
    )


def action(m: float) -> str:
    """The integral of theta' dtheta over a swing, / 2 pi: of theta'^2 over t, by the trapezoidal
    rule, which is spectrally accurate for a periodic function."""
    return f"{float(4 * mp.ellipk(m)):.12g}*mean(theta'[1:]**2)/(2*pi)"


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
        listed(
            id, f"pendulum, {angle} degrees, gauss", "period over that of small swings, 2 K/pi",
            pendulum_ratio(angle), 1e-9, PENDULUM.format(angle),
            '4*times(report, "lowest")[0]/(2*pi)', "--method verlet --step 0.1",
        )
        for id, angle in (("P1a", 90), ("P1b", 170), ("P1c", 179), ("P1d", 179.9))
    ),
    listed(
        "P2a", "pendulum, m = k^2 = .5, gauss", "action (8/pi)(E - (1 - m) K)",
        action_closed(0.5), 1e-9, swing(0.5), action(0.5), "--method verlet --step 0.1",
    ),
    listed(
        "P2b", "pendulum, m = .5, gauss", "frequency pi/(2 K)", float(mp.pi / 2 / mp.ellipk(0.5)),
        1e-9, PENDULUM.format(90), '2*pi/(4*times(report, "lowest")[0])',
        "--method verlet --step 0.1",
    ),
    listed(
        "P2c", "pendulum, m = 1 - 1e-4, gauss", "action at the separatrix, 8/pi",
        8 / pi, CLOSED, swing(1 - 1e-4), action(1 - 1e-4), "--method euler --step 0.02",
    ),
    listed(
        "P3a", "bead on a hoop, R = 1, gauss", "the bottom is unstable from Omega = sqrt(g/R)",
        sqrt(9.81), BOUNDARY,
        f"for w in {around(sqrt(9.81))}; do pkgen run hoop.lag --set Omega=$w --start theta=1e-6 "
        "--method gauss --until 200; done", "edge of w: max(abs(theta)) > 1e-4", "--set g=9.78",
        no_method="the frequency goes to 0 there: of so slow a motion Euler's method with h = .1 "
        "has the boundary too",
    ),
    *(
        listed(
            id, f"bead on a hoop at the critical rate, amplitude {amplitude}, gauss",
            "period, by quadrature", hoop_period(amplitude), 1e-8,
            f"pkgen run hoop.lag --start theta={amplitude} --method gauss --until 40",
            '4*times(report, "bottom")[0]', "--method lobatto2 --step 0.1",
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
