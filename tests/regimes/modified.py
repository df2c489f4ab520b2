"""What the modified Hamiltonian of Verlet, H + h^2 (p V'' p/12 - |V'|^2/24) + O(h^4) (GNI IX.8),
foretells (A1, A2, A6)."""

from math import cos, pi, sin, sqrt

import numpy as np

from .prediction import CLOSED
from .shown import shown

# --- the pendulum under Verlet, from rest at 1.2 --------------------------------------------

AMPLITUDE = 1.2


def swing(k: float, count: int = 400) -> tuple[float, float]:
    """Period, and integral of g = v^2 V''/12 - V'^2/24 over it, of modulus k, by the trapezoidal
    rule in phi, sin(theta/2) = k sin(phi)."""
    s = np.sin(2 * pi * np.arange(count) / count)
    weight = 2 * pi / count / np.sqrt(1 - k * k * s * s)
    cosine, v2 = 1 - 2 * k * k * s * s, 4 * k * k * (1 - s * s)
    g = v2 * cosine / 12 - (1 - cosine**2) / 24
    return float(weight.sum()), float((g * weight).sum())


def period_coefficient(amplitude: float) -> float:
    """(T(h) - T) / h^2: with J the action, T = d(2 pi J)/dE, and at a given value of the modified
    Hamiltonian 2 pi J is less by the integral of h^2 g; the start lies h^2 g(start) higher."""
    d = 1e-4

    def at(energy: float) -> tuple[float, float]:
        return swing(sqrt((1 + energy) / 2))

    e = -cos(amplitude)
    (t_low, g_low), (t_high, g_high) = at(e - d), at(e + d)
    return (-(g_high - g_low) - (t_high - t_low) * sin(amplitude) ** 2 / 24) / (2 * d)


def energy_swing(amplitude: float) -> float:
    """max |E - E(0)| / h^2 of a swing from rest."""
    theta = np.linspace(0, amplitude, 100_001)
    v2 = 2 * (np.cos(theta) - cos(amplitude))
    g = v2 * np.cos(theta) / 12 - np.sin(theta) ** 2 / 24
    return float(np.abs(g - g[-1]).max())


# --- apsidal turn in another central field -------------------------------------------------------


def quartic(energy: float, momentum: float) -> tuple[float, float]:
    """Apsidal angle, and integral of g over a radial period, of V = r^4/4: with u = r^2,
    u p_r^2 = (u - u1)(u2 - u)(u + u1 + u2)/2, by the trapezoidal rule in u = mean + half sin s."""
    roots = np.sort(np.roots([-0.5, 0, 2 * energy, -(momentum**2)]).real)
    u1, u2 = roots[1:]
    s = 2 * pi * (np.arange(400) + 0.5) / 400
    u = (u1 + u2) / 2 + (u2 - u1) / 2 * np.sin(s)
    dt = 2 * pi / 400 / (2 * np.sqrt((u + u1 + u2) / 2))
    along2 = (u - u1) * (u2 - u) * (u + u1 + u2) / 2
    g = (u * (2 * energy - u * u / 2) + 2 * along2) / 12 - u**3 / 24
    return float((momentum / u * dt).sum()), float((g * dt).sum())


def apsidal_coefficient(speed: float) -> float:
    """(turn(h) - turn) / h^2 from the apocentre r = 1: the turn is -d(2 pi J_r)/dL."""
    d, energy = 1e-4, speed**2 / 2 + 1 / 4
    by_momentum = (quartic(energy, speed + d)[1] - quartic(energy, speed - d)[1]) / (2 * d)
    by_energy = (quartic(energy + d, speed)[0] - quartic(energy - d, speed)[0]) / (2 * d)
    return by_momentum + by_energy * (speed**2 / 12 - 1 / 24)


PREDICTIONS = [
    shown(
        "A1", "pendulum from rest at 1.2, verlet, h = .01",
        "max |dE| / h^2, by the modified Hamiltonian", energy_swing(AMPLITUDE), 1e-3,
        f"pkgen run pendulum.lag --start theta={AMPLITUDE} --method verlet --step 0.01 "
        "--until 100 --every 0.01", "max(abs(energy - energy[0]))/0.01**2", "--method yoshida4",
    ),
    shown(
        "A2", "pendulum from rest at 1.2, verlet, h = .02",
        "(T(h) - T) / h^2, from the action of the modified Hamiltonian",
        period_coefficient(AMPLITUDE), 1e-3,
        f"pkgen run pendulum.lag --start theta={AMPLITUDE} --method verlet --step 0.02 --until 400",
        f'(mean(diff(times(report, "top"))) - {swing(sin(AMPLITUDE / 2))[0]:.14g})/0.02**2',
        "--method gauss1",
    ),
    shown(
        "A6", "central force -r^3, verlet, h = .02",
        "(apsidal turn(h) - turn) / h^2, from the modified Hamiltonian",
        apsidal_coefficient(0.6), CLOSED,
        "pkgen run quartic_plane.lag --method verlet --step 0.02 --until 300 --at apocentre",
        f"(mean(diff(unwrap(arctan2(y, x)))) - {quartic(0.6**2 / 2 + 1 / 4, 0.6)[0]:.14g})/0.02**2",
        "--method gauss1",
    ),
]  # fmt: skip
