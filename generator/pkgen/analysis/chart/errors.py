"""Defines the error of a run: of its final state, along the motion, of the energy, or in phase.

Errors of a coordinate or rate are relative to its largest magnitude along the motion, the drift of
the energy is relative to its largest terms (docs/diagnostics.md), a lead or lag to the duration.
"""

from __future__ import annotations

import math

import numpy

from ...record import record
from ...system.exits import NumericsFailed, UsageError
from .rows import Rows

ENERGY = "energy"
END = 0.1  # a lead in phase is averaged over this last fraction of the duration
LAST = slice(-1, None)


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
    """Computes errors of one kind. `exact` has the states of the reference at equal intervals;
    `scales` has the magnitude of each component of a state, to which its error is relative. The
    first `coordinates` components are coordinates, next are their rates."""

    kind: ErrorKind
    exact: Rows
    scales: numpy.ndarray
    coordinates: int

    def of(self, seen: Rows, report: dict) -> float:
        """Returns the error of a run, from its states at the times of the reference or, if the kind
        needs no path, from its last state. The error may be infinite. Raises UsageError if it is
        not defined for the model."""
        if self.kind.name == ENERGY:
            found = [d["max"] for d in report["drifts"] if d["name"] == ENERGY]
            if not found:
                raise UsageError("--error energy: no energy of this model is constant")
            return math.inf if found[0] is None else float(found[0])
        off = self.exact.apart(seen) if self.kind.path else self.exact.apart(seen, LAST, LAST)
        if not numpy.isfinite(off).all():
            raise NumericsFailed("a state is not finite")
        if self.kind.name == "phase":
            return self._phase(off)
        far = (abs(off) / self.scales).max(axis=1)
        return float(far.mean() if self.kind.name == "mean" else far.max())

    def _phase(self, off: numpy.ndarray) -> float:
        n, t = self.coordinates, self.exact.t
        if not n:
            raise UsageError("--error phase: the model has no coordinates")
        late = slice(-max(1, int(END * len(t))), None)
        rates = self.exact.x[late, n : 2 * n]
        parts = rates / self.scales[:n] ** 2
        moved = (parts * rates).sum()
        if not moved:
            return math.inf
        return float(abs((parts * off[late, :n]).sum() / moved) / t[-1])
