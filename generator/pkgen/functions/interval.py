"""Intervals of real numbers, each end included or excluded.

Reference: R. E. Moore, Interval Analysis, Prentice-Hall 1966.
"""

from __future__ import annotations

import math

from ..record import record

INF = math.inf
ROUND = 1e-12  # tolerance for rounding errors of the end points


@record
class Range:
    lo: float = -INF
    hi: float = INF
    above: bool = False  # Whether the interval excludes its end `lo`.
    below: bool = False  # Whether the interval excludes its end `hi`.

    @property
    def positive(self) -> bool:
        return self.lo > ROUND or (self.lo == 0 and self.above)

    @property
    def not_negative(self) -> bool:
        return self.lo >= 0

    @property
    def never_zero(self) -> bool:
        return self.positive or (-self).positive

    def __neg__(self) -> Range:
        return Range(-self.hi, -self.lo, self.below, self.above)

    def __add__(self, other: Range) -> Range:
        return Range(
            self.lo + other.lo,
            self.hi + other.hi,
            self.above or other.above,
            self.below or other.below,
        )

    def __mul__(self, other: Range) -> Range:
        corners = [_corner(*x, *y) for x in self._ends() for y in other._ends()]
        lo, hi = min(x for x, _ in corners), max(x for x, _ in corners)
        return Range(
            lo,
            hi,
            all(excluded for x, excluded in corners if x == lo),
            all(excluded for x, excluded in corners if x == hi),
        )

    def _ends(self) -> tuple[tuple[float, bool], tuple[float, bool]]:
        return (self.lo, self.above), (self.hi, self.below)


def _corner(x: float, x_excluded: bool, y: float, y_excluded: bool) -> tuple[float, bool]:
    """Returns the product x y of an end of one interval and an end of another interval. The second
    result is true if the interval of the products excludes x y, because x or y is excluded."""
    if x == 0 or y == 0:  # 0 * infinity is taken as 0: intervals contain finite numbers only
        return 0.0, (x != 0 or x_excluded) and (y != 0 or y_excluded)
    return x * y, x_excluded or y_excluded


ANY = Range()
UNIT = Range(-1, 1)
NOT_NEGATIVE = Range(0)
POSITIVE = Range(0, above=True)
