"""Properties of a method's step on the linear oscillator q'' = -omega^2 q. A step of size h
multiplies the state (q, v) by a matrix A(y), with y = h omega. The runtime makes the steps.

limit    the first y at which an eigenvalue of A leaves the unit circle, from the method's table
         (pk/limits.h); for a damped mode, from steps on the damped oscillator
angle    the angle by which a step rotates (q, v), such as 2 asin(y/2) for Verlet and 2 atan(y/2)
         for midpoint (E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, I.5, VI)
resonance  y at which the angle is a simple fraction of 2 pi, such as 2 pi/3. After a few steps the
         oscillator returns to the same phase, so a nonlinear force always acts in one direction
pair     y at which the angles of two modes are in resonance
pole     the first y at which a step on q'' = +q has no solution. The equations of an implicit step
         are singular at the pole; longer steps lose the solution that short steps follow
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
from .ask import Asker

FURTHEST = 30.0  # largest y in the search for limits and poles
COARSE = 600  # points of the coarse search
LEAP = 4  # if the error after this many steps is large, the method does not resolve the motion
OUTSIDE = 1e-9  # an eigenvalue is outside the unit circle if its modulus is above 1 + OUTSIDE
FIRST_GROWTH = 0.05  # a limit below this y counts as growth at any step size
TWO_PI = 2 * math.pi
# Resonances of third order between two modes, as (a, b, turns): a times the angle of the faster
# mode plus b times the angle of the slower mode is 2 pi turns. In "1:2" the step shifts the ratio
# of the frequencies to 2. The other two are sum resonances, which exact motions do not have; both
# modes may grow at once in them.
PAIRS = {"1:2": (1, -2, 0), "1+2": (1, 2, 1), "2+1": (2, 1, 1)}


@record
class Map:
    """Properties of the matrix A of a step; None instead of a number that is not finite."""

    growth: float | None  # largest modulus of the eigenvalues
    turn: float | None  # rotation angle in (0, 2 pi); None if the step grows, damps or flips
    trace: float | None

    @property
    def outside(self) -> bool:
        """Whether an eigenvalue is outside the unit circle."""
        return self.growth is None or self.growth > 1 + OUTSIDE


def _once(find: Callable[..., Any]) -> Callable[..., Any]:
    """Caches the results of a method of StepMap by its arguments, since many equilibria and rows of
    a map need the same results."""

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
    """A method's step map on the linear oscillator; results are cached in `found`."""

    traits: ChartedMethod
    asker: Asker
    states: bool = False  # the model has first-order variables, like u' = lambda u
    bound: bool = False  # the model has rotations or constraints
    turning: bool = False  # the model has rotations
    linear: bool = False  # the model is linear with constant coefficients
    found: dict[tuple, Any] = field(default_factory=dict)

    def map(self, y: float, stiffness: float = 1, damping: float = 0) -> Map:
        """Returns the properties of A for a step of size y; they are all None if the step fails."""
        (a, b), (c, d) = self.asker.spring(self.traits.name, stiffness, damping, float(y))
        half, det = (a + d) / 2, a * d - b * c
        if not math.isfinite(half * det):
            return Map(None, None, None)
        apart = half * half - det
        growth = abs(half) + math.sqrt(apart) if apart > 0 else math.sqrt(max(det, 0.0))
        turn = math.atan2(math.sqrt(max(-apart, 0.0)), half)
        turns = abs(det - 1) < 1e-9 and abs(half) < 1
        return Map(growth, (TWO_PI - turn if b < 0 else turn) if turns else None, 2 * half)

    @_once
    def limit(self, ratio: float) -> float | None:
        """Returns the stability limit y of an oscillator with the damping ratio `ratio`. It is None
        if there is no limit up to FURTHEST, and 0 if the motion grows at any step size."""
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
        """Whether an implicit method treats first-order variables unlike coordinates."""
        return self.traits.real != self.traits.imaginary

    @property
    def tells(self) -> bool:
        """Whether steps on the oscillator tell how steps on the model behave. They do not if the
        method treats quaternions, which are first-order variables, unlike coordinates."""
        apart = self.traits.implicit and self._partitioned and "group" not in self.traits.flags
        return not (self.turning and apart)

    @_once
    def pole(self) -> float | None:
        """Returns the first y at which a step on q'' = +q has no solution, up to FURTHEST; else
        None. It is the root of 1/trace (the trace of A), which is extrapolated from shorter steps,
        since steps just below the pole may fail."""
        if not self.traits.implicit or (self.states and self._partitioned):
            return None

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
        """Returns the first y at which the error of LEAP steps on the oscillator is half the range
        of the motion. With `grows`, the steps are on q'' = +q, and the error is half the exact
        solution. Returns None if there is no such y up to FURTHEST."""

        def off(y: float) -> bool:
            step = self.map(y, -1.0 if grows else 1.0)
            if step.growth is None or step.trace is None:
                return True
            if grows:
                return not abs((step.growth / math.exp(y)) ** LEAP - 1) < 0.5
            cosine = max(-1.0, min(step.trace / (2 * step.growth), 1.0))
            made = (step.growth * cmath.exp(1j * math.acos(cosine))) ** LEAP
            return abs(made - cmath.exp(1j * LEAP * y)) >= 1  # half the range of the motion

        return first_change(off, 0.0, FURTHEST, close=1e-9)

    @_once
    def angles(self) -> tuple[list[float], list[float]]:
        """Returns ascending values of y, and the rotation angle of a step for each. The values end
        before the first y at which A is no rotation."""
        limit = self.limit(0.0)
        far = FURTHEST if limit is None else limit
        ys = [far * (k + 1) / COARSE for k in range(COARSE)] if far else []
        turns = list(takewhile(lambda turn: turn is not None, (self.map(y).turn for y in ys)))
        return ys[: len(turns)], turns

    @_once
    def resonance(self, angle: float) -> float | None:
        """Returns the first y at which a step rotates by `angle`, or None."""

        def past(y: float) -> bool:
            turn = self.map(y).turn
            return turn is None or turn >= angle

        ys, turns = self.angles()
        for low, high, turn in zip([0.0, *ys], ys, turns, strict=False):
            if turn >= angle:
                return first_change(past, low, high)
        return None

    @_once
    def pair(self, kind: str, ratio: float) -> float | None:
        """Returns the y of the faster of two modes at which their rotation angles are in the
        resonance `kind` (a key of PAIRS), or None if there is none. `ratio` is the ratio of the
        exact frequencies."""
        if kind == "1:2" and abs(ratio - 2) < 1e-6:
            return None  # the exact modes are already in resonance

        def excess(y: float) -> float:
            slow, fast = self.map(y / ratio).turn, self.map(y).turn
            return math.nan if slow is None or fast is None else combined(kind, fast, slow)

        ys, _ = self.angles()
        if not ys:
            return None
        first = excess(ys[0])
        return first_change(lambda y: excess(y) * first < 0, 0.0, ys[-1])


def combined(kind: str, fast: float, slow: float) -> float:
    """Returns `a * fast + b * slow - 2 pi * turns`, which is 0 at the resonance `kind`; `fast` and
    `slow` are the rotation angles of the two modes."""
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
    """Returns the first x in (low, high] at which `test` becomes true, from a coarse search with
    `looks` points and refinements into `parts` intervals, to precision `close` (0: round-off). It
    may miss intervals narrower than the spacing of the coarse search."""
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
