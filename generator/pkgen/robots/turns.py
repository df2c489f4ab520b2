"""Turns as matrices of numbers: from roll, pitch and yaw, quaternions, axes and angles, and back."""

from __future__ import annotations

import math
from collections.abc import Sequence

Vector = tuple[float, ...]
Matrix = tuple[Vector, Vector, Vector]
UNIT: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def inner(a: Sequence[float], b: Sequence[float]) -> float:
    return sum(x * y for x, y in zip(a, b, strict=True))


def applied(m: Matrix, v: Sequence[float]) -> Vector:
    return tuple(inner(row, v) for row in m)


def added(a: Sequence[float], b: Sequence[float], sign: float = 1.0) -> Vector:
    return tuple(x + sign * y for x, y in zip(a, b, strict=True))


def product(a: Matrix, b: Matrix) -> Matrix:
    columns = list(zip(*b, strict=True))
    return tuple(tuple(inner(row, c) for c in columns) for row in a)


def seen_from(turn: Matrix, tensor: Matrix) -> Matrix:
    """turn tensor turn^T, made symmetric to the last bit."""
    if turn == UNIT:
        return tensor
    m = product(product(turn, tensor), tuple(zip(*turn, strict=True)))
    return tuple(tuple((m[i][j] + m[j][i]) / 2 for j in range(3)) for i in range(3))


def about(axis: int, angle: float) -> Matrix:
    if angle == 0:
        return UNIT
    c, s = math.cos(angle), math.sin(angle)
    rows = [list(row) for row in UNIT]
    i, j = (axis + 1) % 3, (axis + 2) % 3
    rows[i][i] = rows[j][j] = c
    rows[i][j], rows[j][i] = -s, s
    return tuple(map(tuple, rows))


def of_roll_pitch_yaw(angles: Sequence[float]) -> Matrix:
    """About the fixed x, then y, then z, as URDF has it."""
    roll, pitch, yaw = angles
    return product(product(about(2, yaw), about(1, pitch)), about(0, roll))


def of_quaternion(q: Sequence[float]) -> Matrix | None:
    """w, x, y, z of any length; None of zero."""
    size = math.hypot(*q)
    if not size:
        return None
    w, x, y, z = (part / size for part in q)
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def of_axis_angle(axis: Sequence[float], angle: float) -> Matrix | None:
    size = math.hypot(*axis)
    half = math.sin(angle / 2) / size if size else 0.0
    return of_quaternion((math.cos(angle / 2), *(half * x for x in axis))) if size else None


def axis_angle(m: Matrix) -> tuple[Vector, float]:
    """The axis and the angle from 0 to pi; by the quaternion's largest number (Shepperd, 1978)."""
    if m == UNIT:
        return (0.0, 0.0, 1.0), 0.0
    trace = m[0][0] + m[1][1] + m[2][2]
    numbers = [trace, m[0][0], m[1][1], m[2][2]]
    k = numbers.index(max(numbers))
    across = (m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1])
    if k == 0:
        q = [1 + trace, *across]
    else:
        i = k - 1
        q = [across[i], *(m[i][j] + m[j][i] for j in range(3))]
        q[k] = 1 + 2 * m[i][i] - trace
    w, *v = (-x for x in q) if q[0] < 0 else q
    size = math.hypot(*v)
    return (tuple(x / size + 0.0 for x in v), 2 * math.atan2(size, w)) if size else (UNIT[2], 0.0)
