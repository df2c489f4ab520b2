"""Orbits of a method's step map that close after some steps, and their multipliers: spurious fixed
points and 2-cycles (ghosts), limit cycles, and motions in phase with a driver. Newton's method
(linear/newton.py) solves for the closed orbit; orbits may form families. Some may be missed.

Reference: A. R. Humphries, IMA J. Numer. Anal. 13 (1993) 263 (spurious solutions).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy

from ...record import record
from ..linear.newton import BESIDE, deflation, halton, least, primes, shortened
from ..linear.system import EXACT
from .unknowns import TURN, Placed

MOST_KNOWN, MOST_ORBITS, MOST_TURNS = 128, 32, 60
STATES = 4  # most states of an orbit that are returned
SMALL = 1e-9  # Newton's iteration ends when its correction is smaller
CLOSED = 1e-6  # largest distance between the ends of a closed orbit
SAME = 1e-5  # largest distance of states that count as equal
REST = 1e-6  # a state that moves less than this in a step is an equilibrium
AWAY = 16.0  # distance from the region of the motion beyond which an orbit is ignored
ROUNDED = 1e-6  # round-off of the modulus of a multiplier


@record
class Orbit:
    """An orbit that closes after `steps` steps of size h. A state is q, then v."""

    steps: int
    h: float
    states: tuple[tuple[float, ...], ...]
    multipliers: tuple[complex, ...]  # in descending modulus
    rests: bool  # whether the state is an equilibrium of the equations, so no ghost
    residual: float

    @property
    def growth(self) -> float:
        """Returns the largest modulus of the multipliers."""
        return max(map(abs, self.multipliers), default=0.0)

    @property
    def holds(self) -> bool:
        """Whether the orbit is attracting or neutral."""
        return self.growth < 1 + ROUNDED

    def beyond(self, trivial: int) -> complex:
        """Returns the multiplier with the largest modulus, or 0 if there is none. The number
        `trivial` says how many multipliers, those nearest to 1, do not count."""
        others = sorted(self.multipliers, key=lambda z: abs(z - 1))[trivial:]
        return max(others, key=abs, default=0j)


@record
class Closed:
    """A solution of Newton's method, and the derivatives of the gap there (see _Search)."""

    y: numpy.ndarray
    h: float
    slopes: numpy.ndarray
    gap: float  # largest remaining component
    steps: int


class _Search:
    """Solves gap(y) = 0 by Newton's method from several starts at once. The gap is the state after
    some steps of a method, minus the state y before these steps. Corrections of log h are a quarter
    as long as those of a state may be."""

    def __init__(self, system: Placed, method: str | None, h: float, free: bool):
        self.system, self.unknowns, self.free = system, system.unknowns, free
        self.it = system.begin(method or EXACT, h=h if method else 0.0, rtol=1e-12)
        self.known: list[numpy.ndarray] = []
        self.orbits: list[Orbit] = []

    def gap(self, y: numpy.ndarray, h: float, steps: int) -> numpy.ndarray:
        return self.unknowns.apart(y, self.it.mapped(y, h, steps))

    def slopes(self, y: numpy.ndarray, h: float, steps: int) -> numpy.ndarray:
        """Returns the derivatives of each gap by the unknowns; with a free h, the last column is
        the derivative by log h."""
        d = len(self.unknowns.of)
        by = numpy.zeros((d, y.shape[1]))
        by[range(d), self.unknowns.of] = BESIDE * self.unknowns.box
        beside = y[:, None] + numpy.concatenate([by, -by])
        gaps = self.gap(beside.reshape(-1, y.shape[1]), h, steps).reshape(len(y), 2 * d, d)
        columns = (gaps[:, :d] - gaps[:, d:]) / (2 * BESIDE)
        if self.free:
            ends = [self.gap(y, h * (1 + x), steps) for x in (BESIDE, -BESIDE)]
            of_h = (ends[0] - ends[1]) / (2 * BESIDE)
            columns = numpy.concatenate([columns, of_h[:, None]], 1)
        return columns.transpose(0, 2, 1)

    def newton(self, y: numpy.ndarray, h: float, steps: int) -> dict[int, Closed]:
        """Returns the solutions that are reached from the starts y, keyed by the index of the
        start. If h is unknown, there must be one start only."""
        d, y, at, found = len(self.unknowns.of), y.copy(), numpy.arange(len(y)), {}
        for _ in range(MOST_TURNS):
            gap, slopes = self.gap(y, h, steps), self.slopes(y, h, steps)
            good = numpy.isfinite(gap).all(1) & numpy.isfinite(slopes).all((1, 2))
            at, y, gap, slopes = at[good], y[good], gap[good], slopes[good]
            if not len(at):
                break
            step = least(gap, slopes)[0]
            if self.known:
                apart = self.unknowns.apart(numpy.array(self.known), y[:, None])
                step *= deflation(apart, step[:, :d])[:, None]
            size = abs(step * numpy.where(numpy.arange(step.shape[1]) < d, 1, 4)).max(1)
            step = shortened(step, size)
            y[:, self.unknowns.of] += step[:, :d] * self.unknowns.box
            h = h * (1 + float(step[0, d])) if self.free else h
            small = size < SMALL
            for k in numpy.flatnonzero(small):
                closed = y[k], h, self.slopes(y[k : k + 1], h, steps)[0, :, :d]
                most = float(abs(self.gap(y[k : k + 1], h, steps)).max())
                if most < CLOSED and numpy.isfinite(closed[2]).all():
                    found[int(at[k])] = Closed(*closed, most, steps)
            left = ~small & numpy.isfinite(size) & (h > 0)
            at, y = at[left], y[left]
        return found

    def sought(self, starts: numpy.ndarray, h: float, first: int, steps: int, many: bool) -> None:
        """Finds orbits by Newton's method. With `many`, orbits already found are deflated, and each
        start that reached an orbit is used again, to find another orbit."""
        while len(starts) and len(self.orbits) < MOST_ORBITS and len(self.known) < MOST_KNOWN:
            before, again = len(self.known), []
            for number, found in self.newton(starts, h, steps).items():
                away = abs(self.unknowns.apart(self.system.middle, found.y)).max()
                if not away < AWAY or self._is_known(found.y, before):
                    continue
                if self._is_known(found.y) or self._take(found, first, many):
                    again.append(number)
            starts = starts[again] if many else starts[:0]

    def _take(self, found: Closed, first: int, many: bool) -> bool:
        """Adds a solution to the list of orbits, with the least number of steps after which the
        orbit closes."""
        y, h = found.y, found.h
        for k in range(1, found.steps if many else 1):
            if found.steps % k or not abs(self.gap(y[None], h, k)).max() < SAME:
                continue
            if k < first:
                self.known += [y] if len(self.known) < MOST_KNOWN else []
                return False
            shorter = self.newton(y[None], h, k).get(0)
            if shorter is None:
                return False
            found = shorter
            break
        if len(self.orbits) < MOST_ORBITS:
            self._keep(found)
        return True

    def _is_known(self, y: numpy.ndarray, count: int | None = None) -> bool:
        known = self.known[:count]
        return any(abs(self.unknowns.apart(one, y)).max() < SAME for one in known)

    def _rests(self, y: numpy.ndarray, h: float) -> bool:
        """Returns whether y is an equilibrium."""
        rates = [*self.system.v(y), *self.system.kernel("acceleration", 0.0, y)[0]]
        rates = numpy.array(rates)[self.unknowns.of]
        moves = ~(abs(rates) * h <= REST * self.unknowns.box)
        return bool(self.system.given["autonomous"]) and not moves.any()

    def _keep(self, found: Closed) -> None:
        y, h, slopes = found.y.copy(), found.h, found.slopes
        turns = self.unknowns.of[self.unknowns.turns]
        y[turns] -= TURN * numpy.round(y[turns] / TURN)
        rests = self._rests(y, h)
        values = numpy.linalg.eigvals(slopes + numpy.eye(len(slopes)))
        states = [y]
        while len(states) < min(found.steps, STATES):
            states.append(self.it.mapped(states[-1][None], h, 1)[0])
        self.known += states[: MOST_KNOWN - len(self.known)]
        finite = (tuple(map(float, s)) for s in states if numpy.isfinite(s).all())
        multipliers = tuple(complex(z) for z in sorted(values, key=abs, reverse=True))
        self.orbits.append(Orbit(found.steps, h, tuple(finite), multipliers, rests, found.gap))


@numpy.errstate(all="ignore")
def orbits(
    system: Placed,
    *,
    h: float,
    count: int,
    method: str | None = None,
    state: Sequence[float] | None = None,
    first: int | None = None,
    tries: int = 0,
    free: bool = False,
) -> tuple[Orbit, ...] | None:
    """Returns the orbits that close after `first` (default: `count`) to `count` steps of size h.
    The search starts from `state` and from `tries` other states. With `free`, Newton's method also
    solves for h. Without a method, a step follows the equations exactly for the time h. Returns
    None if the model refuses the method, or if the equations depend on time but are not periodic
    with the duration of these steps."""
    numbers, unknowns = range(first or count, count + 1), system.unknowns
    if not system.given["autonomous"] and (free or not unknowns.in_step([k * h for k in numbers])):
        return None
    search = _Search(system, method, h, free)
    if search.it.failed:
        return None
    bases, of = primes(len(unknowns.of)), unknowns.of
    starts = numpy.tile(system.start if state is None else state, (tries + 1, 1))
    for number in range(1, tries + 1):
        point = numpy.array([halton(number, base) for base in bases])
        starts[number, of] = system.middle[of] + unknowns.box * (2 * point - 1)
    for steps in numbers if len(of) else ():
        search.sought(starts, h, numbers.start, steps, tries > 0)
    return tuple(search.orbits)
