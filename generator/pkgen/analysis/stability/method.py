"""A method seen through one step on the linear oscillator, (q, v) -> A(y) (q, v), y = h omega.
The driver takes the step and says of A what counts.

limit    the first y at which an eigenvalue of A leaves the unit circle: from the method's table
         (pk/limits.h); of a damped mode, from steps on the oscillator with its damping
angle    by which a step turns: the method's own frequency is angle(y)/h. Verlet 2 asin(y/2),
         midpoint 2 atan(y/2); E. Hairer, C. Lubich, G. Wanner, GNI I.5, VI.
resonance  y at which the angle is 2 pi/3 or 2 pi/4: steps return to where they were, and a
         nonlinear force pushes there each time
pair     the same between two modes
pole     the first y at which a step on q'' = +q has no solution: an implicit method's equations
         are singular there, and beyond it the solution that belongs to short steps is lost
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import wraps
from itertools import takewhile
from typing import Any

from ...record import record
from ..chart.points import ChartedMethod
from .ask import Asker, made

FURTHEST = 30.0  # y up to which limits and poles are sought
COARSE = 600  # points of the first look
LEAP = 4  # steps that are to resolve a motion
OUTSIDE = 1e-9  # what counts as outside of the unit circle
FIRST_GROWTH = 0.05  # a limit below this y is none: it grows at any step
TWO_PI = 2 * math.pi
# Resonances of third order between two modes: a (angle of the faster) + b (of the slower) is so
# many turns. The first has the step detune them into 1:2; the others are there by the step alone,
# and in a sum both modes may grow at once.
PAIRS = {"1:2": (1, -2, 0), "1+2": (1, 2, 1), "2+1": (2, 1, 1)}


@record
class Map:
    """Of A; numbers that are not finite are None."""

    growth: float | None  # the larger modulus of the two eigenvalues
    turn: float | None  # the angle in (0, 2 pi); None where it grows, damps or flips
    trace: float | None

    @property
    def outside(self) -> bool:
        """An eigenvalue has left the unit circle."""
        return self.growth is None or self.growth > 1 + OUTSIDE


def _once(find: Callable[..., Any]) -> Callable[..., Any]:
    """A method whose answers are kept: many equilibria and rows ask for the same."""

    @wraps(find)
    def kept(of: StepMap, *given: str | float) -> Any:
        given = tuple(float(f"{x:.12g}") if isinstance(x, float) else x for x in given)
        key = (find, *given)
        if key not in of.found:
            of.found[key] = find(of, *given)
        return of.found[key]

    return kept


@dataclass
class StepMap:
    """A method's map; answers are kept, since limits are asked for again for each equilibrium."""

    traits: ChartedMethod
    asker: Asker
    states: bool = False  # of a system with first-order variables, stepped as u' = lambda u is
    bound: bool = False  # by rotations or constraints
    turning: bool = False  # with rotations
    linear: bool = False  # the model is so, with constant coefficients: nothing answers a resonance
    found: dict[tuple, Any] = field(default_factory=dict)

    def map(self, y: float, stiffness: float = 1, damping: float = 0) -> Map:
        """Of a step that was not made nothing is known."""
        given = {"method": self.traits.name, "stiffness": stiffness, "damping": damping}
        return made(Map, self.asker.ask("oscillator", h=float(y), **given))

    @_once
    def limit(self, ratio: float) -> float | None:
        """By the damping ratio. None: no limit up to FURTHEST. 0: it grows at any step."""
        known = self.traits.imaginary
        if self.states and self.traits.real == math.inf:
            return None
        if ratio == 0 and known is not None:
            return None if math.isinf(known) else known
        found = first_change(
            lambda y: self.map(y, 1.0, 2 * ratio).outside, 0.0, FURTHEST, close=1e-12
        )
        return 0.0 if found is not None and found < FIRST_GROWTH else found

    @property
    def _partitioned(self) -> bool:
        """Of implicit ones: first-order variables are stepped otherwise than coordinates."""
        return self.traits.real != self.traits.imaginary

    @property
    def tells(self) -> bool:
        """The oscillator tells of it: attitudes are first-order variables, but not on the group."""
        apart = self.traits.implicit and self._partitioned and "group" not in self.traits.flags
        return not (self.turning and apart)

    def pole(self) -> float | None:
        """None where no step up to FURTHEST is without a solution."""
        if not self.traits.implicit or (self.states and self._partitioned):
            return None
        return self._pole()

    @_once
    def _pole(self) -> float | None:
        """Where 1/trace vanishes, continued from below: steps this side of it may be refused."""

        def beyond(y: float) -> bool:
            trace = self.map(y, -1.0).trace
            return trace is None or trace < 0

        edge = first_change(beyond, 0.0, FURTHEST)
        if edge is None:
            return None
        ys = [edge * (1 - x) for x in (4e-3, 2e-3, 1e-3)]
        g = [1 / trace for y in ys if (trace := self.map(y, -1.0).trace)]
        if len(g) < len(ys):
            return None
        pole = sum(
            y * math.prod(g[k] / (g[k] - g[i]) for k in range(3) if k != i)
            for i, y in enumerate(ys)
        )
        return pole if abs(pole / edge - 1) < 1e-3 else None

    @_once
    def resolves(self, grows: bool) -> float | None:
        """The first y at which LEAP steps on the oscillator are off by half of what it covers; or
        on what grows as fast, by half of what it has become. None: nowhere up to FURTHEST."""

        def off(y: float) -> bool:
            step = self.map(y, -1.0 if grows else 1.0)
            if step.growth is None or step.trace is None:
                return True
            if grows:
                return not abs((step.growth / math.exp(y)) ** LEAP - 1) < 0.5
            cosine = max(-1.0, min(step.trace / (2 * step.growth), 1.0))
            made = (step.growth * cmath.exp(1j * math.acos(cosine))) ** LEAP
            return abs(made - cmath.exp(1j * LEAP * y)) >= 1  # it covers twice its amplitude

        return first_change(off, 0.0, FURTHEST, close=1e-9)

    @_once
    def angles(self) -> tuple[list[float], list[float]]:
        """y and the angle a step, from 0 to where the map stops being a rotation (or FURTHEST)."""
        limit = self.limit(0.0)
        far = FURTHEST if limit is None else limit
        ys = [far * (k + 1) / COARSE for k in range(COARSE)] if far else []
        turns = list(takewhile(lambda turn: turn is not None, (self.map(y).turn for y in ys)))
        return ys[: len(turns)], turns

    @_once
    def resonance(self, angle: float) -> float | None:
        """The first y at which a step turns by `angle`; None where it does not, or damps."""

        def past(y: float) -> bool:
            turn = self.map(y).turn
            return turn is None or turn >= angle

        ys, turns = self.angles()
        for low, high, turn in zip([0.0, *ys], ys, turns, strict=False):
            if turn >= angle:
                return first_change(past, low, high)
        return None

    def pair(self, kind: str, ratio: float) -> float | None:
        """y of the faster of two modes at which the angles of a step meet the condition `kind` of
        PAIRS; `ratio` is that of their true frequencies."""
        if kind == "1:2" and abs(ratio - 2) < 1e-6:
            return None  # they are so already; a step can but detune them
        return self._pair(kind, ratio)

    @_once
    def _pair(self, kind: str, ratio: float) -> float | None:
        def excess(y: float) -> float:
            slow, fast = self.map(y / ratio).turn, self.map(y).turn
            return math.nan if slow is None or fast is None else combined(kind, fast, slow)

        ys, _ = self.angles()
        if not ys:
            return None
        first = excess(ys[0])
        return first_change(lambda y: excess(y) * first < 0, 0.0, ys[-1])


def combined(kind: str, fast: float, slow: float) -> float:
    """How far the angles of two modes are from the resonance."""
    a, b, turns = PAIRS[kind]
    return a * fast + b * slow - turns * TWO_PI


def first_change(
    test: Callable[[float], bool],
    low: float,
    high: float,
    looks: int = COARSE,
    parts: int = 32,
    close: float = 0.0,
) -> float | None:
    """The first x in (low, high] at which `test` becomes true, by a coarse look and ever finer
    ones, each of so many parts, until it is known to `close`; 0: to its last digits. A gap narrower
    than the coarse look's spacing is missed."""
    xs = [low + (high - low) * (k + 1) / looks for k in range(looks)]
    where = next((k for k, x in enumerate(xs) if test(x)), None)
    while where is not None:
        low, high = (xs[where - 1] if where else low), xs[where]
        if high - low <= (close or 1e-13 * high):
            return high
        xs = [low + (high - low) * (k + 1) / parts for k in range(parts - 1)]
        where = next((k for k, x in enumerate(xs) if test(x)), parts - 1)
        xs.append(high)
    return None
