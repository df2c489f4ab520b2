"""The six models of contacts, and their exact states, by nothing of the packages.

All are closed forms from one impact or change of friction to the next; the rocking block's times
are elliptic integrals by Gauss's rule. Ends are the states at the times of TIMES, one behind the
other; those of "graze" are of a stop that is hit and of one that is missed.
"""

from __future__ import annotations

import math

from numpy.polynomial.legendre import leggauss

TIMES = {"ball": (3.2, 6.0), "cradle": (1.0,), "rock": (3.0, 14.0), "box": (10.0,)}
TIMES |= {"belt": (17.0, 60.0), "graze": (10.0,)}
G = 9.81
SLENDER, TILT = 0.2, 0.1  # rocking block: angles in rad; its diagonal is 2 m
GAP = LESS = 1e-6  # between balls at rest; by how much the oscillator passes or misses the stop
MU, OVER, SPEED = 0.5, 1e-6, 4e-5  # box: tan(slope) is MU -+ OVER, its first rate SPEED


def ball() -> list[float]:
    """y, y': each bounce keeps 0.8 of the speed."""
    end = []
    for until in TIMES["ball"]:
        t, v = 0.0, 5.0
        while v > 1e-18 and t + 2 * v / G < until:
            t, v = t + 2 * v / G, 0.8 * v
        s = until - t
        end += [v * s - G / 2 * s**2, v - G * s] if v > 1e-18 else [0, 0]
    return end


def cradle() -> list[float]:
    """Five x, then their rates: neighbours swap their rates where they meet."""
    w, t, until = math.sqrt(G / 0.3), 0.0, TIMES["cradle"][0]
    x, v = [-0.1, 0, 0, 0, 0], [0.0] * 5

    def meets(i):
        p, q = x[i + 1] - x[i], (v[i + 1] - v[i]) / w
        size = math.hypot(p, q)
        if size <= GAP:
            return math.inf
        return (math.atan2(q, p) + math.acos(-GAP / size)) % (2 * math.pi) / w

    while t < until:
        i = min(range(4), key=meets)
        s = min(meets(i), until - t)
        c, z = math.cos(w * s), math.sin(w * s)
        x, v = (
            [a * c + b / w * z for a, b in zip(x, v, strict=True)],
            [b * c - a * w * z for a, b in zip(x, v, strict=True)],
        )
        t += s
        if t < until:
            v[i], v[i + 1] = v[i + 1], v[i]
    return [*x, *v]


def rock(times: tuple = TIMES["rock"]) -> list[float]:
    """theta, theta': Housner's block leaves 1 - 3/2 sin^2 of the rate at each impact.

    Between impacts sin((slender - |theta|)/2) = s cosh(u), and p dt = du/sqrt(1 - s^2 cosh^2 u).
    """
    nodes, weights = leggauss(40)
    p, corner, end = math.sqrt(0.75 * G), math.sin(SLENDER / 2), []

    def lasts(s, u):
        return sum(
            w / math.sqrt(1 - (s * math.cosh(u / 2 * (1 + n))) ** 2)
            for n, w in zip(nodes, weights, strict=True)
        ) * (u / 2 / p)

    for until in times:
        s, side = math.sin((SLENDER - TILT) / 2), 1
        most = math.acosh(corner / s)
        top, half = 0.0, lasts(s, most)
        while half > 1e-17 and top + half < until:
            rate = 2 * p * s * math.sinh(most) * (1 - 1.5 * math.sin(SLENDER) ** 2)
            top, side = top + half, -side
            s = math.sqrt(corner**2 - (rate / 2 / p) ** 2)
            most = math.asinh(rate / 2 / p / s)
            half = lasts(s, most)
            top += half
        if half <= 1e-17:
            end += [0, 0]
            continue
        u = p * (until - top)
        for _ in range(50):
            f = lasts(s, u) - (until - top)
            u -= f * p * math.sqrt(1 - (s * math.cosh(u)) ** 2)
        end += [
            side * (SLENDER - 2 * math.asin(s * math.cosh(u))),
            -2 * side * p * s * math.sinh(u),
        ]
    return end


def box() -> list[float]:
    """x, x' on the less steep slope, where it comes to rest, and on the steeper one."""
    end = []
    for over in (-OVER, OVER):
        a = G * over / math.hypot(1, MU + over)
        t = min(TIMES["box"][0], SPEED / -a if a < 0 else math.inf)
        end += [SPEED * t + a / 2 * t**2, SPEED + a * t]
    return end


def belt() -> list[float]:
    """x, x': on the belt's 0.1 m/s to x = 1.5, then round x = 1 until its speed is met again."""
    end, slips = [], 2 * (math.pi - math.atan2(0.5, 0.1))
    for t in TIMES["belt"]:
        t = math.fmod(t - 15, slips + 10)
        c, s = math.cos(t), math.sin(t)
        slip = [1 + 0.5 * c + 0.1 * s, 0.1 * c - 0.5 * s]
        end += slip if t < slips else [0.5 + 0.1 * (t - slips), 0.1]
    return end


def graze() -> list[float]:
    """x, x' of an oscillator from x' = 1, whose stop at 1 -+ LESS gives half the speed back."""
    end = []
    for stop in (1 - LESS, 1 + LESS):
        left, x, v = TIMES["graze"][0], 0.0, 1.0
        while True:
            size = math.hypot(x, v)
            if size <= stop:
                break
            s = (math.atan2(v, x) - math.acos(stop / size)) % (2 * math.pi)
            if s > left:
                break
            left, x, v = left - s, stop, -0.5 * math.sqrt(size**2 - stop**2)
        c, s = math.cos(left), math.sin(left)
        end += [x * c + v * s, v * c - x * s]
    return end


EXACT = {"ball": ball, "cradle": cradle, "rock": rock, "box": box, "belt": belt, "graze": graze}


def _rows(model: str, end: list[float]) -> list[list[float]]:
    n = 10 if model == "cradle" else 2
    return [list(map(float, end[i : i + n])) for i in range(0, len(end), n)]


def energy(model: str, row: list[float]) -> float:
    """The energy for a unit mass or moment; 0 is at rest at the lowest place."""
    n = len(row) // 2
    x, kinetic = row[0], sum(v**2 for v in row[n:]) / 2
    if model == "rock":
        rise = math.cos(SLENDER - abs(x)) - math.cos(SLENDER)
        return kinetic + 0.75 * G * rise
    slope = {"ball": G, "box": -G * MU / math.hypot(1, MU)}
    spring = G / 0.3 if model == "cradle" else 1
    return kinetic + (
        slope[model] * x if model in slope else spring / 2 * sum(a**2 for a in row[:n])
    )


FIRST = {"ball": [0, 5], "cradle": [-0.1, *[0] * 9], "rock": [TILT, 0], "box": [0, SPEED]}
FIRST |= {"belt": [1.5, 0.1], "graze": [0, 1]}


def energy_error(model: str, found: list[float], exact: list[float]) -> float:
    """The largest of the rows, relative to the largest energy, that of the start among them."""
    here = [energy(model, row) for row in _rows(model, found)]
    there = [energy(model, row) for row in _rows(model, exact)]
    size = max(map(abs, [*there, energy(model, FIRST[model])]))
    return max(abs(a - b) for a, b in zip(here, there, strict=True)) / size
