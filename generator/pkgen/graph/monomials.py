"""Products as monomials: tuples of (base, exponent), sorted by base, each base once."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

Node = int
Factors = tuple[tuple[Node, Fraction | int], ...]


def merged(left: Factors, right: Factors) -> Factors:
    """Returns the product of two monomials."""
    if not left:
        return right
    if not right:
        return left
    if left[-1][0] < right[0][0]:
        return left + right
    if right[-1][0] < left[0][0]:
        return right + left
    powers = dict(left)
    for base, exponent in right:
        powers[base] = powers.get(base, 0) + exponent
    return tuple(sorted((b, e) for b, e in powers.items() if e))


def without_reciprocals(
    factors: Factors, reciprocals: Mapping[Node, tuple[Node, Fraction | int]]
) -> Factors:
    """Simplifies x^k reciprocal(x) to x^(k-1). The case k = 1 is left out: since reciprocal(0) is
    0, the two differ at x = 0. `reciprocals` maps each node reciprocal(x) to x, as (base,
    exponent)."""
    powers = dict(factors)
    for reciprocal, times in factors:
        found = reciprocals.get(reciprocal)
        if found is None or times < 1 or times != int(times):
            continue
        base, exponent = found
        there = powers.get(base, 0)
        left = there - times * exponent
        if there < 0 or (left > 0 and there > 0):
            del powers[reciprocal]
            powers[base] = left
    if len(powers) == len(factors):
        return factors
    return tuple(sorted((b, e) for b, e in powers.items() if e))
