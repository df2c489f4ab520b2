"""The motion of a scene, by the tightest runs of the program itself: what trials are compared with,
and how far it can be trusted.

Two runs of one method at tolerances near round-off differ by what round-off makes of the motion,
which no double-precision run is without; a method of another family says whether the two are both
wrong (as gauss is across a kink). The smaller of these differences is the reference's own error.
"""

from __future__ import annotations

from dataclasses import dataclass

from .trials import LAND, Trial, Trials

TOLERANCES = {"radau": (1e-13, 1e-12)}  # of order 5: no tighter
USUAL = (1e-15, 1e-14)
NOISE = 0.1  # a column is nothing but errors where two references differ by that much of it,
TINY = 1e-10  # and it is that small beside others
SMALL_UNITS = 1e-3  # where what is recorded is no larger, absolute tolerances are cut likewise
WRONG = 1e3  # times that two runs of one method differ, another method must not differ by


@dataclass(frozen=True)
class Check:
    """A reference up to `span`. `floor` is its own error, `holds` until when two runs agreed to the
    accuracy."""

    method: str
    setting: float
    span: float
    every: float  # between rows of trials; 0: the scene's
    floor: float
    holds: float
    seconds: float
    against: str  # what the floor is from
    ignored: tuple[int, ...]  # columns that are zero but for errors
    small: float  # absolute tolerances over relative ones


def tight(method: str) -> float:
    return TOLERANCES.get(method, USUAL)[0]


def loose(method: str) -> float:
    return TOLERANCES.get(method, USUAL)[1]


def methods(structure: object) -> tuple[str, ...]:
    """What may be exact, in turns until one arrives."""
    if not getattr(structure, "smooth", False):
        return ("dop853", "dopri5")
    if not getattr(structure, "variational", False):
        return ("gauss", "radau", "dop853")
    return ("gauss", "dop853")


class _Finder:
    def __init__(self, trials: Trials, until: float, every: float, accuracy: float):
        self.trials, self.until, self.every, self.accuracy = trials, until, every, accuracy
        self.span, self.interval = until, 0.0
        self.made: list[Trial] = []

    def attempt(self, name: str, setting: float, cap: float = 0.0) -> Trial:
        trial = self.trials.attempt(
            name,
            setting,
            LAND,
            self.span,
            accuracy=self.accuracy,
            cap=cap,
            every=self.interval,
        )
        self.made.append(trial)
        return trial

    def farthest(self, names: tuple[str, ...], cap: float) -> Trial:
        """The first method that arrives, or a part of the way by that which came farthest: what is
        stiff stops one long before another."""
        for name in names:
            if self.attempt(name, tight(name), cap).arrived:
                return self.made[-1]
        first = max(self.made, key=lambda t: t.t if t.slow else 0.0)
        self.span, self.interval = part(first.t, self.every)
        return self.attempt(first.method, first.setting) if self.span > 0 else first

    def scaled(self, exact: Trial) -> tuple[Trial, tuple[float, ...], float]:
        """With absolute tolerances that are small beside what is recorded, made exact."""
        scales = self.trials.keep_as_exact()
        small = min((x for x in scales if x > TINY * max(scales)), default=1.0)
        if small >= SMALL_UNITS:
            return exact, scales, 1.0
        self.trials.absolute(small)
        exact = self.attempt(exact.method, exact.setting)
        return exact, self.trials.keep_as_exact(), small


def find(
    trials: Trials, names: tuple[str, ...], until: float, every: float, accuracy: float, cap: float
) -> tuple[Check | None, list[Trial]]:
    """Over the whole duration, or as far as `cap` seconds reach; exact rows stay in `trials`."""
    finder = _Finder(trials, until, every, accuracy)
    exact = finder.farthest(names, cap)
    if not exact.arrived:
        return None, finder.made
    exact, scales, small = finder.scaled(exact)
    name = exact.method
    again = finder.attempt(name, loose(name))
    other = next(n for n in names if n != name)
    beside = finder.attempt(other, loose(other), max(5 * exact.seconds, cap))
    ignored = _noise([again, beside], scales)
    for column in ignored:
        trials.ignore(column)
    judge = _judge(again, beside, ignored, accuracy)
    check = Check(
        method=name,
        setting=exact.setting,
        span=finder.span,
        every=finder.interval,
        floor=_error(judge, ignored),
        holds=judge.holds,
        seconds=exact.seconds,
        against=judge.method,
        ignored=ignored,
        small=small,
    )
    return check, finder.made


def _judge(again: Trial, beside: Trial, ignored: tuple[int, ...], accuracy: float) -> Trial:
    """The run that says how far the reference can be trusted."""
    own, other = _error(again, ignored), _error(beside, ignored)
    if not beside.arrived:
        return again
    if other > max(WRONG * own, accuracy):
        return beside
    return again if own <= other else beside


def part(t: float, every: float) -> tuple[float, float]:
    """A span below t of whole intervals, and their length; 0: the scene's own."""
    count = int(0.9 * t / every)
    if count >= 8:
        return count * every, 0.0
    # A scene of few rows: its intervals are cut.
    interval = every
    while interval * 8 > 0.9 * t:
        interval /= 2
    return int(0.9 * t / interval) * interval, interval


def _noise(agree: list[Trial], scales: tuple[float, ...]) -> tuple[int, ...]:
    columns = [t.columns for t in agree if t.arrived]
    if not columns:
        return ()
    return tuple(
        i
        for i, scale in enumerate(scales)
        if scale < TINY * max(scales) and min(c[i] for c in columns) > NOISE
    )


def _error(trial: Trial, ignored: tuple[int, ...]) -> float:
    kept = [x for i, x in enumerate(trial.columns) if i not in ignored]
    return max(kept, default=0.0) if trial.arrived else float("inf")
