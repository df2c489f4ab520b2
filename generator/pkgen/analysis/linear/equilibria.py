"""Equilibria and relative equilibria, by Newton's method from many starts.

Cyclic coordinates may turn: they have constant rates, and the momenta of the start. All other
coordinates rest. The unknowns are a number for each entry of v: the coordinate, or for cyclic
coordinates and first-order variables the entry of v itself. The equations are, for

    a coordinate          force_i = 0, of a model with rotations or constraints a_i = 0
    a cyclic coordinate   p_i = its value at the start
    a body rate           w_i = 0
    a quaternion Q        the three angular accelerations of its body = 0, |Q|^2 = 1
    another variable      x' = 0; if no rate depends on it, x = its value at the start
    the constraints       phi = 0, J v + j0 = 0

Constraints make these equations dependent, and equilibria may form a continuum. Both are harmless
to corrections of least norm (newton.py). The search may miss some equilibria.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy
from numpy import linalg

from ...compiler import Compilation
from ...system.exits import UsageError
from . import modes
from .newton import BESIDE, FLAT, deflation, halton, least, primes, shortened
from .rest import ZERO, Equilibrium, Mode, Rest
from .symmetries import Fields, Symmetry, symmetries
from .system import EXACT, System, floats, opened

TURN = 2 * math.pi
TRIES = 100  # starts of the search, besides the start of the motion
MOST = 32  # equilibria that are returned
FURTHEST = 1e6  # an equilibrium farther away, in boxes, is none
ROUNDS, POLISH, AGAIN = 200, 60, 40  # Newton's iterations; at a root; searches from a start
EXACT_FLAT = 1e-15  # as FLAT, where derivatives are exact
MORE = 8  # starts for each equilibrium found, or more
SMALL = 1e-12  # the iteration ends when its correction is smaller, in units of reach()
HELD, NEAR = 2e-10, 1e-4  # of a root: the equations hold, and the last correction is small
FAR, UNDERFLOWN = 3, 1e-290  # in boxes; derivatives so small there are of no root
STILL = 1e-9  # smaller corrections are round-off
ASIDE = 1e-2  # length of a step along a continuum, in units of reach()
WIDTHS = (32, 1, 4, 1)  # of the region of start k, in boxes, by k % 4
# The motion whose extent is the box: its steps, with those before the step has found its length,
# and how many times farther than the first step it may go.
MOTION, SETTLING, RUNAWAY = 48, 100, 100


class Search:
    """A search in middle +- box. `known` are the unknowns z of each equilibrium found, `doubts` the
    last corrections of Newton's method, `slacks` the dimensions of the continua. Arrays of unknowns
    have the shape (states, n)."""

    def __init__(self, system: System, symmetries: Sequence[Symmetry] = (), cyclic: bool = True):
        """Without `cyclic`, cyclic coordinates have to rest too."""
        self.system, self.fields = system, Fields(system)
        n, m, turning = system.n, system.m, system.turning
        bodies = turning // 3
        self.body_rates = slice(m, m + turning)
        self.quaternions = slice(m + turning, m + turning + 4 * bodies)
        turning_on = system.given["cyclic"] if cyclic else []
        self.moving = [s for s in symmetries if s.name != "q" or s.index not in turning_on]
        self.by_rate = numpy.arange(n) >= m
        self.by_rate[turning_on] = True
        self.cyclic = numpy.flatnonzero(self.by_rate[:m])
        self.unread = system.idle & (numpy.arange(n) >= m)
        start0 = numpy.where(numpy.isnan(system.start), 0.0, system.start)
        self.q0, v0 = numpy.split(start0, 2)
        self.momenta = system.kernel("free momenta", 0.0, start0)
        start = numpy.where(self.by_rate, v0, self.q0)
        start[self.body_rates] = 0
        samples = self.fields.samples(6) if self.moving else self.fields.start[None]
        self.conserved = [s for s in self.moving if self.fields.is_conserved(s, samples)]
        self.sliced = self.moving if self.fields.commute(self.moving) else []
        self.start = numpy.concatenate([start, self._speeds(v0)])
        # The base 2 would correlate with k % 4.
        self.bases = primes(len(self.start) + 1)[1:]
        self.middle = self.start.copy()
        turns = [not self.by_rate[i] and self._is_turn(i) for i in range(n)]
        self.turns = numpy.array([*turns, *(False for _ in self.moving)])
        self.middle[self.turns] = 0
        self.box = self._box()
        plain = not system.bound and not self.moving and n == m
        self.is_exact = plain and system.kernel("momentum jacobian", 0.0, start0).size > 0
        self.known: list[numpy.ndarray] = []
        self.doubts: list[numpy.ndarray] = []
        self.slacks: list[int] = []
        self.failed = self.singular = 0

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
            Y = self.fields.dense(numpy.atleast_2d(found))
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
            a[:, : w.stop] -= (v @ symmetry.G[system.m :, system.m :].T)[:, : w.stop] * z[
                :, k, None
            ]
        found = a.copy()
        if self.cyclic.size:
            p = system.kernel("free momenta", 0.0, states)
            found[:, self.cyclic] = (p - self.momenta)[:, self.cyclic]
        found[:, w] = z[:, w]
        if system.turning:
            turning, lengths = a[:, w].reshape(len(v), -1, 3), _quaternions(v[:, Q])
            length = ((lengths**2).sum(2, keepdims=True) - 1) / 2
            found[:, Q] = numpy.concatenate([turning, length], 2).reshape(len(v), -1)
        found[:, self.unread] = (z[:, : system.n] - self.middle[: system.n])[:, self.unread]
        parts = [found]
        if system.given["holonomic"]:
            parts.append(system.kernel("constraint", 0.0, states))
        if system.given["constraints"]:
            parts.append(system.kernel("constraint rates", 0.0, states))
        Y, start = self.fields.dense(states), self.fields.start
        for symmetry in self.conserved:
            known = self.fields.momentum(symmetry, start[None])
            parts.append((self.fields.momentum(symmetry, Y) - known)[:, None])
        places = [*range(system.m), *range(system.m + Q.start, system.m + Q.stop)]
        for symmetry in self.sliced:
            parts.append((Y - start)[:, places] @ symmetry.at(start)[places, None])
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
        given = self.system.given
        of = ["acceleration"] if self.system.bound else ["force", "momenta"]
        of += ["constraint"] * bool(given["holonomic"])
        of += ["constraint rates"] * bool(given["constraints"])
        found = numpy.concatenate([self.system.kernel(kind, 0.0, both) for kind in of], 1)
        size, change = abs(found[:3]).max(0), abs(found[3:] - found[:3]).max(0)
        return bool((change <= 1e-9 * size + 1e-14 * size.max()).all())

    def _extent(self) -> numpy.ndarray:
        """Returns how far the unknowns go in the first MOTION steps of a loose integration: its
        steps count from the first that is less than twice as long as the one
        before. The motion is cut off where an unknown runs away."""
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
        return self._normal(z)

    @cached_property
    def scale(self) -> numpy.ndarray:
        """The largest size of each equation in the box. Equations that are round-off there, beside
        others of the same kind, hold: they get the largest size of the kind."""
        points = numpy.array([self.place(2 * k + 1) for k in range(1, 33)])
        sizes = abs(self.equations(points))
        sizes = sizes[numpy.isfinite(sizes).all(1)].max(0, initial=0.0)
        self.is_forced = bool(sizes.max(initial=0.0) > 0)
        n, holonomic = self.system.n, self.system.given["holonomic"]
        kinds = []
        rows = n + holonomic + self.system.given["constraints"]
        ends = [n, n + holonomic, *range(rows, len(sizes))]
        for kind in numpy.split(sizes, ends):
            most = kind.max(initial=0.0) or 1.0
            kinds.append(numpy.where(kind > 1e-14 * most, kind, most))
        scale = numpy.concatenate(kinds)
        scale[self.body_rates] = self.box[self.body_rates]  # they are 0 at all points
        scale[self.quaternions][3::4] = 1
        return scale

    def _normal(self, z: numpy.ndarray) -> numpy.ndarray:
        """Returns the unknowns with quaternions of length 1."""
        Q = _quaternions(z[..., self.quaternions])
        z = z.copy()
        z[..., self.quaternions] = (Q / linalg.norm(Q, axis=-1, keepdims=True)).reshape(
            z[..., self.quaternions].shape
        )
        return z

    def _reach(self, z: numpy.ndarray) -> numpy.ndarray:
        return numpy.fmax(self.box, abs(z - self.middle))

    def apart(self, known: numpy.ndarray, z: numpy.ndarray) -> numpy.ndarray:
        """Returns z - known in boxes; angles by the shorter way, Q and -Q are the same."""
        d = z - known
        d -= self.turns * TURN * numpy.round(d / TURN)
        R = _quaternions((z - d)[..., self.quaternions])
        Q = _quaternions((z + 0 * d)[..., self.quaternions])
        opposite = (Q * R).sum(-1, keepdims=True) < 0
        d[..., self.quaternions] = numpy.where(opposite, Q + R, Q - R).reshape(
            d[..., self.quaternions].shape
        )
        return d / self.box

    # -- Newton's method ----------------------------------------------------------------------

    def _linear(self, z: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray]:
        """Returns the equations in units of their scales, their derivatives in units of reach(),
        and whether all are finite; others are replaced by 0."""
        n, reach = z.shape[1], self._reach(z)
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
        system, n, states = self.system, self.system.n, self.states(z)
        if not self.is_exact:
            return None
        found = system.kernel("momentum jacobian", 0.0, states)
        p_q, f_q, f_v = found.reshape(-1, 3, n, n).transpose(1, 0, 2, 3)
        M = system.kernel("mass", 0.0, states).reshape(-1, n, n)
        of_p, of_f = (
            numpy.where(self.by_rate, by_v, by_q) for by_q, by_v in ((p_q, M), (f_q, f_v))
        )
        return numpy.where(self.by_rate[:, None], of_p, of_f)

    def _least(self, gap: numpy.ndarray, slopes: numpy.ndarray) -> tuple[numpy.ndarray, ...]:
        return least(gap, slopes, EXACT_FLAT if self.is_exact else FLAT)

    def newton(self, z: numpy.ndarray, rounds: int, deflated: bool) -> numpy.ndarray:
        """Returns where the iterations from the starts z end; NaN where one fails."""
        z, left = z.copy(), numpy.arange(len(z))
        for _ in range(rounds):
            at = z[left]
            gap, slopes, good = self._linear(at)
            step, reach = self._least(gap, slopes)[0], self._reach(at)
            if deflated and self.known:
                apart = self.apart(numpy.array(self.known), at[:, None])
                step *= deflation(apart, step * reach / self.box)[:, None]
            size = abs(step).max(1)
            z[left] = self._normal(at + shortened(step, size) * reach)
            z[left[~good]] = numpy.nan
            left = left[good & ~(size < SMALL)]
            if not left.size:
                break
        return z

    def _polished(self, z: numpy.ndarray) -> numpy.ndarray:
        """Returns the unknowns after some more iterations. Those that are much smaller than the box
        become 0, since their squares would underflow."""
        z = self.newton(z[None], POLISH, False)[0]
        z = numpy.where(abs(z) > 1e-40 * self.box, z, 0.0)
        z[self.body_rates] = 0
        return z

    def _correction(self, z: numpy.ndarray) -> tuple[numpy.ndarray, int, numpy.ndarray] | None:
        """Returns of a root Newton's next correction, the number of singular values that are 0, and
        the direction of the least one; None if z is no root. The test of the correction excludes
        points on the way to infinity, where forces tend to 0."""
        (gap,), (slopes,), (good,) = self._linear(z[None])
        held = (abs(gap) <= HELD * numpy.fmax(1, abs(slopes).max(1))).all()
        (step,), (flat,), (directions,) = self._least(gap[None], slopes[None])
        far = self.is_forced and (abs(z - self.middle) > FAR * self.box).any()
        good &= not far or abs(slopes).max(initial=0.0) > UNDERFLOWN
        size = abs(step).max()
        if not good or not held or not size <= NEAR:
            return None
        if size > STILL:  # corrections towards a root shrink, those on the way to infinity do not
            (gap,), (slopes,), _ = self._linear((z + step * self._reach(z))[None])
            if not abs(self._least(gap[None], slopes[None])[0]).max() < 0.97 * size:
                return None
        return step, int(flat.sum()), directions[-1]

    def _goes_on(self, z: numpy.ndarray, along: numpy.ndarray) -> bool:
        """Returns whether a root is on a continuum of roots: from beside it, Newton's method does
        not come back."""
        reach = self._reach(z)
        there = z + ASIDE * along * reach
        end = self.newton(self._normal(there)[None], ROUNDS, False)[0]
        if not numpy.isfinite(end).all() or self._correction(end) is None:
            return False
        return bool(linalg.norm((end - there) / reach) < linalg.norm((there - z) / reach) / 2)

    # -- the list -----------------------------------------------------------------------------

    def energy(self, z: numpy.ndarray) -> float:
        found = self.system.kernel("energy", 0.0, self.states(z))
        return float(found[0, 0]) if found.size else 0.0

    def _spectrum(self, z: numpy.ndarray) -> numpy.ndarray:
        """Returns sums of powers of the moduli of the eigenvalues at an equilibrium."""
        A = self.system.linearised(0.0, self.states(z))
        sizes = abs(linalg.eigvals(A)) if numpy.isfinite(A).all() else numpy.full(1, numpy.nan)
        return numpy.array([(sizes**power).sum() for power in (2, 4, 6, 8)])

    def _is_known(self, z: numpy.ndarray, slack: int) -> bool:
        """Returns whether z is a known root, or on the same continuum as one: their energies are
        equal, or with constraints on rates their eigenvalues."""
        if any(abs(self.apart(one, z)).max() <= NEAR for one in self.known):
            return True
        given, h = self.system.given, self.energy(z)
        energies = [self.energy(one) for one in self.known]
        size = max(map(abs, (h, self.energy(self.start), *energies)))
        for one, energy, other in zip(self.known, energies, self.slacks, strict=True):
            if not slack or not other:
                continue
            if self.moving and given["constraints"] > given["holonomic"]:
                return True  # the one nearest to the start stands for them
            if abs(h - energy) <= 1e-9 * size:
                return True
            if given["constraints"] > given["holonomic"]:
                a, b = self._spectrum(one), self._spectrum(z)
                if (abs(a - b) <= 2e-5 * numpy.fmax(a, b)).all():
                    return True
        return False

    def _is_definite(self, z: numpy.ndarray) -> bool:
        (M,) = self.system.kernel("mass", 0.0, self.states(z))
        try:
            linalg.cholesky(M.reshape(self.system.n, -1))
        except linalg.LinAlgError:
            return False
        return True

    def _take(self, z: numpy.ndarray, first: bool) -> None:
        """Adds a root to the list. The `first` search counts failures and singular M."""
        root = self._polished(z) if numpy.isfinite(z).all() else z
        found = self._correction(root) if numpy.isfinite(root).all() else None
        if found is None:
            self.failed += first
            return
        step, slack, along = found
        if not self.system.bound and not self._is_definite(root):
            self.singular += first
            return
        if slack and not self._goes_on(root, along):
            # An isolated root is known less accurately where it is flat.
            slack, step = 0, ASIDE * along / 100
        if not self._is_known(root, slack):
            self.known.append(root)
            self.doubts.append(step * self._reach(root))
            self.slacks.append(slack)

    def run(self, tries: int) -> bool:
        """Searches from the start and from `tries` other points or more, again while new roots are
        found. Returns whether there are more than MOST equilibria."""
        tried = 0
        while not tried or (tries and tried <= MORE * len(self.known)):
            starts = numpy.array([self.place(k) for k in range(tried, tried + tries + 1)])
            for again in range(AGAIN):
                before = len(self.known)
                for end in self.newton(starts, ROUNDS, tried + again > 0):
                    self._take(end, tried + again == 0)
                    if len(self.known) > MOST:
                        return True
                if tried + again and len(self.known) == before:
                    break
            tried += len(starts)
        return False


def _quaternions(numbers: numpy.ndarray) -> numpy.ndarray:
    return numbers.reshape(*numbers.shape[:-1], -1, 4)


@numpy.errstate(all="ignore")
def rest(system: System, tries: int = TRIES, symmetries: Sequence[Symmetry] = ()) -> Rest:
    """Returns the equilibria with their modes, in the order of energy; with `symmetries`, motions
    along these too. Angles are in (-pi, pi], and the first number of a quaternion that is not 0 is
    positive."""
    if not system.is_steady():
        return Rest("PK_REFUSED", (), 0, 0, False)
    search = Search(system, symmetries)
    more = search.run(tries)
    found = []
    for z, doubt, slack in zip(search.known, search.doubts, search.slacks, strict=True):
        z[abs(z) < 1e-15 * search.box] = 0
        z[search.turns] -= TURN * numpy.ceil(z[search.turns] / TURN - 0.5 - 1e-8)
        for Q in z[search.quaternions].reshape(-1, 4):
            Q *= numpy.sign(Q[(abs(Q) > 1e-9).argmax()])
        state, energy = search.states(z), search.energy(z)
        # Far away rates may only be too small; L may be undefined.
        if math.isfinite(energy) and (abs(z - search.middle) <= FURTHEST * search.box).all():
            speeds = z[system.n :]
            moving = list(zip(speeds, search.moving, strict=True))
            status, modes_of = modes.settled(system, state, doubt[: system.n], moving)
            q, v = floats(system.q(state)), floats(system.v(state))
            # The energy of a model that is judged by distances is not used.
            h = 0.0 if system.by_norm else energy
            at = Equilibrium(q, v, h, tuple(modes_of), status, slack, floats(speeds))
            found.append((energy, at))
    found.sort(key=lambda x: x[0])
    fastest = max((m.rate for _, e in found for m in e.modes), default=0.0)

    def cleared(mode: Mode) -> Mode:
        """Returns a mode; the growth and frequency of a slow mode are numerical errors."""
        slow = mode.rate <= ZERO * fastest
        return replace(mode, growth=0.0, frequency=0.0) if slow else mode

    return Rest(
        "PK_DONE",
        tuple(replace(e, modes=tuple(map(cleared, e.modes))) for _, e in found[:MOST]),
        search.failed,
        search.singular,
        more,
        tuple(map(bool, search.turns)),
        floats(search.middle[: system.n]),
        floats(search.box[: system.n]),
        tuple(map(int, search.cyclic)),
        tuple(search.moving),
    )


def of_system(system: System, compilation: Compilation, tries: int) -> Rest:
    """Returns the equilibria of a system, and its motions along symmetries. Raises UsageError."""
    if not system.is_steady():
        raise UsageError(
            "the equations depend on time: nothing rests, and nothing goes on steadily"
        )
    units = [item.unit for item in compilation.equations.coordinates[: system.m]]
    with numpy.errstate(all="ignore"):
        found = symmetries(Fields(system), units)
    return rest(system, tries, found)


def of_model(options: argparse.Namespace, compilation: Compilation) -> Rest:
    """Returns the equilibria and steady motions of a compiled model. Raises UsageError, ModelError,
    BuildError."""
    system = opened(options, compilation, "pkgen equilibria")
    return of_system(system, compilation, options.tries or TRIES)
