"""States of more digits than a double has, and how far they are apart."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction

from ...system.exits import NumericsFailed


class Exact(list):
    """A state of more digits than a double's: a fraction for each coordinate, then each rate and
    each first-order variable."""

    coordinates = 0  # how many of the former

    @staticmethod
    def of(high: Iterable[float], low: Iterable[float], coordinates: int) -> Exact:
        """Each number is the sum of two doubles."""
        pairs = list(zip(high, low, strict=True))
        if not all(math.isfinite(x) for pair in pairs for x in pair):
            raise NumericsFailed("a state is not finite")
        exact = Exact(Fraction(float(x)) + Fraction(float(y)) for x, y in pairs)
        exact.coordinates = coordinates
        return exact


def difference(one: Exact, other: Exact, scales: list[float]) -> float:
    """The largest difference of a coordinate or rate, relative to its scale."""
    return max(float(abs(a - b)) / s for a, b, s in zip(one, other, scales, strict=True))
