"""Rewrites conditions as numbers.

`truth` is 1 where a condition holds, else 0. It consists of calls of step, so that integrators
locate each boundary (see middle/derive/switches.py). `positive` is continuous, and is positive
where the condition holds.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import reduce

from ...tree import Add, Call, Condition, Expr, Multiply, Negate, names
from ..units import NONE
from .checking import Checked
from .names import Wrong, joined
from .written import written

_TRUTH = {
    "<": "1 - step(a - b)",
    ">": "1 - step(b - a)",
    "<=": "step(b - a)",
    ">=": "step(a - b)",
    "==": "step(a - b + 0.5) - step(a - b - 0.5)",  # of two integers
}


def truth(expr: Expr, cells: Collection[str] = ()) -> Expr:
    """Returns a number that is 1 where the condition holds, and 0 elsewhere. `cells` are the names
    of memory cells."""
    _check(expr)
    at, operator = expr.span, expr.operator
    if operator == "not":
        return written("1 - a", at, truth(*expr.parts, cells))
    if operator in ("and", "or"):
        parts = [truth(part, cells) for part in expr.parts]
        if operator == "or":  # not (not a and not b)
            parts = [written("1 - a", part.span, part) for part in parts]
        product = Multiply(tuple(parts), (1,) * len(parts), at)
        return written("1 - a", at, product) if operator == "or" else product
    of_cells = operator == "==" and names(expr) & {*cells}
    return written("step(a - b)*step(b - a)" if of_cells else _TRUTH[operator], at, *expr.parts)


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
    a, b = reversed(expr.parts) if operator in ("<", "<=") else expr.parts
    return check(Add((a, b), (1, -1), at))


def _check(expr: Expr) -> None:
    if not isinstance(expr, Condition):
        raise Wrong("this is no condition", "e.g. x > 0, or a < b and not c > d", expr)
