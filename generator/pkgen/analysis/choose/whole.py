"""Checks over the whole scene a choice that was made on its first part: compares it with a tighter
run, and tightens it until it keeps the accuracy. If even the tightest runs differ, finds the time
until which they agree.
"""

from __future__ import annotations

from dataclasses import replace

from ...record import record
from . import reference, search
from .candidates import Candidate, alone
from .choice import GivenUp
from .race import MARGIN
from .reference import FLOOR, Check, Task, growth
from .search import Found
from .trials import Trial

SECONDS = 5.0  # a trial of the whole scene that takes more seconds is given up
TIGHTER = 0.03  # intended error of the run for comparison, relative to the accuracy
SAME = 0.9  # two settings count as equal if the smaller is at least SAME times the larger
MENDED = 4  # a setting is tightened at most this many times


@record
class Kept:
    """A trial that keeps the accuracy to the end or, if `horizon` is not None, up to this time."""

    candidate: Candidate
    trial: Trial
    horizon: float | None = None


class TooLong(Exception):
    """The exception that is raised if a trial of the whole scene was stopped at its time limit."""

    def __init__(self, given_up: GivenUp):
        self.given_up = given_up


class Whole:
    """Trials over the whole scene. Methods raise TooLong if a trial takes more than `seconds`."""

    def __init__(self, asked: Task, check: Check, seconds: float):
        self.asked, self.check, self.seconds = asked, check, seconds

    def verified(self, best: Found | None, found: list[Found]) -> Kept:
        """Returns the checked choice. `best` is the result of the cheapest candidate on the first
        part of the scene; it is None if no candidate keeps the accuracy there."""
        # If the reference's error, extrapolated to the whole scene, is too large, two tight runs of
        # one method are compared. They may agree better, since their energy errors are the same.
        floor = self.check.floor * growth(self.asked, self.check, steady=False)
        if best is None or floor > FLOOR * self.asked.accuracy:
            return self._tightest()
        if self.check.steady(self.asked):
            return self._mended(best, [best], FLOOR * self.asked.accuracy)
        return self._mended(best, found, MARGIN * self.asked.accuracy - 2 * floor)

    def _mended(self, best: Found, found: list[Found], aim: float) -> Kept:
        """Compares the choice with the cheapest run that is much tighter. If the two differ by too
        much, both are tightened and compared again: the first part of the scene, on which the
        choice was made, may be easier than the rest."""
        judge = min((f for f in found if f.kept), key=lambda f: f.kept.seconds / _share(f))
        candidate = best.candidate
        whole = Found(candidate)
        scale = search.scale(candidate, self.asked.every)
        setting, judged = scale.allowed(best.kept.setting), self._tighter(judge, 1.0)
        for _ in range(MENDED):
            if judge.candidate == candidate and judged > SAME * setting:
                break  # there is no tighter setting
            if not self._run(judge.candidate, judged, self.asked.max_step).arrived:
                break
            self.asked.trials.keep_as_exact()
            trial = self._run(candidate, setting)
            whole.tried.append(trial)
            if trial.arrived and trial.error <= aim:
                return Kept(candidate, trial)
            setting = scale.allowed(search.next_setting(whole, aim))
            judged = self._tighter(judge, best.kept.setting / setting)
        return self._tightest()

    def _tightest(self) -> Kept:
        """Returns a run by the reference's method at a tolerance near round-off. The run is
        compared with a second one, in a wider type if there is one."""
        candidate, every = alone(self.check.method), self.asked.every
        setting = reference.setting(candidate.name, every)
        if self._in_more_digits(candidate):
            trial = self._run(candidate, setting, self.asked.max_step)
            keeps = trial.error <= self.asked.accuracy
            return Kept(candidate, trial, None if keeps or not trial.arrived else trial.holds)
        exact = self._run(candidate, setting, self.asked.max_step)
        if not exact.arrived:
            return Kept(candidate, exact)
        self.asked.trials.keep_as_exact()
        self.check = replace(self.check, against=candidate.name)
        setting = reference.setting(candidate.name, every, looser=True)
        agree = FLOOR * self.asked.accuracy
        trial = self._run(candidate, setting, reference.other_steps(self.asked), agree)
        keeps = trial.arrived and trial.error <= agree
        return Kept(candidate, trial, None if keeps else trial.holds)

    def _in_more_digits(self, candidate: Candidate) -> bool:
        """Replaces the exact rows by those of a run in a type wider than double. Returns whether
        this run was possible."""
        if candidate.name == reference.EXACT:
            return False
        how = {"cap": self.seconds, "max_step": reference.other_steps(self.asked)}
        precise = reference.precise_rows(self.asked, candidate.name, self.asked.until, **how)
        if precise is None:
            return False
        self.asked.trials.exact = precise.exact
        self.check = replace(self.check, against=f"{candidate.name}{reference.DIGITS}")
        return True

    def _run(
        self,
        candidate: Candidate,
        setting: float,
        max_step: float | None = None,
        accuracy: float | None = None,
    ) -> Trial:
        asked = self.asked
        run = candidate.name, setting, candidate.rows, asked.until
        how = {"accuracy": accuracy or asked.accuracy, "cap": self.seconds, "max_step": max_step}
        trial = asked.trials.attempt(*run, **how)
        if trial.slow:
            raise TooLong(GivenUp(trial.t, trial.took, asked.until))
        return trial

    def _tighter(self, found: Found, more: float) -> float:
        """Returns the setting of `found`, tightened so that the error is expected to become TIGHTER
        times as large; and further divided by `more`."""
        share = _share(found) if found.candidate.method.fixed else TIGHTER
        setting = found.kept.setting * share / more
        return search.scale(found.candidate, self.asked.every).allowed(setting)


def _share(found: Found) -> float:
    return TIGHTER ** (1 / max(found.candidate.method.order, 1))
