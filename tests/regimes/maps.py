"""Steps as area-preserving maps: a pendulum that looks at rest, a separatrix that splits, a
resonance 1:3 (A3 to A5)."""

from math import exp, pi, sqrt
from math import log as ln

import numpy as np

from .prediction import BOUNDARY, CLOSED, Prediction
from .probe import Probe
from .shown import around, shown

# --- a pendulum that turns about once a step looks at rest ------------------------------------


# --- the separatrix of the pendulum under Verlet splits by exp(-pi^2/h) -----------------------


def splitting_closed(h: float) -> float:
    """Lazutkin's homoclinic invariant of the standard map, K = 4 sinh^2(mu/2): V. Gelfreich, V.
    Lazutkin, Russ. Math. Surveys 56 (2001) 499."""
    mu = 2 * np.arcsinh(h / 2)
    series = 1118.827706 + 18.59891 * mu**2
    return float(4 * pi / mu**2 * exp(-(pi**2) / mu) * series)


def splitting(method: str, h: float) -> float:
    """The cross product of the tangents of both manifolds where they meet at theta = 0, each per
    unit of the time in which a step is mu: by reflection 2 h theta_t v_t of the unstable one. A
    point delta along the saddle's eigenvector runs for as many steps as bring it to 0."""
    mu = 2 * np.arcsinh(h / 2)
    rate = np.sinh(mu) / h  # v over theta + pi on the eigenvector of Verlet's step

    def after(delta: float, steps: int) -> np.ndarray:
        start = {"theta": -pi + delta, "theta'": rate * delta}
        return Probe("pendulum", method, h, start=start).steps(steps, steps)[-1, 1:3]

    steps = int(ln(4e5) / mu) + 1
    low, high = 1e-6, 1e-4
    for _ in range(80):
        middle = sqrt(low * high)
        low, high = (middle, high) if after(middle, steps)[0] < 0 else (low, middle)
    d = 1e-4
    ahead, behind = after(low * exp(d), steps), after(low * exp(-d), steps)
    theta_t, v_t = (ahead - behind) / (2 * d)
    return abs(2 * h * theta_t * v_t)


# --- 1:3 resonance of the step ------------------------------------------------------------------


def corner(h: float) -> float:
    """The periodic orbit (a, b, b) of q_(n+1) - 2 q_n + q_(n-1) = -h^2 (q_n + q_n^2) that shrinks
    to 0 at h = sqrt 3: a = b - h^2 b (1 + b) and 2 b (1 + b) + a (1 + a) = 0. It bounds the
    stable motion on the line of starts at rest."""
    a = np.polynomial.Polynomial([0, 1 - h * h, -h * h])
    b = np.polynomial.Polynomial([0, 1])
    roots = (2 * b * (1 + b) + a * (1 + a)).roots()
    real = [r.real for r in roots if abs(r.imag) < 1e-9 and abs(r) > 1e-9]
    return float(a(min(real, key=abs)))


PREDICTIONS = [
    shown(
        "A3", "pendulum, verlet, h = .2",
        "spun at 2 pi/h + d it swings about that rate as if at rest, for d < 2/sqrt(1 + h^2/6)",
        2 / sqrt(1 + 0.2**2 / 6), BOUNDARY,
        f"for d in {around(2 / sqrt(1 + 0.2**2 / 6))}; do pkgen run pendulum.lag --start theta=0 "
        "--start \"theta'=10*pi+$d\" --method verlet --step 0.2 --until 300 --every 0.2; done",
        "edge of d: min(theta') > 10*pi", "--method gauss2",
    ),
    *(
        Prediction(
            id, f"pendulum, verlet, h = {h}",
            "its separatrix splits: Lazutkin's invariant, ~ exp(-pi^2/h)", splitting_closed(h),
            CLOSED, lambda h=h: splitting("verlet", h),
            "yoshida4", lambda h=h: splitting("yoshida4", h), own=True,
        )
        for id, h in (("A4a", 1.0), ("A4b", 0.7))
    ),
    shown(
        "A5", "V = q^2/2 + q^3/3, verlet, h = 1.7",
        "1:3 resonance of the step at sqrt 3: starts at rest stay up to the 3-cycle's corner",
        corner(1.7), CLOSED,
        f"for q in {around(corner(1.7))}; do pkgen run cubic_well.lag --start q=$q "
        "--method verlet --step 1.7 --until 5100 --every 5100; done",
        "edge of q: exit_code != 0 or abs(q[-1]) > 2", "--method suzuki4",
    ),
]  # fmt: skip
