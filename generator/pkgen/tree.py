"""Expressions as written in a model. Nodes are immutable and know their position in the text.

Sums and products are flat, so that a sum of many terms is not a deep tree. The depth of other
nesting (brackets, powers, calls) is limited by `limits.DEPTH`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from fractions import Fraction

from .record import record
from .source import Span

AXES = "xyz"
COMPONENTS = AXES + "w"  # names after the dot, indexed by Component.axis


@record
class Number:
    """A literal with its exact value."""

    value: Fraction
    span: Span


@record
class Name:
    """`theta1`, or `q[i+1]` with an index. A Greek letter is replaced by its name. Built-in names
    are `t`, `pi`, and in outputs `T`, `V`, `L`, `energy`, `p_COORD` (unless the model declares
    them)."""

    id: str
    index: Expr | None
    span: Span


@record
class Prime:
    """The total time derivative of an expression: `x1'`, `q[i]'`, `(a*b)'`."""

    of: Expr
    span: Span


@record
class Component:
    """`.x`, `.y` or `.z` of a vector, `.w` of a quaternion; `axis` is an index in COMPONENTS."""

    of: Expr
    axis: int
    span: Span


@record
class Negate:
    of: Expr
    span: Span


@record
class Add:
    """A sum: each term has a sign, +1 or -1; the first sign is +1."""

    terms: tuple[Expr, ...]
    signs: tuple[int, ...]
    span: Span


@record
class Multiply:
    """A product: each factor has an exponent, +1 (times) or -1 (divided by); the first is +1."""

    factors: tuple[Expr, ...]
    exponents: tuple[int, ...]
    span: Span


@record
class Power:
    base: Expr
    exponent: Expr
    span: Span


@record
class Call:
    """A call of a function of `functions/`, or of a vector function: dot, cross, norm. Checked
    expressions also have rotate(axis, angle, vector) and attitude(quaternion, vector), where the
    quaternion is a vector w, x, y, z."""

    function: str
    arguments: tuple[Expr, ...]
    span: Span


@record
class Condition:
    """A comparison `a < b` (also <=, >, >=, ==), or `and`, `or`, `not` of conditions. Before
    checking, it stands in an `if`, an event or behind `while`. The checker replaces it by
    numbers."""

    operator: str
    parts: tuple[Expr, ...]
    span: Span


@record
class Range:
    """`i = lo..hi`, both ends included; the ends are integer expressions."""

    variable: str
    lo: Expr
    hi: Expr
    span: Span


@record
class Sum:
    """`sum(body, i = 1..N, j = i+1..N)`: a range may use the variables of earlier ranges."""

    body: Expr
    ranges: tuple[Range, ...]
    span: Span


@record
class Vector:
    items: tuple[Expr, ...]
    span: Span


@record
class Quantity:
    """`EXPR [unit]` before checking; `check` replaces it by a product with the SI factor. `whole`
    means that the unit ends a full expression, as in `1 - 0.3 [m]` but not in `2 [N]*cos(w*t)`."""

    of: Expr
    unit: str
    unit_span: Span
    span: Span
    whole: bool = True


Expr = (
    Number
    | Name
    | Prime
    | Component
    | Negate
    | Add
    | Multiply
    | Power
    | Call
    | Condition
    | Sum
    | Vector
    | Quantity
)


def children(expr: Expr) -> tuple[Expr, ...]:
    """Returns the direct children, including indices and the ends of ranges."""
    match expr:
        case Number() | Name(index=None):
            return ()
        case Name(index=index):
            return (index,)
        case (
            Add(terms=parts)
            | Multiply(factors=parts)
            | Call(arguments=parts)
            | Condition(parts=parts)
        ):
            return parts
        case Vector(items=parts):
            return parts
        case Power(base=base, exponent=exponent):
            return (base, exponent)
        case Sum(body=body, ranges=ranges):
            return (body, *(end for r in ranges for end in (r.lo, r.hi)))
    return (expr.of,)  # the remaining classes: Prime, Component, Negate, Quantity


def within(expr: Expr) -> Iterator[Expr]:
    """Yields an expression and all its subexpressions."""
    waiting = [expr]
    while waiting:
        part = waiting.pop()
        yield part
        waiting.extend(children(part))


def names(expr: Expr) -> frozenset[str]:
    """Returns the names in an expression, including those in indices, and loop variables."""
    return frozenset(part.id for part in within(expr) if isinstance(part, Name))


def replaced(expr: Expr, by: Callable[[Expr], Expr | None]) -> Expr:
    """Replaces each subexpression by `by(it)`; if that is None, replaces within it."""
    new = by(expr)
    if new is not None:
        return new
    changed = {}
    for field in fields(expr):
        old = getattr(expr, field.name)
        inner = _inside(old, by)
        if inner != old:
            changed[field.name] = inner
    return replace(expr, **changed) if changed else expr


def of_member(expr: Expr, variable: str, index: Expr) -> Expr:
    """Returns the expression with `index` in place of the loop variable."""
    return replaced(
        expr, lambda part: index if isinstance(part, Name) and part.id == variable else None
    )


def _inside(part: object, by: Callable[[Expr], Expr | None]) -> object:
    if isinstance(part, tuple):
        return tuple(_inside(x, by) for x in part)
    if isinstance(part, Range):
        return replace(part, lo=replaced(part.lo, by), hi=replaced(part.hi, by))
    return replaced(part, by) if isinstance(part, Expr) else part
