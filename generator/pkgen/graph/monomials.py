"""Products as monomials: each base once, with its exponent, in order."""

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
    """Simplifies x^k reciprocal(x) -> x^(k-1), equal at x = 0 too unless k is 1. `reciprocals`
    maps the node of each reciprocal(x) to (base, exponent) of x."""
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
