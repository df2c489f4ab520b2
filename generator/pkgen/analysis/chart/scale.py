"""Computes the steps and tolerances that are tried in charts, and in the choice of a method for
`accuracy` in a scene."""

from __future__ import annotations

import math
from typing import Any

ROUNDING = 1e-12  # rounding error of a quotient that should be an integer


def pieces(interval: float, step: float) -> int:
    """Returns the least number of equal steps in `interval` that are no longer than `step`."""
    return max(1, math.ceil(interval / step * (1 - ROUNDING)))


def divided(interval: float, step: float) -> float:
    """Returns the step, shortened so that a whole number of steps fills the interval. `pkgen run`
    does the same."""
    return interval / pieces(interval, step)


def slope(one: Any, other: Any) -> float:
    """Returns the exponent p in error ~ setting^p from two runs."""
    return math.log(one.error / other.error) / math.log(one.setting / other.setting)


def two_digits(tolerance: float) -> float:
    """Rounds a tolerance down to two significant digits, and to at most 0.99, since `pkgen run`
    refuses tolerances of 1 or more."""
    size = 10.0 ** (math.floor(math.log10(tolerance)) - 1)
    return min(float(f"{math.floor(tolerance / size * (1 + ROUNDING)) * size:.1e}"), 0.99)
