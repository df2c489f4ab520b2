"""The equations of equilibria and steady motions, and the region in which they are sought.

Cyclic coordinates have constant rates, and the momenta of the start. All other coordinates rest.
The unknowns are a number for each entry of v: the coordinate, or for cyclic coordinates and first-
order variables the entry of v itself. The equations are, for

    a coordinate          force_i = 0, of a model with rotations or constraints a_i = 0
    a cyclic coordinate   p_i = its value at the start
    a body rate           w_i = 0
    a quaternion Q        the three angular accelerations of its body = 0, |Q|^2 = 1
    another variable      x' = 0; if no rate depends on it, x = its value at the start
    the constraints       phi = 0, J v + j0 = 0

With other symmetries (symmetries.py) there is a speed along each, which adds to the rates and the
accelerations. Its momentum is that of the start where it is conserved. If all commute, the position
along each is that of the start.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy
from numpy import linalg

from .newton import BESIDE, halton, primes
from .symmetries import Fields, Symmetry
from .system import EXACT, System

TURN = 2 * math.pi
WIDTHS = (32, 1, 4, 1)  # the width of the region of start k, in boxes, by k % 4
# The motion whose extent is the box: its steps, with those before the step has found its length,
# and how many times farther than the first step it may go.
MOTION, SETTLING, RUNAWAY = 48, 100, 100


class Steady:
    """The equations. Their unknowns z are sought in middle +- box; arrays of them have the shape
    (states, unknowns)."""

    def __init__(self, system: System, symmetries: Sequence[Symmetry] = (), cyclic: bool = True):
        """Without `cyclic`, cyclic coordinates have to rest too."""
        self.system, self.fields = system, Fields(system)
        n, m, turning = system.n, system.m, system.turning
        bodies = turning // 3
        self.body_rates = slice(m, m + turning)
        self.quaternions = slice(m + turning, m + turning + 4 * bodies)
        turning_on = system.given["cyclic"] if cyclic else []
        # The cyclic coordinates are symmetries whose speed is an unknown already.
        self.moving = [s for s in symmetries if s.name != "q" or s.index not in turning_on]
        self.by_rate = numpy.arange(n) >= m
        self.by_rate[turning_on] = True
        self.cyclic = numpy.flatnonzero(self.by_rate[:m])
        self.unread = system.idle & (numpy.arange(n) >= m)
        self.q0, v0 = numpy.split(system.begun, 2)
        self.momenta = system.kernel("free momenta", 0.0, system.begun)
        start = numpy.where(self.by_rate, v0, self.q0)
        start[self.body_rates] = 0
        begun = self.fields.start[None]
        samples = self.fields.samples(6) if self.moving else begun
        self.conserved = [
            (s, self.fields.momentum(s, begun))
            for s in self.moving
            if self.fields.is_conserved(s, samples)
        ]
        # For each symmetry its direction at the start, and the places that it moves.
        self.sliced = (
            [s.at(begun)[0] for s in self.moving] if self.fields.commute(self.moving) else []
        )
        self.places = [*range(m), *range(m + self.quaternions.start, m + self.quaternions.stop)]
        self.start = numpy.concatenate([start, self._speeds(v0)])
        # The base 2 would correlate with k % 4.
        self.bases = primes(len(self.start) + 1)[1:]
        self.middle = self.start.copy()
        turns = [not self.by_rate[i] and self._is_turn(i) for i in range(n)]
        self.turns = numpy.array([*turns, *[False] * len(self.moving)])
        self.middle[self.turns] = 0
        self.box = self._box()
        plain = not system.bound and not self.moving and n == m
        self.is_exact = plain and system.kernel("momentum jacobian", 0.0, system.begun).size > 0
        sizes = self._sizes()
        self.is_forced = bool(sizes.max(initial=0.0) > 0)
        self.scale = self._scale(sizes)

    def _speeds(self, v: numpy.ndarray) -> numpy.ndarray:
        """Returns the speeds along the symmetries, other than cyclic coordinates, that are nearest
        to the rates v of the start."""
        if not self.moving:
            return numpy.zeros(0)
        turns = [self.fields.turn(s, self.fields.start[None])[0] for s in self.moving]
        rates = v[: len(turns[0])].copy()
        rates[self.cyclic] = 0
        return linalg.lstsq(numpy.array(turns).T, rates, rcond=1e-9)[0]

    def states(self, z: numpy.ndarray) -> numpy.ndarray:
        n = self.system.n
        q = numpy.where(self.by_rate, self.q0, z[..., :n])
        v = numpy.where(self.by_rate, z[..., :n], 0.0)
        found = numpy.concatenate([q, v], -1)
        if self.moving:
            Y = numpy.atleast_2d(found)[:, self.system.used]
            for k, symmetry in enumerate(self.moving, n):
                turn = self.fields.turn(symmetry, Y) * numpy.atleast_2d(z)[:, k, None]
                found[..., n : n + turn.shape[1]] += turn.reshape(*z.shape[:-1], -1)
        return found

    def equations(self, z: numpy.ndarray) -> numpy.ndarray:
        system, states = self.system, self.states(z)
        v, w, Q = system.v(states), self.body_rates, self.quaternions
        of = "acceleration" if system.bound or self.moving else "force"
        a = system.kernel(of, 0.0, states)
        for k, symmetry in enumerate(self.moving, system.n):
            by = (v @ symmetry.G[system.m :, system.m :].T)[:, : w.stop]
            a[:, : w.stop] -= by * z[:, k, None]
        found = a.copy()
        if self.cyclic.size:
            p = system.kernel("free momenta", 0.0, states)
            found[:, self.cyclic] = (p - self.momenta)[:, self.cyclic]
        found[:, w] = z[:, w]
        if system.turning:
            turning, lengths = a[:, w].reshape(len(v), -1, 3), quaternions(v[:, Q])
            length = ((lengths**2).sum(2, keepdims=True) - 1) / 2
            found[:, Q] = numpy.concatenate([turning, length], 2).reshape(len(v), -1)
        found[:, self.unread] = (z[:, : system.n] - self.middle[: system.n])[:, self.unread]
        parts, Y = [found, system.constraints(states)], states[:, system.used]
        for symmetry, momentum in self.conserved:
            parts.append((self.fields.momentum(symmetry, Y) - momentum)[:, None])
        for along in self.sliced:
            parts.append((Y - self.fields.start)[:, self.places] @ along[self.places, None])
        return numpy.concatenate(parts, 1)

    # -- the region ---------------------------------------------------------------------------

    def _is_turn(self, i: int) -> bool:
        """Returns whether q_i is an angle: all momenta and forces are the same at q_i + 2 pi. Three
        states are compared. The tolerance of each number is relative to its own size."""
        bases = primes(self.system.n)
        numbers = [[halton(k, base) for base in bases] for k in (8, 9, 10)]
        q = self.q0 * ~self.by_rate + 2 * numpy.array(numbers) - 1
        states = numpy.concatenate([q, 0.7 - numpy.array(numbers)], 1)
        both = numpy.concatenate([states, states])
        both[3:, i] += TURN
        of = ["acceleration"] if self.system.bound else ["force", "momenta"]
        found = [self.system.kernel(kind, 0.0, both) for kind in of]
        found = numpy.concatenate([*found, self.system.constraints(both)], 1)
        size, change = abs(found[:3]).max(0), abs(found[3:] - found[:3]).max(0)
        return bool((change <= 1e-9 * size + 1e-14 * size.max()).all())

    def _extent(self) -> numpy.ndarray:
        """Returns how far the unknowns go in the first MOTION steps of a loose integration. Its
        steps count from the first that is less than twice as long as the one before. The motion is
        cut off where an unknown runs away."""
        rows = self.system.begin(EXACT, rtol=1e-6).steps(1e300, MOTION + SETTLING)
        lengths = numpy.diff(rows[:, 0], prepend=0.0)
        settled = numpy.flatnonzero(lengths[1:] < 2 * lengths[:-1])
        rows = rows[settled[0] + 1 :][:MOTION] if settled.size else rows[:0]
        q, v = self.system.q(rows[:, 1:]), self.system.v(rows[:, 1:])
        far = numpy.where(self.by_rate, abs(v), abs(q - self.q0))
        first = far[(far > 0).argmax(0), range(far.shape[1])] if len(far) else far
        away = numpy.flatnonzero((far > RUNAWAY * first).any(1))
        return far[: away[0] if away.size else None].max(0, initial=0.0)

    def _box(self) -> numpy.ndarray:
        """Returns half a turn for an angle, 1 for a quaternion, else twice the extent of the motion
        or of the start. If both are 0, a coordinate gets the largest box of the others, or 1."""
        by_rate = numpy.concatenate([self.by_rate, numpy.ones(len(self.moving), bool)])
        extent = numpy.concatenate([self._extent(), numpy.zeros(len(self.moving))])
        box = 2 * numpy.fmax(extent, abs(self.start))
        box[self.turns] = TURN / 2
        others = box[~by_rate & ~self.turns].max(initial=0.0)
        none = ~(box > 1e-200)
        box[none] = numpy.where(by_rate[none] | (others == 0), 1.0, others)
        box[self.quaternions] = 1
        return box

    def place(self, k: int) -> numpy.ndarray:
        """Returns start k of the search: the middle of the box, then points of Halton's sequence.
        Half of them lie in the box, the others in one 4 or 32 times as wide, but angles and
        quaternions always in the box."""
        wide = numpy.where(self.turns, 1, WIDTHS[k % len(WIDTHS)])
        point = numpy.array([2 * halton(k, base) - 1 if k else 0.0 for base in self.bases])
        z = self.middle + wide * self.box * point
        z[self.body_rates] = 0
        if k:  # any orientation: the start's is taken away
            z[self.quaternions] -= self.middle[self.quaternions]
        return self.normal(z)

    def _sizes(self) -> numpy.ndarray:
        """Returns the largest size of each equation in the box. That of J v + j0, which vanishes
        along a symmetry, is with the rates of another point."""
        points = numpy.array([self.place(2 * k + 1) for k in range(1, 33)])
        sizes, states = abs(self.equations(points)), self.states(points)
        rates = self.system.v(states)[:, : self.body_rates.stop]
        rates[:] = numpy.roll(rates, 1, 0)
        kept = abs(self.system.constraints(states))
        part = sizes[:, self.system.n :][:, : kept.shape[1]]
        numpy.fmax(part, kept, out=part)
        return sizes[numpy.isfinite(sizes).all(1)].max(0, initial=0.0)

    def _scale(self, sizes: numpy.ndarray) -> numpy.ndarray:
        """Returns the scale of each equation. One that is round-off in the box, beside others of
        its kind, gets the largest size of the kind: it holds."""
        given, n = self.system.given, self.system.n
        ends = numpy.cumsum([n, given["holonomic"], given["constraints"]])
        kinds = numpy.split(sizes, [*ends, *range(ends[-1] + 1, len(sizes))])
        most = [kind.max(initial=0.0) or 1.0 for kind in kinds]
        scale = numpy.concatenate(
            [numpy.where(x > 1e-14 * y, x, y) for x, y in zip(kinds, most, strict=True)]
        )
        scale[self.body_rates] = self.box[self.body_rates]  # they are 0 at all points
        scale[self.quaternions][3::4] = 1
        return scale

    def normal(self, z: numpy.ndarray) -> numpy.ndarray:
        """Returns the unknowns with quaternions of length 1."""
        Q = quaternions(z[..., self.quaternions])
        z = z.copy()
        z[..., self.quaternions] = (Q / linalg.norm(Q, axis=-1, keepdims=True)).reshape(
            z[..., self.quaternions].shape
        )
        return z

    def reach(self, z: numpy.ndarray) -> numpy.ndarray:
        return numpy.fmax(self.box, abs(z - self.middle))

    def apart(self, known: numpy.ndarray, z: numpy.ndarray) -> numpy.ndarray:
        """Returns z - known in boxes; angles by the shorter way, Q and -Q are the same."""
        z, known = numpy.broadcast_arrays(z, known)
        d = z - known
        d -= self.turns * TURN * numpy.round(d / TURN)
        R, Q = (quaternions(x[..., self.quaternions]) for x in (known, z))
        opposite = (Q * R).sum(-1, keepdims=True) < 0
        d[..., self.quaternions] = numpy.where(opposite, Q + R, Q - R).reshape(
            d[..., self.quaternions].shape
        )
        return d / self.box

    # -- derivatives --------------------------------------------------------------------------

    def linear(self, z: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray]:
        """Returns the equations in units of their scales, their derivatives in units of reach(),
        and whether all are finite; others are replaced by 0."""
        n, reach = z.shape[1], self.reach(z)
        exact = self._slopes(z)
        if exact is not None:
            gap = self.equations(z) / self.scale
            slopes = exact * reach[:, None] / self.scale[:, None]
        else:
            by = BESIDE * reach[:, :, None] * numpy.eye(n)
            points = numpy.concatenate([z[:, None] + by, z[:, None] - by, z[:, None]], 1)
            found = self.equations(points.reshape(-1, n)) / self.scale
            found = found.reshape(len(z), 2 * n + 1, -1)
            gap = found[:, -1]
            slopes = (found[:, :n] - found[:, n : 2 * n]).transpose(0, 2, 1) / (2 * BESIDE)
        good = numpy.isfinite(gap).all(1) & numpy.isfinite(slopes).all((1, 2))
        return numpy.where(good[:, None], gap, 0), numpy.where(good[:, None, None], slopes, 0), good

    def _slopes(self, z: numpy.ndarray) -> numpy.ndarray | None:
        """Returns the derivatives of the equations, of shape (states, rows, n), if the kernels have
        them: differences tell little beside a root where the linear terms vanish."""
        if not self.is_exact:
            return None
        system, n, states = self.system, self.system.n, self.states(z)
        found = system.kernel("momentum jacobian", 0.0, states)
        p_q, f_q, f_v = found.reshape(-1, 3, n, n).transpose(1, 0, 2, 3)
        M = system.kernel("mass", 0.0, states).reshape(-1, n, n)
        of_p, of_f = (
            numpy.where(self.by_rate, by_v, by_q) for by_q, by_v in ((p_q, M), (f_q, f_v))
        )
        return numpy.where(self.by_rate[:, None], of_p, of_f)


def quaternions(numbers: numpy.ndarray) -> numpy.ndarray:
    """Returns numbers as quaternions, along a last axis of four."""
    return numbers.reshape(*numbers.shape[:-1], -1, 4)
