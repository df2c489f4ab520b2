"""`accuracy` in a scene: which method, at which step or tolerance, keeps it at the least cost.

1. A reference (reference.py), over the whole scene where that takes little time, else over a part.
2. Each candidate (candidates.py) at the loosest setting that keeps the accuracy (search.py).
3. Those that may be the cheapest are timed; of equals the first of the table is taken (race.py).
4. Where only a part was tried, the choice is compared over the whole scene with a tighter run, and
   its setting mended until it is kept (whole.py).

Where round-off forbids it (a chaotic motion, an accuracy near it), the reference itself is the
choice, with the time to which it holds. Where no method arrives the reference is run, to say why.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from . import reference
from .candidates import alone
from .choice import Choice
from .race import Race
from .reference import FLOOR, Check, Task
from .search import Found
from .whole import SECONDS, Kept, TooLong, Whole

REFERENCE_SECONDS = 0.03  # that the reference may take; else a part of the scene is tried


def choose(asked: Task, whole_seconds: float = SECONDS) -> Choice:
    """Trials of a whole scene may take so many seconds each."""
    check = reference.find(asked, REFERENCE_SECONDS)
    if check.ends or check.floor > FLOOR * asked.accuracy:
        return _reference(asked, check, [])
    race = Race(asked, check)
    found = race.run()
    kept = [f for f in found if f.kept is not None]
    best = race.cheapest(kept) if kept else None
    if check.span == asked.until:
        if best is None:
            return _reference(asked, check, found)
        return _choice(asked, check, Kept(best.candidate, best.kept), found)
    try:
        whole = Whole(asked, check, whole_seconds)
        made = whole.verified(best, found)
    except TooLong as too_long:
        candidate, trial = (
            (best.candidate, best.kept) if best else (alone(check.method), check.exact)
        )
        foreseen = trial.seconds * asked.until / check.span
        trial = replace(trial, error=math.inf, seconds=foreseen)
        choice = _choice(asked, check, Kept(candidate, trial), found)
        return replace(choice, given_up=too_long.given_up)
    if made.horizon is not None:
        check = whole.check
    if not made.trial.arrived:
        check = replace(check, ends=made.trial.reason)
    return _choice(asked, check, made, found)


def _reference(asked: Task, check: Check, found: Sequence[Found]) -> Choice:
    """No other run keeps it: the reference itself, and until when two of them agree."""
    if check.in_more_digits:
        return _farthest(asked, check, found)
    seconds = math.inf if check.ends else check.exact.seconds * asked.until / check.span
    trial = replace(check.exact, error=check.floor, seconds=seconds)
    horizon = None if check.ends or check.floor <= FLOOR * asked.accuracy else check.holds
    return _choice(asked, check, Kept(alone(check.method), trial, horizon), found)


def _farthest(asked: Task, check: Check, found: Sequence[Found]) -> Choice:
    """Of all runs, the reference's own among them, the one that keeps it longest."""
    exact, own = check.exact, alone(check.method)
    how = {"accuracy": asked.accuracy, "every": check.every, "max_step": exact.max_step}
    again = asked.trials.attempt(exact.method, exact.setting, exact.rows, check.span, **how)
    tried = [(own, again), *((f.candidate, t) for f in found for t in f.tried if t.arrived)]
    candidate, trial = max(tried, key=lambda pair: (pair[1].holds, -pair[1].error))
    keeps = trial.error <= asked.accuracy
    return _choice(asked, check, Kept(candidate, trial, None if keeps else trial.holds), found)


def _choice(asked: Task, check: Check, kept: Kept, found: Sequence[Found]) -> Choice:
    candidate, trial = kept.candidate, kept.trial
    return Choice(
        accuracy=asked.accuracy,
        method=candidate.name,
        rows=candidate.rows,
        setting=trial.setting,
        fixed=candidate.method.fixed,
        expected=max(trial.error, check.floor),  # it is known no better than that
        horizon=kept.horizon,
        check=check,
        found=tuple(found),
        seconds=asked.trials.spent,
        run_seconds=trial.seconds,
        without=asked.trials.without,
        max_step=trial.max_step,
    )
