"""Euler's disk (X1), whose motion ends, and a throw through air (X2), whose force has a kink."""

from __future__ import annotations

import mpmath as mp
import numpy as np

from .prediction import Prediction
from .probe import Probe

SINGULAR_TIME = -11


def flight(method: str, tolerance: float, h: float = 0.0) -> tuple[float, float, float]:
    """Apex, its time, and the speed of impact, by Newton's iteration."""

    def at(t: float) -> np.ndarray:
        return Probe("drag", method, h, tolerance=tolerance).at([t])[0]

    t = 2.6
    for _ in range(20):
        row = at(t)
        t += row[2] / 9.81
    top, height = t, at(t)[1]
    t = 6.0
    for _ in range(30):
        row = at(t)
        t -= row[1] / row[2]
    return height, top, -at(t)[2]


def end_of_the_disk(method: str, model: str = "euler_disk") -> float:
    """When the runtime says that the motion ends in a singularity: the last valid time."""
    probe = Probe(model, method)
    probe.steps(100_000, 100_000, strict=False)
    return float(probe.now[0]) if probe.status == SINGULAR_TIME else 0.0


def unguarded_disk(h: float) -> float:
    """How far the classical Runge-Kutta method gets, over the same acceleration, of 3."""
    probe = Probe("euler_disk", "rk4", h)

    def rate(y: np.ndarray) -> np.ndarray:
        return np.array([y[1], probe.acceleration(y[:1], y[1:])[0]])

    y, t = np.array([0.2, -0.05]), 0.0
    while t < 3 and np.isfinite(y).all():
        k1 = rate(y)
        k2 = rate(y + h / 2 * k1)
        k3 = rate(y + h / 2 * k2)
        y, t = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(y + h * k3)), t + h
    return t


def unguarded_state(h: float) -> float:
    """The same of the disk of first order, whose state is a rate of the runtime's."""
    probe = Probe("euler_disk_first", "rk4", h)

    def rate(x: float) -> float:
        return float(probe.acceleration(np.zeros(1), np.array([x]))[0])

    x, t = 0.2, 0.0
    while t < 3 and np.isfinite(x):
        k1 = rate(x)
        k2 = rate(x + h / 2 * k1)
        k3 = rate(x + h / 2 * k2)
        x, t = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(x + h * k3)), t + h
    return t


DRAG = (
    mp.log(1 + 0.02 * mp.mpf(2500) / mp.mpf("9.81")) / mp.mpf("0.04"),
    mp.atan(50 * mp.sqrt(mp.mpf("0.02") / mp.mpf("9.81")))
    / mp.sqrt(mp.mpf("0.02") * mp.mpf("9.81")),
    50 / mp.sqrt(1 + 0.02 * mp.mpf(2500) / mp.mpf("9.81")),
)

PREDICTIONS = [
    Prediction(
        "X1", "Euler's disk, theta0 = .2, k = .01, dop853",
        "stops with PK_SINGULAR_TIME, its last valid time at theta0^2/(2 k)", 2.0, 1e-9,
        lambda: end_of_the_disk("dop853"),
        "RK4 without singularities, h = .01, runs on to", lambda: unguarded_disk(0.01),
    ),
    Prediction(
        "X1a", "Euler's disk of first order, theta' = -k/theta, dop853",
        "stops with PK_SINGULAR_TIME, its last valid time at theta0^2/(2 k)", 2.0, 1e-9,
        lambda: end_of_the_disk("dop853", "euler_disk_first"),
        "RK4 without singularities, h = .01, runs on to", lambda: unguarded_state(0.01),
    ),
    *(
        Prediction(
            f"X2{'abc'[i]}", "ball in air, k = .02, 50 m/s straight up, dop853", text,
            float(DRAG[i]), 1e-9, lambda i=i: flight("dop853", 1e-13)[i],
            "rk4, h = .1 s", lambda i=i: flight("rk4", 1.0, 0.1)[i],
        )
        for i, text in enumerate(("apex", "time of the apex", "speed of impact"))
    ),
]  # fmt: skip
