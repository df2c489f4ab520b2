"""Newton's method from several starts at once, with corrections of least norm and deflation.

Deflation keeps the iteration away from known solutions. It multiplies the equations by p = prod (1
+ 1/|z - known|^2). The correction for the multiplied equations is that for the equations
themselves, times 1/(1 - grad(p).correction/p).

References: P. E. Farrell, A. Birkisson, S. W. Funke, SIAM J. Sci. Comput. 37 (2015) A2026; J. H.
Halton, Numer. Math. 2 (1960) 84 (points that fill a box evenly).
"""

from __future__ import annotations

import math
from itertools import count, islice

import numpy

BESIDE = 1e-6  # step of central differences, in units of z; the error of these is about 1e-10
FLAT = 1e-7  # a singular value below this part of the largest counts as 0
FURTHEST = 0.5  # largest correction, in units of z


def primes(n: int) -> list[int]:
    return [*islice((p for p in count(2) if all(p % k for k in range(2, math.isqrt(p) + 1))), n)]


def halton(k: int, base: int) -> float:
    """Returns element k of Halton's sequence, in (0, 1)."""
    x, digit = 0.0, 1.0
    while k:
        k, rest = divmod(k, base)
        digit /= base
        x += digit * rest
    return x


def least(
    gap: numpy.ndarray, slopes: numpy.ndarray, rounded: float = FLAT
) -> tuple[numpy.ndarray, ...]:
    """Returns for each of several systems the correction of least norm; for each singular value,
    whether it counts as 0; the right singular vectors, as rows. Along singular values below
    `rounded` of the largest nothing is corrected."""
    u, s, v = numpy.linalg.svd(slopes, full_matrices=False)
    parts = numpy.einsum("kij,ki->kj", u, gap)
    parts = numpy.where(s <= rounded * s[:, :1], 0.0, -parts / numpy.where(s > 0, s, 1))
    return numpy.einsum("kj,kji->ki", parts, v), s <= FLAT * s[:, :1], v


def deflation(apart: numpy.ndarray, step: numpy.ndarray) -> numpy.ndarray:
    """Returns the factor of each correction `step` of shape (starts, n). `apart` has the
    displacements from the known solutions, of shape (starts, known, n)."""
    square = (apart * apart).sum(2)
    slope = -2 * ((apart * step[:, None]).sum(2) / (square * (1 + square))).sum(1)
    return numpy.where(slope == 1, 1.0, 1 / (1 - slope))


def shortened(step: numpy.ndarray, size: numpy.ndarray) -> numpy.ndarray:
    """Returns the corrections, none of which has a `size` above FURTHEST."""
    return step * numpy.fmin(1, FURTHEST / numpy.fmax(size, FURTHEST))[:, None]
