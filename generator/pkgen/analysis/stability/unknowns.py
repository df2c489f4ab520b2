"""The unknowns of closed orbits are the numbers of a state on which the equations depend. All other
numbers may differ between the start and the end of a closed orbit: a cyclic coordinate, or the
integral of a first-order variable. If the equations have the period 2 pi in a coordinate, it may
differ by a multiple of 2 pi. Distances are in boxes: the box of a number is the width of the region
that the motion covers.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy

from ..linear.newton import halton, primes
from ..linear.rest import Equilibrium
from ..linear.system import System

TURN = 2 * math.pi
# Number of test points, and of elements of Halton's sequence that are skipped before them: a sine
# may vanish at these elements.
PROBES, ODD = 3, 16
ALIKE = 1e-11  # largest relative difference of rates that count as equal
# Largest coordinate of a probe for the period 2 pi. At a coordinate of 1e12 every equation seems to
# have this period, since a turn is less than ALIKE of it.
NEAR = 1e3


class Unknowns:
    """The unknowns of a system. `of` has their indices in a state; `turns` tells for each unknown
    whether the equations have the period 2 pi in it."""

    def __init__(self, system: System):
        system.cover()
        self.system = system
        n, m, box = system.n, system.m, system.box
        place = [*range(m), *range(n + m, 2 * n)]
        idle = [i for i in place if self._same(i, 0.7390851 * box[i])]
        of = sorted({*place, *range(n, n + m)}.difference(idle))
        self.of = numpy.array(of, int)
        self.turns = numpy.array([i in place and self._same(i, TURN, NEAR) for i in of], bool)
        self.box = box[self.of].copy()
        self.box[self.turns] = numpy.fmin(self.box[self.turns], TURN / 2)
        system.box[self.of] = self.box

    def _same(self, i: int | None, by: float, most: float = math.inf) -> bool:
        """Returns whether the equations do not change if number i of the state increases by `by`
        (if i is None: if the time t increases). The accelerations at PROBES states, whose numbers
        are at most about `most`, are compared."""
        system = self.system
        bases = primes(8 * PROBES)
        wide = range(2 * system.n)
        numbers = range(1 + ODD, PROBES + 1 + ODD)
        points = numpy.array([[halton(k, bases[j % len(bases)]) for j in wide] for k in numbers])
        middle = numpy.clip(system.middle, -most, most)
        states = middle + numpy.fmin(system.box, most) * (2 * points - 1)
        t = numpy.array([by * halton(k, 5) if i is None else 0.0 for k in numbers])
        before = system.kernel("acceleration", t, states)
        if i is None:
            t = t + by
        else:
            states[:, i] += by
        after = system.kernel("acceleration", t, states)
        good = ~(numpy.isnan(before).all(1) | numpy.isnan(after).all(1))
        before, after = before[good], after[good]
        return bool((abs(before - after) <= ALIKE * abs(before).max(1, initial=0)[:, None]).all())

    def in_step(self, times: list[float]) -> bool:
        """Returns whether the equations are periodic in time with each of these periods."""
        return all(self._same(None, t) for t in times)

    def apart(self, a: numpy.ndarray, b: numpy.ndarray) -> numpy.ndarray:
        """Returns b - a for the unknowns, in boxes; angles are taken modulo 2 pi."""
        d = (b - a)[..., self.of]
        return (d - self.turns * TURN * numpy.round(d / TURN)) / self.box


class Placed(System):
    """A system with the unknowns of its equilibria and closed orbits. Runs start at the equilibrium
    `place` if it is set, else at the model's start."""

    place: Equilibrium | None = None

    @cached_property
    def unknowns(self) -> Unknowns:
        with numpy.errstate(all="ignore"):
            return Unknowns(self)
