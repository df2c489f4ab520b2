"""What a chart is for: which method, at which step or tolerance, is cheapest for an accuracy.

A curve foresees at which setting each method reaches the accuracy, and what that costs; the
foremost few are then measured at just that setting, and tightened if they miss. So every answer
is a run that was made and did meet it, with luck left out (Track.without_luck).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from .points import Method, Point, Track
from .sweep import Bench

ACCURACIES = (1e-3, 1e-6, 1e-9, 1e-12)
AXES = ("seconds", "work")
FOREMOST = 3
MARGIN = 0.7  # aimed at, of the accuracy
TRIALS = 4
ROUNDING = 1e-12  # of a quotient that is meant to be whole


@dataclass(frozen=True)
class Answer:
    """`point` is None where no method gets there; then `reason` says why."""

    accuracy: float
    axis: str
    method: Method | None
    point: Point | None
    reason: str = ""


def answers(bench: Bench, tracks: list[Track]) -> tuple[list[Answer], list[Track]]:
    """For every accuracy the cheapest by each measure; and the tracks, with what was measured for
    it among their points."""
    found: dict[float, dict[str, Point]] = {}
    for accuracy in ACCURACIES:
        met: dict[str, Point] = {}
        if accuracy > 10 * bench.floor:
            for track in _foremost(tracks, accuracy):
                point = _reach(bench, track, accuracy)
                if point is not None:
                    met[track.method.name] = point
        found[accuracy] = met
    methods = {track.method.name: track.method for track in tracks}
    told = [
        _best(accuracy, axis, met, methods, tracks, bench.floor)
        for accuracy, met in found.items()
        for axis in AXES
    ]
    return told, [_with(track, found) for track in tracks]


def _foremost(tracks: list[Track], accuracy: float) -> list[Track]:
    """The methods that are foreseen to be cheapest, by either measure."""
    chosen: dict[str, Track] = {}
    for axis in AXES:
        costs = [(track.cost_at(accuracy, axis), track) for track in tracks]
        able = sorted((c, t.method.name, t) for c, t in costs if c is not None)
        chosen.update({name: track for _, name, track in able[:FOREMOST]})
    return list(chosen.values())


def _reach(bench: Bench, track: Track, accuracy: float) -> Point | None:
    """A measured point that meets the accuracy, at the loosest setting that promises it."""
    method, aim = track.method, accuracy * MARGIN
    for _ in range(TRIALS):
        setting = track.setting_for(aim)
        if setting is None:
            break
        setting = _whole(bench, setting) if method.fixed else _two_digits(setting)
        point = bench.point(method, setting, cap=bench.effort.seconds / 4)
        if point.error is not None and point.error <= accuracy:
            return point
        aim *= MARGIN / 2
    # The curve itself has points that meet it.
    able = [p for worst, p in track.without_luck() if worst <= accuracy]
    return able[0] if able else None


def _whole(bench: Bench, step: float) -> float:
    """A step of which a whole number makes the time to go."""
    return bench.until / math.ceil(bench.until / step * (1 - ROUNDING))


def _two_digits(tolerance: float) -> float:
    """No more digits than a person would give, and no looser."""
    size = 10.0 ** (math.floor(math.log10(tolerance)) - 1)
    return float(f"{math.floor(tolerance / size * (1 + ROUNDING)) * size:.1e}")


def _best(
    accuracy: float,
    axis: str,
    met: dict[str, Point],
    methods: dict[str, Method],
    tracks: list[Track],
    floor: float,
) -> Answer:
    able = [p for p in met.values() if p.cost(axis) is not None]
    if able:
        point = min(able, key=lambda p: p.cost(axis) or 0.0)
        return Answer(accuracy, axis, methods[point.method], point)
    if accuracy <= 10 * floor:
        reason = f"cannot be told: the reference itself is known to {floor:.0e}"
    else:
        errors = [(p.error, p.method) for t in tracks for p in t.good if p.error is not None]
        best = min(errors, default=None)
        reason = (
            f"none; the most accurate is {best[1]}, with {best[0]:.1e}" if best else "none arrives"
        )
    return Answer(accuracy, axis, None, None, reason)


def _with(track: Track, found: dict[float, dict[str, Point]]) -> Track:
    """The track with the points that were measured for answers, in their places."""
    known = {p.setting for p in track.points}
    more = []
    for met in found.values():
        point = met.get(track.method.name)
        if point is not None and point.setting not in known:
            known.add(point.setting)
            more.append(point)
    points = sorted((*track.points, *more), key=lambda p: -p.setting)
    return Track(track.method, tuple(points))
