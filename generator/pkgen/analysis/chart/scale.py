"""Settings of a method, steps or tolerances, as charts and the choice by `accuracy` try them."""

from __future__ import annotations

import math
from typing import Any

ROUNDING = 1e-12  # tolerance on a quotient that is meant to be an integer


def pieces(interval: float, step: float) -> int:
    """Returns the least number of equal steps in an interval that are no longer than `step`."""
    return max(1, math.ceil(interval / step * (1 - ROUNDING)))


def divided(interval: float, step: float) -> float:
    """Returns the step, shortened to divide the interval, as a run does."""
    return interval / pieces(interval, step)


def slope(one: Any, other: Any) -> float:
    """Returns the power of `setting` with which `error` falls between two runs."""
    return math.log(one.error / other.error) / math.log(one.setting / other.setting)


def two_digits(tolerance: float) -> float:
    """Rounds a tolerance down to two digits."""
    size = 10.0 ** (math.floor(math.log10(tolerance)) - 1)
    return float(f"{math.floor(tolerance / size * (1 + ROUNDING)) * size:.1e}")
