"""The exact value of a number as it is written, or why no double can hold it."""

from __future__ import annotations

from fractions import Fraction

from .. import limits


def literal_value(spelt: str) -> Fraction | str:
    """The exact value of a literal, or what is wrong with it; never computes a huge power."""
    digits, _, exponent = spelt.lower().partition("e")
    if len(digits) > limits.LITERAL_DIGITS:
        return f"a number of {len(digits)} digits; the limit is {limits.LITERAL_DIGITS}"
    if exponent and (len(exponent) > 6 or abs(int(exponent)) > limits.LITERAL_EXPONENT):
        return f"an exponent beyond {limits.LITERAL_EXPONENT}: no double holds this number"
    value = Fraction(spelt)
    try:
        rounded = float(value)
    except OverflowError:
        return "this number is too large for a double"
    return limits.lost(value, rounded, "number") or value
