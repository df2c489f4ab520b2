"""Chooses the method, with its step or tolerance, that keeps the `accuracy` of a scene at the least
cost.

1. A reference run is computed (reference.py) for the whole scene, or for its first part if the
   whole takes long.
2. The loosest setting that keeps the accuracy is found for each candidate method (candidates.py,
   search.py).
3. The cheapest candidates are timed. If several cost the same, the first in the table of candidates
   is chosen (race.py).
4. If only the first part was tried, a run of the whole scene with the choice is compared with a
   tighter run. The setting of the choice is tightened until it keeps the accuracy (whole.py).

If round-off prevents the accuracy (a chaotic motion, or a very tight accuracy), the choice is the
method and setting of the reference, with the time until which they keep the accuracy. If no method
reaches the end of the scene, the reference method is run, so that it reports the reason.
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

REFERENCE_SECONDS = 0.03  # if a reference takes longer, only the first part of the scene is tried


def choose(asked: Task, whole_seconds: float = SECONDS) -> Choice:
    """Makes the choice. Each trial of a whole scene may take `whole_seconds`."""
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
    """Returns the reference as the choice, with the time until which two of its runs agree."""
    if check.in_more_digits:
        return _farthest(asked, check, found)
    seconds = math.inf if check.ends else check.exact.seconds * asked.until / check.span
    trial = replace(check.exact, error=check.floor, seconds=seconds)
    horizon = None if check.ends or check.floor <= FLOOR * asked.accuracy else check.holds
    return _choice(asked, check, Kept(alone(check.method), trial, horizon), found)


def _farthest(asked: Task, check: Check, found: Sequence[Found]) -> Choice:
    """Runs the reference's method once more, as a trial. Returns the trial that keeps the accuracy
    for the longest time, among this one and all others."""
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
        expected=max(trial.error, check.floor),  # an error below that of the reference is unknown
        horizon=kept.horizon,
        check=check,
        found=tuple(found),
        seconds=asked.trials.spent,
        run_seconds=trial.seconds,
        without=asked.trials.without,
        max_step=trial.max_step,
    )
