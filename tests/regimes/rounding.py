"""Sums of many steps, and drifts that only many steps show."""

from __future__ import annotations

from math import cos

from .prediction import ORDER
from .shown import shown

ORBITS = (
    "for n in 10 20 40 80; do pkgen run kepler.lag --method {} --until 2*pi*$n --every 0.1; done"
)
CLOSING = (
    "for n in 10 20 40 80; do pkgen run kepler.lag --method {} --until 2*pi*$n --every 2*pi; done"
)
ROD = (
    "for n in 20 40 80 160; do pkgen run ../../../models/constrained/pendulum_rod.lag "
    "--method {} --step 0.02 --until $n --every 0.5 --record energy; done"
)
DRIFT = "power of n: max(abs(energy - energy[0]))"

PREDICTIONS = [
    shown(
        "R1", "x' = 1 from 1e16, verlet, h = .1", "steps below the last digit of x add up, to",
        1000.0, 0, "pkgen run far.lag --method verlet --step 0.1 --until 1000", "x[-1] - 1e16",
        "--method gsl_rkf45 --max-step 0.1",
    ),
    shown(
        "R2", "1 + 1e100 + 1 - 1e100, euler, h = 1", "W. Kahan's sum of it is 0, not Neumaier's 2",
        (0.0, 0.0), 0, "pkgen run terms.lag --method euler --step 1 --until 4", "s[-1]",
        "--method gsl_rkf45 --max-step 1",
    ),
    shown(
        "R3", "oscillator, exponential, one step of 1e6", "q is cos(1e6) but for rounding",
        cos(1e6), 1e-9, "pkgen run oscillator.lag --method exponential --until 1e6 --every 1e6",
        "q[-1]", "--method gauss",
    ),
    shown(
        "R4", "Kepler, e = .6, dopri5", "steps that follow the error do not reverse: energy drifts "
        "with the power of t", 1.0, ORDER, ORBITS.format("dopri5"), DRIFT,
        "--method adaptive_verlet --step 0.01",
    ),
    shown(
        "R5", "Kepler, e = .6, adaptive_verlet, first step .01", "reversible steps: energy drifts "
        "with the power of t", (-0.05, 0.05), 0, ORBITS.format("adaptive_verlet --step 0.01"),
        DRIFT, "--method dopri5",
    ),
    shown(
        "R6", "Kepler, e = .6, dopri5, 10 to 80 orbits", "the position error grows with the power "
        "of t", 2.0, ORDER, CLOSING.format("dopri5"), "power of n: hypot(x[-1] - 0.4, y[-1])",
        "--method adaptive_verlet --step 0.01",
    ),
    shown(
        "R7", "pendulum on a rod, rk4 and projection, h = .02", "on the constraint, and yet energy "
        "drifts with the power of t", 1.0, ORDER, ROD.format("rk4"), DRIFT, "--method rattle",
    ),
    shown(
        "R8", "pendulum on a rod, rattle, h = .02", "energy drifts with the power of t",
        (-0.01, 0.01), 0, ROD.format("rattle"), DRIFT, "--method rk4",
    ),
]  # fmt: skip
