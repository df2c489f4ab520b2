"""Expressions as C text with the fewest brackets, with lists of their operands and operations.

A `Form` is an expression before it is joined to one text: the terms of a sum, or the factors of a
fraction's numerator and denominator. Nested sums and products are flattened; a minus moves to the
front.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from decimal import ROUND_HALF_EVEN, Context, Decimal, Inexact
from fractions import Fraction
from typing import NamedTuple

PLUS, MINUS = 1, -1


class Code(str):
    """C text of an expression. `reads` are the names, struct members and array elements in it, in
    order; `operations` its operators and functions, without those in constants such as 1/3."""

    reads: tuple[str, ...]
    operations: tuple[str, ...]

    def __new__(cls, text: str, reads: Iterable[str] = (), operations: Iterable[str] = ()) -> Code:
        code = super().__new__(cls, text)
        code.reads = tuple(reads)
        code.operations = tuple(operations)
        return code

    @property
    def names(self) -> set[str]:
        """Returns the variables that the text reads: p for p->m, q for q[0]."""
        return {base(read) for read in self.reads}


def base(place: str) -> str:
    """Returns the variable in a C lvalue: `p` for p->m, `out` for out[3]."""
    return place.partition("->")[0].partition("[")[0]


def variable(text: str) -> Code:
    """Returns the Code of a C variable: a name, a member of a struct, or an element of an array."""
    return Code(text, (text,))


def joined(parts: Sequence[Code]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Returns the `reads` of several Codes, without repetition, and all their `operations`."""
    reads = dict.fromkeys(name for part in parts for name in part.reads)
    return tuple(reads), tuple(operation for part in parts for operation in part.operations)


class Form(NamedTuple):
    """An expression: the sum of `terms`, pairs (sign, text), if there are any. Otherwise a fraction
    with a sign; `above` are the factors of its numerator, `below` those of its denominator. An atom
    is a fraction with one factor in the numerator."""

    terms: tuple[tuple[int, Code], ...] = ()
    sign: int = PLUS
    above: tuple[Code, ...] = ()
    below: tuple[Code, ...] = ()
    length: int = 0  # approximate number of characters of the C text

    @property
    def is_sum(self) -> bool:
        return bool(self.terms)


def atom(code: Code) -> Form:
    return Form(above=(code,), length=len(code))


def constant(text: str) -> Form:
    """Returns the form of a number with its sign."""
    form = atom(Code(text.removeprefix("-")))
    return negated(form) if text[0] == "-" else form


def negated(form: Form) -> Form:
    if form.is_sum:
        return Form(terms=tuple((-s, x) for s, x in form.terms), length=form.length)
    return Form((), -form.sign, form.above, form.below, form.length)


def added(a: Form, b: Form) -> Form:
    return Form(terms=_as_terms(a) + _as_terms(b), length=a.length + b.length + 3)


def multiplied(a: Form, b: Form) -> Form:
    # In most calls a and b are both products. Products skip _as_factors to save time.
    sign_a, above_a, below_a = _as_factors(a) if a.terms else a[1:4]
    sign_b, above_b, below_b = _as_factors(b) if b.terms else b[1:4]
    above = above_a + above_b
    if ONE in above and len(above) > 1:  # 1/x * y
        above = tuple(x for x in above if x != ONE) or (ONE,)
    length = a.length + b.length + 3
    return Form((), sign_a * sign_b, above, below_a + below_b, length)


def inverted(form: Form) -> Form:
    sign, above, below = _as_factors(form)
    if below:  # 1/(a/b) is not simplified, since a/b may be shared.
        return Form((), sign, (ONE,), (_bracketed(_fraction(above, below)),), form.length + 6)
    return Form((), sign, (ONE,), above, form.length + 4)


def called(function: str, arguments: Sequence[Form], operation: str) -> Form:
    """Returns the form of a function call; `operation` is its name in operation counts."""
    codes = [code(a) for a in arguments]
    reads, operations = joined(codes)
    return atom(Code(f"{function}({', '.join(codes)})", reads, (*operations, operation)))


ONE = Code("1")


def code(form: Form) -> Code:
    """Returns a form as C text. A sum starts with a positive term if there is one."""
    if not form.is_sum:
        fraction = _fraction(form.above, form.below)
        if form.sign > 0:
            plain = fraction[0] == "(" and not (fraction.reads or fraction.operations)
            return Code(fraction[1:-1]) if plain and len(form.above) == 1 else fraction
        return Code("-" + fraction, fraction.reads, (*fraction.operations, "neg"))
    terms = list(form.terms)
    first = next((i for i, (sign, _) in enumerate(terms) if sign > 0), 0)
    terms.insert(0, terms.pop(first))
    text = "-" + terms[0][1] if terms[0][0] < 0 else terms[0][1]
    signs = ["neg"] if terms[0][0] < 0 else []
    for sign, term in terms[1:]:
        signs.append("-" if sign < 0 else "+")
        text += f" {signs[-1]} {term}"
    reads, operations = joined([term for _, term in terms])
    return Code(text, reads, (*operations, *signs))


def _bracketed(x: Code) -> Code:
    return Code(f"({x})", x.reads, x.operations)


def _fraction(above: tuple[Code, ...], below: tuple[Code, ...]) -> Code:
    if len(above) == 1 and not below:
        return above[0]
    reads, operations = joined(above + below)
    signs = ["*"] * (len(above) - 1 + max(len(below) - 1, 0)) + ["/"] * bool(below)
    text = " * ".join(above)
    if below:
        bottom = " * ".join(below)
        text += f" / ({bottom})" if len(below) > 1 else f" / {bottom}"
    return Code(text, reads, (*operations, *signs))


def _as_terms(form: Form) -> tuple[tuple[int, Code], ...]:
    return form.terms or ((form.sign, _fraction(form.above, form.below)),)


def _as_factors(form: Form) -> tuple[int, tuple[Code, ...], tuple[Code, ...]]:
    if form.is_sum:
        if all(sign < 0 for sign, _ in form.terms):
            return MINUS, (_bracketed(code(negated(form))),), ()
        return PLUS, (_bracketed(code(form)),), ()
    return form.sign, form.above, form.below


# -- constants -----------------------------------------------------------------------------------

# An integer up to 2^24 is written as it is, and a number with a finite decimal expansion in full:
# the compiler rounds it once, in the type at hand. A ratio of two integers up to 2^24 is
# PK_C(1.0) / PK_C(3.0): both are exact in every type, and IEEE division rounds once. (Decimal
# digits would be rounded twice: here and by the compiler.) All other numbers get 60 digits, so that
# this rounding changes the result of the compiler's rounding for less than one number in 1e20.
PI = "PK_PI"
_EXACT = 2**24  # float's 24 bits
_DIGITS = 60


def literal(value: Fraction) -> str:
    """Returns C text of a number >= 0 that can be a factor of a product without brackets, correctly
    rounded in float, double, long double and quad."""
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
