"""Reads the options: the varied quantity, the methods, the settings, the duration."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy

from ...compiler import Compilation
from ...defaults import UNTIL
from ...methods import provides
from ...middle.structure import Structure
from ...plot.names import label
from ...record import record
from ...run import named
from ...run.methods_table import in_words
from ...run.settings import Settings
from ...scenes import run_settings as parsing
from ...scenes import scene
from ...system.exits import UsageError
from ..chart.points import ChartedMethod
from ..linear.rest import Equilibrium, Rest
from .ask import Motion
from .cycles import Cycle

# The default methods of a map: one or two of each family, since families fail in different ways.
USUAL = ("verlet", "yoshida4", "rk4", "gauss1", "gauss2", "lobatto3", "radau5")
HOLONOMIC = ("rattle", "lie_midpoint")  # replace verlet and yoshida4 if there are constraints
PANELS = 6
FACTORS = ("amplitude", "rates", "coordinates")  # kinds of Axis whose values are factors
AMPLITUDES = (0.0, 1.5)  # range of the factor on the displacement of the start
AT_REST = 1e-12  # a start within this relative distance of an equilibrium is the equilibrium
PERIODS = 50  # duration of each run, in periods of the slowest mode
FULL, QUICK = (48, 32), (24, 12)  # default numbers of step sizes and of rows
MOST_POINTS = 1_000_000


@record
class Axis:
    """The vertical axis of a map: the varied quantity. Its values are factors if the kind is
    "amplitude" (on the displacement of the start from an equilibrium) or, in a model without
    equilibrium, "rates" (on the rates and first-order variables of the start) or "coordinates" (on
    the coordinates of the start). The kinds "q" and "v" mean one coordinate or rate of the start,
    "parameter" means one parameter, each given by its index."""

    kind: str  # "amplitude", "rates", "coordinates", "q", "v" or "parameter"
    name: str
    unit: str
    values: tuple[float, ...]
    index: int = 0

    @property
    def label(self) -> str:
        if self.kind in FACTORS:
            return f"{self.kind} (the start: 1)"
        return label(self.name, self.unit)

    def origin(self, at: Equilibrium | None, motion: Motion, turned: range) -> numpy.ndarray:
        """Returns the state (q, v) for the factor 0. `at` is the equilibrium from which the start
        is displaced; `turned` has the indices of quaternion components among the rates."""
        if self.kind == "amplitude" and at:
            return numpy.array([*at.q, *at.v])
        q, v = numpy.zeros(len(motion.q)), numpy.array(motion.v)
        if self.kind == "coordinates":
            v[turned] = [float(k % 4 == 0) for k in range(len(turned))]
        else:
            q, v = numpy.array(motion.q), numpy.where(numpy.isin(range(len(v)), turned), v, 0.0)
        return numpy.concatenate([q, v])

    def settings(
        self,
        base: Settings,
        x: float,
        at: Equilibrium | None,
        motion: Motion,
        turned: range = range(0),
    ) -> Settings:
        """Returns the settings of runs in the row with the value x of the varied quantity; for `at`
        and `turned` see origin(). The start in the settings is not yet projected onto constraints,
        and its quaternions are not yet normalised."""
        if self.kind in FACTORS:
            origin = self.origin(at, motion, turned)
            state = origin + x * (numpy.array([*motion.q, *motion.v]) - origin)
            q, v = (tuple(enumerate(part.tolist())) for part in numpy.split(state, 2))
            return replace(base, start_q=q, start_v=v)
        field = {"q": "start_q", "v": "start_v", "parameter": "parameters"}[self.kind]
        kept = tuple(item for item in getattr(base, field) if item[0] != self.index)
        return replace(base, **{field: (*kept, (self.index, x))})

    def place(self, state: Sequence[float], at: Equilibrium | None, motion: Motion) -> float:
        """Returns the value of the varied quantity for a state. If the values are factors, this is
        the largest displacement of the state, divided by the largest displacement of the start."""
        half = len(motion.q)
        if self.kind == "parameter":
            return motion.parameters[self.index]
        if self.kind in ("q", "v"):
            return state[self.index + (half if self.kind == "v" else 0)]
        origin = self.origin(at, motion, range(0))
        whole = abs(numpy.array([*motion.q, *motion.v]) - origin)
        if self.kind == "amplitude":  # of the coordinates or, by_norm, of the rates alone
            whole[:half] *= not motion.by_norm
            whole[half:] *= motion.by_norm
        moved = abs(numpy.array(state) - origin)[whole > 0]
        return float(moved.max(initial=0.0) / whole.max()) if len(moved) else 0.0


def numbers(text: str | None, quick: bool) -> tuple[int, int]:
    """Reads `--points 48x32`: numbers of step sizes and of values of the varied quantity."""
    if text is None:
        return QUICK if quick else FULL
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(p.isascii() and p.isdecimal() and len(p) < 6 for p in parts):
        raise UsageError(f"--points {text}: give two numbers, steps x values, e.g. 48x32")
    across, up = map(int, parts)
    if across < 2 or up < 1 or across * up > MOST_POINTS:
        raise UsageError(f"--points {text}: 2x1 at least, {MOST_POINTS:,} points at most")
    return across, up


def axis(text: str | None, compilation: Compilation, count: int) -> Axis:
    """Reads `--vary "theta=0..3.1"` or `--vary "k=1..100 [N/m]"`; the default is the amplitude."""
    if text is None:
        return Axis("amplitude", "amplitude", "", _spread(*AMPLITUDES, count, open_low=True))
    left, equal, right = text.partition("=")
    if not (equal and left.strip() and ".." in right):
        some = next(iter([*named.parameters(compilation), *named.coordinates(compilation)]))
        raise UsageError(f'--vary {text}: give a name and a range, e.g. --vary "{some}=LO..HI"')
    values = parsing.Values(compilation)
    name = values.flat_name("--vary", left.strip())
    for kind, known in (
        ("q", named.coordinates(compilation)),
        ("v", named.coordinates(compilation, rates=True)),
        ("parameter", named.parameters(compilation)),
    ):
        if name in known:
            index, quantity = known[name]
            low, high = span("--vary", right, values, quantity.unit, name)
            return Axis(kind, name, quantity.unit, _spread(low, high, count), index)
    listed = [*named.coordinates(compilation), *named.parameters(compilation)]
    raise UsageError(parsing.unknown("--vary", name, listed, "coordinate, rate or parameter"))


def without_equilibrium(axis: Axis, motion: Motion, turned: range = range(0)) -> Axis:
    """Returns the axis for a model without an equilibrium: the rates of the start or, if it is at
    rest, its coordinates and the rotation angles of bodies."""
    moves = any(v for i, v in enumerate(motion.v) if i not in turned)
    kind = "rates" if moves else "coordinates"
    return replace(axis, kind=kind, name=kind)


def still(
    axis: Axis, at: Equilibrium | None, motion: Motion, cyclic: frozenset[int], autonomous: bool
) -> bool:
    """Returns whether all rows of the map have the same start, since the varied quantity is a
    factor on numbers that are all 0. Raises UsageError if moreover nothing moves."""
    if axis.kind not in FACTORS:
        return False
    rest = numpy.array([*at.q, *at.v]) if at and axis.kind == "amplitude" else numpy.zeros(1)
    apart = numpy.delete(abs(numpy.array([*motion.q, *motion.v]) - rest), [*cyclic])
    if apart.max(initial=0.0) > AT_REST * abs(rest).max(initial=0.0):
        return False
    if at and autonomous:
        raise UsageError(
            "the start is the equilibrium itself: every multiple of its displacement is 0, and "
            "nothing moves. Give a start by --start, or vary one by --vary NAME=LO..HI"
        )
    return True


def span(
    option: str, text: str, values: parsing.Values, unit: str, name: str
) -> tuple[float, float]:
    """Reads `LO..HI`; a unit at the end applies to both numbers."""
    low, _, high = text.partition("..")
    high, bracket, written = high.partition("[")
    ends = [
        values.value(option, f"{end} {bracket}{written}".strip(), unit, name) for end in (low, high)
    ]
    if not ends[0] < ends[1]:
        raise UsageError(f"{option} {text.strip()}: the range must go upwards")
    return ends[0], ends[1]


def _spread(low: float, high: float, count: int, open_low: bool = False) -> tuple[float, ...]:
    """Returns `count` values from low (one spacing above it with `open_low`) to high."""
    if open_low:
        return tuple(low + (high - low) * (k + 1) / count for k in range(count))
    return tuple(low + (high - low) * k / max(count - 1, 1) for k in range(count))


def methods(
    text: str | None,
    known: Sequence[ChartedMethod],
    structure: Structure,
    own: Sequence[str] = (),
    bound: bool = False,
) -> tuple[list[ChartedMethod], list[str]]:
    """Returns the methods to map, and a sentence on each method that is left out."""
    by_name = {m.name: m for m in known}
    names = (
        [n.strip() for n in text.split(",") if n.strip()]
        if text
        else [*own, *USUAL, *(HOLONOMIC if bound else ())]
    )
    taken, left = [], []
    for name in dict.fromkeys(names):
        if name not in by_name:
            if text:
                raise UsageError(parsing.unknown("--methods", name, list(by_name), "method"))
            continue
        traits = by_name[name]
        missing = [r for r in traits.requires if not provides(structure, r)]
        if not traits.fixed:
            left.append(f"{name} chooses its steps itself: there is no map of it over the step")
        elif missing:
            needs = ", ".join(in_words(missing))
            left.append(f"{name} is refused: it needs a system that is {needs}")
        elif text or len(taken) < PANELS:
            taken.append(traits)
    if not taken:
        raise UsageError(f"--methods: none can be mapped; {'; '.join(left)}")
    return taken, left


def settings(options: argparse.Namespace, compilation: Compilation) -> Settings:
    """Returns the settings of a run without output rows."""
    chosen = scene.of(options, compilation.declared)
    whole = parsing.settings(options, compilation, chosen=chosen)
    return replace(whole, every=None, method="rk4", step=None, show=(), at=None)


def nearest(rest: Rest, place: Sequence[float], cyclic: frozenset[int]) -> int | None:
    """Returns the index of the equilibrium nearest to the coordinates `place`. If there are stable
    equilibria, the others do not count."""

    def distance(number: int) -> tuple[bool, float]:
        at = beside(rest, number, place, cyclic)
        return not at.stable, apart(at, place, cyclic)

    return min(range(len(rest.equilibria)), key=distance, default=None)


def apart(at: Equilibrium, place: Sequence[float], cyclic: frozenset[int]) -> float:
    """Returns the largest distance, over all coordinates that are not cyclic, between the
    coordinates `place` and the equilibrium."""
    far = (abs(a - b) for a, b in zip(at.q, place, strict=True))
    return max((x for i, x in enumerate(far) if i not in cyclic), default=0.0)


def beside(
    rest: Rest, number: int | None, place: Sequence[float], cyclic: frozenset[int]
) -> Equilibrium | None:
    """Returns equilibrium `number`, with angles shifted by multiples of 2 pi to be near `place`."""
    if number is None:
        return None
    at = rest.equilibria[number]
    q = tuple(
        a if i in cyclic else rest.beside(a, b, i)
        for i, (a, b) in enumerate(zip(at.q, place, strict=True))
    )
    return replace(at, q=q)


def duration(at: Equilibrium | None, given: float | None, cycle: Cycle | None = None) -> float:
    """Returns the duration of runs: `given` if it is set. Else it is PERIODS periods of the cycle
    or of the slowest mode or, if there are none, the default duration of `pkgen run`."""
    if given is not None:
        return given
    slow = [at.modes[k].frequency for k in at.oscillating] if at else []
    period = cycle.period if cycle else 2 * math.pi / min(slow) if slow else None
    return PERIODS * period if period else UNTIL
