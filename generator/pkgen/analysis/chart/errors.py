"""Defines the error of a run: of its final state, along the motion, of the energy, or in phase.

Errors of a coordinate or rate are relative to its largest magnitude along the motion, the drift of
the energy is relative to its largest terms (docs/diagnostics.md), a lead or lag to the duration.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable
from fractions import Fraction

from ...record import record
from ...system.exits import UsageError
from .exact import Exact, difference

ENERGY = "energy"
END = 0.1  # a lead in phase is averaged over this last fraction of the duration
State = tuple[float, Exact]


@record
class ErrorKind:
    """A kind of error. `axis` is its name in pictures, `said` is its definition in words, `beside`
    says to which quantity the error is relative. If `path` is true, the error needs states at equal
    intervals; otherwise it needs only the final state."""

    name: str
    axis: str
    said: str
    path: bool = True
    beside: str = "Relative to the largest of each coordinate and rate along the motion."


OF_STATES = (
    "the largest of |x - reference| / max |x along the motion|, x each coordinate and each rate"
)
KINDS = {
    kind.name: kind
    for kind in (
        ErrorKind(
            "final", "relative error of the final state", f"{OF_STATES}, at the end", path=False
        ),
        ErrorKind(
            "max", "largest relative error on the way", f"{OF_STATES}, at any of 100 equal times"
        ),
        ErrorKind(
            "mean", "mean relative error on the way", f"{OF_STATES}, the mean over 100 equal times"
        ),
        ErrorKind(
            ENERGY,
            "largest relative drift of the energy",
            "the largest drift of the energy",
            path=False,
            beside="Relative to the largest of the energy's parts.",
        ),
        ErrorKind(
            "phase",
            "lead or lag, part of the time",
            "by how much the motion leads or lags the reference over the last tenth, by least "
            "squares of its coordinates, as a part of the time",
            beside="",
        ),
    )
}


@record
class Measure:
    """Computes errors of one kind. `path` has the states of the reference at equal intervals;
    `scales` has the magnitude of each component of a state, to which its error is relative."""

    kind: ErrorKind
    path: list[State]
    scales: list[float]

    def of(self, states: list[State], report: dict) -> float:
        """Returns the error, which may be infinite. Raises UsageError if it is not defined for the
        model."""
        if self.kind.name == ENERGY:
            found = [d["max"] for d in report["drifts"] if d["name"] == ENERGY]
            if not found:
                raise UsageError("--error energy: no energy of this model is constant")
            return math.inf if found[0] is None else float(found[0])
        return _OF[self.kind.name](self, [state for _, state in states])

    def _far(self, states: list[Exact]) -> list[float]:
        """Returns the error at each time of the reference. Raises ValueError if `states` has not
        as many states as the reference."""
        pairs = zip(states, self.path, strict=True)
        return [difference(one, other, self.scales) for one, (_, other) in pairs]

    def _final(self, states: list[Exact]) -> float:
        return difference(states[-1], self.path[-1][1], self.scales)

    def _max(self, states: list[Exact]) -> float:
        return max(self._far(states))

    def _mean(self, states: list[Exact]) -> float:
        return statistics.fmean(self._far(states))

    def _phase(self, states: list[Exact]) -> float:
        n = self.path[0][1].coordinates
        if not n:
            raise UsageError("--error phase: the model has no coordinates")
        last = max(1, int(END * len(self.path)))
        moved = apart = Fraction(0)
        for (_, exact), state in [*zip(self.path, states, strict=True)][-last:]:
            for i in range(n):
                rate = exact[n + i] / Fraction(self.scales[i]) ** 2
                moved += rate * exact[n + i]
                apart += rate * (state[i] - exact[i])
        return abs(float(apart / moved)) / self.path[-1][0] if moved else math.inf


_OF: dict[str, Callable[[Measure, list[Exact]], float]] = {
    "final": Measure._final,
    "max": Measure._max,
    "mean": Measure._mean,
    "phase": Measure._phase,
}
