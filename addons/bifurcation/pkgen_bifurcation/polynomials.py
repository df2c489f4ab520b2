"""Polynomials of degree 4 on the intervals of a grid, by their values at 5 points of each.

Reference: R. D. Russell, J. Christiansen, SIAM J. Numer. Anal. 15 (1978) 59 (the choice of grids).
"""

from __future__ import annotations

import math

import numpy

DEGREE = 4
LEAST_INTERVALS, MOST_INTERVALS = 24, 300
INTERVALS_PER_UNIT = 8.0  # intervals for each unit of the monitor function's integral


def _tables() -> tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray]:
    """Returns the Gauss points in (0, 1), and there the values and the derivatives of Lagrange's
    polynomials of the points k/DEGREE."""
    points = (numpy.polynomial.legendre.leggauss(DEGREE)[0] + 1) / 2
    inner = numpy.arange(DEGREE + 1) / DEGREE
    W, D = numpy.empty((2, DEGREE, DEGREE + 1))
    for k in range(DEGREE + 1):
        basis = numpy.poly1d(numpy.delete(inner, k), r=True)
        basis /= basis(inner[k])
        W[:, k], D[:, k] = basis(points), basis.deriv()(points)
    return points, W, D


POINTS, W, D = _tables()
HIGHEST = numpy.array([(-1) ** (DEGREE - k) * math.comb(DEGREE, k) for k in range(DEGREE + 1)])


def points(grid: numpy.ndarray) -> numpy.ndarray:
    """Returns the times of all states."""
    inner = grid[:-1, None] + numpy.diff(grid)[:, None] * numpy.arange(DEGREE) / DEGREE
    return numpy.append(inner.ravel(), grid[-1])


def interpolated(grid: numpy.ndarray, z: numpy.ndarray, times: numpy.ndarray) -> numpy.ndarray:
    """Returns the polynomials at times."""
    i = numpy.clip(numpy.searchsorted(grid, times, "right") - 1, 0, len(grid) - 2)
    s = (times - grid[i]) / numpy.diff(grid)[i] * DEGREE
    found = 0.0
    for k in range(DEGREE + 1):
        others = [j for j in range(DEGREE + 1) if j != k]
        basis = numpy.prod([(s - j) / (k - j) for j in others], axis=0)
        found = found + basis[:, None] * z[i * DEGREE + k]
    return found


def adapted(grid: numpy.ndarray, z: numpy.ndarray) -> numpy.ndarray:
    """Returns a grid whose intervals have like errors: the integral of |5th derivative|^(1/5) over
    each is the same. Raises ArithmeticError if it has too many."""
    count, h = len(grid) - 1, numpy.diff(grid)
    index = numpy.arange(count)[:, None] * DEGREE + numpy.arange(DEGREE + 1)
    top = numpy.einsum("k,ikd->id", HIGHEST, z[index]) * (DEGREE / h[:, None]) ** DEGREE
    jumps = numpy.diff(top, axis=0, append=top[:1])
    fifth = abs(jumps).max(1) / ((h + numpy.roll(h, -1)) / 2)
    root = fifth ** (1 / (DEGREE + 1))
    monitor = (root + numpy.roll(root, 1)) / 2
    monitor = numpy.fmax(monitor, 0.05 * (monitor @ h))
    total = numpy.append(0.0, numpy.cumsum(monitor * h))
    if not total[-1] < MOST_INTERVALS:
        raise ArithmeticError
    wanted = math.ceil(INTERVALS_PER_UNIT * total[-1])
    wanted = min(MOST_INTERVALS, max(LEAST_INTERVALS, wanted))
    return numpy.interp(numpy.linspace(0, total[-1], wanted + 1), total, grid)
