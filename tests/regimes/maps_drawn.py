"""Limits and resonances as `pkgen stability` measures them, and one that is slow."""

from math import sqrt

import mpmath as mp
import numpy as np

from .linear import axis_limit, stability_polynomial
from .prediction import BOUNDARY, Prediction
from .shown import around, shown

MAP = "pkgen stability {} --methods {} --quick --json"


def lorenz_modes(r: float) -> list[complex]:
    """At the points of rest beside the origin, sigma = 10, b = 8/3."""
    b = 8 / 3
    x = sqrt(b * (r - 1))
    return list(np.linalg.eigvals([[-10, 10, 0], [1, -1, -x], [x, x, -b]]))


def rk4_limit(modes: list[complex]) -> float:
    """The least h at which |R(h lambda)| = 1 for a mode that decays."""
    r = stability_polynomial("rk4")[::-1]

    def at(mode: complex) -> float:
        h = 0.01 / abs(mode)
        while abs(mp.polyval(r, h * mode)) <= 1:
            h += 0.001 / abs(mode)
        return float(h)

    return min(map(at, modes))


def turning(first: float, second: float) -> float:
    """The step of the midpoint rule at which theta_1 + 2 theta_2 = 2 pi, theta = 2 atan(h w/2)."""

    def gap(h):
        return 2 * mp.atan(h * first / 2) + 4 * mp.atan(h * second / 2) - 2 * mp.pi

    return float(mp.findroot(gap, (0.5, 2), solver="anderson"))


# The shipped elastic pendulum: m = 1, l0 = 1, k = 3 m g/l0: stretch sqrt(k), swing half of it.
STRETCH = sqrt(3 * 9.81)
ELASTIC = MAP.format("../../../models/elastic_pendulum.lag", "gauss1")
EULER = min(-2 * m.real / abs(m) ** 2 for m in lorenz_modes(15))

PREDICTIONS: list[Prediction] = [
    shown(
        "Y1", "x' = x (1 - x), rk4, its map", "x = 1 is lost from |R(-h)| = 1 on",
        axis_limit("rk4", -1), BOUNDARY, MAP.format("logistic.lag", "rk4"),
        'mapped(report, "limit")', "--methods euler", long=True,
    ),
    shown(
        "Y2", "elastic pendulum 1:2, gauss1, its map", "A-stable, yet two modes turn by "
        "theta_1 + 2 theta_2 = 2 pi a step", turning(STRETCH, STRETCH / 2), 1e-6, ELASTIC,
        'mapped(report, "1+2")', "--methods gauss2", long=True,
    ),
    shown(
        "Y3", "elastic pendulum 1:2, gauss1, its map", "and there the smallest motion grows, by",
        (1e2, 1e5), 0, ELASTIC, 'mapped(report, "1+2", "response")', "--methods gauss2", long=True,
    ),
    shown(
        "Y4", "Kepler, e = .9, verlet, its map", "within a factor of 2 of its limit over the "
        "fastest rate, 2 r_p^1.5/sqrt 2", (sqrt(2) * 0.1**1.5 / 2, 2 * sqrt(2) * 0.1**1.5), 0,
        MAP.format("kepler.lag --set e=0.9", "verlet"), 'mapped(report, "local")',
        "--methods suzuki4", long=True,
    ),
    shown(
        "Y5", "Lorenz's equations, r = 15, rk4, their map", "rest is lost where |R(h lambda)| = 1",
        rk4_limit(lorenz_modes(15)), BOUNDARY, MAP.format("lorenz.lag --set r=15", "rk4"),
        'mapped(report, "limit")', "--methods rk3", long=True,
    ),
    shown(
        "Y6", "Lorenz's equations, r = 15, euler", "rest is lost at h = 2 |Re lambda|/|lambda|^2",
        EULER, BOUNDARY,
        f"for h in {around(EULER)}; do pkgen run lorenz.lag --set r=15 --start x=6.1102 "
        "--start y=6.1101 --start z=14 --method euler --step $h --until 4000 --every 1; done",
        "edge of h: max(abs(x[-200:] - sqrt(8/3*14))) > max(abs(x[:200] - sqrt(8/3*14)))",
        "--method rk4",
    ),
    shown(
        "Y7a", "x' = x (1 - x), euler, its map", "finds a 2-cycle, whose points sum to (2 + h)/h: "
        "over that", 1.0, 1e-6, MAP.format("logistic.lag", "euler"),
        'first([sum(x)*h/(2 + h) for h, x in ghosts(report, "2-cycle")])', "--methods rk4",
        long=True,
    ),
    shown(
        "Y7b", "x' = x (1 - x), rk2, its map", "finds a point of rest that is none, 2/h: times h",
        2.0, 1e-6, MAP.format("logistic.lag", "rk2"),
        'first([x[0]*h for h, x in ghosts(report, "fixed point")])', "--methods euler", long=True,
    ),
    shown(
        "Y8", "van der Pol's oscillator, mu = 1, its map", "its cycle's other multiplier, by "
        "Taylor's series of order 30 in 30 digits", 0.000859695063603805, 1e-5,
        MAP.format("van_der_pol.lag", "rk4"),
        'min([re for re, im in report["cycle"]["multipliers"]])', "--set mu=1.001", long=True,
        no_method="the cycle is the motion's own, whatever the method",
    ),
]  # fmt: skip
