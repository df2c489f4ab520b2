"""Computes the points of the map, row by row, and measures each prediction on the model itself. The
measurement depends on the kind of the prediction:

limit      The run starts near the equilibrium, displaced along all modes that do not grow by 1e-6
           of the displacement of the model's start. The limit is the step size from which on the
           displacement grows by a factor of 1000 in 4000 steps.
resonance  The step size at which the mode's leading coordinate rotates by the predicted angle per
           step, averaged over hundreds of steps. Whether the motion grows at the resonance is
           measured by other runs, with larger displacements.
branch     The shortest step near the equilibrium that fails.
growth     The growth rate of a reference motion that starts displaced along the mode.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from ...record import record
from ..linear.rest import Rest
from .ask import Asker, Motion
from .method import FURTHEST, LEAP, combined, first_change
from .orbits import ROUNDED
from .points import FAILURES, Point
from .predict import RESONANCES, Prediction

SMALL = 1e-6  # amplitude of small motions, relative to the displacement of the start
LEAST = 1e-8  # smaller amplitudes, relative to the largest coordinate, are too close to round-off
STEPS = 4000
LONGER = 100  # just beyond a limit growth is slow: runs there have this many times more steps
FAR = 1e3
LOOKS = 16  # points of the coarse search for a step size
FINE = 1e-6  # relative precision of a step size found by search
# A resonance has a response if the motion grows this many times more than at step sizes beside it.
RESPONDS = 1.3
LOST = 0.5  # a motion with a larger energy error, relative to the range of v.p, is lost
FAILED = {"growing", "failed", *FAILURES.values()} - {"refused"}
BESIDE = 0.06  # step sizes within this relative distance of a resonance are scanned for a response


@record
class Effort:
    """The effort spent on the measurement of a resonance."""

    turns: int  # number of steps over which the rotation angle is averaged
    scan: int  # number of step sizes, near the resonance, at which a response is sought
    steps: int  # number of steps of each run that seeks a response
    sizes: tuple[float, ...]  # amplitudes of these runs, relative to the start's displacement


FULL = Effort(1000, 17, 1500, (0.02, 0.1, 0.5))
QUICK = Effort(500, 9, 700, (0.1, 0.5))


@record
class Row:
    """The predictions and measured points at one value of the varied quantity."""

    x: float
    rest: Rest
    primary: int | None
    motion: Motion
    predictions: tuple[Prediction, ...]
    points: tuple[Point, ...]  # the points of all methods, each in ascending step size


@record
class Measured:
    """A prediction, and the step size h at which the predicted event was measured. If the event did
    not happen, h is None."""

    prediction: Prediction
    h: float | None
    how: str  # how the measured event showed, in words
    response: float | None = None  # growth at a resonance, relative to that beside it
    peak: float | None = None  # step size at which the growth near a resonance is largest

    @property
    def silent(self) -> bool:
        """Whether the prediction is a resonance at which the motion does not grow."""
        return self.response is not None and self.response < RESPONDS


@record
class Growth:
    """The predicted and measured growth rate of a mode at an equilibrium."""

    equilibrium: int
    mode: int
    predicted: float
    measured: float


def row(
    asker: Asker,
    steps: dict[str, Sequence[float]],
    known: Rest | None,
    tries: int,
    linear: bool = False,
) -> tuple[Rest, Motion, tuple[Point, ...]]:
    """Returns the equilibria, the reference motion and the points of a row. The equilibria are
    `known`; if this is None, they are searched."""
    found, moved = known or asker.rest(tries), asker.motion()
    points = [asker.point(name, h) for name, hs in steps.items() for h in hs]
    return found, moved, tuple(_settled(asker, p) if linear else p for p in points)


def _settled(asker: Asker, point: Point) -> Point:
    """Changes the class of a "growing" point of a linear model to "wrong amplitude" if no
    eigenvalue of the method's step is outside the unit circle. Then the run settles at a finite but
    wrong amplitude, since long steps sample the driving force coarsely."""
    if point.kind != "growing":
        return point
    found = radius(asker, point.method, point.h)
    settles = found is not None and found <= 1 + ROUNDED
    return replace(point, kind="wrong amplitude") if settles else point


def radius(asker: Asker, method: str, h: float) -> float | None:
    """Returns the spectral radius of the linear map by which a step on a linear model changes the
    difference of two states. A driving force has no effect on this difference. Returns None if a
    step fails."""
    import numpy

    states = [asker.start, *(asker.start + numpy.eye(len(asker.start)))]
    question = {"method": method, "h": h, "count": 1, "amplitude": 1e-3}
    after = [asker.beside(state=y, **question) for y in states]
    if any(status != "PK_DONE" for status, *_ in after):
        return None
    first, *others = (state for *_, state in after)
    return float(max(abs(numpy.linalg.eigvals([y - first for y in others]))))


def small(at: Rest, cyclic: frozenset[int], size: float) -> float:
    """Returns an amplitude so small that the motion is linear, but above round-off: SMALL times
    `size`, the distance of the start from the equilibrium. If `size` is 0, it is replaced by the
    largest coordinate of any equilibrium."""
    largest = max(
        (abs(x) for e in at.equilibria for i, x in enumerate(e.q) if i not in cyclic), default=0.0
    )
    return max(SMALL * (size or largest or 1.0), LEAST * largest)


def measured(
    asker: Asker,
    at: Rest,
    prediction: Prediction,
    size: float,
    amplitude: float,
    effort: Effort = FULL,
    bound: bool = False,
) -> Measured:
    """Measures a prediction on the model. `size` is the displacement of the start, `amplitude` that
    of small motions; `bound` means that the model has rotations or constraints."""
    if prediction.known:
        return Measured(prediction, *prediction.known)
    if prediction.equilibrium is None:
        return _local(asker, prediction, bound)
    asker = asker.at(at.equilibria[prediction.equilibrium])
    if prediction.kind == "limit":
        return _limit(asker, at, prediction, amplitude)
    if prediction.kind == "branch":
        return _branch(asker, prediction, amplitude)
    return _resonance(asker, prediction, size, amplitude, effort)


def growths(asker: Asker, at: Rest, amplitude: float) -> list[Growth]:
    """Measures each growing mode by a reference motion that starts at a tenth of `amplitude`."""
    found = []
    for e, place in enumerate(at.equilibria):
        here = asker.at(place)
        for k, mode in enumerate(place.modes):
            if mode.growth > 0:
                found.append(Growth(e, k, mode.growth, here.leave(k, amplitude / 10)))
    return found


def _limit(asker: Asker, at: Rest, p: Prediction, amplitude: float) -> Measured:
    fastest = at.equilibria[p.equilibrium].modes[p.mode].rate
    steps = 100 if p.h is None else STEPS
    status = "PK_DONE"  # status of the last run that grew

    def grows(h: float) -> bool:
        nonlocal status
        close = asker.near(method=p.method, h=h, amplitude=amplitude, count=steps)
        bad = close.status != "PK_DONE" or not close.growth < FAR
        status = close.status if bad else status
        return bad

    if p.h is None:
        hs = [FURTHEST * part / fastest for part in (0.05, 0.1, 0.25, 0.5, 0.9)]
        bad = next(filter(grows, hs), None)
        if bad is None:
            return Measured(p, None, f"stable up to h |lambda| = {hs[-1] * fastest:.3g}")
        h = _search(grows, 0.0, bad)
    elif p.h == 0:
        h = _search(grows, 0.0, 0.5 / fastest)
    elif not any(grows(p.h * x) for x in (0.5, 0.7, 0.9, 0.999)) and grows(1.001 * p.h):
        h = _search(grows, 0.999 * p.h, 1.001 * p.h)  # growth may be limited to a narrow interval
    else:
        h = _search(grows, 0.5 * p.h, 1.5 * p.h)
        if h is None or h > 1.005 * p.h:
            steps *= LONGER
            narrow = grows(1.0001 * p.h)
            h = _search(grows, 0.995 * p.h, 1.0001 * p.h if narrow else h or 1.5 * p.h)
    if h is None:
        return Measured(p, None, "no growth up to 1.5 times the prediction")
    return Measured(p, h, "growth" if status == "PK_DONE" else status)


def _local(asker: Asker, p: Prediction, bound: bool) -> Measured:
    """Measures the first step size, between 1/8 and 8 times the prediction, at which the method
    fails or its error reaches LOST. The error is that of the energy, relative to the range of v.p.
    If `bound` is set, it is the error of the state after LEAP steps, relative to the width of the
    region of the motion."""
    assert p.h is not None
    asker = asker.with_settings(asker.settings)  # a copy, since other threads use the original
    if not bound and not asker.motion().judges:
        return Measured(p, None, "the motion itself ends or leaves")
    kind = ""

    def lost(h: float) -> bool:
        nonlocal kind
        if bound:
            status, off = asker.resolved(p.method, h, LEAP)
            failed = status != "PK_DONE"
            bad = failed or not off < LOST
            kind = (status if failed else f"{LEAP} steps are elsewhere") if bad else kind
            return bad
        point = asker.point(p.method, h)
        off = max((x for x in (point.rise, point.away) if x is not None), default=math.inf)
        bad = point.kind in FAILED or not off < LOST
        kind = (point.kind if point.kind in FAILED else "the motion is lost") if bad else kind
        return bad

    hs = [p.h * 2 ** (k / 4) for k in range(-12, 13)]
    first = next((k for k, h in enumerate(hs) if lost(h)), None)
    if first is None:
        return Measured(p, None, "the motion stays up to eight times the scale")
    if first == 0:
        return Measured(p, hs[0], f"{kind}, and below")
    h = first_change(lost, hs[first - 1], hs[first], looks=2, parts=2, close=0.01 * hs[first])
    return Measured(p, h, kind)


def _branch(asker: Asker, p: Prediction, amplitude: float) -> Measured:
    status = "every step was made"

    def fails(h: float) -> bool:
        nonlocal status
        tiny = {"method": p.method, "mode": p.mode, "amplitude": amplitude / 1e6, "count": 1}
        found = asker.near(h=h, **tiny).status
        status = status if found == "PK_DONE" else found
        return found != "PK_DONE"

    assert p.h is not None
    h = _search(fails, 0.0, 2 * p.h)
    return Measured(p, h, status)


def _search(test: Callable[[float], bool], low: float, high: float) -> float | None:
    """Returns the first x in (low, high] at which `test` becomes true, to precision FINE * high."""
    return first_change(test, low, high, looks=LOOKS, parts=2, close=FINE * high)


def _resonance(
    asker: Asker, p: Prediction, size: float, amplitude: float, effort: Effort
) -> Measured:
    assert p.h is not None

    def excess(h: float) -> float | None:
        modes = [p.mode] if p.other is None else [p.mode, p.other]
        turns = {"method": p.method, "amplitude": amplitude, "count": effort.turns}
        closes = [asker.near(h=h, mode=k, **turns) for k in modes]
        if any(c.status != "PK_DONE" or c.steps < effort.turns for c in closes):
            return None
        if p.other is None:
            return closes[0].turn - RESONANCES[p.kind]
        return combined(p.kind, closes[0].turn, closes[1].turn)

    h = secant(excess, p.h, 1.01 * p.h)
    if h is None:
        return Measured(p, None, "the mode does not turn steadily there")
    peak, response = _response(asker, p, size, effort)
    return Measured(p, h, "turning", response, peak)


def secant(f: Callable[[float], float | None], a: float, b: float) -> float | None:
    """Returns a root of f near a and b by the secant method, or None if it finds none."""
    fa, fb = f(a), f(b)
    for _ in range(4):
        if fa is None or fb is None:
            return None
        if fb == fa or abs(b - a) <= 1e-6 * abs(b):
            break
        c = b - fb * (b - a) / (fb - fa)
        if not (math.isfinite(c) and 0 < c < 2 * max(a, b)):
            return None
        a, fa, b, fb = b, fb, c, f(c)
    return b


def _response(
    asker: Asker, p: Prediction, size: float, effort: Effort
) -> tuple[float | None, float | None]:
    """Scans step sizes near a resonance for the strongest response. Returns the step size, and the
    response: the growth of the motion at this step size, divided by the larger growth at the first
    and the last step size of the scan. Several amplitudes are tried; the largest response counts.
    Returns (None, None) if the motion grows too far at the first and the last step size.

    In a resonance of two modes, the growth of the slower mode is measured. It starts with 1/100 of
    the amplitude of the faster mode.
    """
    assert p.h is not None
    hs = [p.h * (1 + BESIDE * (2 * k / (effort.scan - 1) - 1)) for k in range(effort.scan)]
    found: list[tuple[float, float]] = []
    for part in effort.sizes:
        amplitude = part * size
        more = {} if p.other is None else {"other": p.other, "seed": amplitude / 100}
        more |= {"method": p.method, "mode": p.mode, "amplitude": amplitude}
        closes = [asker.near(h=h, count=effort.steps, **more) for h in hs]
        # A run that fails counts as growth by FAR.
        grown = [c.growth if c.status == "PK_DONE" else FAR for c in closes]
        beside = max(grown[0], grown[-1])
        if beside < FAR:
            best = max(range(effort.scan), key=lambda k: grown[k])
            found.append((grown[best] / beside, hs[best]))
    response, peak = max(found, default=(None, None))
    return peak, response
