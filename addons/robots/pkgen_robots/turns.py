"""Rotations as products of rot(AXIS, ANGLE), the rightmost applied first, and numeric matrices."""

from __future__ import annotations

import math
from collections.abc import Sequence

Vector = tuple[float, ...]
Matrix = tuple[Vector, Vector, Vector]
Turns = tuple[tuple[Vector, float], ...]  # axes of any length, angles

UNIT: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
# An angle this near a multiple of a right angle is that multiple: no double is nearer to it.
NEAR = 1e-15


def right_angles(angle: float) -> int | None:
    """Returns the multiple of a right angle; None if the angle is none."""
    count = round(angle / (math.pi / 2))
    return count if abs(angle - count * math.pi / 2) < NEAR else None


def inner(a: Sequence[float], b: Sequence[float]) -> float:
    return sum(x * y for x, y in zip(a, b, strict=True))


def crossed(a: Sequence[float], b: Sequence[float]) -> Vector:
    return tuple(a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3))


def applied(m: Matrix, v: Sequence[float]) -> Vector:
    return tuple(inner(row, v) for row in m)


def added(a: Sequence[float], b: Sequence[float], sign: float = 1.0) -> Vector:
    return tuple(x + sign * y for x, y in zip(a, b, strict=True))


def product(a: Matrix, b: Matrix) -> Matrix:
    columns = list(zip(*b, strict=True))
    return tuple(tuple(inner(row, c) for c in columns) for row in a)


def seen_from(turns: Turns, tensor: Matrix) -> Matrix:
    """Returns R tensor R^T, made exactly symmetric."""
    if not turns:
        return tensor
    turn = matrix(turns)
    m = product(product(turn, tensor), tuple(zip(*turn, strict=True)))
    return tuple(tuple((m[i][j] + m[j][i]) / 2 for j in range(3)) for i in range(3))


def matrix(turns: Turns) -> Matrix:
    """Returns the product of the rotation matrices, each by Rodrigues' formula."""
    whole = UNIT
    for axis, angle in turns:
        size = math.hypot(*axis)
        n = [x / size for x in axis]
        right = right_angles(angle)
        c = math.cos(angle) if right is None else (1, 0, -1, 0)[right % 4]
        s = math.sin(angle) if right is None else (0, 1, 0, -1)[right % 4]
        k = ((0.0, -n[2], n[1]), (n[2], 0.0, -n[0]), (-n[1], n[0], 0.0))
        rows = range(3)
        one = tuple(
            tuple((1 - c) * n[i] * n[j] + s * k[i][j] + c * (i == j) for j in rows) for i in rows
        )
        whole = product(whole, one)
    return whole


def of_roll_pitch_yaw(angles: Sequence[float]) -> Turns:
    """Returns the rotation about the fixed x, then y, then z axis, like URDF."""
    axes = (UNIT[0], UNIT[1], UNIT[2])
    return of_angles(axes[::-1], angles[::-1])


def of_angles(axes: Sequence[Vector], angles: Sequence[float]) -> Turns:
    """Returns the rotations with nonzero angles."""
    return tuple(
        (n, angle) for n, angle in zip(axes, angles, strict=True) if right_angles(angle) != 0
    )


def of_quaternion(q: Sequence[float]) -> Turns | None:
    """Returns the rotation of a quaternion (w, x, y, z) of any length; None if it is 0."""
    if not any(q):
        return None
    w, *v = (-x for x in q) if q[0] < 0 else q
    return of_angles([tuple(x + 0.0 for x in v)], [2 * math.atan2(math.hypot(*v), w)])


def of_direction(z: Sequence[float]) -> Turns:
    """Returns the shortest rotation of the z axis to a direction."""
    axis = (-z[1], z[0], 0.0) if z[0] or z[1] else UNIT[0]
    return of_angles([axis], [math.atan2(math.hypot(z[0], z[1]), z[2])])


def of_axes(x: Sequence[float], y: Sequence[float]) -> Turns | None:
    """Returns the rotation with the x axis along x, and the y axis nearest to y; None if x and y
    are parallel."""
    z = crossed(x, y)
    if not any(z):
        return None
    first = of_direction(z)
    near = [inner(column, x) for column in zip(*matrix(first), strict=True)]  # x before the first
    return first + of_angles([UNIT[2]], [math.atan2(near[1], near[0])])
