"""Computes reference states beyond double precision, in __float128 (or else in long double): by
gauss of order 16 at a tolerance near round-off, then at a looser one, and by dop853, an independent
method: the C code of its step is not that of gauss. The largest difference of the three runs is the
reference's error. All three runs use the model's C equations, which other tests check.

States are compared at the ends of a hundred equal intervals. Errors of a coordinate or rate are
relative to its largest magnitude during the motion. The three runs of a chaotic motion agree only
up to some time, after which the reference is invalid; this time is found.
"""

from __future__ import annotations

import sys
from itertools import takewhile

import numpy

from ...compiler import Compilation
from ...middle.structure import Structure
from ...record import record
from ...run.settings import Settings
from ...system.exits import BuildError, NumericsFailed, UsageError
from . import wide
from .errors import ErrorKind, Measure
from .measure import Program
from .rows import Rows, rows_of

TIMES = 100
PRECISE = ("gauss", "dop853")  # the methods that compute the reference
MUST_AGREE = 1e-13  # a reference with a larger error is not good enough for a full chart
SLOWEST = 60.0  # an integration for the reference is stopped after these CPU seconds

# For each scalar type: the tolerances of the first and the second run of gauss, and of dop853. The
# step of dop853 is proportional to tolerance^(1/8). At the tolerance 1e-22 it takes as long as the
# runs of gauss, so a tighter tolerance would take too long.
TOLERANCES = {"__float128": (1e-28, 1e-25, 1e-22), "long double": (1e-18, 1e-17, 1e-17)}


@record
class Reference:
    """Reference states at equal intervals, in `exact`. `scales` has the largest magnitude of each
    component; if that is 0, the largest magnitude of all coordinates or all rates. `error` is the
    error of the last state, `worst` is the largest error of any state. Up to the time `holds`
    errors are below MUST_AGREE."""

    exact: Rows
    scales: numpy.ndarray
    coordinates: int
    error: float
    worst: float
    holds: float
    scalar: str
    steps: int

    def measure(self, kind: ErrorKind) -> Measure:
        return Measure(kind, self.exact, self.scales, self.coordinates)

    def text(self, time: str) -> str:
        said = (
            f"gauss in {self.scalar}, {self.steps} steps, agrees with dop853 and a looser "
            f"tolerance to {self.error:.1e}"
        )
        if self.error <= MUST_AGREE:
            return said
        unit = f" {time}" if time else ""
        return (
            f"{said}: not to {MUST_AGREE:.0e}, so the chart is cut at ten times that; "
            f"it does so until t = {self.holds:.3g}{unit} (--until)"
        )


def find(compilation: Compilation, settings: Settings) -> Reference:
    """Computes the reference. Raises NumericsFailed; UsageError if nothing moves; BuildError if the
    model does not compile."""
    found = wide.library(compilation.files, compilation.model.name, PRECISE)
    if found is None:
        raise BuildError("no C compiler here has a type wider than double")
    program, scalar = found
    return _agree(Program(program, settings), scalar, best(compilation.structure))


def best(structure: Structure) -> str:
    """Returns the method for the tightest runs. It is gauss, or dop853 if the equations have kinks,
    at which gauss is inaccurate."""
    return "gauss" if structure.smooth_in_pieces else "dop853"


def _agree(program: Program, scalar: str, method: str) -> Reference:
    tight, loose, other = TOLERANCES[scalar]
    runs = [(method, tight), (method, loose), ("dop853", other)]
    if method == "dop853":  # the third run would repeat the first method
        runs = [(method, other), (method, other * 100)]
    (exact, steps), *checks = (_path(program, *run) for run in runs)
    largest, n = abs(exact.x).max(axis=0), len(program.start["q"])
    # Nothing moves if no number changes by more than the round-off of a double.
    if (numpy.ptp(exact.x, axis=0) <= sys.float_info.epsilon * largest).all():
        raise UsageError(
            "nothing moves from this start, so every method is exact; give another by --start"
        )
    kinds = largest[:n], largest[n:]
    scales = numpy.concatenate([numpy.where(x > 0, x, x.max(initial=0.0) or 1.0) for x in kinds])
    worst = numpy.max([(abs(exact.apart(rows)) / scales).max(axis=1) for rows, _ in checks], axis=0)
    agreed = takewhile(lambda pair: pair[1] <= MUST_AGREE, zip(exact.t, worst, strict=True))
    holds = max((float(t) for t, _ in agreed), default=0.0)
    return Reference(exact, scales, n, float(worst[-1]), float(worst.max()), holds, scalar, steps)


def _path(program: Program, method: str, tolerance: float) -> tuple[Rows, int]:
    done = program.path(method, tolerance, TIMES, SLOWEST)
    found = done.report
    if found["status"] != "PK_DONE":
        raise NumericsFailed(
            f"the reference ends early: {found['reason']}; give an --until before that"
        )
    if found["slow"]:
        raise NumericsFailed(
            f"the reference came to t = {found['t']:.3g} in {SLOWEST:g} s; take a shorter --until"
        )
    return rows_of(done), found["steps"]
