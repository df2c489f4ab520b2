"""Computes the reference of a scene, a run at the tightest setting, and its error. The program of
the trials makes all runs.

Two runs of one method at different tolerances near round-off differ by the effect of round-off on
the motion, which every run in double precision has. A third run, by a method of another family,
shows whether both runs are wrong, as those of gauss across a kink. The reference is compared with
the other two runs; the smaller difference is its error. Linear equations have an exact flow: then
the first two runs take one step and two steps per row.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...record import record
from .candidates import Candidate, alone
from .trials import DENSE, LAND, Trial, Trials

EXACT = "exponential"
TOLERANCES = {"radau": (1e-13, 1e-12)}  # radau has order 5: tighter tolerances take too long
USUAL = (1e-15, 1e-14)
# A column has only numerical errors, and is 0 in theory, if its largest magnitude is below TINY
# times that of the largest column, and two references differ in it by more than NOISE times it.
NOISE = 0.1
TINY = 1e-10
FINER = 1e-3  # tolerance of runs in a wider type, relative to that of runs in double
DIGITS = " in more digits"
SLOWEST = 5.0  # most seconds of a run in a wider type
# If no method reaches the end, the reference is by the first method that gets at least this
# fraction of the way of the farthest method.
NEARLY = 0.2
FLOOR = 0.3  # largest error of a reference, relative to the accuracy
ROUNDED = 2.0**-49  # round-off of a matrix exponential, the same in each run
OTHER = 0.7  # longest step of the run for comparison, relative to the longest step of the reference
# The reference is wrong if it differs from the run by another method by more than WRONG times the
# difference of the reference's own two runs, at its step and at a shorter one, and by more than
# WRONG times the tolerance of the other method.
WRONG = 1e3


STEPS = 1000  # if the equations depend on time, the reference has at least this many steps


@record
class Task:
    trials: Trials
    able: tuple[Candidate, ...]  # methods that may be chosen
    exact: tuple[str, ...]  # methods for the reference, tried in order until one reaches the end
    damped: bool
    accuracy: float
    timed: bool = False  # whether the equations depend on time
    precise: Callable[[], Trials | None] = lambda: None  # returns trials in a wider type, or None

    @property
    def until(self) -> float:
        return self.trials.settings.until

    @property
    def every(self) -> float:
        """Returns the time between rows, or the duration of the scene if that is shorter."""
        return min(self.trials.settings.every or self.until, self.until)

    @property
    def max_step(self) -> float | None:
        """Returns a bound on the steps of the reference, or None. If the equations depend on time,
        the error control of long steps could miss short features of the equations."""
        return self.until / STEPS if self.timed else None


@record
class Check:
    """A reference up to the time `span`. `exact` is its run and `floor` its error. Up to the time
    `holds` this run and the run for comparison agree to FLOOR times the accuracy."""

    exact: Trial
    span: float
    every: float  # time between rows in trials; 0: as in the scene
    floor: float
    holds: float
    against: str  # method of the run for comparison, whose difference is `floor`
    ignored: tuple[int, ...] = ()  # columns that are 0 in theory: they have only numerical errors
    unsure: tuple[int, ...] = ()  # columns of expectations that are smaller than the errors
    ends: str = ""  # why no method reaches the end; "" if one does

    @property
    def method(self) -> str:
        return self.exact.method

    @property
    def in_more_digits(self) -> bool:
        """Whether trials are compared with the rows of a run in a type wider than double. (The run
        `exact` is always in double.)"""
        return self.against.endswith(DIGITS)

    def steady(self, asked: Task) -> bool:
        """Whether the motion is undamped, and round-off prevents the accuracy in every run."""
        return self.in_more_digits and not asked.damped


def setting(method: str, every: float, looser: bool = False) -> float:
    """Returns the setting of the reference, or with `looser` that of the run for comparison."""
    if method == EXACT:
        return every / 2 if looser else every
    return TOLERANCES.get(method, USUAL)[looser]


def other_steps(asked: Task) -> float | None:
    """Returns the bound on the steps of the run for comparison, or None. It is less than the bound
    of the reference, since two runs with equal steps would miss the same features."""
    return asked.max_step and OTHER * asked.max_step


def methods(structure: object, events: bool) -> tuple[str, ...]:
    """Returns the methods for the reference, to be tried in order until one reaches the end. If the
    scene has events, the exact flow is not among them: one step of it leads from a row to the next,
    and could miss an event in between."""
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

    def run(self, name: str, cap: float = 0.0, looser: bool = False) -> Trial:
        """Makes a run with the setting of the reference, or of the run for comparison."""
        how = setting(name, self.interval or self.asked.every, looser), cap
        return self.attempt(name, *how, other_steps(self.asked) if looser else self.asked.max_step)

    def farthest(self, cap: float) -> Trial:
        """Returns the run of the first method that reaches the end of the scene. If none does,
        shortens `span` to the part that is reached by the first method that gets far (NEARLY), and
        returns its run. Stiffness stops some methods early."""
        made = []
        for name in self.asked.exact:
            made.append(self.run(name, cap))
            if made[-1].arrived:
                return made[-1]
        slow = [t for t in made if t.slow]
        far = max(t.t for t in slow or made)
        first = next(t for t in slow or made if t.t >= NEARLY * far)
        if slow:
            self.span, self.interval = part(first.t, self.asked.every)
        return self.run(first.method) if slow and self.span > 0 else first

    def beside(self, name: str, cap: float) -> Trial:
        """Returns a run of another method than `name`, for comparison. The methods for the
        reference are tried from the last to the first, until one reaches the end."""
        for other in reversed([other for other in self.asked.exact if other != name]):
            trial = self.run(other, cap, looser=True)
            if trial.arrived:
                break
        return trial

    def in_more_digits(self, check: Check) -> Check:
        """Returns a check whose exact rows are those of a run in a scalar type wider than double.
        Methods differ in their round-off too, and with these rows it can be measured. The error of
        the check is the difference of two runs in the wider type.
        Returns `check` itself if there is no wider type, or if the error would not be smaller."""
        name, asked = "gauss" if check.method == EXACT else check.method, self.asked
        how = {"cap": SLOWEST, "every": self.interval}
        precise = precise_rows(asked, name, self.span, max_step=asked.max_step, **how)
        if precise is None:
            return check
        tolerance, steps = FINER * setting(name, 0.0, looser=True), other_steps(asked)
        again = precise.attempt(name, tolerance, LAND, self.span, max_step=steps, **how)
        if not again.error < check.floor:
            return check
        self.trials.exact = precise.exact
        return replace(check, floor=again.error, against=f"{name}{DIGITS}")


def precise_rows(asked: Task, name: str, span: float, **how: float | None) -> Trials | None:
    """Makes a tight run in a scalar type wider than double. Returns a Trials object in this type,
    with the rows of the run as exact rows. Returns None if no wider type is available, or if the
    run does not reach the end."""
    precise = asked.precise()
    if precise is None:
        return None
    precise.between, precise.ignored = asked.trials.between, asked.trials.ignored
    if not precise.attempt(name, FINER * setting(name, 0.0), LAND, span, **how).arrived:
        return None
    precise.keep_as_exact()
    return precise


def find(asked: Task, cap: float) -> Check:
    """Returns the reference over the whole duration, or over the part that it reaches in `cap`
    seconds. The Trials object keeps the reference's rows, to compare them with later runs."""
    finder = _Finder(asked)
    exact = finder.farthest(cap)
    if not exact.arrived:
        return Check(exact, exact.t, 0.0, float("inf"), 0.0, "", ends=exact.reason)
    dense = DENSE if "dense" in alone(exact.method).method.flags else LAND
    asked.trials.look_between(exact.method, exact.setting, dense, finder.span)
    scales = asked.trials.keep_as_exact()
    again = finder.run(exact.method, looser=True)
    beside = finder.beside(exact.method, max(5 * exact.seconds, cap))
    recorded = len(scales) - len(asked.trials.settings.watched.columns())
    ignored, expected = _noise([again, beside], scales), tuple(range(recorded, len(scales)))
    judge = _judge(again, beside, (*ignored, *expected), asked.accuracy)
    unsure = tuple(
        i for i in expected if i not in ignored and not judge.columns[i] <= FLOOR * asked.accuracy
    )
    asked.trials.ignored |= {*ignored, *unsure}
    if ignored or unsure:  # repeats the comparison without the ignored and unsure columns
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
    """Returns the factor by which errors grow from the end of the trials to the end of the scene.
    Errors grow linearly with time if the method is symplectic (`steady`; E. Hairer, C. Lubich, G.
    Wanner, Geometric Numerical Integration, X.3) or the motion is damped; else quadratically."""
    ratio = asked.until / check.span
    return ratio if steady or asked.damped else ratio**2


def _judge(again: Trial, beside: Trial, ignored: tuple[int, ...], accuracy: float) -> Trial:
    """Returns the run for comparison, `again` or `beside`: its difference from the reference is
    taken as the error of the reference."""
    own, other = _error(again, ignored), _error(beside, ignored)
    if not beside.arrived:
        return again
    able = beside.setting if beside.method != EXACT else 0.0
    if other > max(WRONG * own, WRONG * able, accuracy):
        return beside
    return again if own <= other else beside


def part(t: float, every: float) -> tuple[float, float]:
    """Returns a time below t that is a multiple of the time between rows, and this time between
    rows: 0 if it is `every`, that of the scene, or a fraction of `every`."""
    interval = every
    while interval * 8 > 0.9 * t:  # A trial would have too few rows.
        interval /= 2
    return int(0.9 * t / interval) * interval, interval if interval < every else 0.0


def _noise(agree: list[Trial], scales: tuple[float, ...]) -> tuple[int, ...]:
    def differ(i: int) -> float:
        """Returns the least nonzero difference of runs in column i. A difference of 0, between
        identical runs, says nothing on their errors."""
        return min((t.columns[i] for t in agree if t.arrived and t.columns[i] > 0), default=0.0)

    tiny = TINY * max(scales, default=0.0)
    return tuple(i for i, scale in enumerate(scales) if scale < tiny and differ(i) > NOISE)


def _error(trial: Trial, ignored: tuple[int, ...]) -> float:
    kept = [x for i, x in enumerate(trial.columns) if i not in ignored]
    return max(kept, default=0.0) if trial.arrived else float("inf")
