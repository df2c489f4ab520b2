"""Kepler's problem, mu = a = 1, from the pericentre (K1 to K6), and Arenstorf's orbit (K7)."""

from functools import cache
from math import pi

import numpy as np

from .prediction import CLOSED, MEASURED, Prediction
from .probe import Probe
from .shown import listed


def orbit(method: str, e: float, steps: int, orbits: float = 1, every: int = 1) -> np.ndarray:
    """Rows t, x, y, x', y', energy, `steps` steps an orbit."""
    probe = Probe("kepler", method, 2 * pi / steps, set={"e": e})
    return probe.steps(round(steps * orbits), every)


def apsidal_predicted(e: float, h: float) -> float:
    return -pi / 8 * h * h * (4 + e * e) / (1 - e * e) ** 3


def energy_coefficient(e: float) -> float:
    """max |E - E(0)| / h^2 of Verlet, from its modified Hamiltonian H + h^2 (p V'' p / 12 -
    |V'|^2 / 24) (GNI IX.8): p V'' p = (p^2 - 3 p_r^2)/r^3, on the unperturbed ellipse."""
    eccentric = np.linspace(0, pi, 200_001)
    r = 1 - e * np.cos(eccentric)
    p2 = 2 / r - 1
    radial = e * np.sin(eccentric) / r
    g = (p2 - 3 * radial**2) / r**3 / 12 - 1 / r**4 / 24
    return np.abs(g - g[0]).max()


def energy_error(method: str, e: float, steps: int, orbits: float = 1) -> float:
    return np.abs(orbit(method, e, steps, orbits)[:, -1] + 0.5).max()


def steps_for_a_percent(method: str, e: float, guess: int) -> float:
    """The fewest steps an orbit that keep max |dE/E| of the first orbit within 1%."""
    low, high = guess // 2, guess * 2
    while high - low > max(1, guess // 300):
        middle = (low + high) // 2
        low, high = (low, middle) if energy_error(method, e, middle) <= 0.005 else (middle, high)
    return high


def variable_drift(orbits: int) -> float:
    """|dE| of Verlet with h = .05 r^1.5, of the r at the start of each step."""
    probe = Probe("kepler", "verlet", 1.0, set={"e": 0.8})
    q, v = probe.q.copy(), probe.v.copy()
    return probe.lib.misused_variable(probe.p, 0.05, 2 * pi * orbits, q, v)


@cache
def momentum_error(plain: bool, steps: int) -> float:
    """Root mean square of L/L(0) - 1 at a hundred times of so many Verlet steps of 2 pi/100."""
    probe = Probe("kepler", "verlet", 2 * pi / 100, set={"e": 0.2})
    q, v = probe.q.copy(), probe.v.copy()
    first = q[0] * v[1] - q[1] * v[0]
    errors = []
    for _ in range(100):
        if plain:
            probe.lib.plain_verlet(probe.p, 2 * pi / 100, steps // 100, q, v)
        else:
            q, v = probe.steps(steps // 100, steps // 100)[-1, 1:5].reshape(2, 2)
        errors.append((q[0] * v[1] - q[1] * v[0]) / first - 1)
    return float(np.sqrt(np.mean(np.square(errors))))


PERIOD = "17.0652165601579625588917206249"
ARENSTORF = f"pkgen run arenstorf.lag --until {PERIOD} --every {PERIOD} --method {{}}"
CLOSURE = "sqrt(sum([(a[-1] - a[0])**2 for a in (x, y, x', y')]))"
# The angle of the Laplace vector, and with it that of the apses.
TURNED = "unwrap(arctan2(-x'*(x*y' - y*x') - y/hypot(x, y), y'*(x*y' - y*x') - x/hypot(x, y)))"


H = 2 * pi / 2000

PREDICTIONS = [
    *(
        listed(
            id, f"Kepler, e = .6, {method}, h = 2 pi/2000", says, predicted, CLOSED,
            "pkgen run kepler.lag --set e=0.6 --method " + method
            + " --step 2*pi/2000 --until 40*pi --every 2*pi/2000",
            f"mean(diff({TURNED}[999::2000]))", f"--method {worse}",
        )
        for id, method, says, predicted, worse in (
            ("K1a", "verlet", "apsidal turn an orbit, -(pi/8) h^2 (4 + e^2)/(1 - e^2)^3",
             apsidal_predicted(0.6, H), "gauss1"),
            ("K1b", "gauss1", "apsidal turn an orbit, -2 times Verlet's",
             -2 * apsidal_predicted(0.6, H), "verlet"),
        )
    ),
    *(
        listed(
            id, f"Kepler, e = {e}, verlet, {steps:,} steps an orbit",
            "max |dE| / h^2, by its modified Hamiltonian", energy_coefficient(e), CLOSED,
            f"pkgen run kepler.lag --set e={e} --method verlet --step 2*pi/{steps} --until 2*pi "
            f"--every 2*pi/{steps} --record energy", f"max(abs(energy + 0.5))/(2*pi/{steps})**2",
            "--method yoshida4",
        )
        for id, e, steps in (("K2a", 0.5, 2000), ("K2b", 0.8, 20_000), ("K2c", 0.9, 50_000))
    ),
    *(
        Prediction(
            id, f"Kepler, e = {e}, {method}", "steps an orbit for max |dE/E| = 1%",
            steps, MEASURED, lambda m=method, e=e, n=steps: steps_for_a_percent(m, e, n),
            worse, lambda m=worse, e=e, n=steps: steps_for_a_percent(m, e, n),
        )
        for id, method, e, steps, worse in (
            ("K3a", "verlet", 0.9, 3196, "rk4"), ("K3b", "verlet", 0.99, 329_382, "rk4"),
            ("K3c", "rk4", 0.9, 608, "verlet"), ("K3d", "rk4", 0.99, 31_667, "verlet"),
        )
    ),
    *(
        Prediction(
            id, "Kepler, e = .8, Verlet with h = .05 r^1.5 of each step's start",
            f"max |dE| in {orbits} orbits", predicted, MEASURED,
            lambda n=orbits: variable_drift(n),
            "verlet, as many steps of one length",
            lambda n=orbits: energy_error("verlet", 0.8, 200, n),
        )
        for id, orbits, predicted in (
            ("K4a", 10, 0.0034), ("K4b", 100, 0.0138), ("K4c", 1000, 0.145),
        )
    ),
    listed(
        "K4d", "Kepler, e = .8, adaptive_verlet, h = .05 r^1.5, 1000 orbits", "max |dE| stays",
        0.0014318, MEASURED,
        "pkgen run kepler.lag --set e=0.8 --method adaptive_verlet --step 0.05*0.2^1.5 "
        "--until 2000*pi --every 0.3 --record energy", "max(abs(energy + 0.5))",
        "--method verlet --step pi/100",
    ),
    *(
        listed(
            id, f"Kepler, e = .3, {method}, {steps} steps an orbit, {text} orbits",
            "the position error grows with the power of t", power, CLOSED,
            f"for n in {orbits}; do pkgen run kepler.lag --set e=0.3 --method {method} "
            f"--step 2*pi/{steps} --until 2*pi*$n --every 2*pi*$n; done",
            "power of n: hypot(x[-1] - 0.7, y[-1])", f"--method {worse}",
        )
        for id, method, steps, text, power, orbits, worse in (
            ("K5a", "verlet", 2000, "10 to 1000", 1.0, "10 30 100 300 1000", "rk2"),
            ("K5b", "rk4", 200, "100 to 800", 2.0, "100 200 400 800", "verlet"),
        )
    ),
    Prediction(
        "K6a", "Kepler, e = .2, Verlet without compensated sums, 1e8 steps of 2 pi/100",
        "L/L(0) - 1, root mean square, round-off walks: 7.1e-13 within a factor 3",
        (7.1e-13 / 3, 7.1e-13 * 3), 0, lambda: momentum_error(True, 10**8),
        "verlet", lambda: momentum_error(False, 10**8), long=True,
    ),
    Prediction(
        "K6b", "Kepler, e = .2, verlet, 1e8 steps of 2 pi/100",
        "L/L(0) - 1, root mean square, sums compensated: 6.0e-15 within a factor 3",
        (2e-15, 1.8e-14), 0, lambda: momentum_error(False, 10**8),
        "without compensated sums", lambda: momentum_error(True, 10**8), long=True,
    ),
    listed(
        "K7a", "Arenstorf's orbit, dop853, tolerance 1e-13", "closes, but for", 2.1e-10, MEASURED,
        ARENSTORF.format("dop853 --rtol 1e-13 --atol 1e-13"), CLOSURE,
        f"--method rk4 --step {PERIOD}/6000 --rtol - --atol -",
        missed="it closes, to 1.3e-9 in (x, y, x', y') and 1e-11 in (x, y), but what is left is "
        "amplified round-off: with the same relative and other absolute tolerances, 1e-14 to "
        "1e-30, 7e-11 to 6e-10; SciPy's DOP853 leaves 1.2e-9, or 4.2e-10 with a relative tolerance "
        "alone. K7c is the same orbit by gauss.",
    ),
    listed(
        "K7b", "Arenstorf's orbit, rk4, 6000 steps", "misses its start by", 2.15, MEASURED,
        ARENSTORF.format(f"rk4 --step {PERIOD}/6000"), CLOSURE, "--method dop853 --step -",
    ),
    listed(
        "K7c", "Arenstorf's orbit, gauss, tolerance 1e-13", "closes but for round-off, amplified",
        (1e-14, 1e-9), 0, ARENSTORF.format("gauss --rtol 1e-13 --atol 1e-13"), CLOSURE,
        "--method dopri5 --rtol 1e-12",
    ),
]  # fmt: skip
