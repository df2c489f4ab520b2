"""Attitudes in the three ways in which the bench has them, and what all are compared by.

Euler angles turn by R = Rz(phi) Rx(theta) Rz(psi), body to space; body rates are

    w = (phi' sin(theta) sin(psi) + theta' cos(psi),
         phi' sin(theta) cos(psi) - theta' sin(psi),  phi' cos(theta) + psi')

(L. Landau, E. Lifshitz, Mechanics, section 35). A quaternion is Q = (w, x, y, z) with
Q' = Q (0, w)/2. An angle that goes round is no error of its own: what is compared are the entries
of R, and w.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin

Numbers = Sequence[float]


def quaternion(phi: float, theta: float, psi: float) -> list[float]:
    half, apart = (phi + psi) / 2, (phi - psi) / 2
    c, s = cos(theta / 2), sin(theta / 2)
    return [c * cos(half), s * cos(apart), s * sin(apart), c * sin(half)]


def matrix(quaternion: Numbers) -> list[float]:
    """Row after row, of a quaternion of any length: its errors of length are seen too."""
    w, x, y, z = quaternion
    return [
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
    ]  # fmt: skip


def body_rates(angles: Numbers, rates: Numbers) -> list[float]:
    _, theta, psi = angles
    precession, nutation, spin = rates
    return [
        precession * sin(theta) * sin(psi) + nutation * cos(psi),
        precession * sin(theta) * cos(psi) - nutation * sin(psi),
        precession * cos(theta) + spin,
    ]


def of_angles(state: Numbers) -> list[float]:
    """R and w, of phi, theta, psi and their rates."""
    return matrix(quaternion(*state[:3])) + body_rates(state[:3], state[3:6])


def of_quaternion(state: Numbers) -> list[float]:
    """R and w, of a quaternion and w."""
    return matrix(state[:4]) + list(state[4:7])


def angles_to_quaternion(state: Numbers) -> list[float]:
    return quaternion(*state[:3]) + body_rates(state[:3], state[3:6])
