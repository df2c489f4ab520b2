"""SciPy: the equations are the user's; solve_ivp stops where an event function says so."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import scipy
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from .cases import UNTIL, road

VERSION = f"SciPy {scipy.__version__}"
BEST = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}


def settings(way: str) -> dict:
    return {} if way == "default" else BEST


def wind():
    m1, m2, l1, l2, a1, a2, I1, I2, g, c, w = 1, 0.5, 1, 0.8, 0.5, 0.4, 0.09, 0.03, 9.81, 0.2, 4
    A, B, D = m1 * a1**2 + I1 + m2 * l1**2, m2 * l1 * a2, m2 * a2**2 + I2

    def f(t, y):
        p, dp = y[0], y[2]
        q, dq = y[0] + y[1], y[2] + y[3]
        sp, cp, sq, cq, s = np.sin(p), np.cos(p), np.sin(q), np.cos(q), np.sin(p - q)
        fx = c * (w - l1 * cp * dp - l2 * cq * dq)
        fz = -c * (l1 * sp * dp + l2 * sq * dq)
        r = l1 * (fx * cp + fz * sp) - B * s * dq**2 - (m1 * a1 + m2 * l1) * g * sp
        z = l2 * (fx * cq + fz * sq) + B * s * dp**2 - m2 * a2 * g * sq
        k = B * np.cos(p - q)
        det = A * D - k * k
        ddp, ddq = (D * r - k * z) / det, (A * z - k * r) / det
        return [dp, y[3], ddp, ddq - ddp]

    return f, [1.2, -0.5, 0, 0]


def springs():
    def f(t, y, right):
        return [y[1], -(4 if right else 25) * y[0]]

    def edge(t, y, right):
        return y[0]

    edge.terminal = True
    return f, edge, [0.3, 0]


def from_edge_to_edge(f, edge, y, until, settings):
    t, right = 0.0, True
    while t < until:
        edge.direction = -1 if right else 1
        r = solve_ivp(f, (t, until), y, events=edge, args=(right,), **settings)
        t, y, right = r.t[-1], r.y[:, -1], not right
    return y


def car():
    height = CubicSpline(*road())

    def f(t, y):
        inner = 20e3 * (y[0] - y[1]) + 1500 * (y[2] - y[3])
        outer = 180e3 * (y[1] - height(15 * t))
        return [y[2], y[3], -inner / 300, (inner - outer) / 40]

    return f, [0, 0, 0, 0], height.x / 15


def from_time_to_time(f, y, times, settings):
    for begin, end in pairwise(times):
        y = solve_ivp(f, (begin, end), y, **settings).y[:, -1]
    return y


def arm():
    m1, m2, l1, l2, g = 2, 1.5, 0.5, 0.4, 9.81

    def f(t, y, u):
        a, b, da, db = y
        k, s, hand = m2 * l1 * l2, np.sin(b), m2 * l2 * g * np.sin(a + b)
        D = m2 * l2**2
        B = D + k * np.cos(b)
        A = (m1 + m2) * l1**2 + D + 2 * k * np.cos(b)
        r = u[0] + k * s * (2 * da + db) * db - (m1 + m2) * l1 * g * np.sin(a) - hand
        z = u[1] - k * s * da**2 - hand
        det = A * D - B**2
        return [da, db, (D * r - B * z) / det, (A * z - B * r) / det]

    return f, [-0.5, 0.3, 0, 0], pid(), 0.01


def pid():
    """The integral of an error stands still while its motor gives all it can."""
    kp, ki, kd = np.array([150, 90]), np.array([200, 120]), np.array([25, 12])
    most, to, s = np.array([45, 20]), np.array([1, 0.5]), np.zeros(2)

    def sample(y):
        nonlocal s
        error = to - y[:2]
        wanted = kp * error + ki * s - kd * y[2:]
        s = s + np.where(abs(wanted) < most, 0.01 * error, 0)
        return np.clip(wanted, -most, most)

    return sample


def from_sample_to_sample(f, y, sample, T, until, settings):
    y = np.array(y)
    for k in range(round(until / T)):
        y = solve_ivp(f, (k * T, (k + 1) * T), y, args=(sample(y),), **settings).y[:, -1]
    return y


def motors():
    def motor(w, u, J, R, K=0.3, b=0.01):
        return K * (u - K * w) / R - b * w, J

    def f(t, y):
        left, J = motor(3 * y[3], 12, 0.02, 1.5)
        right, K = motor(y[3], 0, 0.3, 4)
        a = (3 * left + right) / (9 * J + K)  # of the right one, through a gearbox of 3
        return [3 * y[3], y[3], 3 * a, a]

    return f, [0, 0, 3, 1]


def _whole(model):
    def prepare(way: str):
        f, y, *_ = model()
        return lambda: solve_ivp(f, (0, UNTIL[model.__name__]), y, **settings(way)).y[:, -1]

    return prepare


def _springs(way: str):
    f, edge, y = springs()
    if way == "best":
        return lambda: from_edge_to_edge(f, edge, y, UNTIL["springs"], BEST)
    across = lambda t, y: f(t, y, y[0] > 0)  # noqa: E731
    return lambda: solve_ivp(across, (0, UNTIL["springs"]), y, **settings(way)).y[:, -1]


def _road(way: str):
    f, y, times = car()
    until = UNTIL["road"]
    times = [*(t for t in times if t < until - 1e-9), until] if way == "best" else [0, until]
    return lambda: from_time_to_time(f, y, times, settings(way))


def _arm(way: str):
    f, y, _, T = arm()
    return lambda: from_sample_to_sample(f, y, pid(), T, UNTIL["arm"], settings(way))


ACROSS = ("springs", "road")
OWN = "own stops; else silent"
CASES = {
    "wind": (_whole(wind), (wind,), "equations by hand", "–"),
    "springs": (_springs, (springs, from_edge_to_edge), "terminal event, own loop", OWN),
    "road": (_road, (car, from_time_to_time), "CubicSpline, own loop", OWN),
    "arm": (_arm, (arm, pid, from_sample_to_sample), "own loop", "own stops"),
    "motors": (_whole(motors), (motors,), "function twice, gear by hand", "–"),
}
