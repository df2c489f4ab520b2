"""Oscillators that are driven (A13, A14)."""

from math import sqrt

import mpmath as mp
import numpy as np

from .prediction import BOUNDARY, Prediction
from .probe import Probe
from .shown import around, shown


def mathieu_amplitude(w: float) -> float:
    """Amplitude at which the shaken pendulum stands: -4/w^2 = a_0(q), q = 2 A, with a_0 the least
    eigenvalue of Hill's matrix for even functions of period pi."""

    def gap(q):
        m = np.diag([(2.0 * k) ** 2 for k in range(20)])
        m += np.diag([float(q)] * 19, 1) + np.diag([float(q)] * 19, -1)
        m[0, 1] = m[1, 0] = sqrt(2) * float(q)
        return np.linalg.eigvalsh(m)[0] + 4 / w**2

    low, high = 0.0, 0.8
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if gap(middle) > 0 else (low, middle)
    return low / 2


def ramp_closed(tau: float) -> float:
    """Largest change of the action over the phases, less 1, of the frequency going from 1 to 2 by
    a tanh: (1 + r)/(1 - r) - 1, r the reflection of the corresponding barrier, L. D. Landau, E. M.
    Lifshitz, Quantum Mechanics, section 25."""
    r = mp.sinh(mp.pi * tau / 2 * (2 - 1)) / mp.sinh(mp.pi * tau / 2 * (2 + 1))
    return float((1 + r) / (1 - r) - 1)


def ramp(method: str, tau: float, h: float = 0.0) -> float:
    """The same from the two motions that start with q = 1 and q' = 1: actions are the squares of
    (sqrt(w) q, q'/sqrt(w)), which a matrix takes from one end to the other."""
    columns, middle = [], 20 * tau
    for start in ({"q": 1.0}, {"q": 0.0, "q'": 1.0}):
        given = {"set": {"tau": tau, "middle": middle}, "start": start, "tolerance": 1e-14}
        row = Probe("ramp", method, h, **given).at([2 * middle])[0]
        columns.append([sqrt(2) * row[1], row[2] / sqrt(2)])
    return float(np.linalg.svd(np.array(columns), compute_uv=False)[0] ** 2 - 1)


PREDICTIONS = [
    shown(
        "A13", "pendulum upside down on a pivot shaken at w = 10, gauss",
        "stands from the amplitude where Mathieu's a_0(2 A) = -4/w^2",
        mathieu_amplitude(10), BOUNDARY,
        f"for A in {around(mathieu_amplitude(10))}; do pkgen run kapitza.lag --set A=$A "
        "--method gauss --until 300 --every 1; done", "edge of A: max(abs(theta)) < 1e-4",
        "--method euler --step 0.02",
    ),
    *(
        Prediction(
            id, f"oscillator, frequency 1 to 2 by tanh(t/{tau}), dop853",
            "largest change of the action, adiabatic: ~ 2 exp(-pi tau)",
            ramp_closed(tau), tolerance,
            lambda x=tau: ramp("dop853", x), "rk4, h = .2", lambda x=tau: ramp("rk4", x, 0.2),
            own=True,
        )
        for id, tau, tolerance in (("A14a", 1.0, 1e-6), ("A14b", 5.0, 1e-3))
    ),
]  # fmt: skip
