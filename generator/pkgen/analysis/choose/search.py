"""Finds the loosest setting of one method that keeps an accuracy on a scene, by a few trials.

An error is proportional to a power of the step or tolerance: the method's order, or if there are
two trials, the slope between them. The next setting is extrapolated with this power, between the
tightest setting that missed the accuracy and the loosest that kept it. The search ends if a looser
setting would save little time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from ..chart.points import ChartedMethod
from ..chart.scale import divided, pieces, slope
from .candidates import Candidate
from .trials import Trial

TRIALS = 8
AIM = 0.85  # intended error of a trial, relative to the accuracy
LOST = 0.1  # an error above this is not proportional to a power of the setting
BLIND = 3.0  # after an error above LOST, the step is divided by BLIND
GAIN = 1.05  # least speedup for which another trial is made
LOOSEST, TIGHTEST = 0.5, 2.0**-51
# Factors on the setting if the first trial of a method is too slow. A tolerance is multiplied by
# LOOSENED, since the error may be far smaller than necessary. A step is multiplied by SHORTENED,
# since the implicit equations of long steps take long to solve.
LOOSENED, SHORTENED = 100.0, 0.25
ITERATIONS = 40  # an implicit step is assumed to take rtol^(-1/ITERATIONS) iterations
FURTHEST = 1e5  # largest factor on the setting from one trial to the next


@dataclass
class Found:
    """The result of the search for one candidate. `kept` is the trial with the loosest setting that
    keeps the accuracy. If the candidate does not keep it, or would take too long, `kept` is None
    and `verdict` is the reason."""

    candidate: Candidate
    kept: Trial | None = None
    verdict: str = ""
    tried: list[Trial] = field(default_factory=list)


Attempt = Callable[[Candidate, float], Trial]


def loosest(
    candidate: Candidate,
    accuracy: float,
    start: float,
    interval: float,
    limit: float,
    attempt: Attempt,
) -> Found:
    """Finds the loosest setting of a candidate that keeps the accuracy. `start` is the first
    setting to try. A fixed step must divide `interval`. A setting that is expected to take more
    than `limit` seconds is not tried."""
    steps = scale(candidate, interval)
    found = Found(candidate)
    setting = steps.allowed(start)
    missed: Trial | None = None
    for _ in range(TRIALS):
        trial = attempt(candidate, setting)
        found.tried.append(trial)
        first = len(found.tried) == 1
        if trial.slow and first and steps.other:
            setting = steps.allowed(setting * steps.other)
            continue
        if trial.refused or trial.slow:
            found.verdict = trial.reason if trial.refused else "slower"
            break
        if trial.arrived and trial.error <= accuracy:
            found.kept = trial
        else:
            missed = trial
        wanted = next_setting(found, accuracy)
        setting, kept = steps.between(wanted, found.kept, missed), found.kept
        if setting is None:
            break
        if kept and (setting <= kept.setting or steps.gain(kept, setting) < GAIN):
            break
        if not found.kept and trial.arrived:
            setting = steps.affordable(trial, setting, limit)
            if setting is None and first and steps.other and candidate.method.fixed:
                setting = steps.between(trial.setting * steps.other, None, trial)
            if setting is None:
                found.verdict = "slower"
                break
    if not found.kept and not found.verdict:
        best = min((t.error for t in found.tried), default=math.inf)
        last = found.tried[-1]
        found.verdict = f"no better than {best:.1e}" if last.arrived else last.reason
    return found


def scale(candidate: Candidate, interval: float) -> _Steps | _Tolerances:
    method = candidate.method
    return _Steps(interval, method) if method.fixed else _Tolerances(method)


def next_setting(found: Found, accuracy: float) -> float:
    """Returns the setting that is expected to just keep the accuracy."""
    trial = found.tried[-1]
    fixed = found.candidate.method.fixed
    power = float(max(found.candidate.method.order, 1)) if fixed else 1.0
    if not trial.arrived or trial.error > LOST:
        return trial.setting / (BLIND if fixed else BLIND**4)
    if not trial.error > 0:
        return trial.setting * FURTHEST
    known = sorted(
        (t for t in found.tried if t.arrived and 0 < t.error <= LOST), key=lambda t: t.setting
    )
    if len(known) > 1:
        at = known.index(trial) if trial in known else 0
        other = known[at - 1] if at else known[1]
        if other.setting != trial.setting:
            power = min(max(slope(other, trial), power / 3), 1.5 * power)
    factor = (AIM * accuracy / trial.error) ** (1 / power)
    return trial.setting * min(max(factor, 1 / FURTHEST), FURTHEST)


class _Steps:
    """Fixed steps, which divide the interval between rows."""

    def __init__(self, interval: float, method: ChartedMethod):
        self.interval = interval
        self.other = SHORTENED if method.implicit else None

    def allowed(self, setting: float) -> float:
        return divided(self.interval, setting)

    def between(self, wanted: float, kept: Trial | None, missed: Trial | None) -> float | None:
        count = pieces(self.interval, wanted)
        low = 0 if missed is None else self._count(missed)
        high = math.inf if kept is None else self._count(kept)
        if high - low <= 1:
            return None
        return self.interval / min(max(low + 1, count), high - 1)

    def _count(self, trial: Trial) -> int:
        return round(self.interval / trial.setting)

    def affordable(self, trial: Trial, setting: float, limit: float) -> float | None:
        """Returns the step to try after `trial`: `setting` or, if a run with this step would take
        more than `limit` seconds, the shortest step that does not. Returns None if this is no
        shorter than the step of `trial`. Half of the time of `trial` is assumed not to depend on
        its step."""
        if not limit < math.inf:
            return setting
        most = math.floor(self._count(trial) * (2 * limit / trial.seconds - 1))
        count = min(round(self.interval / setting), most)
        return self.interval / count if count > self._count(trial) else None

    def gain(self, kept: Trial, setting: float) -> float:
        return setting / kept.setting


class _Tolerances:
    other: float | None = LOOSENED

    def __init__(self, method: ChartedMethod):
        self.order, self.implicit = max(method.order, 1), method.implicit

    def allowed(self, setting: float) -> float:
        return min(max(setting, TIGHTEST), LOOSEST)

    def between(self, wanted: float, kept: Trial | None, missed: Trial | None) -> float | None:
        low = TIGHTEST if kept is None else kept.setting
        high = LOOSEST if missed is None else missed.setting
        if missed is not None and missed.setting <= TIGHTEST:
            return None
        if kept is not None and missed is not None and not low < wanted < high:
            wanted = math.sqrt(low * high)
        wanted = min(max(wanted, low), high)
        if missed is not None and wanted >= missed.setting:
            wanted = math.sqrt(low * high)
        if kept is not None and wanted <= kept.setting:
            return None
        return wanted

    def affordable(self, trial: Trial, setting: float, limit: float) -> float | None:
        return setting if trial.seconds <= limit else None

    def gain(self, kept: Trial, setting: float) -> float:
        """Returns the expected speedup by `setting` instead of the setting of the trial `kept`. If
        every step ends at the next row, the number of steps stays the same. Then only an implicit
        method is faster, since it needs fewer iterations."""
        power = self.order
        if kept.steps <= 1.02 * (kept.compared - 1):
            power = ITERATIONS if self.implicit else math.inf
        return (setting / kept.setting) ** (1 / power)
