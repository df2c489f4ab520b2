"""Exact values of functions at numbers, where there is one."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import isqrt

NUMBER_BITS = 512  # numbers beyond are left to the C as a product


def fits(value: Fraction) -> bool:
    """Whether a number is short enough to be worked out."""
    return max(value.numerator.bit_length(), value.denominator.bit_length()) <= NUMBER_BITS


def root(value: Fraction) -> Fraction | None:
    """The exact square root, or None."""
    if value < 0:
        return None
    n, d = isqrt(value.numerator), isqrt(value.denominator)
    exact = n * n == value.numerator and d * d == value.denominator
    return Fraction(n, d) if exact else None


def raised(value: Fraction, exponent: Fraction) -> Fraction | None:
    """The exact power, or None where there is none or it is long."""
    if exponent.denominator == 2:
        value, exponent = root(value), Fraction(exponent.numerator)
    if value is None or exponent.denominator != 1 or (value == 0 and exponent < 0):
        return None
    bits = max(value.numerator.bit_length(), value.denominator.bit_length())
    return value**exponent.numerator if bits * abs(exponent.numerator) <= NUMBER_BITS else None


def square_part(value: Fraction) -> Fraction:
    """A rational s with s^2 dividing a positive value; powers of 2, 3 and 5 are looked for."""
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


def _at(point: int, value: int) -> Callable[[Fraction], Fraction | None]:
    return lambda x: Fraction(value) if x == point else None


_EXACT: dict[str, Callable[..., Fraction | None]] = {
    "sin": _at(0, 0),
    "cos": _at(0, 1),
    "tan": _at(0, 0),
    "asin": _at(0, 0),
    "acos": _at(1, 0),
    "atan": _at(0, 0),
    "sinh": _at(0, 0),
    "cosh": _at(0, 1),
    "tanh": _at(0, 0),
    "exp": _at(0, 1),
    "log": _at(1, 0),
    "sqrt": root,
    "abs": abs,
    "min": min,
    "max": max,
    "step": lambda x: Fraction(x >= 0),
    "sign": lambda x: Fraction((x > 0) - (x < 0)),
    "reciprocal": lambda x: 1 / x if x else Fraction(0),
}

# Where a function of numbers has no value, and how to say so.
_UNDEFINED: dict[str, tuple[Callable[[Fraction], bool], str]] = {
    "sqrt": (lambda x: x < 0, "the square root of a negative number"),
    "log": (lambda x: x <= 0, "the logarithm of a number that is not positive"),
    "asin": (lambda x: abs(x) > 1, "the arc sine of a number beyond 1"),
    "acos": (lambda x: abs(x) > 1, "the arc cosine of a number beyond 1"),
}


def folded(function: str, values: list[Fraction]) -> Fraction | None:
    """The exact value of a function at numbers, or None where it is not one to write down."""
    exact = _EXACT.get(function)
    return None if exact is None else exact(*values)


def undefined(function: str, values: list[Fraction]) -> str:
    """What is wrong with a function of these numbers, or ""."""
    if function in _UNDEFINED:
        wrong, message = _UNDEFINED[function]
        return message if wrong(values[0]) else ""
    return ""
