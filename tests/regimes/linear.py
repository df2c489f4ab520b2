"""Linear limits and phase (L1 to L14): the oscillator q'' = -q, y = h omega, and q'' = -q'."""

from itertools import pairwise
from math import asin, atan, pi

import mpmath as mp
import numpy as np

from .prediction import BOUNDARY, CLOSED, Prediction, boundary
from .probe import Probe
from .shown import around, listed


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


def midpoint_roots(y: float) -> float:
    """Solutions x of x = pi + (y^2/4) a(x), the middle of a midpoint step from rest upright: the
    changes of sign over +-y^2/4 about pi, beyond which there is none."""
    probe = Probe("pendulum", "gauss1", y)
    x = pi + np.linspace(-y * y / 4 - 0.1, y * y / 4 + 0.1, 4000)
    gap = [z - pi - y * y / 4 * probe.acceleration([z], [0.0])[0] for z in x]
    return float(np.sum(np.diff(np.sign(gap)) != 0))


RATIO = 1 / (1 - 1.9**2 / 4)
OSCILLATOR = "pkgen run oscillator.lag --method {} --step {} --until {} --every {}"
FREQUENCY = "acos(sum(q[1:-1]*(q[2:] + q[:-2]))/(2*sum(q[1:-1]**2)))/0.1 - 1"


def limit(method: str, at: float, steps: int, more: str = "") -> str:
    run = f"pkgen run oscillator.lag --method {method} --step $h{more}"
    return f"for h in {around(at)}; do {run} --until {steps}*$h --every {steps}*$h; done"


# Splitting methods: beyond the limit |trace| > 2; below it H only oscillates.
SPLIT = "edge of h: not energy[-1] < 1e6*energy[0]"
# Runge-Kutta methods: H is multiplied by |R(iy)|^2 in each step.
AMPLIFIED = "edge of h: not energy[-1] < energy[0]"

PREDICTIONS = [
    listed(
        "L1", "oscillator, euler, h = .1", "H grows by 1 + h^2 a step: over 1000 steps by",
        1.01**1000, 1e-9, OSCILLATOR.format("euler", 0.1, 100, 100), "energy[-1]/energy[0]",
        "--method rk2",
    ),
    listed(
        "L2a", "oscillator, symplectic_euler", "limit y = 2", 2.0, BOUNDARY,
        limit("symplectic_euler", 2, 4000), SPLIT, "--method yoshida4",
    ),
    listed(
        "L2b", "oscillator, symplectic_euler, h = .3, 10,000 steps",
        "p^2 + q^2 - h p q is constant but for round-off: relative change", (1e-17, 1e-13), 0,
        OSCILLATOR.format("symplectic_euler", 0.3, 3000, 0.3),
        "max(abs(q'**2 + q**2 - 0.3*q'*q - 1))", "--method verlet",
    ),
    listed(
        "L3a", "oscillator, verlet", "limit y = 2", 2.0, BOUNDARY, limit("verlet", 2, 4000),
        SPLIT, "--method yoshida4",
    ),
    listed(
        "L3b", "oscillator, verlet, h = 1.9, 10,000 steps",
        "p^2 + (1 - h^2/4) q^2 is constant but for round-off: relative change", (1e-17, 1e-13), 0,
        OSCILLATOR.format("verlet", 1.9, 19000, 1.9),
        "max(abs((q'**2 + (1 - 1.9**2/4)*q**2)/(1 - 1.9**2/4) - 1))",
        "--method symplectic_euler",
    ),
    listed(
        "L3c", "oscillator, verlet, h = 1.9", "Hmax / Hmin = 1/(1 - h^2/4)", RATIO, 1e-6,
        OSCILLATOR.format("verlet", 1.9, 19000, 1.9), "max(energy)/min(energy)",
        "--method gauss1",
    ),
    *(
        listed(
            id, f"oscillator, {method}", "limit: the trace of a step's matrix is -2 or 2",
            at, BOUNDARY, limit(method, at, 4000), SPLIT, f"--method {worse}",
        )
        for id, method, at, worse in (
            ("L4", "yoshida4", composed(triple(2)), "verlet"),
            ("L6", "yoshida6", composed(YOSHIDA6), "yoshida4"),
            ("L7a", "suzuki4", composed(suzuki()), "yoshida4"),
            ("L7b", "kahan_li6", composed(KAHAN_LI6), "suzuki4"),
        )
    ),
    *(
        listed(
            id, f"oscillator, {method}", "limit on the imaginary axis, |R(iy)| = 1",
            axis_limit(method, 1j), BOUNDARY, limit(method, axis_limit(method, 1j), 500, more),
            AMPLIFIED, f"--method {worse}",
        )
        for id, method, worse, more in (
            ("L9a", "rk4", "rk3", ""), ("L9b", "rk3", "rk4", ""),
            ("L9c", "dopri5", "dop853", " --max-step $h --rtol 0.9 --atol 1e9"),
        )
    ),
    listed(
        "L9d", "oscillator, rk2, y = .1",
        "no limit at all: H grows by 1 + y^4/4 a step; over 2000 steps, less 1, by",
        (1 + 0.1**4 / 4) ** 2000 - 1, CLOSED, OSCILLATOR.format("rk2", 0.1, 200, 200),
        "energy[-1]/energy[0] - 1", "--method rk3",
    ),
    listed(
        "L10", "oscillator, rk4, y = .5", "H shrinks by y^6/72 - y^8/576 a step",
        0.5**6 / 72 - 0.5**8 / 576, 1e-6, OSCILLATOR.format("rk4", 0.5, 500, 500),
        "1 - (energy[-1]/energy[0])**0.001", "--method rk3",
    ),
    listed(
        "L11", "q'' = -q', rk4", "limit on the real axis, |R(-y)| = 1", axis_limit("rk4", -1),
        BOUNDARY, limit("rk4", axis_limit("rk4", -1), 2000).replace("oscillator", "decay"),
        "edge of h: not abs(q'[-1]) < 1", "--method rk3",
    ),
    listed(
        "L12a", "oscillator, verlet, y = .1", "relative error of the frequency, 2 asin(y/2)/y - 1",
        2 * asin(0.05) / 0.1 - 1, 1e-6, OSCILLATOR.format("verlet", 0.1, 200, 0.1), FREQUENCY,
        "--method gauss1",
    ),
    listed(
        "L12b", "oscillator, gauss1, y = .1", "relative error of the frequency, 2 atan(y/2)/y - 1",
        2 * atan(0.05) / 0.1 - 1, 1e-6, OSCILLATOR.format("gauss1", 0.1, 200, 0.1), FREQUENCY,
        "--method verlet",
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
    listed(
        "L14a", "pendulum at rest upright, gauss1",
        "one solution of the step if y < 2; beyond, it says that there are several", 2.0, BOUNDARY,
        "for h in 1.998 2.002; do pkgen run pendulum.lag --start theta=pi --method gauss1 "
        "--step $h --until $h; done", 'edge of h: "several" in said', "--method radau5",
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
