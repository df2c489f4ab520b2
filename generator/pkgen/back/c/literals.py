"""Exact constants as C text, correctly rounded in float, double, long double and quad.

- An integer up to 2^24 is written as it is: every type represents it exactly.
- A number with a finite decimal expansion is written out in full (0.5, 9.81): the compiler
  rounds it once, in the type at hand.
- A ratio of two integers up to 2^24 is PK_C(1.0) / PK_C(3.0): both are exact in every type, and
  IEEE division rounds once. (Decimal digits would be rounded twice: here and by the compiler.)
- All other numbers get 60 digits, so that the rounding to these digits changes the result of the
  compiler's rounding for less than one number in 1e20.
"""

from __future__ import annotations

from decimal import ROUND_HALF_EVEN, Context, Decimal, Inexact
from fractions import Fraction

PI = "PK_PI"
_EXACT = 2**24  # float's 24 bits
_DIGITS = 60


def literal(value: Fraction) -> str:
    """Returns C text of a number >= 0 that can be a factor of a product without brackets."""
    if value.denominator == 1 and value <= _EXACT:
        return str(value.numerator)
    context = Context(prec=_DIGITS, rounding=ROUND_HALF_EVEN, Emax=10**6, Emin=-(10**6))
    quotient = context.divide(Decimal(value.numerator), Decimal(value.denominator))
    endless = context.flags[Inexact]
    if endless and value.numerator <= _EXACT and value.denominator <= _EXACT:
        return f"(PK_C({value.numerator}.0) / PK_C({value.denominator}.0))"
    return f"PK_C({_spelt(quotient)})"


def _spelt(number: Decimal) -> str:
    """Returns a decimal, without an exponent unless that is long: 0.001, 9.81, 1.5e-11, 5.97e24."""
    _, digits, exponent = number.as_tuple()
    text = "".join(map(str, digits)).rstrip("0") or "0"
    exponent += len(digits) - len(text)
    point = len(text) + exponent  # number of digits before the decimal point
    if -4 < point <= 0:
        return "0." + "0" * -point + text
    if 0 < point <= 17:
        padded = text.ljust(point, "0")
        return padded[:point] + "." + (padded[point:] or "0")
    return f"{text[0]}.{text[1:] or '0'}e{point - 1}"
