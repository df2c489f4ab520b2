"""Computes the reference of a scene, by the tightest runs of the scene's own program, and its
error.

Two runs of one method at tolerances near round-off differ by the effect of round-off on the motion,
which every run in double precision has; a method of another family shows whether both are wrong
(like gauss across a kink). The smaller of the two differences is the reference's error. Linear
equations have an exact flow: the two runs then take one and two steps per row.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...record import record
from .candidates import Candidate, alone
from .trials import DENSE, LAND, Trial, Trials

EXACT = "exponential"
TOLERANCES = {"radau": (1e-13, 1e-12)}  # of order 5, so tighter tolerances take too long
USUAL = (1e-15, 1e-14)
NOISE = 0.1  # least relative difference of two references in a column of mere errors
TINY = 1e-10  # largest scale of such a column, relative to the largest column
FINER = 1e-3  # tolerance in a wider type, relative to that in double
DIGITS = " in more digits"
SLOWEST = 5.0  # most seconds of a run in a wider type
NEARLY = 0.2  # the first method that gets as far as this part of the farthest is used
FLOOR = 0.3  # of the accuracy: largest error of a reference; two runs that differ less keep it
ROUNDED = 2.0**-49  # error of an exact flow by round-off of its coefficients, equal in all runs
OTHER = 0.7  # longest step of a run for comparison, relative to the exact run
WRONG = 1e3  # largest error of another method, relative to loose - tight or its tolerance


STEPS = 1000  # least number of steps of an exact run, if the equations depend on time


@record
class Task:
    trials: Trials
    able: tuple[Candidate, ...]  # methods that may be chosen
    exact: tuple[str, ...]  # methods for the reference, tried in order until one arrives
    damped: bool
    accuracy: float
    timed: bool = False  # whether the equations depend on time
    precise: Callable[[], Trials | None] = lambda: None  # returns trials in a wider type, or None

    @property
    def until(self) -> float:
        return self.trials.settings.until

    @property
    def every(self) -> float:
        """Returns the interval of rows, or the duration if that is shorter."""
        return min(self.trials.settings.every or self.until, self.until)

    @property
    def max_step(self) -> float | None:
        """Returns the longest step of the exact run, since error control may miss features shorter
        than a step; None: no bound."""
        return self.until / STEPS if self.timed else None


@record
class Check:
    """A reference up to the time `span`: `exact` is its run, `floor` its error; until the time
    `holds` two runs agree to FLOOR times the accuracy."""

    exact: Trial
    span: float
    every: float  # interval of rows in trials; 0: as in the scene
    floor: float
    holds: float
    against: str  # method of the run for comparison, which gave the floor
    ignored: tuple[int, ...] = ()  # columns that are zero except for errors
    unsure: tuple[int, ...] = ()  # columns of expectations that are smaller than the errors
    ends: str = ""  # reason if no method reaches the end

    @property
    def method(self) -> str:
        return self.exact.method

    @property
    def in_more_digits(self) -> bool:
        """Whether trials are compared with rows in a wider type (`exact` is a run in double)."""
        return self.against.endswith(DIGITS)

    def steady(self, asked: Task) -> bool:
        """Whether round-off prevents the accuracy in all runs of an undamped motion."""
        return self.in_more_digits and not asked.damped


def tight(method: str, every: float) -> float:
    return every if method == EXACT else TOLERANCES.get(method, USUAL)[0]


def loose(method: str, every: float) -> float:
    return every / 2 if method == EXACT else TOLERANCES.get(method, USUAL)[1]


def other_steps(asked: Task) -> float | None:
    """Returns the longest step of a run for comparison; equal ones miss the same features."""
    return asked.max_step and OTHER * asked.max_step


def methods(structure: object, events: bool) -> tuple[str, ...]:
    """Returns the methods for the reference, to be tried in order until one reaches the end. The
    exact flow is not used with events, which its long steps, from row to row, would miss."""
    if not getattr(structure, "smooth_in_pieces", False):
        return ("dop853", "dopri5")
    exact = (EXACT,) if getattr(structure, "affine", False) and not events else ()
    stiff = () if getattr(structure, "variational", False) else ("radau",)
    return (*exact, "gauss", *stiff, "dop853")


class _Finder:
    def __init__(self, asked: Task):
        self.asked, self.trials = asked, asked.trials
        self.span, self.interval = asked.until, 0.0

    def attempt(
        self, name: str, setting: float, cap: float = 0.0, max_step: float | None = None
    ) -> Trial:
        accuracy = FLOOR * self.asked.accuracy
        how = {"accuracy": accuracy, "cap": cap, "every": self.interval, "max_step": max_step}
        return self.trials.attempt(name, setting, LAND, self.span, **how)

    def tight(self, name: str, cap: float = 0.0) -> Trial:
        setting = tight(name, self.interval or self.asked.every)
        return self.attempt(name, setting, cap, self.asked.max_step)

    def loose(self, name: str, cap: float = 0.0) -> Trial:
        setting = loose(name, self.interval or self.asked.every)
        return self.attempt(name, setting, cap, other_steps(self.asked))

    def farthest(self, cap: float) -> Trial:
        """Returns the run of the first method that reaches the end. If none does, cuts the span to
        the part reached by the first method that gets nearly farthest: stiffness stops some methods
        early."""
        made = []
        for name in self.asked.exact:
            made.append(self.tight(name, cap))
            if made[-1].arrived:
                return made[-1]
        slow = [t for t in made if t.slow]
        far = max(t.t for t in slow or made)
        first = next(t for t in slow or made if t.t >= NEARLY * far)
        if slow:
            self.span, self.interval = part(first.t, self.asked.every)
        return self.tight(first.method) if slow and self.span > 0 else first

    def beside(self, name: str, cap: float) -> Trial:
        """Returns the run of another method, the last of those that reach the end."""
        for other in reversed([other for other in self.asked.exact if other != name]):
            trial = self.loose(other, cap)
            if trial.arrived:
                break
        return trial

    def in_more_digits(self, check: Check) -> Check:
        """Returns a check against two runs in a wider type: the error of runs in double is their
        round-off, which may be smaller for another method. Returns the same check if there is no
        wider type, or if these runs agree no better."""
        name, asked = "gauss" if check.method == EXACT else check.method, self.asked
        how = {"cap": SLOWEST, "every": self.interval}
        precise = precise_rows(asked, name, self.span, max_step=asked.max_step, **how)
        if precise is None:
            return check
        tolerance, steps = FINER * loose(name, 0.0), other_steps(asked)
        again = precise.attempt(name, tolerance, LAND, self.span, max_step=steps, **how)
        if not again.error < check.floor:
            return check
        self.trials.exact = precise.exact
        return replace(check, floor=again.error, against=f"{name}{DIGITS}")


def precise_rows(asked: Task, name: str, span: float, **how: float | None) -> Trials | None:
    """Returns trials in a wider type, with the rows of a tight run as exact rows; None if there is
    no wider type or the run does not reach the end."""
    precise = asked.precise()
    if precise is None:
        return None
    precise.between, precise.ignored = asked.trials.between, asked.trials.ignored
    if not precise.attempt(name, FINER * tight(name, 0.0), LAND, span, **how).arrived:
        return None
    precise.keep_as_exact()
    return precise


def find(asked: Task, cap: float) -> Check:
    """Returns the reference over the whole duration, or over the part that it reaches in `cap`
    seconds. Stores its rows in the trials."""
    finder = _Finder(asked)
    exact = finder.farthest(cap)
    if not exact.arrived:
        return Check(exact, exact.t, 0.0, float("inf"), 0.0, "", ends=exact.reason)
    dense = DENSE if "dense" in alone(exact.method).method.flags else LAND
    asked.trials.look_between(exact.method, exact.setting, dense, finder.span)
    scales = asked.trials.keep_as_exact()
    again = finder.loose(exact.method)
    beside = finder.beside(exact.method, max(5 * exact.seconds, cap))
    recorded = len(scales) - len(asked.trials.settings.watched.columns())
    ignored, expected = _noise([again, beside], scales), tuple(range(recorded, len(scales)))
    judge = _judge(again, beside, (*ignored, *expected), asked.accuracy)
    unsure = tuple(
        i for i in expected if i not in ignored and not judge.columns[i] <= FLOOR * asked.accuracy
    )
    for column in (*ignored, *unsure):
        asked.trials.ignore(column)
    if ignored or unsure:  # the comparison is repeated without these columns
        judge = finder.attempt(judge.method, judge.setting, max_step=judge.max_step)
    floor, rounded = _error(judge, (*ignored, *unsure)), ROUNDED if exact.method == EXACT else 0.0
    check = Check(
        exact=exact,
        span=finder.span,
        every=finder.interval,
        floor=max(floor, rounded),
        holds=judge.holds if floor >= rounded else 0.0,
        against=judge.method,
        ignored=ignored,
        unsure=unsure,
    )
    if floor * growth(asked, check, steady=False) <= FLOOR * asked.accuracy:
        return check
    return finder.in_more_digits(check)


def growth(asked: Task, check: Check, steady: bool) -> float:
    """Returns the factor on errors from the span of the trials to the end: linear in time if the
    method conserves energy (E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, X.3)
    or the motion is damped; else quadratic."""
    ratio = asked.until / check.span
    return ratio if steady or asked.damped else ratio**2


def _judge(again: Trial, beside: Trial, ignored: tuple[int, ...], accuracy: float) -> Trial:
    """Returns the run whose difference from the reference is the reference's error."""
    own, other = _error(again, ignored), _error(beside, ignored)
    if not beside.arrived:
        return again
    able = beside.setting if beside.method != EXACT else 0.0
    if other > max(WRONG * own, WRONG * able, accuracy):
        return beside
    return again if own <= other else beside


def part(t: float, every: float) -> tuple[float, float]:
    """Returns a span of whole intervals below t, and their length (0: that of the scene's rows)."""
    count = int(0.9 * t / every)
    if count >= 8:
        return count * every, 0.0
    # With few rows, their intervals are divided.
    interval = every
    while interval * 8 > 0.9 * t:
        interval /= 2
    return int(0.9 * t / interval) * interval, interval


def _noise(agree: list[Trial], scales: tuple[float, ...]) -> tuple[int, ...]:
    def differ(i: int) -> float:
        """Returns the least difference in column i, except 0: identical runs show no errors."""
        return min((t.columns[i] for t in agree if t.arrived and t.columns[i] > 0), default=0.0)

    tiny = TINY * max(scales, default=0.0)
    return tuple(i for i, scale in enumerate(scales) if scale < tiny and differ(i) > NOISE)


def _error(trial: Trial, ignored: tuple[int, ...]) -> float:
    kept = [x for i, x in enumerate(trial.columns) if i not in ignored]
    return max(kept, default=0.0) if trial.arrived else float("inf")
