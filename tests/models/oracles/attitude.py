"""Unit quaternions (w, x, y, z), body to space: their matrix, their rate, turns about an axis."""

import numpy as np


def matrix(q: np.ndarray) -> np.ndarray:
    w, x, y, z = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def rate(q: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """q' = q (0, omega)/2, omega in the body."""
    w, x, y, z = q
    a, b, c = omega
    return (
        np.array(
            [
                -x * a - y * b - z * c,
                w * a + y * c - z * b,
                w * b + z * a - x * c,
                w * c + x * b - y * a,
            ]
        )
        / 2
    )


def turn(axis: tuple, angle: float) -> np.ndarray:
    """The quaternion of a right-handed turn."""
    axis = np.array(axis, float) / np.linalg.norm(axis)
    return np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * axis])


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Of two turns, q first."""
    w = p[0] * q[0] - p[1:] @ q[1:]
    return np.concatenate([[w], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])])
