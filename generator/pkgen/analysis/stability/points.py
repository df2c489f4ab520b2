"""Classifies a method's run at one step size, mostly by its energy E. The definitions use

E0      the initial energy
v.p     rates times momenta, which is twice the kinetic energy for most models
S       the range of v.p over the reference motion
[a, b]  the range of E in the last quarter of the run
R       |v.p| + |L|, a bound on E; the round-off of E is relative to R
away    the distance of E0 from [a, b]
rise    max E - E0 over the run
early   max E - E0 over the first eighth of the run

The classes are

growing        rise > S; moreover E still rises (rise > 2 early), or does not return to E0 (away >
               S/2 or away > (b - a)/4), or has risen further than any beat (rise > 1e4 S)
drifting       not growing, away > (b - a)/4 and away > 1e-11 R
exchange       not growing, and the amplitude of a coordinate is TIMES that in the reference motion
constant lost  not drifting, and a constant of motion other than E has changed by MOVED
bounded        none of these: E returns to E0

A drift smaller than 2.2 times the oscillation of E is not detected. Near a step resonance the
oscillation of E may be slower than the run. Therefore the run of a symplectic or symmetric method
is drifting only if `away` is a fifth larger in a run four times as long. If the energy of the model
is not constant, E0 is replaced by energies of the reference motion: their range in its last quarter
for `away`, their maximum for `rise`. A run has at least LEAST_STEPS steps; the reference motion
lasts as long. If the reference motion leaves (reference.py) or ends early, the run is "not judged".
At y = h omega below its stability limit, Verlet's energy may rise by E0/(1 - y^2/4) and return,
which is bounded. All other classes are failures of steps.

The share of a coordinate is its largest |v_i p_i|. Coordinates with a share below SHARE times the
largest share do not count in the fields of a Point:

exchange  square root of the ratio of the shares in the run and in the reference motion
moved     largest secular change of a proved constant of motion, relative to its scale
          (pk/diagnostics.h)
follows   fraction of the time for which the run stays near the reference motion, as long as the
          latter is known
"""

from __future__ import annotations

import math

import numpy

from ...record import record
from ...run.integration import CONSTANTS, Integration
from ..linear.system import MOST_STEPS, System
from .reference import SHARE, Reference, Summary, Watch

LEAST_STEPS = 200
TIMES = 3.0  # "exchange": an amplitude is at least TIMES that in the reference motion
MOVED = 1e-2  # "constant lost": a constant of motion has changed by this fraction of its scale
STEADY = 1e-6  # a quantity that changes more in the reference motion is not treated as constant
SECULAR = 0.5  # a change counts if at least this part of it is a linear trend, not an oscillation
NOT_FINITE = "PK_NOT_FINITE"
FAILURES = {
    "PK_REFUSED": "refused",
    "PK_NO_CONVERGENCE": "not converged",
    "PK_NO_PROJECTION": "off constraints",
    "PK_AMBIGUOUS_STEP": "wrong branch",
    NOT_FINITE: "not finite",
    "PK_SINGULAR_MASS": "singular",
    "PK_SINGULAR_TIME": "singular",
    "PK_SINGULAR_COORDINATES": "singular",
    "PK_STEP_TOO_LONG": "singular",
}


@record
class Point:
    """The result of a method's run at step size h: a point of the map. `rise` and
    `away` (see above) are changes of the energy relative to Motion.scale."""

    method: str
    h: float
    kind: str
    status: str
    steps: int
    rise: float | None
    away: float | None
    cond: float | None  # condition number of the last step's equations; 0: it has none
    # `exchange`, `moved` and `follows` are None if the method fails (docs/maps.md).
    exchange: float | None = None  # largest ratio of a coordinate's amplitude to the reference's
    moved: float | None = None  # largest relative drift of a constant of motion
    follows: float | None = None  # fraction of the time that the run stays near the reference
    constant: str = ""

    @property
    def shown(self) -> str:
        """Returns the class that the map shows for this point."""
        if self.kind == "bounded" and self.follows is not None and self.follows < 1:
            return "out of phase"
        if self.kind == "drifting" and self.away is not None and self.away < 0.01:
            return "drifting by less than 1 %"
        return self.kind


class _Energies:
    """Follows a method's run, and keeps the energies and other measures that classify the run."""

    def __init__(self, reference: Reference, it: Integration):
        self.reference, self.system, self.it = reference, reference.system, it
        self.most = self.early_most = -math.inf
        self.low, self.high = math.inf, -math.inf  # range of energy, last quarter of the run
        self.rise = self.early = self.away = 0.0
        self.steps, self.lost = 0, math.inf  # `lost`: when the run left the reference motion
        self.watch, self.status = Watch(self.system), it.status

    def follow(self, steps: int, h: float) -> Summary | None:
        """Continues the run to a total of `steps` steps. Returns the summary of the reference
        motion over the same time, or None if a step fails."""
        self.low, self.high = math.inf, -math.inf
        while self.steps < steps:
            rows = self.it.steps((steps + 1) * h, steps - self.steps)
            if not self._look(rows, steps // 8, steps - steps // 4):
                return None
            if self.it.failed or not len(rows):
                self.status = self.it.status
                return None
        self.reference.follow(self.it.t)
        motion = self.reference.summary(self.it.t)
        self.rise = max(self.most - motion.top, 0.0)
        self.early = max(self.early_most - motion.top, 0.0)
        self.away = max(self.low - motion.high, motion.low - self.high, 0.0)
        return motion

    def _look(self, rows: numpy.ndarray, early: int, late: int) -> bool:
        energy, _, _, parts = self.system.energies(rows[:, 0], rows[:, 1:])
        finite = numpy.isfinite(energy)
        good = len(rows) if finite.all() else int(finite.argmin())
        energy, states = energy[:good], rows[:good, 1:]
        if good:
            self.watch.look(self.system, states, parts[:good])
            self.most = max(self.most, float(energy.max()))
            if self.steps < early:
                first = float(energy[: early - self.steps].max())
                self.early_most = max(self.early_most, first)
            last = energy[max(late - self.steps, 0) :]
            self.low = min(self.low, float(last.min(initial=math.inf)))
            self.high = max(self.high, float(last.max(initial=-math.inf)))
            if math.isinf(self.lost) and not self.system.by_norm:
                lost = self.reference.apart_at(rows[:good])
                self.lost = math.inf if lost is None else lost
            self.steps += good
        if good < len(rows):
            self.status = NOT_FINITE
        return good == len(rows)

    @property
    def has_left(self) -> bool:
        return self.away > (self.high - self.low) / 4

    def grows(self, scale: float) -> bool:
        return self.rise > scale and (
            self.rise > 2 * self.early
            or self.away > scale / 2
            or self.has_left
            or self.rise > 1e4 * scale
        )


@numpy.errstate(all="ignore")
def classified(reference: Reference, method: str, h: float) -> Point:
    """Runs a method with step size h."""
    system = reference.system
    steps = int(min(max(math.ceil(system.until / h), LEAST_STEPS), MOST_STEPS))
    it = system.begin(method, h=h, watch=0 if system.by_norm else CONSTANTS)
    e = _Energies(reference, it)
    motion = None if it.failed else e.follow(steps, h)
    kind, scale = "bounded", (motion and motion.scale) or 1.0  # 0 if the motion is at rest
    others: dict[str, str | float | None] = {}
    if motion:
        if not reference.judges:
            kind = "not judged"
        elif e.grows(scale):
            kind = "growing"
        elif e.has_left and e.away > 1e-11 * motion.size:
            before, symmetric = e.away, it.report()["symmetric"]
            motion = e.follow(4 * steps, h) if symmetric else motion
            scale = (motion and motion.scale) or scale
            if not symmetric or (e.has_left and e.away > 1.2 * before):
                kind = "drifting"
        report = it.report()
        others = _others(reference, e, report["constants"])
        if others["exchange"] > TIMES and kind in ("bounded", "drifting"):
            kind = "exchange"
        elif others["moved"] > MOVED and kind == "bounded":
            kind = "constant lost"
    failed = motion is None
    return Point(
        method,
        h,
        FAILURES.get(e.status, "failed") if failed else kind,
        e.status if failed else "PK_DONE",
        e.steps,
        e.rise / scale,
        e.away / scale,
        0.0 if failed else report["cond"],
        **others,
    )


def _others(
    reference: Reference, e: _Energies, constants: list[dict]
) -> dict[str, str | float | None]:
    moved, constant = 0.0, ""
    if not e.system.by_norm:
        for mine, its in zip(constants, reference.report()["constants"], strict=True):
            if (far := _secular(mine, its)) > moved:
                moved, constant = far, mine["name"]
    follows = e.lost / reference.known if e.lost < reference.known else 1.0
    exchange = _exchange(e.system, e.watch.share, reference.watch.share)
    return {"exchange": exchange, "moved": moved, "follows": follows, "constant": constant}


def _exchange(system: System, mine: numpy.ndarray, its: numpy.ndarray) -> float:
    counts = ~system.idle[: system.m]
    if system.by_norm or counts.sum() < 2:
        return 0.0
    counts &= mine > SHARE * its.max()
    return float(numpy.sqrt(mine[counts] / its[counts]).max(initial=0.0))


def _secular(mine: dict[str, float | None], its: dict[str, float | None]) -> float:
    """Returns the largest change of a constant of motion in a method's run (`mine`), relative to
    the scale of the constant in the reference motion (`its`). Returns 0 if most of the change is no
    linear trend, if the constant has no scale, or if it varies in the reference motion."""
    numbers = *(mine[key] for key in ("max", "slope", "mean_t")), its["max"], its["scale"]
    if None in numbers:
        return 0.0
    most, slope, mean_t, unsteady, scale = numbers
    if not unsteady < STEADY * scale:  # Holds for a scale of 0 too.
        return 0.0
    far, steady = most / scale, abs(slope * 2 * mean_t / scale)
    return far if steady > SECULAR * far else 0.0
