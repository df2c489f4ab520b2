"""The options of a map, its range of step sizes, and errors for maps that would show nothing."""

from __future__ import annotations

import math
from collections.abc import Iterable

from ...record import record
from ...run.settings import Settings
from ...system.exits import UsageError
from ..chart.points import ChartedMethod
from .ask import Motion
from .plan import Axis
from .predict import Prediction

MARGIN = 1.25  # the longest step size of a stability map, over the longest predicted limit
TURNS_UNLIMITED = 1.25  # in periods of the fastest mode: the longest step if there is no limit
MOST_STEPS = 2_000_000  # most steps of a run


@record
class MapOptions:
    """The parsed options."""

    settings: Settings
    axis: Axis
    across: int  # number of step sizes
    methods: tuple[ChartedMethod, ...]
    left: tuple[str, ...]  # sentences on methods that are not mapped
    steps: tuple[float, float] | None
    until: float | None
    period: float | None  # period of the driving force, if given as an option
    quick: bool
    seconds: float


def refuse_unjudged(motions: Iterable[Motion]) -> None:
    """Raises UsageError if no method can be judged by any of the reference motions, one per row of
    the map, since each leaves or ends early."""
    motions = iter(motions)
    first = next(motions, None)
    if first is None or first.judges or any(motion.judges for motion in motions):
        return
    if first.leaves:
        raise UsageError(
            f"the motion itself leaves: at t = {first.t:.6g} it is still going away and nothing of "
            "it comes back, so no method can be told by whether it stays. Give a start that "
            "stays by --start, or a longer --until if it comes back later"
        )
    raise UsageError(
        f"the motion itself ends at t = {first.t:.6g}: {first.status}. Give a shorter --until, "
        "or another start by --start"
    )


def steps_over(
    asked: MapOptions,
    predicted: list[Prediction],
    scales: list[str],
    fastest: float,
    until: float,
) -> list[float]:
    """Returns the step sizes of a map, evenly spaced: those of the options or, by default, up to
    MARGIN times the longest predicted limit. Raises UsageError."""
    count = asked.across
    if asked.steps:
        low, high = asked.steps
        _refuse_too_many(low, until)
        return [low + (high - low) * k / (count - 1) for k in range(count)]
    limits = [p.h for p in predicted if p.kind in ("limit", "cycle") and p.h]
    limits = limits or [2 * p.h for p in predicted if p.kind in scales and p.h]
    branches = [p.h for p in predicted if p.kind == "branch" and p.h]
    if limits:
        high = MARGIN * max(limits)
    elif fastest > 0:
        high = max(TURNS_UNLIMITED * 2 * math.pi / fastest, *(MARGIN * b for b in branches), 0.0)
    else:
        raise UsageError(
            "no mode oscillates or grows by the linear terms, nor anything along the motion by a "
            "rate of its own, so no step stands out: give --steps LO..HI"
        )
    _refuse_too_many(high / count, until)
    return [high * (k + 1) / count for k in range(count)]


def _refuse_too_many(shortest: float, until: float) -> None:
    if until / shortest > MOST_STEPS:
        raise UsageError(
            f"the shortest steps, {shortest:.3g}, would be {until / shortest:.3g} in all, above "
            f"{MOST_STEPS}: give a shorter --until, or longer --steps LO..HI"
        )
