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

WHOLE = ("ceil", "floor", "round", "sign", "step")  # functions whose values are whole numbers
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


def positive(expr: Expr, check: Callable[[Expr], Checked], cells: Collection[str] = ()) -> Checked:
    """Returns a continuous function that is positive where the condition holds, and its facts.
    `check` checks each comparison by itself, so that comparisons may differ in unit. Where a
    comparison stays equal for a while, as one of memory cells or of floor, its function jumps from
    -1/2 to 1/2, for a difference of 0 would not tell < from <=."""
    _check(expr)
    at, operator = expr.span, expr.operator
    if operator == "==":
        raise Wrong("an event needs < or >: a quantity equals a value for an instant only", "", at)
    if operator in ("and", "or", "not"):
        parts = [positive(part, check, cells) for part in expr.parts]
        facts = joined(NONE, False, [f for _, f in parts])
        function = "min" if operator == "and" else "max"
        found = reduce(lambda a, b: Call(function, (a, b), at), (e for e, _ in parts))
        return Negate(found, at) if operator == "not" else found, facts
    a, b = reversed(expr.parts) if operator in ("<", "<=") else expr.parts
    difference, facts = check(Add((a, b), (1, -1), at))
    held = facts.inputs and facts.inputs.keys() <= {*cells} and not (facts.time or facts.states)
    if facts.rough in WHOLE or (held and not (facts.coordinates or facts.rates)):
        return check(written("a - 0.5", at, truth(expr)))
    return difference, facts


def _check(expr: Expr) -> None:
    if not isinstance(expr, Condition):
        raise Wrong("this is no condition", "e.g. x > 0, or a < b and not c > d", expr)
