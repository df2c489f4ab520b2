"""What a prediction is, and the ways of meeting one that several share.

A prediction is made before running: a closed form evaluated here, or a value converged by other
means. It is met if the measured value is within `tolerance` of it (relative), or inside the band
that it is; and if the worse method or step, measured in the same way, is not. Tolerances are those
at the head of the list of regimes: closed forms (V, C) within 1% or the digits given, boundaries
(B) within .1%, what was only measured (M) within its band or 20%.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

CLOSED, BOUNDARY, MEASURED = 1e-2, 1e-3, 0.2
ORDER = 0.05  # of a power that is fitted: .15 of order 3, .2 of order 4


@dataclass(frozen=True)
class Prediction:
    id: str
    system: str  # and its method
    says: str
    predicted: float | tuple[float, float]  # a value, or a band from .. to
    tolerance: float  # relative; of no use for a band
    measure: Callable[[], float]
    worse: str
    measure_worse: Callable[[], float]
    long: bool = False
    missed: str = ""  # why it is not met, where it is not
    own: bool = False  # not in the list of regimes
    no_method: str = ""  # why what is worse is no other method, where it is not
    command: str = ""  # of pkgen, where it is measured by that: shown.py
    read: str = ""  # of what it leaves
    instead: str = ""  # options of the worse run
    needs: str = ""  # a package, without which it is skipped

    def met(self, value: float) -> bool:
        if isinstance(self.predicted, tuple):
            low, high = self.predicted
            return low <= value <= high
        return abs(value - self.predicted) <= self.tolerance * abs(self.predicted)


@dataclass(frozen=True)
class Missing:
    """A prediction whose model or method cannot be written yet."""

    id: str
    system: str
    lacks: str


def boundary(predicted: float, grows: Callable[[float], bool], bits: int = 14) -> float:
    """Where growth sets in: stable at .999 of the prediction, growing at 1.001, and bisected in
    between; or wherever it is, if it is not there."""
    low, high = 0.999 * predicted, 1.001 * predicted
    while grows(low):
        high, low = low, 0.8 * low
        if low < 1e-3 * predicted:
            return 0.0
    while not grows(high):
        low, high = high, 1.25 * high
        if high > 1e3 * predicted:
            return math.inf
    for _ in range(bits):
        middle = (low + high) / 2
        low, high = (low, middle) if grows(middle) else (middle, high)
    return (low + high) / 2


def slope(x, y) -> float:
    """Of the line through points (log x, log y) by least squares."""
    u, w = [math.log(a) for a in x], [math.log(b) for b in y]
    mu, mw = sum(u) / len(u), sum(w) / len(w)
    return sum((a - mu) * (b - mw) for a, b in zip(u, w, strict=True)) / sum(
        (a - mu) ** 2 for a in u
    )
