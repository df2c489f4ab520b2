"""The order of a composition of kicks and drifts, by words over a two-letter alphabet.

The step is a product of exponentials, exp(kick_0 h V) exp(drift_0 h T) ... In its expansion the
coefficient of each word of d letters V and T must be 1/d! for d up to the order, as in exp(h (V +
T)). These are the order conditions of a splitting into two parts (E. Hairer, C. Lubich, G. Wanner,
Geometric Numerical Integration, III.5). Numbers are stored as integers, see trees.py.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from .trees import BITS, CLOSE, MOST_ORDER, ONE, scaled


class Series:
    """A series in the letters V and T, which do not commute. The coefficient of a word of d letters
    is of[d][word]. Each bit of the integer `word` is a letter: 0 for V, 1 for T; the lowest bit is
    the last letter."""

    def __init__(self, degree: int):
        self.degree = degree
        self.of = [[ONE], *([0] * 2**d for d in range(1, degree + 1))]
        # For each coefficient, the sum of the absolute values of the terms added up in it.
        self.size = [[ONE], *([0] * 2**d for d in range(1, degree + 1))]

    def times_exp(self, letter: int, x: int) -> None:
        """Multiplies the series by exp(x letter) from the right."""
        if not x:
            return
        powers = [ONE]
        for k in range(1, self.degree + 1):
            powers.append((powers[-1] * x >> BITS) // k)
        ones = -letter  # All bits set for letter 1, none for letter 0.
        for d in range(self.degree, 0, -1):  # Long words first, since they use short ones.
            for word in range(2**d):
                for k in range(1, d + 1):
                    if (word ^ ones) & (1 << (k - 1)):
                        break
                    self.of[d][word] += powers[k] * self.of[d - k][word >> k] >> BITS
                    self.size[d][word] += abs(powers[k]) * self.size[d - k][word >> k] >> BITS

    def missed(self, d: int) -> tuple[bool, float]:
        """Returns whether the condition of a word of d letters fails, and the norm of the errors of
        all these conditions."""
        wanted = ONE // math.factorial(d)
        misses = [x - wanted for x in self.of[d]]
        close = Fraction(CLOSE)
        failed = any(abs(m) > close * s for m, s in zip(misses, self.size[d], strict=True))
        return failed, math.sqrt(sum((m / ONE) ** 2 for m in misses))


def order(kicks: Sequence[Fraction], drifts: Sequence[Fraction]) -> tuple[int, float | None]:
    """Returns the order and the error constant, which is the norm of the errors for words of order
    + 1 letters. Returns (MOST_ORDER, None) if no tested condition fails."""
    for degree in (4, 7, MOST_ORDER + 1):  # Low degrees first: the work doubles with each letter.
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
