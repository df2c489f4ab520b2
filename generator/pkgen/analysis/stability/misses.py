"""Describes each disagreement between a prediction and its measurement in a sentence."""

from __future__ import annotations

import math

from ...record import record
from ..linear.rest import UNDECIDED
from .map import StabilityMap
from .measure import FAILED, Growth, Measured, Row
from .predict import Prediction

TOLERANCE = 0.01  # a larger relative difference of prediction and measurement is a miss
LISTED = 4  # most resonances named in one sentence
NEXT = 0.03  # relative distance within which a failing point is near a prediction


@record
class Miss:
    method: str
    kind: str  # the kind of a prediction, or "response", "below", "above" or "growth"
    text: str


def difference(predicted: float | None, measured: float | None) -> float | None:
    """Returns the difference of the measured and the predicted step size, relative to the latter.
    If neither step size exists, it is 0; if only one exists, it is None."""
    if predicted is None or measured is None:
        return 0.0 if predicted is measured else None
    if predicted == 0:
        return 0.0 if measured < 1e-3 else None
    return measured / predicted - 1


def _missed(off: float | None, sharp: bool = True) -> bool:
    """Whether `off`, a result of difference(), is a miss. If `sharp` is false, the prediction is an
    estimate, which may be wrong by a factor of 2."""
    return off is None or (abs(off) > TOLERANCE if sharp else not -0.5 <= off <= 1)


def name_mode(p: Prediction) -> str:
    if p.mode is None:
        return "the cycle" if p.kind == "cycle" else "the fastest"
    return f"mode {p.mode + 1}" if p.other is None else f"modes {p.other + 1} and {p.mode + 1}"


def of_prediction(m: Measured) -> Miss | None:
    """Returns a Miss if the measurement differs from the prediction, else None."""
    p = m.prediction
    off = difference(p.h, m.h)
    if not _missed(off, p.sharp):
        return None
    what = {
        "limit": "the limit",
        "branch": "the loss of the solution",
        "cycle": "the loss of the cycle",
        "local": "the scale of the fastest that is resolved",
    }.get(p.kind, f"the {p.kind} resonance of {name_mode(p)}")
    said = "nowhere" if p.h is None else f"at h = {p.h:.6g}"
    found = f"nowhere ({m.how})" if m.h is None else f"at h = {m.h:.6g} ({m.how})"
    by = "" if off is None else f", {100 * off:+.2g} %"
    at = "along the motion" if p.equilibrium is None else f"at equilibrium {p.equilibrium + 1}"
    text = f"{p.method}: {what} {at} is predicted {said}, measured {found}{by}"
    return Miss(p.method, p.kind, text)


def unanswered(measured: tuple[Measured, ...], method: str) -> list[Miss]:
    """Returns a miss if modes rotate as predicted at resonances, but the motion does not grow."""
    silent = [m for m in measured if m.prediction.method == method and m.silent]
    if not silent:
        return []
    listed = [
        f"{m.prediction.kind} of {name_mode(m.prediction)} at h = {m.prediction.h:.5g}"
        for m in silent[:LISTED]
    ]
    if len(silent) > LISTED:
        listed.append(f"{len(silent) - LISTED} more")
    text = (
        f"{method}: nothing answers the step resonance {', '.join(listed)}: at the start's size "
        "the forces couple too little there"
    )
    return [Miss(method, "response", text)]


def of_growth(g: Growth) -> Miss | None:
    if not _missed(difference(g.predicted, g.measured)):
        return None
    text = (
        f"mode {g.mode + 1} leaves equilibrium {g.equilibrium + 1} at a rate of {g.measured:.6g}, "
        f"predicted is {g.predicted:.6g}"
    )
    return Miss("dop853", "growth", text)


def of_map(rows: tuple[Row, ...], method: str, varied: str) -> list[Miss]:
    """Returns a miss for points that fail below the stability limit of the row's primary
    equilibrium, and one for points that do not fail above it: the limit only holds for small
    motions."""
    below, above = [], []
    for row in rows:
        own = ("limit", method, row.primary)
        limits = [p for p in row.predictions if (p.kind, p.method, p.equilibrium) == own]
        for point in row.points if limits and row.motion.judges else ():
            limit = math.inf if limits[0].h is None else limits[0].h
            if point.method == method and point.h < (1 - TOLERANCE) * limit:
                below.append((row, point))
            elif point.method == method and point.h > (1 + TOLERANCE) * limit:
                above.append((row, point))
    found = []
    failing = [(row, p) for row, p in below if p.kind in FAILED]
    staying = [(row, p) for row, p in above if p.kind not in FAILED]
    if failing:
        row, p = min(failing, key=lambda pair: pair[0].x)
        text = (
            f"{method}: {len(failing)} of {len(below)} points below the limit fail; the lowest at "
            f"{varied} = {row.x:.4g}, h = {p.h:.4g}: {p.kind}{_close(row, method, p.h)}. The limit "
            "is that of small motions"
        )
        found.append(Miss(method, "below", text))
    if staying:
        row, p = max(staying, key=lambda pair: pair[1].h)
        text = (
            f"{method}: {len(staying)} of {len(above)} points above the limit stay; the furthest "
            f"at {varied} = {row.x:.4g}, h = {p.h:.4g}"
        )
        found.append(Miss(method, "above", text))
    return found


def _close(row: Row, method: str, h: float) -> str:
    """Returns a phrase that names the prediction nearest to the step size h, if its relative
    distance from h is at most NEXT."""
    near = [p for p in row.predictions if p.method == method and p.h and abs(h / p.h - 1) < NEXT]
    if not near:
        return ""
    p = min(near, key=lambda p: abs(h / (p.h or 1.0) - 1))
    return f", next to {p.kind} of {name_mode(p)} at h = {p.h:.4g}"


def unmeasured(made: StabilityMap) -> list[str]:
    """Returns a sentence that lists the predictions that were not measured."""
    seen = [m.prediction for m in made.measured]
    left = [f"{p.kind} of {p.method}" for p in made.predictions if p not in seen]
    growing = sum(m.growth > 0 for e in made.rest.equilibria for m in e.modes)
    left += ["growth rates"] if len(made.growths) < growing else []
    if not left:
        return []
    listed = ", ".join(dict.fromkeys(left[: 2 * LISTED])) + ", ..." * (len(left) > 2 * LISTED)
    done = f"{len(seen)} of {len(made.predictions)} predictions are measured"
    return [f"{done}; not measured: {listed} (--seconds allows for more)"]


def unpredicted(made: StabilityMap) -> str | None:
    """Returns the reason why the map has no predictions; None if it has some."""
    if made.predictions or made.growths or any(row.predictions for row in made.rows):
        return None
    found = made.rest
    if found.status == "PK_REFUSED":
        return f"no equilibria are sought: {unsought(made)}"
    if not found.equilibria:
        return "no equilibrium was found"
    if any(e.verdict == UNDECIDED for e in found.equilibria):
        return "the linear terms at the equilibria decide nothing"
    return "no mode oscillates, decays or grows"


def unsought(made: StabilityMap) -> str:
    """Returns the reason why no equilibria are sought."""
    if made.compilation.structure.autonomous:
        return "it has too many coordinates for the derivatives that a search needs"
    return "the equations depend on time or on inputs"


def misses(made: StabilityMap) -> list[Miss]:
    """Returns all disagreements of predictions and measurements in a stability map: limits measured
    elsewhere, resonances where nothing grows, points that are stable beyond a limit or unstable
    below it."""
    found = [miss for m in made.measured if (miss := of_prediction(m))]
    found += [miss for g in made.growths if (miss := of_growth(g))]
    for method in made.steps:
        found += unanswered(made.measured, method)
    for method in made.steps:
        found += of_map(made.rows, method, made.asked.axis.name)
    return found
