"""States with more digits than a double, and their differences."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction

from ...system.exits import NumericsFailed


class Exact(list):
    """A state with more digits than a double, as fractions: the coordinates, then the rates and
    first-order variables."""

    coordinates = 0  # number of coordinates

    @staticmethod
    def of(high: Iterable[float], low: Iterable[float], coordinates: int) -> Exact:
        """Returns a state whose components are the exact sums of a double from `high` and one from
        `low`. Raises NumericsFailed if a double is not finite."""
        pairs = list(zip(high, low, strict=True))
        if not all(math.isfinite(x) for pair in pairs for x in pair):
            raise NumericsFailed("a state is not finite")
        exact = Exact(Fraction(float(x)) + Fraction(float(y)) for x, y in pairs)
        exact.coordinates = coordinates
        return exact


def difference(one: Exact, other: Exact, scales: list[float]) -> float:
    """Returns the largest component of the difference of two states, each relative to its scale."""
    return max(float(abs(a - b)) / s for a, b, s in zip(one, other, scales, strict=True))
