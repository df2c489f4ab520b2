"""Each candidate at the loosest setting that keeps the accuracy over the span of the reference, and
which of them is the cheapest."""

from __future__ import annotations

import math

from . import search
from .candidates import Candidate
from .reference import Check, Task, growth
from .search import Found
from .trials import Trial

MARGIN = 0.98  # of the accuracy, what a run is to keep beside twice the reference's own error:
# the run that is chosen has itself been compared, and makes the same numbers again
LEAST_CAP = 0.004  # seconds; a trial that takes less is not given up
SLOWER = 1.3  # than the cheapest: not followed any further
NEAR = (3.0, 1.3, 1.3)  # times the cheapest: timed again, in so many rounds
TIE = 1.05
# Times the reference's steps: of fixed ones the first, where rows are farther apart. Those of gauss
# are nearly as long as any method's can be.
FIRST, FIRST_OF_MANY = 4, 30
LAPS = 0.002  # seconds


class Race:
    def __init__(self, asked: Task, check: Check):
        self.asked, self.check = asked, check
        self.best = math.inf

    def run(self) -> list[Found]:
        """All candidates, in their order."""
        asked, check = self.asked, self.check
        aim, every = MARGIN * asked.accuracy - 2 * check.floor, check.every or asked.every
        found, first = [], FIRST if check.method == "gauss" else FIRST_OF_MANY
        stride = first * check.span / max(check.exact.steps, 1)
        # First what the reference found to be able, so that others are given up soon.
        for candidate in sorted(self._able(), key=lambda c: c.name != check.method):
            accuracy = aim / growth(asked, check, "symplectic" in candidate.method.flags)
            start = min(every, stride) if candidate.method.fixed else accuracy
            limit = SLOWER * self.best
            one = search.loosest(candidate, accuracy, start, every, limit, self._attempt)
            if one.kept is not None:
                self.best = min(self.best, one.kept.seconds)
            found.append(one)
        return sorted(found, key=lambda f: asked.able.index(f.candidate))

    def _able(self) -> list[Candidate]:
        """Where it is round-off that forbids the accuracy to tight runs, errors of the energy are
        what grows behind the part that is tried: those stay that keep it."""
        steady = self.check.steady(self.asked) and self.check.span < self.asked.until
        able = [c for c in self.asked.able if not steady or "symplectic" in c.method.flags]
        return able or list(self.asked.able)

    def _attempt(self, candidate: Candidate, setting: float) -> Trial:
        cap = max(LEAST_CAP, 2 * SLOWER * min(self.best, 4 * self.check.exact.seconds))
        run = candidate.name, setting, candidate.rows, self.check.span
        how = {"accuracy": self.asked.accuracy, "cap": cap, "every": self.check.every}
        return self.asked.trials.attempt(*run, **how)

    def cheapest(self, kept: list[Found]) -> Found:
        """The first that ties with the cheapest: those that may be it are timed in turns, for the
        first run of any pays for what is not yet in the processor's memory."""
        seconds = {id(f): f.kept.seconds for f in kept}
        near = kept
        for times in NEAR:
            least = min(seconds.values())
            near = [f for f in near if seconds[id(f)] <= times * least]
            for f in near if len(near) > 1 else ():
                run = f.kept.method, f.kept.setting, f.kept.rows, self.check.span
                laps = min(LAPS, 10 * f.kept.seconds)
                again = self.asked.trials.attempt(*run, laps=laps, every=self.check.every)
                seconds[id(f)] = min(seconds[id(f)], again.seconds)
        least = min(seconds[id(f)] for f in near)
        return next(f for f in near if seconds[id(f)] <= TIE * least)
