"""Expressions as C text with the fewest brackets, and the count of their operations.

A `Form` is text that has not been closed yet: the terms of a sum, or the factors above and below
a fraction bar. Sums and products are joined flat; a minus wanders to where a reader expects it.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from typing import NamedTuple

PLUS, MINUS = 1, -1


class Form(NamedTuple):
    """A sum of (sign, text) terms if there is not exactly one term of `terms`; otherwise a
    product sign * above / below. An atom is a product of one factor."""

    terms: tuple[tuple[int, str], ...] = ()
    sign: int = PLUS
    above: tuple[str, ...] = ()
    below: tuple[str, ...] = ()
    length: int = 0  # of the text, roughly

    @property
    def is_sum(self) -> bool:
        return bool(self.terms)


def atom(text: str) -> Form:
    return Form(above=(text,), length=len(text))


def negated(form: Form) -> Form:
    if form.is_sum:
        return Form(terms=tuple((-s, x) for s, x in form.terms), length=form.length)
    return Form((), -form.sign, form.above, form.below, form.length)


def added(a: Form, b: Form) -> Form:
    return Form(terms=_as_terms(a) + _as_terms(b), length=a.length + b.length + 3)


def multiplied(a: Form, b: Form) -> Form:
    # Most of all are two products: not asked through _as_factors.
    sign_a, above_a, below_a = _as_factors(a) if a.terms else a[1:4]
    sign_b, above_b, below_b = _as_factors(b) if b.terms else b[1:4]
    above = above_a + above_b
    if "1" in above and len(above) > 1:  # 1/x * y
        above = tuple(x for x in above if x != "1") or ("1",)
    length = a.length + b.length + 3
    return Form((), sign_a * sign_b, above, below_a + below_b, length)


def inverted(form: Form) -> Form:
    sign, above, below = _as_factors(form)
    if below:  # 1/(a/b): kept as it is, so that a/b may be shared
        return Form((), sign, ("1",), (f"({_fraction(above, below)})",), form.length + 6)
    return Form((), sign, ("1",), above, form.length + 4)


def called(function: str, arguments: list[Form]) -> Form:
    return atom(f"{function}({', '.join(text(a) for a in arguments)})")


def text(form: Form) -> str:
    """The whole expression. A sum starts with a positive term if it has one."""
    if not form.is_sum:
        fraction = _fraction(form.above, form.below)
        if form.sign > 0 and fraction[0] == "(" and _RATIO.fullmatch(fraction):
            return fraction[1:-1]
        return ("-" if form.sign < 0 else "") + fraction
    terms = list(form.terms)
    first = next((i for i, (sign, _) in enumerate(terms) if sign > 0), 0)
    terms.insert(0, terms.pop(first))
    parts = ["-" + terms[0][1] if terms[0][0] < 0 else terms[0][1]]
    for sign, term in terms[1:]:
        parts.append(f" {'-' if sign < 0 else '+'} {term}")
    return "".join(parts)


def count_operations(expressions: Iterable[str], prefix: str) -> Counter[str]:
    """Operations in expressions' text, constants such as 1/3 aside: what is shown is what is
    counted. `prefix` starts the names of the model's own helper functions."""
    text = "\n".join(x for x in expressions if not _RATIO.fullmatch(f"({x})"))
    text = _RATIO.sub("1", text)
    operations = Counter({sign: text.count(f" {sign} ") for sign in "+-*/"})
    operations["neg"] = len(_MINUS.findall(text))
    operations.update(_FUNCTION.findall(text))
    operations.update(re.findall(rf"\b{prefix}(?:side_)?(\w+)\(", text) if prefix in text else ())
    return +operations  # those that there are


_RATIO = re.compile(r"\(PK_C\([^()]*\) / PK_C\([^()]*\)\)")
_MINUS = re.compile(r"-(?=\S)(?<![^( \n]-)")  # at the start, after a bracket or an operator
_FUNCTION = re.compile(r"PK_F\((\w+)\)")


def _fraction(above: tuple[str, ...], below: tuple[str, ...]) -> str:
    top = " * ".join(above)
    if not below:
        return top
    bottom = " * ".join(below)
    return f"{top} / ({bottom})" if len(below) > 1 else f"{top} / {bottom}"


def _as_terms(form: Form) -> tuple[tuple[int, str], ...]:
    return form.terms or ((form.sign, _fraction(form.above, form.below)),)


def _as_factors(form: Form) -> tuple[int, tuple[str, ...], tuple[str, ...]]:
    if form.is_sum:
        if all(sign < 0 for sign, _ in form.terms):
            return MINUS, (f"({text(negated(form))})",), ()
        return PLUS, (f"({text(form)})",), ()
    return form.sign, form.above, form.below
