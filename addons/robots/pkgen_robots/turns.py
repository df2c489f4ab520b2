"""Rotations: as matrices, or as products of rot(AXIS, ANGLE), where the rightmost factor is applied
first."""

from __future__ import annotations

import math
from collections.abc import Sequence

Vector = tuple[float, ...]
Matrix = tuple[Vector, Vector, Vector]
Turns = tuple[tuple[Vector, float], ...]  # pairs (axis of any length, angle)

UNIT: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
# An angle that differs less than this from a multiple of pi/2 counts as that multiple. The doubles
# nearest to the multiples are not equal to them.
NEAR = 1e-15


def right_angles(angle: float) -> int | None:
    """Returns k if the angle is k pi/2, else None."""
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
    """Returns the tensor R tensor R^T, made exactly symmetric; R is the matrix of the rotations
    `turns`."""
    if not turns:
        return tensor
    turn = matrix(turns)
    m = product(product(turn, tensor), tuple(zip(*turn, strict=True)))
    return tuple(tuple((m[i][j] + m[j][i]) / 2 for j in range(3)) for i in range(3))


def matrix(turns: Turns) -> Matrix:
    """Returns the product of the rotation matrices, by Rodrigues' formula."""
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
    """Returns the rotation about the fixed x, then y, then z axis, as in URDF."""
    axes = (UNIT[0], UNIT[1], UNIT[2])
    return of_angles(axes[::-1], angles[::-1])


def of_angles(axes: Sequence[Vector], angles: Sequence[float]) -> Turns:
    """Returns the rotations about `axes` by `angles`, without angles of 0."""
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
    """Returns the shortest rotation of the z axis to the direction `z`."""
    axis = (-z[1], z[0], 0.0) if z[0] or z[1] else UNIT[0]
    return of_angles([axis], [math.atan2(math.hypot(z[0], z[1]), z[2])])


def of_axes(x: Sequence[float], y: Sequence[float]) -> Turns | None:
    """Returns the rotation to axes with x along `x` and y nearest to `y`; None if these are
    parallel."""
    z = crossed(x, y)
    if not any(z):
        return None
    first = of_direction(z)
    # the vector `x` along the axes after the first rotation
    near = [inner(column, x) for column in zip(*matrix(first), strict=True)]
    return first + of_angles([UNIT[2]], [math.atan2(near[1], near[0])])
