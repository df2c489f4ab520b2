"""Equilibria and steady motions, by Newton's method from many starts (steady.py, newton.py).

Constraints make the equations dependent, and equilibria may form a continuum. Both are harmless to
corrections of least norm. The search may miss some equilibria.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy
from numpy import linalg

from ...compiler import Compilation
from ...system.exits import UsageError
from . import modes
from .newton import FLAT, deflation, least, shortened
from .rest import ZERO, Equilibrium, Mode, Rest
from .steady import TURN, Steady, quaternions
from .symmetries import Fields, Symmetry, symmetries
from .system import System, floats, opened

TRIES = 100  # starts of the search, besides the start of the motion
MOST_TRIES = 100_000
MOST = 32  # largest number of equilibria returned
FURTHEST = 1e6  # largest distance of an equilibrium, in boxes
# Newton's iterations in the search, and at a root; searches from one start.
ROUNDS, POLISH, AGAIN = 200, 60, 40
EXACT_FLAT = 1e-15  # as FLAT, where derivatives are exact
MORE = 8  # least number of starts for each equilibrium found
SMALL = 1e-12  # the iteration ends at a smaller correction, in units of reach()
HELD, NEAR = 2e-10, 1e-4  # largest residual, and largest last correction, at a root
FAR, UNDERFLOWN = 3, 1e-290  # beyond FAR boxes smaller derivatives are underflow, not a root
ASIDE = 1e-2  # length of a step along a continuum, in units of reach()


class Search(Steady):
    """A search. `known` are the unknowns z of each equilibrium found, `errors` the last corrections
    of Newton's method, `nullities` the dimensions of the continua."""

    def __init__(self, system: System, symmetries: Sequence[Symmetry] = (), cyclic: bool = True):
        """Without `cyclic`, cyclic coordinates have to rest too."""
        super().__init__(system, symmetries, cyclic)
        self.known: list[numpy.ndarray] = []
        self.errors: list[numpy.ndarray] = []
        self.nullities: list[int] = []
        self.failed = self.singular = 0

    def _least(self, gap: numpy.ndarray, slopes: numpy.ndarray) -> tuple[numpy.ndarray, ...]:
        return least(gap, slopes, EXACT_FLAT if self.is_exact else FLAT)

    def newton(self, z: numpy.ndarray, rounds: int, deflated: bool) -> numpy.ndarray:
        """Returns where the iterations from the starts z end; NaN where one fails."""
        z, left = z.copy(), numpy.arange(len(z))
        for _ in range(rounds):
            at = z[left]
            gap, slopes, good = self.linear(at)
            step, reach = self._least(gap, slopes)[0], self.reach(at)
            if deflated and self.known:
                apart = self.apart(numpy.array(self.known), at[:, None])
                step *= deflation(apart, step * reach / self.box)[:, None]
            size = abs(step).max(1)
            z[left] = self.normal(at + shortened(step, size) * reach)
            z[left[~good]] = numpy.nan
            left = left[good & ~(size < SMALL)]
            if not left.size:
                break
        return z

    def _polished(self, z: numpy.ndarray) -> numpy.ndarray:
        """Returns the unknowns after some more iterations. Unknowns much smaller than the box are
        set to 0, since their squares would underflow."""
        z = self.newton(z[None], POLISH, False)[0]
        z = numpy.where(abs(z) > 1e-40 * self.box, z, 0.0)
        z[self.body_rates] = 0
        return z

    def _correction(self, z: numpy.ndarray) -> tuple[numpy.ndarray, int, numpy.ndarray] | None:
        """Returns Newton's next correction at a root, the number of singular values that are 0, and
        the direction of the least one; None if z is no root. The test of the correction excludes
        points on the way to infinity, where forces tend to 0."""
        (gap,), (slopes,), (good,) = self.linear(z[None])
        held = (abs(gap) <= HELD * numpy.fmax(1, abs(slopes).max(1))).all()
        (step,), (flat,), (directions,) = self._least(gap[None], slopes[None])
        far = self.is_forced and (abs(z - self.middle) > FAR * self.box).any()
        good &= not far or abs(slopes).max(initial=0.0) > UNDERFLOWN
        if not good or not held or not abs(step).max() <= NEAR:
            return None
        return step, int(flat.sum()), directions[-1]

    def _is_on_continuum(self, z: numpy.ndarray, along: numpy.ndarray) -> bool:
        """Returns whether a root is on a continuum of roots: from beside it, Newton's method does
        not come back."""
        reach = self.reach(z)
        there = z + ASIDE * along * reach
        end = self.newton(self.normal(there)[None], ROUNDS, False)[0]
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

    def _is_listed(self, z: numpy.ndarray) -> bool:
        return any(abs(self.apart(one, z)).max() <= NEAR for one in self.known)

    def _is_known(self, z: numpy.ndarray, nullity: int) -> bool:
        """Returns whether z is a known root, or on the same continuum as one: their energies are
        equal, or with constraints on rates their eigenvalues."""
        if self._is_listed(z):
            return True
        given, h = self.system.given, self.energy(z)
        energies = [self.energy(one) for one in self.known]
        size = max(map(abs, (h, self.energy(self.start), *energies)))
        for one, energy, other in zip(self.known, energies, self.nullities, strict=True):
            if not nullity or not other:
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
        if self._is_listed(z):
            return
        root = self._polished(z) if numpy.isfinite(z).all() else z
        found = self._correction(root) if numpy.isfinite(root).all() else None
        if found is None:
            self.failed += first
            return
        step, nullity, along = found
        if not self.system.bound and not self._is_definite(root):
            self.singular += first
            return
        if nullity and not self._is_on_continuum(root, along):
            # An isolated root is known less accurately where it is flat.
            nullity, step = 0, ASIDE * along / 100
        if not self._is_known(root, nullity):
            self.known.append(root)
            self.errors.append(step * self.reach(root))
            self.nullities.append(nullity)

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
    for z, error, nullity in zip(search.known, search.errors, search.nullities, strict=True):
        z[abs(z) < 1e-15 * search.box] = 0
        z[search.turns] -= TURN * numpy.ceil(z[search.turns] / TURN - 0.5 - 1e-8)
        for Q in quaternions(z[search.quaternions]):
            Q *= numpy.sign(Q[(abs(Q) > 1e-9).argmax()])
        state, energy = search.states(z), search.energy(z)
        # Far away rates may only be too small; L may be undefined.
        if math.isfinite(energy) and (abs(z - search.middle) <= FURTHEST * search.box).all():
            speeds = z[system.n :]
            moving = list(zip(speeds, search.moving, strict=True))
            status, modes_of = modes.settled(system, state, error[: system.n], moving)
            q, v = floats(system.q(state)), floats(system.v(state))
            # The energy of a model that is judged by distances is not used.
            h = 0.0 if system.by_norm else energy
            at = Equilibrium(q, v, h, tuple(modes_of), status, nullity, floats(speeds))
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
        system.m,
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
    tries = TRIES if options.tries is None else options.tries
    if not 1 <= tries <= MOST_TRIES:
        raise UsageError(f"--tries {tries}: give a number from 1 to {MOST_TRIES}")
    return of_system(opened(options, compilation, "pkgen equilibria"), compilation, tries)
