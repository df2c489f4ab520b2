"""Finds the loosest setting of each candidate that keeps the accuracy, over the time that the
reference covers, and the cheapest candidate at these settings.
"""

from __future__ import annotations

import math

from . import search
from .candidates import Candidate
from .reference import Check, Task, growth
from .search import Found
from .trials import Trial

# A trial keeps the accuracy if its error, plus twice the error of the reference, is at most MARGIN
# times the accuracy. The later run reproduces its trial, so the margin may be small.
MARGIN = 0.98
LEAST_CAP = 0.004  # a trial is never stopped before this many seconds
SLOWER = 1.3  # a candidate is given up if it costs this many times as much as the cheapest so far
# Candidates are timed in three rounds. A candidate takes part in a round if its cost is at most
# this many times the least cost.
NEAR = (3.0, 1.3, 1.3)
TIE = 1.05
# The first fixed step to try is the time between rows or, if shorter, this many mean steps of the
# reference: FIRST if the reference is by gauss, whose steps are long, else FIRST_OF_MANY.
FIRST, FIRST_OF_MANY = 4, 30
LAPS = 0.002  # a run is repeated for these seconds to measure its time


class Race:
    def __init__(self, asked: Task, check: Check):
        self.asked, self.check = asked, check
        self.best = math.inf

    def run(self) -> list[Found]:
        """Returns the results of all candidates, in the order of the table."""
        asked, check = self.asked, self.check
        aim, every = MARGIN * asked.accuracy - 2 * check.floor, check.every or asked.every
        found, first = [], FIRST if check.method == "gauss" else FIRST_OF_MANY
        stride = first * check.span / max(check.exact.steps, 1)
        # The method of the reference runs first: its time limits that of the other candidates.
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
        """Returns the candidates to run. If only the first part of the scene is tried and round-off
        prevents the accuracy, energy errors dominate after this part. Then only symplectic methods
        are run, whose energy errors stay bounded."""
        steady = self.check.steady(self.asked) and self.check.span < self.asked.until
        able = [c for c in self.asked.able if not steady or "symplectic" in c.method.flags]
        return able or list(self.asked.able)

    def _attempt(self, candidate: Candidate, setting: float) -> Trial:
        cap = max(LEAST_CAP, 2 * SLOWER * min(self.best, 4 * self.check.exact.seconds))
        run = candidate.name, setting, candidate.rows, self.check.span
        how = {"accuracy": self.asked.accuracy, "cap": cap, "every": self.check.every}
        return self.asked.trials.attempt(*run, **how)

    def cheapest(self, kept: list[Found]) -> Found:
        """Returns the first candidate in the table that costs about as little as the cheapest one.
        Candidates near the least cost are timed again in turns, since the first run of a candidate
        has cold caches."""
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
