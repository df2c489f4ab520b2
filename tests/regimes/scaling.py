"""How errors scale with step, tolerance and eccentricity (A7 to A12)."""

from math import sin

from .kepler import TURNED
from .kepler import energy_error as kepler_error
from .modified import AMPLITUDE, swing
from .prediction import CLOSED, ORDER, Prediction, slope
from .probe import Probe
from .shown import shown


def pericentre_power(method: str) -> float:
    """Of 1 - e, in max |dE| of Kepler at a step far below it."""
    ends = ((0.96, 40_000), (0.98, 120_000), (0.99, 400_000))
    errors = [kepler_error(method, e, n) * n**2 / (1 + 2 * e) for e, n in ends]
    return slope([1 - e for e, _ in ends], errors)


def kink_power(method: str) -> float:
    """Of h, in the error of the rate after a throw at 3 m/s that passes the kink of the drag at its
    apex: the largest of sixteen phases of the grid."""
    errors, steps, start = [], (0.1, 0.05, 0.025, 0.0125), {"y'": 3.0}
    for h in steps:
        worst = 0.0
        for phase in range(16):
            end = 0.5 + phase * h / 16
            row = Probe("drag", method, end / round(end / h), start=start).at([end])[0]
            exact = Probe("drag", "dop853", start=start, tolerance=1e-15).at([end])[0]
            worst = max(worst, abs(row[2] - exact[2]))
        errors.append(worst)
    return slope(steps, errors)


SWING = repr(swing(sin(AMPLITUDE / 2))[0])

PREDICTIONS = [
    shown(
        "A7", "central force -r^3, yoshida4, h = .1, 1e5 steps",
        "kicks along r and drifts along v keep L: but for round-off its relative change is",
        (1e-17, 1e-13), 0,
        "pkgen run quartic_plane.lag --method yoshida4 --step 0.1 --until 10000 --every 1",
        "max(abs((x*y' - y*x')/0.6 - 1))", "--method rk4",
    ),
    shown(
        "A8", "pendulum from rest at 1.2, rk4",
        "reversible motion: the drift of E goes with h^5, not with the method's h^4", 5.0, ORDER,
        f"for n in 20 28 40 56; do pkgen run pendulum.lag --start theta={AMPLITUDE} --method rk4 "
        f"--step {SWING}/$n --until {SWING}*50 --every {SWING}; done",
        "power of n: 1/abs(energy[-1] - energy[10])", "--method euler",
    ),
    shown(
        "A9", "pendulum from rest at 1.2, dopri5",
        "the drift of E goes with the power of the tolerance", 1.0, ORDER,
        f"for e in 1e-5 1e-6 1e-7 1e-8 1e-9; do pkgen run pendulum.lag --start theta={AMPLITUDE} "
        "--method dopri5 --rtol $e --until 300 --every 300; done",
        "power of e: abs(energy[-1] - energy[0])", "--method gsl_msbdf",
    ),
    Prediction(
        "A10", "Kepler, verlet, e = .96 to .99",
        "max |dE| goes with (1 + 2 e) and the power of 1 - e", -4.0, CLOSED,
        lambda: pericentre_power("verlet"), "rk4", lambda: pericentre_power("rk4"), own=True,
    ),
    shown(
        "A11", "Kepler, e = .3, yoshida4", "the apsidal turn goes with the power of h", 4.0, ORDER,
        "for n in 60 80 120 160; do pkgen run kepler.lag --set e=0.3 --method yoshida4 "
        "--step 2*pi/$n --until 80*pi --every pi; done",
        f"power of n: 1/abs(({TURNED}[1::2])[-1] - ({TURNED}[1::2])[0])", "--method verlet",
    ),
    Prediction(
        "A12", "ball in air through its apex, rk4",
        "across the kink of |v| v the error goes with h^3, not h^4", 3.0, ORDER,
        lambda: kink_power("rk4"), "euler", lambda: kink_power("euler"), own=True,
    ),
    *(
        shown(
            id, f"q' held to sin t by friction 1e6, {method}", says, power, ORDER,
            f"for n in 8 12 16 24 32; do pkgen run follow.lag --method {method} --step 1/$n "
            "--until 1 --every 1; done", "power of n: 1/abs(q'[-1] - sin(1))", f"--method {worse}",
        )
        for id, method, says, power, worse in (
            ("A15a", "gauss2", "order 4 falls to s = 2, R(inf) being 1", 2.0, "gauss3"),
            ("A15b", "gauss3", "order 6 falls to s + 1 = 4, R(inf) being -1", 4.0, "gauss2"),
            ("A15c", "radau5", "order 5 falls to s = 3, error h^s / lambda", 3.0, "gauss3"),
        )
    ),
]  # fmt: skip
