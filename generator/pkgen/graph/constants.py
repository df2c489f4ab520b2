"""Exact rational arithmetic on numbers of limited length."""

from __future__ import annotations

from fractions import Fraction

from ..functions import FUNCTIONS

# The largest number of bits of a constant. A product with more bits is computed by the C code.
NUMBER_BITS = 512


def fits(value: Fraction) -> bool:
    """Whether a number is short enough to be stored as one exact constant."""
    return max(value.numerator.bit_length(), value.denominator.bit_length()) <= NUMBER_BITS


def raised(value: Fraction, exponent: Fraction) -> Fraction | None:
    """Returns value^exponent exactly, or None if it is irrational, undefined or too long."""
    if exponent.denominator == 2:
        value, exponent = FUNCTIONS["sqrt"].exact(value), Fraction(exponent.numerator)
    if value is None or exponent.denominator != 1 or (value == 0 and exponent < 0):
        return None
    bits = max(value.numerator.bit_length(), value.denominator.bit_length())
    return value**exponent.numerator if bits * abs(exponent.numerator) <= NUMBER_BITS else None


def square_part(value: Fraction) -> Fraction:
    """Returns the largest product s of powers of 2, 3 and 5 (also negative powers) such that s^2
    divides the positive value."""
    result = Fraction(1)
    for prime in (2, 3, 5):
        n, d = value.numerator, value.denominator
        while n % prime**2 == 0:
            n //= prime**2
            result *= prime
        while d % prime**2 == 0:
            d //= prime**2
            result /= prime
    return result
