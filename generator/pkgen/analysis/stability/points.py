"""Classifies a method's run at one step size, mostly by its energy E. E0 is the initial energy, S
the range of v.p over the reference motion (twice the varying kinetic energy), [a, b] the range of E
in the last quarter of the run, and R = |v.p| + |L| a bound on E, to which round-off is relative:

away distance of E0 from [a, b] rise max E - E0; early: max E - E0 in the first eighth of the run
growing rise > S, and it continues (rise > 2 early), or E does not return (away > S/2 or away > (b -
a)/4), or rise is larger than any beat (rise > 1e4 S) drifting not growing, away > (b - a)/4 and
away > 1e-11 R exchange not growing, and the amplitude of a coordinate is TIMES that in the
reference motion constant lost not drifting, and a constant other than E has changed by MOVED
bounded otherwise: E returns to E0

A drift smaller than 2.2 times the oscillation of E is not detected. Near a step resonance the
oscillation of E may be slower than the run: a symplectic or symmetric method is `drifting` only if
`away` is a fifth larger in a run four times as long. If the energy of the model is not constant, E0
is replaced by energies of the reference motion: the range in its last quarter, and the maximum. A
run has at least LEAST_STEPS steps; the reference motion lasts as long. If the reference motion
leaves or ends, the run is `not judged`. Below its stability limit, Verlet's energy may rise by
E0/(1 - y^2/4) and return, which is bounded. The other classes are failures of the steps.

The share of a coordinate is its largest |v_i p_i|. Only coordinates with a share above SHARE of the
largest count:

exchange square root of the ratio of the shares in the run and in the reference motion moved largest
secular change of a proved constant, relative to its scale (pk/diagnostics.h) follows fraction of
the time, up to the horizon, for which the run stays near the motion
"""

from __future__ import annotations

import math

import numpy

from ...run.integration import CONSTANTS, Integration
from ...system.exits import UsageError
from .reference import SHARE, Reference, Summary, Watch
from .system import MOST_STEPS, System

LEAST_STEPS = 200
TIMES = 3.0  # least amplitude ratio that counts as exchange of energy
MOVED = 1e-2  # relative change above which a constant counts as lost
STEADY = 1e-6  # largest relative change of a constant in the reference motion
SECULAR = 0.5  # least part of the change that is a linear trend, not an oscillation
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


class _Energies:
    """The energies of a method's run so far, and its other measures."""

    def __init__(self, reference: Reference, it: Integration):
        self.reference, self.system, self.it = reference, reference.system, it
        self.most = self.early_most = -math.inf
        self.low, self.high = math.inf, -math.inf  # range of energy in the last quarter
        self.rise = self.early = self.away = 0.0
        self.steps, self.lost = 0, math.inf  # `lost`: time of departure from the motion
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
def classified(reference: Reference, method: str, h: float) -> dict[str, str | float | None]:
    """Runs a method with step size h; returns the fields of a Point (ask.py)."""
    system = reference.system
    if not reference.followed:
        raise UsageError("ask for the motion first")
    steps = int(min(max(math.ceil(system.until / h), LEAST_STEPS), MOST_STEPS))
    it = system.begin(method, h=h, watch=0 if system.by_norm else CONSTANTS)
    e = _Energies(reference, it)
    motion = None if it.failed else e.follow(steps, h)
    kind, scale = "bounded", motion.scale if motion else 1.0
    others: dict[str, str | float | None] = {}
    if motion:
        if not reference.judges:
            kind = "not judged"
        elif e.grows(scale):
            kind = "growing"
        elif e.has_left and e.away > 1e-11 * motion.size:
            before, symmetric = e.away, it.report()["symmetric"]
            motion = e.follow(4 * steps, h) if symmetric else motion
            scale = motion.scale if motion else scale
            if not symmetric or (e.has_left and e.away > 1.2 * before):
                kind = "drifting"
        report = it.report()
        others = _others(reference, e, report["constants"])
        if others["exchange"] > TIMES and kind in ("bounded", "drifting"):
            kind = "exchange"
        elif others["moved"] > MOVED and kind == "bounded":
            kind = "constant lost"
    failed = motion is None
    return others | {
        "method": method,
        "h": h,
        "kind": FAILURES.get(e.status, "failed") if failed else kind,
        "status": e.status if failed else "PK_DONE",
        "steps": e.steps,
        "rise": e.rise / scale,
        "away": e.away / scale,
        "cond": 0.0 if failed else report["cond"],
    }


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
    """Returns the largest change of a constant, relative to its scale in the reference motion, if
    most of it is a linear trend; else 0, also if the constant has no scale or varies in that
    motion."""
    numbers = *(mine[key] for key in ("max", "slope", "mean_t")), its["max"], its["scale"]
    if None in numbers:
        return 0.0
    most, slope, mean_t, unsteady, scale = numbers
    if not scale > 0 or not unsteady < STEADY * scale:
        return 0.0
    far, steady = most / scale, abs(slope * 2 * mean_t / scale)
    return far if steady > SECULAR * far else 0.0
