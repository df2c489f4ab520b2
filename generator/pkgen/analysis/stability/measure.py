"""The points of the map, row by row, and each prediction measured on the model itself.

A limit is measured where the motion is small: 4000 steps from 1e-6 of the start's displacement
beside the equilibrium, all modes that do not grow at once, must not carry it a thousand times as
far. A resonance is where the mode's leading coordinate turns, on the average over thousands of
steps, by the angle predicted; whether the motion responds to it is asked apart, at some parts of
the start's size. A branch is lost where one step from the equilibrium itself fails: from beside it
a solution leads away. Growth is that of a reference motion that leaves along the mode.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from ...record import record
from .ask import Asker, Motion, Point, Rest
from .method import FURTHEST, LEAP, combined, first_change
from .orbits import ROUNDED
from .predict import RESONANCES, Prediction

SMALL = 1e-6  # of the size of the motion
LEAST = 1e-8  # of the largest coordinate: clear of round-off
STEPS = 4000
LONGER = 100  # times as many, where growth just beyond a limit is slow
FAR = 1e3
LOOKS = 16  # points of the first look for where something begins
FINE = 1e-6  # relative: how well it is known then
RESPONDS = 1.3  # growth at a resonance over that beside it, from which it is seen
LOST = 0.5  # of the range of v.p, by which energy is off once the motion is lost
FAILED = (
    "growing",
    "not converged",
    "wrong branch",
    "not finite",
    "singular",
    "failed",
    "off constraints",
)
BESIDE = 0.06  # how far to either side a response is sought, relative to the resonant step


@record
class Effort:
    """What a resonance is measured with."""

    turns: int  # steps over which its angle is a mean
    scan: int  # steps h at which a response is sought
    steps: int  # of each of these
    sizes: tuple[float, ...]  # of the start's displacement, at which it is


FULL = Effort(1000, 17, 1500, (0.02, 0.1, 0.5))
QUICK = Effort(500, 9, 700, (0.1, 0.5))


@record
class Row:
    """One value of what is varied: what is predicted there and what came of it."""

    x: float
    rest: Rest
    primary: int | None
    motion: Motion
    predictions: tuple[Prediction, ...]
    points: tuple[Point, ...]  # a method after the other, steps ascending


@record
class Measured:
    """A prediction and what the model did: h is where it happened, None where it never did."""

    prediction: Prediction
    h: float | None
    how: str  # what happened there, in words
    response: float | None = None  # of a resonance: growth at its peak over that beside it
    peak: float | None = None  # the step of that peak

    @property
    def silent(self) -> bool:
        """A resonance that nothing answers."""
        return self.response is not None and self.response < RESPONDS


@record
class Growth:
    """A mode that leaves an equilibrium: predicted and measured rate."""

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
    """The motion and what becomes of it at each step; equilibria too, unless they are known."""
    found, moved = known or asker.rest(tries), asker.motion()
    points = [asker.point(name, h) for name, hs in steps.items() for h in hs]
    apart = asker.with_settings(asker.settings)  # multipliers forget the motion
    return found, moved, tuple(_settled(apart, p) if linear else p for p in points)


def _settled(asker: Asker, point: Point) -> Point:
    """Steps of a linear model grow only if a multiplier of theirs is outside the unit circle. Else
    they come to rest about another amplitude, that of a driver between whose turns they fall."""
    if point.kind != "growing":
        return point
    found = radius(asker, point.method, point.h)
    settles = found is not None and found <= 1 + ROUNDED
    return replace(point, kind="wrong amplitude") if settles else point


def radius(asker: Asker, method: str, h: float) -> float | None:
    """The largest modulus of the multipliers of a step on a linear model, whatever drives it: a
    difference of two states goes on as the homogeneous equations say. None: no step was made."""
    import numpy

    begun = asker.start()
    states = [numpy.array([*begun.q, *begun.v])]
    states += list(states[0] + numpy.eye(len(states[0])))
    question = {"method": method, "h": h, "count": 1, "amplitude": 1e-3}
    after = [asker.ask("beside", state=tuple(y), **question) for y in states]
    if any(one["status"] != "PK_DONE" for one in after):
        return None
    first, *others = (numpy.array(one["state"], float) for one in after)
    return float(max(abs(numpy.linalg.eigvals([y - first for y in others]))))


def small(at: Rest, cyclic: frozenset[int], size: float) -> float:
    """An amplitude at which motions are linear and round-off is not seen. The unit may be any: it
    is SMALL beside the start's displacement `size`, or beside the places of rest."""
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
    """What the model does of what is predicted; `size` is the start's displacement, `amplitude`
    that of small motions; `bound` says that the model has rotations or constraints."""
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
    """Each mode that grows, left by a reference motion from a tenth of `amplitude`."""
    found = []
    for e, place in enumerate(at.equilibria):
        growing = [k for k, mode in enumerate(place.modes) if mode.growth > 0]
        here = asker.at(place)
        for k in growing:
            rate = here.ask("leave", mode=k, amplitude=amplitude / 10)["rate"]
            found.append(Growth(e, k, place.modes[k].growth, rate or 0.0))
    return found


def _limit(asker: Asker, at: Rest, p: Prediction, amplitude: float) -> Measured:
    fastest = at.equilibria[p.equilibrium].modes[p.mode].rate
    steps = 100 if p.h is None else STEPS
    status = "PK_DONE"  # of the last step that was too long

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
        h = _search(grows, 0.999 * p.h, 1.001 * p.h)  # intervals of growth may be narrow
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
    """The first step, from an eighth of the scale to eight times it, at which the motion is lost:
    the method fails, or energy is off by half of what comes and goes. Of what is `bound` energy may
    not tell: there LEAP steps from somewhere along the motion are off by half of what it covers."""
    assert p.h is not None
    if not bound and not asker.motion().judges:
        return Measured(p, None, "the motion itself ends or leaves")
    kind = ""

    def lost(h: float) -> bool:
        nonlocal kind
        if bound:
            found = asker.ask("resolved", method=p.method, h=h, count=LEAP)
            failed, off = found["status"] != "PK_DONE", found["off"]
            bad = failed or off is None or not off < LOST
            kind = (found["status"] if failed else f"{LEAP} steps are elsewhere") if bad else kind
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
    """The first x in (low, high] at which `test` becomes true, to FINE of the way."""
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
    """A root of f close to a and b."""
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
    """The step near the resonant one at which the motion grows most, and that growth over the one
    on either side, where no resonance is: the largest over all sizes. None, None where none is
    known.

    Of a pair: of the slower mode, begun a hundred times as small as the faster one."""
    assert p.h is not None
    hs = [p.h * (1 + BESIDE * (2 * k / (effort.scan - 1) - 1)) for k in range(effort.scan)]
    found: list[tuple[float, float]] = []
    for part in effort.sizes:
        amplitude = part * size
        more = {} if p.other is None else {"other": p.other, "seed": amplitude / 100}
        more |= {"method": p.method, "mode": p.mode, "amplitude": amplitude}
        closes = [asker.near(h=h, count=effort.steps, **more) for h in hs]
        # A motion that fails there, and not on either side, has responded.
        grown = [c.growth if c.status == "PK_DONE" else FAR for c in closes]
        beside = max(grown[0], grown[-1])
        if beside < FAR:
            best = max(range(effort.scan), key=lambda k: grown[k])
            found.append((grown[best] / beside, hs[best]))
    response, peak = max(found, default=(None, None))
    return peak, response
