"""Symmetries of a motion, found numerically: combinations of shifts of coordinates, rotations of
the plane of two of them, and turns of bodies about axes in space or in the body.

Y = (q, v) is a state without unused entries. A generator is an affine field g(Y) = G Y + h, and a
symmetry if it commutes with the motion Y' = F(Y), and is tangent to the constraints:

    (dF/dY) g = G F,   (d phi/dY) g = 0,   (d(J v + j0)/dY) g = 0

A rotation of a body that is turned in space has Q' = (0, e)/2 Q; turned about an axis of its own
Q' = Q (0, e)/2, w' = w x e. Q is its quaternion, w its angular velocity along its own axes.
Reference: J. Marsden, T. Ratiu, Introduction to Mechanics and Symmetry (1999), ch. 9 and 11.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations

import numpy
from numpy import linalg

from ...record import record
from .newton import halton, primes
from .system import System

BESIDE = 2e-5  # step of central differences, relative to the size of a state
SMALL = 2e-5  # a singular value below this part of the largest counts as 0
MOST = 24  # coordinates beyond which rotations of planes are not tried
SAMPLES = 6  # states at which fields are compared, beside one for each number of a state
AXES = numpy.eye(3)


@record
class Symmetry:
    """The field G Y + h. `name` is "q" for a shift of coordinate `index`, else "plane", "space" or
    "body", and then `index` is the axis."""

    name: str
    index: int
    G: numpy.ndarray
    h: numpy.ndarray

    def at(self, Y: numpy.ndarray) -> numpy.ndarray:
        return Y @ self.G.T + self.h


def _cross(e: numpy.ndarray) -> numpy.ndarray:
    """Returns the matrix of w -> w x e."""
    return numpy.cross(numpy.eye(3), e).T


def _products(e: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Returns the matrices of Q -> (0, e) Q and of Q -> Q (0, e)."""
    left, right = numpy.zeros((4, 4)), numpy.zeros((4, 4))
    for matrix, sign in ((left, -1), (right, 1)):
        matrix[0, 1:], matrix[1:, 0] = -e, e
        matrix[1:, 1:] = sign * _cross(e)
    return left, right


def _candidates(system: System, units: Sequence[str]) -> list[Symmetry]:
    m, size = system.m, system.m + system.n
    found = []

    def add(name: str, index: int, *blocks: tuple[int, numpy.ndarray]) -> None:
        G, h = numpy.zeros((size, size)), numpy.zeros(size)
        for place, block in blocks:
            G[place : place + len(block), place : place + len(block)] = block
        if name == "q":
            h[index] = 1
        found.append(Symmetry(name, index, G, h))

    for i in range(m):
        add("q", i)
    for i, j in combinations(range(m), 2) if m <= MOST else ():
        if units[i] == units[j]:
            G = numpy.zeros((m, m))
            G[i, j], G[j, i] = -1, 1
            add("plane", i, (0, G), (m, G))
    for b in range(system.turning // 3):
        rates, Q = 2 * m + 3 * b, 2 * m + system.turning + 4 * b
        for k, e in enumerate(AXES):
            left, right = _products(e)
            add("space", k, (Q, left / 2))
            add("body", k, (Q, right / 2), (rates, _cross(e)))
    return found


class Fields:
    """The motion Y' = F(Y) of a system at states Y = (q, v) without unused entries, along which all
    arrays have a first axis."""

    def __init__(self, system: System):
        self.system = system
        self.start = system.begun[system.used]

    def states(self, Y: numpy.ndarray) -> numpy.ndarray:
        found = numpy.zeros((len(Y), 2 * self.system.n))
        found[:, self.system.used] = Y
        return found

    def motion(self, Y: numpy.ndarray) -> numpy.ndarray:
        m, a = self.system.m, self.system.kernel("acceleration", 0.0, self.states(Y))
        return numpy.concatenate([Y[:, m : 2 * m], a], 1)

    def constraints(self, Y: numpy.ndarray) -> numpy.ndarray:
        return self.system.constraints(self.states(Y))

    def along(self, of: Callable, Y: numpy.ndarray, g: numpy.ndarray) -> numpy.ndarray:
        """Returns the derivatives of of(Y) along g. Differences over two steps cancel the error of
        the second order (L. F. Richardson, 1911)."""
        by = BESIDE * abs(Y).max() / (abs(g).max() or 1.0)
        single, double = ((of(Y + k * by * g) - of(Y - k * by * g)) / (2 * k * by) for k in (1, 2))
        return (4 * single - double) / 3

    def samples(self, count: int) -> numpy.ndarray:
        """Returns states beside the start and on the constraints."""
        size = abs(self.start)
        for part in numpy.split(size, [self.system.m]):
            part[part <= 0.1 * part.max(initial=0.0)] = part.max(initial=0.0) or 1.0
        bases = primes(len(size))
        points = [[2 * halton(k, b) - 1 for b in bases] for k in range(11, 11 + count)]
        Y = self.start + 0.5 * size * numpy.array(points)
        if self.system.bound:
            it = self.system.reference()
            ends = [it.projected(y) for y in self.states(Y)]
            on = [y[self.system.used] for status, y in ends if status == "PK_DONE"]
            Y = numpy.array(on).reshape(len(on), Y.shape[1])
        return Y[numpy.isfinite(self.motion(Y)).all(1)]

    def turn(self, symmetry: Symmetry, Y: numpy.ndarray) -> numpy.ndarray:
        """Returns the rates of coordinates, then the angular velocities of bodies, with which a
        symmetry moves the states Y."""
        m, turning = self.system.m, self.system.turning
        g, Q = symmetry.at(Y), Y[:, 2 * m + turning :][:, : 4 * turning // 3]
        by = g[:, 2 * m + turning :][:, : 4 * turning // 3].reshape(len(Y), -1, 4)
        Q = Q.reshape(len(Y), -1, 4)
        w = (
            Q[..., :1] * by[..., 1:]
            - by[..., :1] * Q[..., 1:]
            - numpy.cross(Q[..., 1:], by[..., 1:])
        )
        return numpy.concatenate([g[:, :m], 2 * w.reshape(len(Y), -1)], 1)

    def commute(self, found: Sequence[Symmetry]) -> bool:
        """Returns whether any two of the symmetries commute."""
        return all(
            abs(a.G @ b.G - b.G @ a.G).max() + abs(a.G @ b.h - b.G @ a.h).max() < 1e-9
            for a, b in combinations(found, 2)
        )

    def momentum(self, symmetry: Symmetry, Y: numpy.ndarray) -> numpy.ndarray:
        p = self.system.kernel("free momenta", 0.0, self.states(Y))
        turn = self.turn(symmetry, Y)
        return (p[:, : turn.shape[1]] * turn).sum(1)

    def is_conserved(self, symmetry: Symmetry, Y: numpy.ndarray) -> bool:
        """Returns whether the momentum of a symmetry is constant, at the samples Y."""
        F = self.motion(Y)
        rate = self.along(lambda y: self.momentum(symmetry, y)[:, None], Y, F)[:, 0]
        size = abs(self.momentum(symmetry, Y)).max() * (abs(F) / abs(Y).max()).max()
        return bool(abs(rate).max() <= 1e-6 * size)


def symmetries(fields: Fields, units: Sequence[str]) -> list[Symmetry]:
    """Returns a basis of the symmetries. `units` are those of the coordinates: two with different
    units are not rotated."""
    tried = _candidates(fields.system, units)
    Y = fields.samples(SAMPLES + fields.start.size) if tried else fields.start[None]
    if len(Y) < 2 or not tried:
        return []
    F, columns, sizes = fields.motion(Y), [], []
    for symmetry in tried:
        g = symmetry.at(Y)
        by_F, by_g = fields.along(fields.motion, Y, g), F @ symmetry.G.T
        on = fields.along(fields.constraints, Y, g)
        columns.append(numpy.concatenate([by_F - by_g, on], 1))
        # Less than a millionth of F in a displacement of the size of Y is round-off.
        least = 1e-6 * abs(F).max(0) * abs(g).max() / abs(Y).max()
        sizes.append(numpy.concatenate([abs(by_F) + abs(by_g) + least, abs(on)], 1))
    found, size = numpy.array(columns), numpy.array(sizes)
    good = numpy.isfinite(found).all((0, 2))
    found, size = found[:, good], size[:, good]
    each = size.max((0, 1), initial=1e-99)
    each[F.shape[1] :] = numpy.fmax(
        each[F.shape[1] :], 1e-6 * each[F.shape[1] :].max(initial=1e-99)
    )
    A, size = ((x / each).reshape(len(tried), -1).T for x in (found, size))
    units_of = size.max(0, initial=1e-99)
    _, s, v = linalg.svd(A / units_of)
    rank = int((s > SMALL * s.max(initial=1.0)).sum())
    return [
        Symmetry(
            tried[lead].name,
            tried[lead].index,
            sum(x * t.G for x, t in zip(c, tried, strict=True)),
            sum(x * t.h for x, t in zip(c, tried, strict=True)),
        )
        for lead, c in _reduced(v[rank:], units_of)
    ]


def _reduced(basis: numpy.ndarray, units: numpy.ndarray) -> list[tuple[int, numpy.ndarray]]:
    """Returns the places of the pivots and the rows of the reduced row echelon form, each row
    divided by `units` and then by its pivot."""
    rows, pivots = basis.copy(), []
    for column in range(rows.shape[1]):
        k = len(pivots)
        lead = k + int(abs(rows[k:, column]).argmax()) if k < len(rows) else k
        if k == len(rows) or abs(rows[lead, column]) < 2e-5:
            continue
        rows[[k, lead]] = rows[[lead, k]]
        rows[k] /= rows[k, column]
        others = numpy.arange(len(rows)) != k
        rows[others] -= rows[others, column][:, None] * rows[k]
        pivots.append(column)
    rows[abs(rows) < 2e-5] = 0
    return [(at, row * units[at] / units) for at, row in zip(pivots, rows, strict=True)]
