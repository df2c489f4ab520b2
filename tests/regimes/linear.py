"""Linear limits and phase (L1 to L14): the oscillator q'' = -q, y = h omega, and q'' = -q'."""

from __future__ import annotations

from itertools import pairwise
from math import acos, asin, atan, pi

import mpmath as mp
import numpy as np

from .prediction import BOUNDARY, CLOSED, Prediction, boundary
from .probe import Failed, Probe

STEPS = 2000


def energy_after(method: str, y: float, steps: int = STEPS) -> float:
    """H / H(0); infinite if the motion overflows."""
    probe = Probe("oscillator", method, y, fixed=True)
    try:
        return probe.steps(steps, steps)[-1, -1] / 0.5
    except Failed:
        return np.inf


def limit(method: str, predicted: float) -> float:
    """Splitting methods: beyond the limit |trace| > 2; below it H only oscillates."""
    return boundary(predicted, lambda y: energy_after(method, y) > 1e6)


def amplification_limit(method: str, predicted: float) -> float:
    """Runge-Kutta methods: H is multiplied by |R(iy)|^2 in each step."""
    return boundary(predicted, lambda y: energy_after(method, y, 500) > 1)


def trace_limit(kick: list, drift: list) -> float:
    """The first y > 0 where a composition of kicks and drifts has trace -2 or 2."""

    def excess(y):
        m = mp.eye(2)
        for i, k in enumerate(kick):
            m = mp.matrix([[1, 0], [-k * y, 1]]) * m
            if i < len(drift):
                m = mp.matrix([[1, drift[i] * y], [0, 1]]) * m
        return abs(m[0, 0] + m[1, 1]) - 2

    y = mp.mpf("0.01")
    while excess(y) < 0:
        y += mp.mpf("0.01")
    return float(mp.findroot(excess, (y - mp.mpf("0.01"), y), solver="anderson"))


def composed(weights: list) -> float:
    """The limit of a composition of Verlet steps of these lengths."""
    kick = [weights[0] / 2]
    kick += [(a + b) / 2 for a, b in pairwise(weights)]
    return trace_limit([*kick, weights[-1] / 2], weights)


def triple(order: int) -> list:
    a = 1 / (2 - mp.mpf(2) ** (mp.mpf(1) / (order + 1)))
    return [a, 1 - 2 * a, a]


def suzuki() -> list:
    a = 1 / (4 - mp.cbrt(4))
    return [a, a, 1 - 4 * a, a, a]


def symmetric(*halves: str) -> list:
    """Weights w_m .. w_1, w_0, w_1 .. w_m from w_1 .. w_m."""
    w = [mp.mpf(x) for x in halves]
    return [*reversed(w), 1 - 2 * sum(w), *w]


# H. Yoshida, Phys. Lett. A 150 (1990) 262, solution A; W. Kahan, R.-C. Li, Math. Comp. 66 (1997)
# 1089, s9odr6a.
YOSHIDA6 = symmetric("-1.17767998417887", "0.235573213359357", "0.784513610477560")
KAHAN_LI6 = symmetric(
    "0.082213596293550800230", "-0.70624617255763935981", "0.33259913678935943860",
    "0.39216144400731413928",
)  # fmt: skip


def stability_polynomial(method: str) -> list:
    """R(z), rising powers."""
    factorial = [1 / mp.factorial(k) for k in range(6)]
    return {
        "rk2": factorial[:3], "rk3": factorial[:4], "rk4": factorial[:5],
        # E. Hairer, S. P. Norsett, G. Wanner, Solving ODEs I, II.5: stages 1 to 6 of DOPRI5.
        "dopri5": [*factorial, mp.mpf(1) / 600],
    }[method]  # fmt: skip


def axis_limit(method: str, direction) -> float:
    """The first y > 0 where |R(direction y)| = 1 again."""
    r = stability_polynomial(method)[::-1]
    y = mp.mpf("0.1")
    while abs(mp.polyval(r, direction * y)) <= 1:
        y += mp.mpf("0.001")
    inside = y - mp.mpf("0.001")
    return float(
        mp.findroot(lambda x: abs(mp.polyval(r, direction * x)) - 1, (inside, y), solver="anderson")
    )


def kick_first_invariant(h: float, method: str = "symplectic_euler") -> float:
    """Largest relative change of p^2 + q^2 - h p q."""
    rows = Probe("oscillator", method, h, start={"q": 0.7, "q'": 0.31}).steps(10_000)
    q, p = rows[:, 1], rows[:, 2]
    invariant = p * p + q * q - h * p * q
    return np.abs(invariant / (0.31**2 + 0.7**2 - h * 0.31 * 0.7) - 1).max()


def verlet_invariant(h: float, method: str = "verlet") -> float:
    rows = Probe("oscillator", method, h).steps(10_000)
    q, p = rows[:, 1], rows[:, 2]
    return np.abs((p * p + (1 - h * h / 4) * q * q) / (1 - h * h / 4) - 1).max()


def energy_ratio(method: str, h: float) -> float:
    energy = Probe("oscillator", method, h).steps(20_000)[:, -1]
    return energy.max() / energy.min()


def frequency(method: str, y: float) -> float:
    """omega h a step, of what is exactly periodic but for round-off: q_(n+1) + q_(n-1) =
    2 cos(angle) q_n."""
    q = Probe("oscillator", method, y).steps(2000)[:, 1]
    return acos((q[1:-1] @ (q[2:] + q[:-2])) / (2 * q[1:-1] @ q[1:-1])) / y - 1


def real_axis(method: str, predicted: float) -> float:
    """q'' = -q': the rate decays only below the limit."""

    def grows(h: float) -> bool:
        return abs(Probe("decay", method, h, fixed=True).steps(2000, 2000)[-1, 2]) > 1

    return boundary(predicted, grows)


def fixed_point_limit(method: str, predicted: float) -> float:
    """Beyond y rho(A) = 1 the fixed-point iteration of the stages diverges, and must say so."""

    def fails(y: float) -> bool:
        probe = Probe("oscillator", method, y, fixed_point=True, max_iterations=200_000)
        probe.steps(3, strict=False)
        assert probe.status in (0, -6, -8), probe.status
        return probe.status < 0

    return boundary(predicted, fails, bits=9)


def iteration_limit(s: int) -> float:
    """1 / rho(A) of the s-stage Gauss method: the smallest root of det(1 - z A), which is the
    denominator of the diagonal Pade approximant of exp (GNI II.1, HW IV.3)."""
    rising = [
        mp.factorial(2 * s - j) * mp.factorial(s)
        / (mp.factorial(2 * s) * mp.factorial(j) * mp.factorial(s - j)) * (-1) ** j
        for j in range(s + 1)
    ]  # fmt: skip
    return float(min(abs(z) for z in mp.polyroots(rising[::-1], maxsteps=200, extraprec=100)))


AMBIGUOUS = -13


def ambiguous_from(method: str, predicted: float) -> float:
    """The step from which a pendulum at rest upright is refused: its equations have more solutions
    than to stay there. (Within some 1e-5 of it, where they are singular, Newton's iteration does
    not converge, which it says.)"""

    def status(y: float) -> int:
        probe = Probe("pendulum", method, y, start={"theta": pi, "theta'": 0.0})
        probe.steps(1, strict=False)
        return probe.status

    found = boundary(predicted, lambda y: status(y) < 0)
    return found if status(1.001 * found) == AMBIGUOUS else 0.0


def midpoint_roots(y: float) -> float:
    """Solutions x of x = pi + (y^2/4) a(x), the middle of a midpoint step from rest upright: the
    changes of sign over +-y^2/4 about pi, beyond which there is none."""
    probe = Probe("pendulum", "gauss1", y)
    x = pi + np.linspace(-y * y / 4 - 0.1, y * y / 4 + 0.1, 4000)
    gap = [z - pi - y * y / 4 * probe.acceleration([z], [0.0])[0] for z in x]
    return float(np.sum(np.diff(np.sign(gap)) != 0))


RATIO = 1 / (1 - 1.9**2 / 4)

PREDICTIONS = [
    Prediction(
        "L1", "oscillator, euler, h = .1", "H grows by 1 + h^2 a step: over 1000 steps by",
        1.01**1000, 1e-9, lambda: energy_after("euler", 0.1, 1000),
        "rk2", lambda: energy_after("rk2", 0.1, 1000),
    ),
    Prediction(
        "L2a", "oscillator, symplectic_euler", "limit y = 2", 2.0, BOUNDARY,
        lambda: limit("symplectic_euler", 2.0),
        "yoshida4", lambda: limit("yoshida4", 2.0),
    ),
    Prediction(
        "L2b", "oscillator, symplectic_euler, h = .3, 10,000 steps",
        "p^2 + q^2 - h p q is constant but for round-off: relative change", (1e-17, 1e-13), 0,
        lambda: kick_first_invariant(0.3),
        "verlet", lambda: kick_first_invariant(0.3, "verlet"),
    ),
    Prediction(
        "L3a", "oscillator, verlet", "limit y = 2", 2.0, BOUNDARY, lambda: limit("verlet", 2.0),
        "yoshida4", lambda: limit("yoshida4", 2.0),
    ),
    Prediction(
        "L3b", "oscillator, verlet, h = 1.9, 10,000 steps",
        "p^2 + (1 - h^2/4) q^2 is constant but for round-off: relative change", (1e-17, 1e-13), 0,
        lambda: verlet_invariant(1.9),
        "symplectic_euler", lambda: verlet_invariant(1.9, "symplectic_euler"),
    ),
    Prediction(
        "L3c", "oscillator, verlet, h = 1.9", "Hmax / Hmin = 1/(1 - h^2/4)", RATIO, 1e-6,
        lambda: energy_ratio("verlet", 1.9),
        "gauss1", lambda: energy_ratio("gauss1", 1.9),
    ),
    *(
        Prediction(
            id, f"oscillator, {method}", "limit: the trace of a step's matrix is -2 or 2",
            predicted, BOUNDARY, lambda m=method, p=predicted: limit(m, p),
            worse, lambda m=worse, p=predicted: limit(m, p),
        )
        for id, method, predicted, worse in (
            ("L4", "yoshida4", composed(triple(2)), "verlet"),
            ("L6", "yoshida6", composed(YOSHIDA6), "yoshida4"),
            ("L7a", "suzuki4", composed(suzuki()), "yoshida4"),
            ("L7b", "kahan_li6", composed(KAHAN_LI6), "suzuki4"),
        )
    ),
    *(
        Prediction(
            id, f"oscillator, {method}", "limit on the imaginary axis, |R(iy)| = 1",
            axis_limit(method, 1j), BOUNDARY,
            lambda m=method: amplification_limit(m, axis_limit(m, 1j)),
            worse, lambda m=method, w=worse: amplification_limit(w, axis_limit(m, 1j)),
        )
        for id, method, worse in (
            ("L9a", "rk4", "rk3"), ("L9b", "rk3", "rk4"), ("L9c", "dopri5", "rk4"),
        )
    ),
    Prediction(
        "L9d", "oscillator, rk2, y = .1",
        "no limit at all: H grows by 1 + y^4/4 a step; over 2000 steps, less 1, by",
        (1 + 0.1**4 / 4) ** 2000 - 1, CLOSED, lambda: energy_after("rk2", 0.1) - 1,
        "rk3, which decays", lambda: energy_after("rk3", 0.1) - 1,
    ),
    Prediction(
        "L10", "oscillator, rk4, y = .5", "H shrinks by y^6/72 - y^8/576 a step",
        0.5**6 / 72 - 0.5**8 / 576, 1e-6,
        lambda: 1 - energy_after("rk4", 0.5, 1000) ** 0.001,
        "rk3", lambda: 1 - energy_after("rk3", 0.5, 1000) ** 0.001,
    ),
    Prediction(
        "L11", "q'' = -q', rk4", "limit on the real axis, |R(-y)| = 1",
        axis_limit("rk4", -1), BOUNDARY, lambda: real_axis("rk4", axis_limit("rk4", -1)),
        "dopri5", lambda: real_axis("dopri5", axis_limit("rk4", -1)),
    ),
    Prediction(
        "L12a", "oscillator, verlet, y = .1", "relative error of the frequency, 2 asin(y/2)/y - 1",
        2 * asin(0.05) / 0.1 - 1, 1e-6, lambda: frequency("verlet", 0.1),
        "gauss1", lambda: frequency("gauss1", 0.1),
    ),
    Prediction(
        "L12b", "oscillator, gauss1, y = .1", "relative error of the frequency, 2 atan(y/2)/y - 1",
        2 * atan(0.05) / 0.1 - 1, 1e-6, lambda: frequency("gauss1", 0.1),
        "verlet", lambda: frequency("verlet", 0.1),
    ),
    *(
        Prediction(
            f"L13{'abc'[s - 1]}", f"oscillator, gauss{s} by fixed-point iteration",
            "A-stable, but the iteration converges only for y < 1/rho(A); beyond, it says so",
            iteration_limit(s), BOUNDARY,
            lambda s=s: fixed_point_limit(f"gauss{s}", iteration_limit(s)),
            f"gauss{s + 1}", lambda s=s: fixed_point_limit(f"gauss{s + 1}", iteration_limit(s)),
        )
        for s in (1, 2, 3)
    ),
    Prediction(
        "L14a", "pendulum at rest upright, gauss1",
        "one solution of the step if y < 2; beyond, it says that there are several", 2.0, BOUNDARY,
        lambda: ambiguous_from("gauss1", 2.0),
        "radau5", lambda: ambiguous_from("radau5", 2.0),
    ),
    *(
        Prediction(
            id, f"pendulum at rest upright, midpoint, y = {y}", "solutions of a step",
            count, 0, lambda y=y: midpoint_roots(y),
            f"y = {other}", lambda y=other: midpoint_roots(y),
            no_method="solutions of the equation of a step are counted; nothing is integrated",
        )
        for id, y, count, other in (("L14b", 2.01, 3.0, 1.99), ("L14c", 6.0, 7.0, 5.0))
    ),
]  # fmt: skip
