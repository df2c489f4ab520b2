"""Time at equal final error: what one method costs where it is as accurate as another.

A method's curve has a point a setting: the median final error over the starts, the median time. A
loose setting may be lucky, so its error counts as no smaller than those of all tighter settings.
Between the two settings that bracket an error, log time is linear in log error.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Point:
    setting: float
    error: float
    seconds: float


@dataclass(frozen=True)
class Match:
    """Seconds at an error, and the settings that bracket it. `bound` where the loosest setting
    is more accurate already: then the time is that of the loosest, an upper bound."""

    seconds: float
    between: tuple[float, float]
    bound: bool


def curve(
    settings: Sequence[float],
    errors: Sequence[Sequence[float]],
    seconds: Sequence[Sequence[float]],
) -> list[Point]:
    """Of settings from loose to tight; errors[i] and seconds[i] have a number a start."""
    points = [
        Point(s, statistics.median(e), statistics.median(t))
        for s, e, t in zip(settings, errors, seconds, strict=True)
    ]
    worst, out = 0.0, []
    for p in reversed(points):
        worst = max(worst, p.error)
        out.append(Point(p.setting, worst, p.seconds))
    return out[::-1]


def seconds_at(points: Sequence[Point], error: float) -> Match | None:
    """None where no setting reaches the error."""
    reached = next((i for i, p in enumerate(points) if p.error <= error), None)
    if reached is None:
        return None
    tight = points[reached]
    if reached == 0:
        return Match(tight.seconds, (tight.setting, tight.setting), tight.error < error)
    loose = points[reached - 1]
    if tight.error == 0 or not math.isfinite(loose.error):
        return Match(tight.seconds, (loose.setting, tight.setting), True)
    share = math.log(loose.error / error) / math.log(loose.error / tight.error)
    seconds = loose.seconds * (tight.seconds / loose.seconds) ** share
    return Match(seconds, (loose.setting, tight.setting), False)


@dataclass(frozen=True)
class Ratio:
    """Of two times, taken round by round: the median and the quartiles."""

    median: float
    low: float
    high: float


def ratio(numerators: Sequence[float], denominators: Sequence[float]) -> Ratio:
    found = sorted(a / b for a, b in zip(numerators, denominators, strict=True))
    low, high = quartiles(found)
    return Ratio(statistics.median(found), low, high)


def quartiles(values: Sequence[float]) -> tuple[float, float]:
    if len(values) < 2:
        return values[0], values[0]
    low, _, high = statistics.quantiles(values, n=4, method="inclusive")
    return low, high


def spread(values: Sequence[float]) -> float:
    """The distance of the quartiles relative to the median."""
    low, high = quartiles(values)
    return (high - low) / statistics.median(values)
