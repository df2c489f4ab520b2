"""The linear equations of collocation. Unknowns inside of intervals are eliminated, and intervals
are joined to SEGMENTS.

Reference: T. F. Fairgrieve, A. D. Jepson, SIAM J. Numer. Anal. 28 (1991) 1446 (multipliers).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy

from .polynomials import DEGREE, D, W

SEGMENTS = 12
CONTRACTS = 1e10  # condition of a map whose inverse says nothing


@dataclass
class Condensed:
    """The equations between the beginnings of segments: the state at the end of each is a linear
    map of that at its beginning, and of the unknowns that are no states."""

    jacobian: numpy.ndarray
    residual: numpy.ndarray
    maps: list[numpy.ndarray]  # of each segment
    segments: numpy.ndarray  # the first interval of each segment, then the number of intervals
    begins: numpy.ndarray  # the state at the beginning of each interval, by that of its segment
    inner: numpy.ndarray  # the states inside of each interval, by that at its beginning

    def expand(self, step: numpy.ndarray, homogeneous: bool) -> numpy.ndarray:
        """Returns the correction at all points, from that at the beginnings of segments."""
        count, d, _ = self.begins.shape
        own, tail = step[: SEGMENTS * d].reshape(SEGMENTS, d), step[SEGMENTS * d :]
        last = numpy.append(tail, 0.0 if homogeneous else 1.0)
        found = numpy.empty((count, DEGREE, d))
        for k, (first, end) in enumerate(pairwise(self.segments)):
            at = self.begins[first:end] @ numpy.append(own[k], last)
            found[first:end, 0] = at
            both = numpy.concatenate([at, numpy.tile(last, (end - first, 1))], 1)
            inside = numpy.einsum("iab,ib->ia", self.inner[first:end], both)
            found[first:end, 1:] = inside.reshape(end - first, DEGREE, d)[:, :-1]
        return numpy.append(found.ravel(), tail)


def condensed(h, segments, A, columns, residual) -> Condensed | None:
    """Returns the equations z' - A z = columns . (unknowns that are no states) - residual, which
    hold at the Gauss points of intervals of lengths h; None where they are not finite or singular.
    The shapes are (intervals, DEGREE, d, ...)."""
    count, _, d, extra = columns.shape
    B = numpy.einsum("jk,de->jdke", D, numpy.eye(d))[None] / h[:, None, None, None, None]
    B = B - numpy.einsum("jk,ijde->ijdke", W, A)
    B = B.reshape(count, DEGREE * d, (DEGREE + 1) * d)
    columns, residual = columns.reshape(count, -1, extra), residual.reshape(count, -1, 1)
    right = numpy.concatenate([-B[:, :, :d], columns, -residual], 2)
    if not numpy.isfinite(right).all() or not numpy.isfinite(B).all():
        return None
    try:
        inner = numpy.linalg.solve(B[:, :, d:], right)
    except numpy.linalg.LinAlgError:
        return None
    begins = numpy.empty((count, d, d + extra + 1))
    rows = numpy.zeros((SEGMENTS * d, SEGMENTS * d + extra))
    off, maps = numpy.empty(SEGMENTS * d), []
    to = numpy.concatenate([numpy.zeros((extra + 1, d)), numpy.eye(extra + 1)], 1)
    for k, (first, last) in enumerate(pairwise(segments)):
        M = numpy.eye(d, d + extra + 1)
        for i in range(first, last):
            begins[i] = M
            M = inner[i, -d:] @ numpy.concatenate([M, to])
        maps.append(M[:, :d])
        part, after = slice(k * d, (k + 1) * d), (k + 1) % SEGMENTS * d
        rows[part, part] += M[:, :d]
        rows[part, after : after + d] -= numpy.eye(d)
        rows[part, SEGMENTS * d :] += M[:, d:-1]
        off[part] = M[:, -1]
    return Condensed(rows, off, maps, segments, begins, inner)


def multipliers(maps: list[numpy.ndarray]) -> numpy.ndarray:
    """Returns the multipliers, by the maps over both halves of the orbit: their product has lost
    the small ones where others are large, unless all are small."""
    from scipy.linalg import eig

    halves = []
    for part in (maps[: SEGMENTS // 2], maps[SEGMENTS // 2 :]):
        M = numpy.eye(len(maps[0]))
        for one in part:
            M = one @ M
        halves.append(M)
    if numpy.linalg.cond(halves[1]) > CONTRACTS:
        return numpy.linalg.eigvals(halves[1] @ halves[0])
    return eig(halves[0], numpy.linalg.inv(halves[1]), right=False)
