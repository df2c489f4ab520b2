"""Elastic pendulum (E) and tops (T)."""

from math import acos, cos, degrees, pi, sin, sqrt

import mpmath as mp
import numpy as np

from .prediction import BOUNDARY, CLOSED, Prediction
from .probe import Probe
from .shown import around, listed

# --- elastic pendulum, m = g = l = 1, k = 4: stretch 2, swing 1 ------------------------------


def exchange_period(stretch: float, swing: float, method: str = "gauss", h: float = 0.0) -> float:
    """Mean time between greatest swings, each the top of a parabola through three samples once
    a swing."""
    start = {"x": swing, "y": -1 - stretch, "x'": 0.0}
    probe = Probe("spring_plane", method, h, start=start)
    rows = probe.at(2 * pi * np.arange(1, 1801))
    action = rows[:, 1] ** 2 + rows[:, 3] ** 2
    tops = []
    for k in range(20, len(action) - 20):
        if action[k] == action[k - 20 : k + 21].max():
            c = np.polyfit(np.arange(-20, 21), action[k - 20 : k + 21], 2)
            tops.append(2 * pi * (k + 1 - c[1] / (2 * c[0])))
    return float((tops[-1] - tops[0]) / (len(tops) - 1))


# --- heavy top, I1 = mgl = 1 --------------------------------------------------------------------


def nutation() -> tuple[float, float, float]:
    """Period, precession a period, and largest angle in degrees of the top released at rest at 60
    degrees with p_psi = 3: with u = cos theta, u'^2 = 2 (u0 - u)(1 - u^2) - 9 (u0 - u)^2, and
    phi' = 3 (u0 - u)/(1 - u^2)."""
    u0 = mp.mpf(1) / 2
    # u'^2 = (u0 - u) (2 - 2 u^2 - 9 (u0 - u)): the other end of the swing is a root of the second.
    low = (9 - mp.sqrt(81 - 8 * (9 * u0 - 2))) / 4
    high = (9 + mp.sqrt(81 - 8 * (9 * u0 - 2))) / 4

    def at(w):  # u from u0 to low as w goes from 0 to pi/2
        u = u0 - (u0 - low) * mp.sin(w) ** 2
        return u, 2 / mp.sqrt(2 * (high - u))

    time = 2 * mp.quad(lambda w: at(w)[1], [0, mp.pi / 2])
    turn = 2 * mp.quad(
        lambda w: at(w)[1] * 3 * (u0 - at(w)[0]) / (1 - at(w)[0] ** 2), [0, mp.pi / 2]
    )
    return float(time), float(turn), float(mp.degrees(mp.acos(low)))


# --- free top ------------------------------------------------------------------------------------


# Tilted so that the motion keeps clear of beta = 90 degrees, where these angles end.
TILT = {"alpha": 0.3, "beta": 0.4, "psi": 0.5}


def free_start(w1: float, w2: float, w3: float) -> str:
    beta, psi = TILT["beta"], TILT["psi"]
    alpha1 = (w1 * cos(psi) - w2 * sin(psi)) / cos(beta)
    rates = {"alpha'": alpha1, "beta'": w1 * sin(psi) + w2 * cos(psi)}
    rates["psi'"] = w3 - alpha1 * sin(beta)
    return " ".join(f'--start "{name}={value!r}"' for name, value in (TILT | rates).items())


def tumbling_closed(w1: float, w3: float) -> float:
    """4 K / rate for I = (1, 2, 3), w2 = 1: L. D. Landau, E. M. Lifshitz, Mechanics, section 37."""
    energy2 = mp.mpf(w1) ** 2 + 2 + 3 * mp.mpf(w3) ** 2
    momentum2 = mp.mpf(w1) ** 2 + 4 + 9 * mp.mpf(w3) ** 2
    if momentum2 > 2 * energy2:
        rate = mp.sqrt((3 - 2) * (momentum2 - energy2) / 6)
        m = (2 - 1) * (3 * energy2 - momentum2) / ((3 - 2) * (momentum2 - energy2))
    else:
        rate = mp.sqrt((2 - 1) * (3 * energy2 - momentum2) / 6)
        m = (3 - 2) * (momentum2 - energy2) / ((2 - 1) * (3 * energy2 - momentum2))
    return float(4 * mp.ellipk(m) / rate)


def turn_closed(w: tuple[float, float, float]) -> float:
    """The precession of the third axis about the momentum, |L| (I1 w1^2 + I2 w2^2)/(L^2 - L3^2),
    over a period of the rates, Jacobi's functions: Landau and Lifshitz, Mechanics, section 37."""
    energy2 = sum(i * mp.mpf(x) ** 2 for i, x in zip((1, 2, 3), w, strict=True))
    momentum2 = sum((i * mp.mpf(x)) ** 2 for i, x in zip((1, 2, 3), w, strict=True))
    swapped = momentum2 < 2 * energy2
    i1, i2, i3 = (3, 2, 1) if swapped else (1, 2, 3)
    low, high = energy2 * i3 - momentum2, momentum2 - energy2 * i1
    rate = mp.sqrt((i3 - i2) * high / (i1 * i2 * i3))
    m = (i2 - i1) * low / ((i3 - i2) * high)
    squares = low / (i1 * (i3 - i1)), low / (i2 * (i3 - i2)), high / (i3 * (i3 - i1))

    def turn(u):
        cn2, sn2, dn2 = (mp.ellipfun(name, u, m=m) ** 2 for name in ("cn", "sn", "dn"))
        one, two, three = (a * b for a, b in zip(squares, (cn2, sn2, dn2), strict=True))
        first, third = (three, one) if swapped else (one, three)
        return (first + 2 * two) / (momentum2 - 9 * third)

    quarter = mp.ellipk(m)
    ends = [quarter * k / 8 for k in range(9)]
    return float(4 * mp.sqrt(momentum2) * mp.quad(turn, ends) / rate % (2 * mp.pi))


PREDICTIONS = [
    listed(
        "E1", "elastic pendulum 1:2, stretch .01, gauss", "a swing grows at the rate 3/4 A",
        0.0075, CLOSED,
        "pkgen run spring_plane.lag --set k=4 --start x=1e-7 --start y=-1.01 --method gauss "
        "--until 1200 --every 2*pi",
        # Between 3e-6 and 3e-4, where it is neither settling nor saturated.
        "polyfit(t[t > 500][t[t > 500] < 1000], "
        "log(hypot(x, x')[t > 500][t[t > 500] < 1000]), 1)[0]", "--method verlet --step 0.2",
    ),
    Prediction(
        "E2", "elastic pendulum 1:2, stretch .01, swing .001, gauss", "exchange period",
        1075.28117, 2e-3, lambda: exchange_period(0.01, 0.001),
        "verlet, h = .1", lambda: exchange_period(0.01, 0.001, "verlet", 0.1),
    ),
    listed(
        "E3", "elastic pendulum, k = 1e4, verlet", "limit 2 / sqrt(k)", 0.02, BOUNDARY,
        f"for h in {around(0.02)}; do pkgen run spring_plane.lag --set k=1e4 --start x=0 "
        "--start y=-1.000001 --method verlet --step $h --until 1000*$h --every 50*$h; done",
        "edge of h: not max(abs(y + 1)) < 1e-3", "--method yoshida4",
    ),
    *(
        listed(
            f"T2{'abc'[i]}", "heavy top, p_psi = 3, at rest at 60 degrees, gauss", text,
            nutation()[i], 1e-8, "pkgen run nodding_top.lag --method gauss --until 3 --at rest",
            read, "--method rk4 --step 0.1",
        )
        for i, (text, read) in enumerate(
            (
                ("nutation period", 'times(report, "rest")[1]'),
                ("precession a period", 'phi[t == times(report, "rest")[1]][0]'),
                ("largest angle, degrees", "max(theta)*180/pi"),
            )
        )
    ),
    listed(
        "T3a", "sleeping top, gauss", "wakes where p_psi < 2 sqrt(I1 mgl)", 2.0, BOUNDARY,
        "for p in 2.002 1.998; do pkgen run sleeping_top.lag --set p_spin=$p --start alpha=1e-7 "
        "--method gauss --until 400 --every 1; done",
        "edge of p: not max(hypot(alpha, beta)) < 1e-5", "--method euler --step 0.05",
    ),
    listed(
        "T3b", "sleeping top, p_psi = 1.8, gauss", "a tilt grows at the rate sqrt(1 - .81)",
        sqrt(1 - 0.81), 1e-4,
        "pkgen run sleeping_top.lag --start alpha=1e-8 --method gauss --until 25 --every 0.25",
        "polyfit(t[40:], log(hypot(alpha, beta)[40:]), 1)[0]", "--method rk2 --step 0.1",
    ),
    listed(
        "T3c", "sleeping top, p_psi = 1.8, gauss", "cos of the largest tilt is p_psi^2/2 - 1",
        degrees(acos(1.8**2 / 2 - 1)), 1e-4,
        "pkgen run sleeping_top.lag --start alpha=1e-6 --method gauss --until 80 --every 0.01",
        "acos(min(cos(alpha)*cos(beta)))*180/pi", "--method euler --step 0.01",
    ),
    listed(
        "T4a", "free top, I = (1, 2, 3), gauss",
        "grows at the rate Omega/sqrt 3 about the middle axis", 1 / sqrt(3), CLOSED,
        f"pkgen run free_top.lag {free_start(1e-6, 1.0, 0.0)} --method gauss --until 12 "
        "--every 0.1 --record w1", "polyfit(t[40:], log(abs(w1[40:])), 1)[0]",
        "--method euler --step 0.1",
    ),
    *(
        listed(
            id, f"free top from omega = ({w[0]}, {w[1]}, {w[2]}), gauss", "period 4 K / rate",
            tumbling_closed(w[0], w[2]), 1e-8,
            f"pkgen run free_top.lag {free_start(*w)} --method gauss --rtol 1e-12 --until 60",
            '2*mean(diff(times(report, "between")))', "--method rk4 --step 0.1 --rtol -",
        )
        for id, w in (("T4b", (0.01, 1, 0)), ("T4c", (0, 1, 0.01)))
    ),
    *(
        listed(
            id, f"free top by its attitude from omega = ({w[0]}, {w[1]}, {w[2]}), gauss",
            "turned about its momentum in a period", turn_closed(w), 1e-9,
            "pkgen run turning_body.lag "
            + " ".join(f'--start "omega(R).{a}={x}"' for a, x in zip("xyz", w, strict=True))
            + f" --method gauss --rtol 1e-14 --until {tumbling_closed(w[0], w[2]):.12g}",
            f"2*arctan2((R_x[-1]*{w[0]} + R_y[-1]*2*{w[1]} + R_z[-1]*3*{w[2]})/"
            f"sqrt({w[0]}**2 + 4*{w[1]}**2 + 9*{w[2]}**2), R_w[-1]) % (2*pi)",
            "--method rkmk4 --step 0.1 --rtol -",
        )
        for id, w in (("T4d", (0.01, 1, 0)), ("T4e", (0, 1, 0.01)))
    ),
    listed(
        "T3d", "sleeping top by its attitude, p_psi = 1.8, gauss",
        "cos of the largest tilt is p_psi^2/2 - 1", degrees(acos(1.8**2 / 2 - 1)), 1e-4,
        "pkgen run turning_body.lag --set I1=1 --set I2=1 --set I3=0.5 --set mgl=1 "
        '--start "omega(R).z=3.6" --start R.x=5e-7 --method gauss --until 80 --every 0.05',
        "acos(min(R_w**2 - R_x**2 - R_y**2 + R_z**2))*180/pi", "--method lie_midpoint --step 0.05",
    ),
]  # fmt: skip
