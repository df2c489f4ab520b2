"""Equilibria and their modes."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ...record import record
from .symmetries import Symmetry

ZERO = 1e-7  # a mode's rate below this part of the largest rate at any equilibrium counts as 0
UNDECIDED = "not decided by the linear terms"


@record
class Mode:
    """A mode of small motions: the displacement from the equilibrium at time t is Re(shape
    exp(lambda t)), with lambda = growth + i frequency and shape = re + i im."""

    growth: float
    frequency: float
    re: tuple[float, ...]
    im: tuple[float, ...]
    on_group: bool = False  # the mode is a body's rotation: it limits Lie-group methods only

    @property
    def value(self) -> complex:
        """lambda."""
        return complex(self.growth, self.frequency)

    @property
    def rate(self) -> float:
        """|lambda|."""
        return abs(self.value)


@record
class Equilibrium:
    q: tuple[float, ...]
    v: tuple[float, ...]
    energy: float
    modes: tuple[Mode, ...]  # the fastest first
    status: str = "PK_DONE"  # status of the computation of modes
    nullity: int = 0  # dimension of the continuum of equilibria that contains this one
    speeds: tuple[float, ...] = ()  # along each symmetry in Rest.moving

    @property
    def stable(self) -> bool:
        """Whether the modes are known, none grows, and not all have rate 0."""
        moves = not self.modes or any(mode.rate > 0 for mode in self.modes)
        return self.status == "PK_DONE" and moves and not self._grows

    @property
    def _grows(self) -> bool:
        return any(mode.growth > 0 for mode in self.modes)

    @property
    def verdict(self) -> str:
        """Describes the stability in words. If no mode grows but one has the rate 0, the linear
        terms of the equations do not decide whether the equilibrium is stable."""
        if self.status != "PK_DONE":
            return f"modes: {self.status}"
        if self._grows:
            return "unstable"
        if any(mode.rate == 0 for mode in self.modes):
            return "one of a continuum" if self.nullity else UNDECIDED
        return "stable"

    @property
    def oscillating(self) -> list[int]:
        """Returns the indices of modes that oscillate and do not grow."""
        return [k for k, m in enumerate(self.modes) if m.frequency > 0 and m.growth <= 0]


@record
class Rest:
    """The equilibria found, and the region searched."""

    status: str
    equilibria: tuple[Equilibrium, ...]
    failed: int
    singular: int
    more: bool
    turns: tuple[bool, ...] = ()  # for each coordinate: whether it has the period 2 pi
    middle: tuple[float, ...] = ()  # the search begins within middle +- box (docs/maps.md)
    box: tuple[float, ...] = ()
    cyclic: tuple[int, ...] = ()
    places: int = 0  # number of coordinates; first-order variables follow
    moving: tuple[Symmetry, ...] = ()  # symmetries besides shifts of cyclic coordinates

    def nearest(self, q: Sequence[float], v: Sequence[float], stable: bool = False) -> Equilibrium:
        """Returns the equilibrium nearest to a state, in boxes; with `stable`, unstable ones count
        only if there are no others. Cyclic coordinates count by their rates."""

        def moved(at: Equilibrium, i: int) -> float:
            if i in self.cyclic or i >= self.places:
                return at.v[i] - v[i]
            return self.beside(at.q[i], q[i], i) - q[i]

        def distance(at: Equilibrium) -> tuple[bool, float]:
            far = (abs(moved(at, i)) / size for i, size in enumerate(self.box))
            return stable and not at.stable, max(far, default=0.0)

        return min(self.equilibria, key=distance)

    def beside(self, q: float, place: float, i: int) -> float:
        """Returns the value q of coordinate i. If the coordinate is an angle, a multiple of 2 pi is
        added, so that it is nearest to the value `place`."""
        turns = bool(self.turns) and self.turns[i]
        return q + 2 * math.pi * round((place - q) / (2 * math.pi)) if turns else q
