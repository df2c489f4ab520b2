"""Rewrites conditions as numbers.

`truth` is 1 where a condition holds, else 0. It consists of calls of step, so that integrators
locate each boundary (see middle/derive/switches.py). `positive` is continuous, and is positive
where the condition holds.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from fractions import Fraction
from functools import reduce

from ...tree import Add, Call, Condition, Expr, Multiply, Negate, Number, names
from ..units import NONE
from .checking import Checked
from .names import Wrong, joined

_SWAPPED = ("<", "<=")


def truth(expr: Expr, cells: Collection[str] = ()) -> Expr:
    """Returns a number that is 1 where the condition holds, and 0 elsewhere. `cells` are the names
    of memory cells."""
    _check(expr)
    at, operator = expr.span, expr.operator
    if operator in ("and", "or", "not"):
        parts = [truth(part, cells) for part in expr.parts]
        if operator == "not":
            return _opposite(*parts)
        if operator == "or":  # not (not a and not b)
            parts = [_opposite(part) for part in parts]
        product = Multiply(tuple(parts), (1,) * len(parts), at)
        return _opposite(product) if operator == "or" else product
    a, b = expr.parts
    if operator == "==" and names(expr) & {*cells}:
        signs = (1, -1), (-1, 1)
        ends = (Call("step", (Add((a, b), s, at),), at) for s in signs)
        return Multiply(tuple(ends), (1, 1), at)
    if operator == "==":  # of two integers
        half = Number(Fraction(1, 2), at)
        ends = (Call("step", (Add((a, b, half), (1, -1, s), at),), at) for s in (1, -1))
        return Add(tuple(ends), (1, -1), at)
    if operator in _SWAPPED:
        a, b = b, a
    strict = operator in ("<", ">")
    difference = Add((b, a) if strict else (a, b), (1, -1), at)
    found = Call("step", (difference,), at)
    return _opposite(found) if strict else found


def positive(expr: Expr, check: Callable[[Expr], Checked]) -> Checked:
    """Returns a continuous function that is positive where the condition holds, and its facts.
    `check` checks each comparison by itself, so that comparisons may differ in unit."""
    _check(expr)
    at, operator = expr.span, expr.operator
    if operator == "==":
        raise Wrong("an event needs < or >: a quantity equals a value for an instant only", "", at)
    if operator in ("and", "or", "not"):
        parts = [positive(part, check) for part in expr.parts]
        facts = joined(NONE, False, [f for _, f in parts])
        function = "min" if operator == "and" else "max"
        found = reduce(lambda a, b: Call(function, (a, b), at), (e for e, _ in parts))
        return Negate(found, at) if operator == "not" else found, facts
    a, b = reversed(expr.parts) if operator in _SWAPPED else expr.parts
    return check(Add((a, b), (1, -1), at))


def _check(expr: Expr) -> None:
    if not isinstance(expr, Condition):
        raise Wrong("this is no condition", "e.g. x > 0, or a < b and not c > d", expr)


def _opposite(number: Expr) -> Expr:
    one = Number(Fraction(1), number.span)
    return Add((one, number), (1, -1), number.span)
