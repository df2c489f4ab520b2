"""What a chart is for: which method, at which step or tolerance, is cheapest for an accuracy.

The answer is the cheapest of all points measured that keep the accuracy and not by luck: so do the
runs a little finer (search.py, which measures what is missing). "None" is said where no point does.
"""

from __future__ import annotations

from ...record import record
from ...system import children
from .points import AXES, ChartedMethod, Point, Track
from .search import Search
from .sweep import Bench

ACCURACIES = (1e-3, 1e-6, 1e-9, 1e-12)


@record
class Answer:
    """`point` is None where no method gets there; then `reason` says why. `unmeasured` names the
    methods that could be cheaper and for which there was no time."""

    accuracy: float
    axis: str
    method: ChartedMethod | None
    point: Point | None
    reason: str = ""
    unmeasured: tuple[str, ...] = ()


def answers(bench: Bench, tracks: list[Track]) -> tuple[list[Answer], list[Track]]:
    """For every accuracy the cheapest by each measure; and the tracks, with what was measured for
    it among their points."""
    search = Search(bench, tracks)
    told = [accuracy for accuracy in ACCURACIES if accuracy > 10 * bench.floor]
    try:
        for accuracy in told:
            search.refine(accuracy)
        for accuracy in told:
            search.time_again(accuracy)
        best = _best(search, told)
    except KeyboardInterrupt:  # no more is measured then
        best = _best(search, told)
    found = [_answer(search, bench.floor, *asked, point) for asked, point in best.items()]
    return found, search.tracks(told)


def _best(search: Search, told: list[float]) -> dict[tuple[float, str], Point | None]:
    """Judging may measure new points, which change other answers: repeated until none does."""
    count = -1
    while count != search.measured:
        count = search.measured
        best = {
            (a, x): search.cheapest(a, x) if a in told else None for a in ACCURACIES for x in AXES
        }
    return best


def _answer(
    search: Search, floor: float, accuracy: float, axis: str, point: Point | None
) -> Answer:
    if point is not None:
        others = search.unmeasured(accuracy, axis)
        return Answer(accuracy, axis, search.methods[point.method], point, unmeasured=others)
    if accuracy <= 10 * floor:
        reason = f"cannot be told: the reference itself is known to {floor:.0e}"
    else:
        best = min(search.good(), key=lambda p: p.error or 0.0, default=None)
        if best is None:
            reason = "none arrives"
        elif (best.error or 0.0) > accuracy:
            late = " in the time (--seconds)" if search.left <= 0 else ""
            late = " before the interrupt" if children.ended() else late
            reason = f"none{late}; the most accurate is {best.method}, with {best.error:.1e}"
        else:
            reason = f"none but by luck, such as {best.method}, with {best.error:.1e}"
    others = search.unmeasured(accuracy, axis) if accuracy > 10 * floor else ()
    return Answer(accuracy, axis, None, None, reason, others)
