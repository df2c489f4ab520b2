"""Finds the cheapest method, and its step or tolerance, for an accuracy.

A point is a run of a method at one setting. The answer is the cheapest point that keeps the
accuracy, if runs at slightly finer settings keep it too; else the point may be lucky. search.py
measures these finer runs. If no point qualifies, the answer is "none".
"""

from __future__ import annotations

from contextlib import suppress

from ...record import record
from ...system import children
from .points import AXES, ChartedMethod, Point, Track
from .search import Search
from .sweep import Bench

ACCURACIES = (1e-3, 1e-6, 1e-9, 1e-12)


@record
class Answer:
    """The answer for an accuracy. If no method keeps it, `point` is None and `reason` says why.
    `unmeasured` names methods that may be cheaper but were not measured in time."""

    accuracy: float
    axis: str
    method: ChartedMethod | None
    point: Point | None
    reason: str = ""
    unmeasured: tuple[str, ...] = ()


@record
class Beside:
    """The fastest answers of one other package, for each accuracy. If it has no answers, `why` is
    the reason."""

    name: str
    version: str
    takes: str  # description of the package's input; "" if pkgen's runtime contains its methods
    answers: tuple[Answer, ...] = ()
    why: str = ""


def answers(bench: Bench, tracks: list[Track]) -> tuple[list[Answer], list[Track]]:
    """Returns the cheapest method for every accuracy and measure of cost, and the points of every
    method (a Track each), including points that the search added."""
    search = Search(bench, tracks)
    told = [accuracy for accuracy in ACCURACIES if accuracy > 10 * bench.floor]
    with suppress(KeyboardInterrupt):
        for improve in (search.refine, search.time_again):
            for accuracy in told:
                improve(accuracy)
        _best(search, told)
    best = _best(search, told)  # after an interrupt effort.left() is 0: nothing more is measured
    found = [_answer(search, bench.floor, *asked, point) for asked, point in best.items()]
    return found, search.tracks(told)


def _best(search: Search, told: list[float]) -> dict[tuple[float, str], Point | None]:
    """Returns the cheapest point for each accuracy and measure of cost. To check a point, new
    points are measured, and a new point may be cheaper than another answer. Therefore the choice is
    repeated until no point is added."""
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
