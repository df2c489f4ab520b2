"""The order of a composition of kicks and drifts, by words in two letters.

The step is a product of exponentials, exp(kick_0 h V) exp(drift_0 h T) ...; its coefficient of
every word of d letters V, T must be that of exp(h (V + T)), 1/d!, for d up to the order. That is
all of the conditions of a splitting in two (E. Hairer, C. Lubich, G. Wanner, Geometric Numerical
Integration, III.5), none of them twice. Numbers as in trees.py.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from .trees import BITS, CLOSE, MOST_ORDER, ONE, scaled


class Series:
    """Coefficients by the number of letters and the word, a bit a letter, the last one lowest."""

    def __init__(self, degree: int):
        self.degree = degree
        self.of = [[ONE], *([0] * 2**d for d in range(1, degree + 1))]
        self.size = [[ONE], *([0] * 2**d for d in range(1, degree + 1))]  # of what is summed

    def times_exp(self, letter: int, x: int) -> None:
        """Followed by exp(x letter)."""
        if not x:
            return
        powers = [ONE]
        for k in range(1, self.degree + 1):
            powers.append((powers[-1] * x >> BITS) // k)
        ones = -letter  # all bits, or none
        for d in range(self.degree, 0, -1):  # from below nothing is needed that has changed
            for word in range(2**d):
                for k in range(1, d + 1):
                    if (word ^ ones) & (1 << (k - 1)):
                        break
                    self.of[d][word] += powers[k] * self.of[d - k][word >> k] >> BITS
                    self.size[d][word] += abs(powers[k]) * self.size[d - k][word >> k] >> BITS

    def missed(self, d: int) -> tuple[bool, float]:
        """Whether a condition of words of d letters fails, and the norm of what they miss."""
        wanted = ONE // math.factorial(d)
        misses = [x - wanted for x in self.of[d]]
        close = Fraction(CLOSE)
        failed = any(abs(m) > close * s for m, s in zip(misses, self.size[d], strict=True))
        return failed, math.sqrt(sum((m / ONE) ** 2 for m in misses))


def order(kicks: Sequence[Fraction], drifts: Sequence[Fraction]) -> tuple[int, float | None]:
    """And the error constant, the norm of what words of one letter more miss; MOST_ORDER, None
    where all conditions hold that were tried."""
    for degree in (4, 7, MOST_ORDER + 1):  # long words take time
        series = Series(degree)
        for k, kick in enumerate(kicks):
            series.times_exp(0, scaled(kick))
            if k < len(drifts):
                series.times_exp(1, scaled(drifts[k]))
        for d in range(1, degree + 1):
            failed, size = series.missed(d)
            if failed:
                return d - 1, size
    return MOST_ORDER, None
