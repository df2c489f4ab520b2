"""The five models, their ends, and the exact final states, by nothing of the packages.

Two have closed forms. The others are integrated in 64-bit significands by extrapolation, from one
knot or sample to the next (published_by_hand.py). A state is all coordinates, then their rates.
"""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy
from numpy import cos, longdouble, sin

from ..published_by_hand import integrate

ROOT = Path(__file__).resolve().parent.parent.parent
ROAD = ROOT / "models/bodies/quarter_car_road.csv"
UNTIL = {"wind": 10.0, "springs": 20.0, "road": 6.0, "arm": 0.5, "motors": 4.0}
SPEED = 15.0  # of the quarter car


def road() -> tuple[list[float], list[float]]:
    """Places and heights, in metres."""
    with ROAD.open(encoding="utf-8") as file:
        rows = [[float(x) for x in row] for row in list(csv.reader(file))[1:]]
    return [x for x, _ in rows], [1e-3 * y for _, y in rows]


def wind() -> list[float]:
    """hip, knee: by the angles from the vertical, p and q."""
    c, w, g = longdouble("0.2"), longdouble(4), longdouble("9.81")
    l1, l2, heavy, light = longdouble(1), longdouble("0.8"), longdouble("0.84"), longdouble("0.11")
    both, g1, g2 = longdouble("0.2"), g, longdouble("0.2") * g

    def f(x, v):
        (p, q), (dp, dq) = x, v
        fx = c * (w - l1 * cos(p) * dp - l2 * cos(q) * dq)
        fz = -c * (l1 * sin(p) * dp + l2 * sin(q) * dq)
        a = l1 * (fx * cos(p) + fz * sin(p)) - both * sin(p - q) * dq**2 - g1 * sin(p)
        b = l2 * (fx * cos(q) + fz * sin(q)) + both * sin(p - q) * dp**2 - g2 * sin(q)
        m = both * cos(p - q)
        return numpy.array([light * a - m * b, heavy * b - m * a]) / (heavy * light - m**2)

    start = [longdouble("1.2"), longdouble("0.7")]
    p, q, dp, dq = integrate(f, start, [0, 0], UNTIL["wind"], 200)
    return [float(x) for x in (p, q - p, dp, dq - dp)]


def springs() -> list[float]:
    """x, from one half of an oscillation to the next."""
    a, t = 0.3, math.fmod(UNTIL["springs"] + math.pi / 4, math.pi / 2 + math.pi / 5)
    if t < math.pi / 2:
        return [a * math.sin(2 * t), 2 * a * math.cos(2 * t)]
    t -= math.pi / 2
    return [-a * 0.4 * math.sin(5 * t), -2 * a * math.cos(5 * t)]


def car() -> list[float]:
    """z, w; the third coordinate is the time since the last knot."""
    from scipy.interpolate import CubicSpline

    x, y = road()
    spline = CubicSpline(x, y)
    M, m, K, C, k = (longdouble(n) for n in (300, 40, 20e3, 1500, 180e3))
    state, start = numpy.zeros(4, dtype=longdouble), longdouble(0)
    for i in range(round(SPEED * UNTIL["road"] / 0.1)):
        c3, c2, c1, c0 = (longdouble(n) for n in spline.c[:, i])
        base = longdouble(x[i])

        def f(q, v, c3=c3, c2=c2, c1=c1, c0=c0, back=SPEED * start - base):
            s = SPEED * q[2] + back
            h = ((c3 * s + c2) * s + c1) * s + c0
            inner = K * (q[0] - q[1]) + C * (v[0] - v[1])
            return numpy.array([-inner / M, (inner - k * (q[1] - h)) / m, 0 * h])

        end = longdouble(x[i + 1]) / SPEED
        z, w, _, dz, dw, _ = integrate(f, [*state[:2], 0], [*state[2:], 1], end - start, 1)
        state, start = numpy.array([z, w, dz, dw]), end
    return [float(n) for n in state]


def arm() -> list[float]:
    """a, b: fifty samples, between which the torques u are held."""
    m1, m2, l1, l2 = (longdouble(n) for n in ("2", "1.5", "0.5", "0.4"))
    g, T = longdouble("9.81"), longdouble("0.01")
    gains = ((150, 200, 25, 45, longdouble(1)), (90, 120, 12, 20, longdouble("0.5")))
    q, v, s, u = [longdouble("-0.5"), longdouble("0.3")], [0, 0], [longdouble(0)] * 2, [0, 0]

    def f(x, v):
        (a, b), (da, db) = x, v
        ca, sb, cb, hand = m2 * l1 * l2, sin(b), cos(b), m2 * l2 * g * sin(a + b)
        A, B = (m1 + m2) * l1**2 + m2 * l2**2 + 2 * ca * cb, m2 * l2**2 + ca * cb
        D = m2 * l2**2
        r = u[0] + ca * sb * (2 * da + db) * db - (m1 + m2) * l1 * g * sin(a) - hand
        z = u[1] - ca * sb * da**2 - hand
        return numpy.array([D * r - B * z, A * z - B * r]) / (A * D - B**2)

    for _ in range(round(UNTIL["arm"] / 0.01)):
        for i, (kp, ki, kd, most, to) in enumerate(gains):
            wanted = kp * (to - q[i]) + ki * s[i] - kd * v[i]
            u[i] = min(max(wanted, -most), most)
            s[i] += T * (to - q[i]) if abs(wanted) < most else 0
        *q, v0, v1 = integrate(f, q, v, T, 2)
        v = [v0, v1]
    return [float(x) for x in (*q, *v)]


def motors() -> list[float]:
    """left, right: the gearbox leaves one of them."""
    n, t = 3, UNTIL["motors"]
    J, c = 0.02 + 0.3 / n**2, 0.01 + 0.3**2 / 1.5 + (0.01 + 0.3**2 / 4) / n**2
    last, first = 0.3 * 12 / 1.5 / c, 3
    speed = last + (first - last) * math.exp(-t * c / J)
    angle = last * t + (first - last) * J / c * -math.expm1(-t * c / J)
    return [angle, angle / n, speed, speed / n]


EXACT = {"wind": wind, "springs": springs, "road": car, "arm": arm, "motors": motors}


def error(found: list[float], exact: list[float]) -> float:
    """The largest difference, relative to the largest number of the state."""
    size = max(abs(x) for x in exact)
    return max(abs(float(x) - e) for x, e in zip(found, exact, strict=True)) / size
