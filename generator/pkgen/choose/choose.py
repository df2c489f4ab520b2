"""Which method, at which setting, for a scene that promises an accuracy.

1. A reference (reference.py), over the whole scene where that takes little time, else over a part.
2. Each candidate (candidates.py) at the loosest setting that keeps the accuracy (search.py).
3. Those that may be the cheapest are timed; of equals the first of the table is taken.
4. Where only a part was tried, the choice is compared over the whole scene with a tighter run, and
   its setting mended until it is kept.

Where round-off forbids it (a chaotic motion, an accuracy near it), the reference itself is the
choice, with the time to which it holds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

from ..build import build_program
from ..chart.chart import methods as all_methods
from ..compiler import Compilation
from ..ensemble import Ensemble
from ..exits import NumericsFailed
from ..simulate import Settings, columns
from . import reference, sample, search
from .candidates import Candidate, candidates
from .reference import Check
from .search import Found
from .trials import LAND, Trial, Trials

REFERENCE_SECONDS = 0.03  # that the reference may take; else a part of the scene is tried
MARGIN = 0.98  # of the accuracy, what a run is to keep beside twice the reference's own error:
# the run that is chosen has itself been compared, and makes the same numbers again
FLOOR = 0.3  # of the accuracy: a reference of a larger error forbids it
LEAST_CAP = 0.004  # seconds; a trial that takes less is not given up
SLOWER = 1.3  # than the cheapest: not followed any further
NEAR = (3.0, 1.3, 1.3)  # times the cheapest: timed again, in so many rounds
TIE = 1.05
LAPS = 0.002  # seconds
WHOLE_SECONDS = 5.0  # that a trial of the whole scene may take; else what is chosen is not verified
TIGHTER = 0.03  # of the accuracy: the error of what a choice is compared with over the whole
MENDED = 4  # times that the setting is mended there


@dataclass(frozen=True)
class Choice:
    """`expected` is the error of this very run beside a tighter one."""

    accuracy: float
    method: str
    rows: str
    setting: float
    fixed: bool
    expected: float
    horizon: float | None  # None: it is kept to the end
    check: Check
    found: tuple[Found, ...]
    seconds: float  # of the processor, for all trials
    run_seconds: float  # foreseen
    compiled_for: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()  # columns that are zero but for errors
    sampled: int = 0  # members that were tried, of an ensemble
    of: tuple[str, ...] = ()  # the coordinates of a part; none: it is of all
    unverified: float | None = None  # until when it was tried, where the whole takes too long

    def settings(self, given: Settings) -> Settings:
        """What is run, by the program that the trials were made with."""
        chosen = {"method": self.method, "rows": self.rows, "compiled_for": self.compiled_for}
        if self.fixed:
            return replace(given, **chosen, step=self.setting)
        atol = self.check.small * self.setting
        return replace(given, **chosen, step=None, rtol=self.setting, atol=atol)


def for_scene(
    compilation: Compilation, settings: Settings, ensemble: Ensemble | None
) -> Choice | None:
    """None where nothing is promised. Raises BuildError, NumericsFailed."""
    if settings.accuracy is None:
        return None
    methods = all_methods(None)
    able = candidates(compilation.structure, methods)
    names = tuple(dict.fromkeys(c.name for c in able))
    program = build_program(compilation.files, compilation.model.name, *names)
    if ensemble is not None:
        able = [c for c in able if c.rows == LAND]
        return of_members(program, settings, ensemble, compilation.structure, able)
    found = choose(program, settings, compilation.structure, able, settings.accuracy)
    shown = [c.name for c in columns(compilation, show=settings.show)[1:]]
    left_out = tuple(shown[i] for i in found.check.ignored)
    return replace(found, compiled_for=names, left_out=left_out)


def of_members(
    program: Path,
    settings: Settings,
    ensemble: Ensemble,
    structure: object,
    able: list[Candidate],
) -> Choice:
    """By trials of a few members: the method of that which takes longest, at the tightest setting
    that any of them needs, with some to spare for those that were not tried."""
    # Without an interval members have two rows, and so have their trials.
    settings = replace(settings, every=settings.every or settings.until)
    some = sample.members(settings, ensemble)
    accuracy = sample.SPARE * settings.accuracy
    tried = [choose(program, one, structure, able, accuracy) for one in some]
    longest = max(tried, key=lambda c: c.run_seconds)
    only = [c for c in able if c.name == longest.method]
    same = [
        c if c.method == longest.method else choose(program, one, structure, only, accuracy)
        for one, c in zip(some, tried, strict=True)
    ]
    horizons = [c.horizon for c in same if c.horizon is not None]
    again = [c for c in same if c not in tried]
    return replace(
        longest,
        accuracy=settings.accuracy,
        setting=min(c.setting for c in same),
        expected=max(c.expected for c in same),
        horizon=min(horizons, default=None),
        seconds=sum(c.seconds for c in (*tried, *again)),
        sampled=len(some),
    )


def choose(
    program: Path,
    settings: Settings,
    structure: object,
    able: list[Candidate],
    accuracy: float,
) -> Choice:
    """Raises NumericsFailed where not even the reference arrives."""
    with Trials(program, settings) as trials:
        return _Chooser(trials, settings, structure, able, accuracy).choose()


class TooLong(Exception):
    """A trial of the whole scene was given up."""


class _Chooser:
    def __init__(
        self,
        trials: Trials,
        settings: Settings,
        structure: object,
        able: list[Candidate],
        accuracy: float,
    ):
        self.trials, self.settings, self.structure = trials, settings, structure
        self.able, self.accuracy = able, accuracy
        self.until = settings.until
        self.every = min(settings.every or settings.until, settings.until)
        self.spent = 0.0
        self.best = math.inf

    def choose(self) -> Choice:
        names = reference.methods(self.structure)
        check, made = reference.find(
            self.trials, names, self.until, self.every, self.accuracy, REFERENCE_SECONDS
        )
        self.spent += sum(t.took for t in made)
        if check is None:
            raise NumericsFailed(f"no method finds the motion: {made[0].reason}")
        self.check = check
        whole = check.span == self.until
        found = self._race(check)
        kept = [f for f in found if f.kept is not None]
        if check.floor > FLOOR * self.accuracy or not kept:
            return self._horizon(found)
        best = self._cheapest(kept)
        if whole:
            return self._kept(best.candidate, best.kept, found)
        try:
            if self._floor() > FLOOR * self.accuracy:
                return self._tightest(found, MARGIN * self.accuracy)
            return self._verify(best, found)
        except TooLong:
            growth = self.until / check.span
            seconds = best.kept.seconds * growth
            setting = best.kept.setting
            made = self._choice(best.candidate, setting, math.inf, seconds, found, None)
            return replace(made, unverified=check.span)

    def _race(self, check: Check) -> list[Found]:
        """Each candidate's loosest setting over the span of the reference."""
        if check.floor > FLOOR * self.accuracy:
            return []
        aim = MARGIN * self.accuracy - 2 * check.floor
        found = []
        # First what the reference found to be able, so that others are given up soon.
        for candidate in sorted(self.able, key=lambda c: c.name != check.method):
            growth = self._growth(candidate)
            one = search.loosest(
                candidate,
                aim / growth,
                self._start(candidate, aim / growth),
                check.every or self.every,
                SLOWER * self.best,
                self._attempt,
            )
            if one.kept is not None:
                self.best = min(self.best, one.kept.seconds)
            found.append(one)
        return sorted(found, key=lambda f: self.able.index(f.candidate))

    def _growth(self, candidate: Candidate) -> float:
        """From the span of the trials to the end: errors grow linearly where the method keeps the
        energy (E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, X.3), or where
        the motion is damped; else with the square."""
        ratio = self.until / self.check.span
        steady = "symplectic" in candidate.method.flags or self._damped()
        return ratio if steady else ratio**2

    def _damped(self) -> bool:
        return not getattr(self.structure, "variational", False)

    def _floor(self) -> float:
        """What the reference's own error grows to: two tight runs of one method over the whole
        scene would agree by more, for they share what their steps do to the energy."""
        return self.check.floor * (self.until / self.check.span) ** (1 if self._damped() else 2)

    def _start(self, candidate: Candidate, aim: float) -> float:
        if not candidate.method.fixed:
            return aim
        return self.check.every or self.every

    def _attempt(self, candidate: Candidate, setting: float) -> Trial:
        cap = max(LEAST_CAP, 2 * SLOWER * min(self.best, 4 * self.check.seconds))
        trial = self.trials.attempt(
            candidate.name,
            setting,
            candidate.rows,
            self.check.span,
            accuracy=self.accuracy,
            cap=cap,
            every=self.check.every,
        )
        self.spent += trial.took
        return trial

    def _cheapest(self, kept: list[Found]) -> Found:
        """The first that ties with the cheapest: those that may be it are timed in turns, for the
        first run of any pays for what is not yet in the processor's memory."""
        seconds = {id(f): f.kept.seconds for f in kept}
        near = kept
        for times in NEAR:
            least = min(seconds.values())
            near = [f for f in near if seconds[id(f)] <= times * least]
            for f in near if len(near) > 1 else ():
                again = self.trials.attempt(
                    f.kept.method,
                    f.kept.setting,
                    f.kept.rows,
                    self.check.span,
                    laps=min(LAPS, 10 * f.kept.seconds),
                    every=self.check.every,
                )
                self.spent += again.took
                seconds[id(f)] = min(seconds[id(f)], again.seconds)
        least = min(seconds[id(f)] for f in near)
        return next(f for f in near if seconds[id(f)] <= TIE * least)

    def _verify(self, best: Found, found: list[Found]) -> Choice:
        """The choice over the whole scene, beside a tighter run: that which is foreseen to be the
        cheapest. Where they differ by too much both are tightened, for the part that was tried may
        have been an easy one."""
        judge = min((f for f in found if f.kept), key=_tighter_cost)
        candidate, aim = best.candidate, MARGIN * self.accuracy - 2 * self._floor()
        whole = Found(candidate)
        scale = search.scale(candidate, self.every)
        setting, judged = scale.allowed(best.kept.setting), self._tighter(judge, 1.0)
        for _ in range(MENDED):
            self._whole(judge.candidate, judged)
            self.trials.keep_as_exact()
            trial = self._whole(candidate, setting)
            whole.tried.append(trial)
            if trial.arrived and trial.error <= aim:
                return self._kept(candidate, trial, found)
            setting = scale.allowed(search.next_setting(whole, aim))
            judged = self._tighter(judge, best.kept.setting / setting)
        return self._tightest(found, aim)

    def _tightest(self, found: list[Found], aim: float) -> Choice:
        """The reference's method over the whole scene, near round-off twice."""
        candidate = _alone(self.check.method)
        self._whole(candidate, reference.tight(candidate.name))
        self.trials.keep_as_exact()
        trial = self._whole(candidate, reference.loose(candidate.name))
        keeps = trial.arrived and trial.error <= aim
        return self._kept(candidate, trial, found, None if keeps else trial.holds)

    def _whole(self, candidate: Candidate, setting: float) -> Trial:
        trial = self.trials.attempt(
            candidate.name,
            setting,
            candidate.rows,
            self.until,
            accuracy=self.accuracy,
            cap=WHOLE_SECONDS,
        )
        self.spent += trial.took
        if trial.slow:
            raise TooLong
        return trial

    def _tighter(self, found: Found, more: float) -> float:
        """A setting at which the error is much smaller, and the setting that times `more`."""
        setting = found.kept.setting * TIGHTER ** (1 / _power(found.candidate)) / more
        return search.scale(found.candidate, self.every).allowed(setting)

    def _horizon(self, found: list[Found]) -> Choice:
        """No run keeps it: the reference itself, and until when two of them agree."""
        check = self.check
        return self._choice(
            _alone(check.method),
            check.setting,
            check.floor,
            check.seconds * self.until / check.span,
            found,
            horizon=check.holds,
        )

    def _kept(
        self, candidate: Candidate, trial: Trial, found: list[Found], horizon: float | None = None
    ) -> Choice:
        return self._choice(candidate, trial.setting, trial.error, trial.seconds, found, horizon)

    def _choice(
        self,
        candidate: Candidate,
        setting: float,
        expected: float,
        seconds: float,
        found: list[Found],
        horizon: float | None,
    ) -> Choice:
        return Choice(
            accuracy=self.accuracy,
            method=candidate.name,
            rows=candidate.rows,
            setting=setting,
            fixed=candidate.method.fixed,
            expected=expected,
            horizon=horizon,
            check=self.check,
            found=tuple(found),
            seconds=self.spent,
            run_seconds=seconds,
        )


def _alone(name: str) -> Candidate:
    return Candidate(all_methods([name])[0], LAND, "the reference itself")


def _power(candidate: Candidate) -> int:
    return max(candidate.method.order, 1) if candidate.method.fixed else 1


def _tighter_cost(found: Found) -> float:
    return found.kept.seconds * TIGHTER ** (-1 / max(found.candidate.method.order, 1))
