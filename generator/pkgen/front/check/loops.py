"""Loops over families: which indices an expression reaches, and whether they are there.

An index is first bounded by interval arithmetic over its loops, which settles nearly every
one; only where that says no are the loops gone through point by point.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ... import limits
from ...indices import assignments, integer
from ...record import record
from ...tree import Add, Expr, Multiply, Name, Negate, Number, Range

Interval = tuple[int, int]


@record
class Loop:
    """A range whose ends are known to be integers, and the interval its variable covers."""

    range: Range
    interval: Interval


def bound(expr: Expr, variables: Mapping[str, Interval]) -> Interval:
    """The interval of an index expression that `indices.integer` accepts."""
    match expr:
        case Number(value=value):
            return int(value), int(value)
        case Name(id=name):
            return variables[name]
        case Negate(of=of):
            lo, hi = bound(of, variables)
            return -hi, -lo
        case Add(terms=terms, signs=signs):
            ends = [bound(x, variables) for x in terms]
            return (
                sum(e[0] if s > 0 else -e[1] for e, s in zip(ends, signs, strict=True)),
                sum(e[1] if s > 0 else -e[0] for e, s in zip(ends, signs, strict=True)),
            )
        case Multiply(factors=factors):
            lo = hi = 1
            for factor in factors:
                a, b = bound(factor, variables)
                products = (lo * a, lo * b, hi * a, hi * b)
                lo, hi = min(products), max(products)
            return lo, hi
    raise TypeError(expr)


def intervals(sizes: Mapping[str, int], loops: tuple[Loop, ...]) -> dict[str, Interval]:
    known = {name: (value, value) for name, value in sizes.items()}
    known.update((loop.range.variable, loop.interval) for loop in loops)
    return known


def points(sizes: Mapping[str, int], loops: tuple[Loop, ...]) -> Iterator[dict[str, int]]:
    """Every assignment of the loop variables (sizes included), up to the limit."""
    ranges = tuple(loop.range for loop in loops)
    for number, values in enumerate(assignments(ranges, sizes)):
        if number == limits.UNROLLED:
            return
        yield values


def first_outside(
    index: Expr, sizes: Mapping[str, int], loops: tuple[Loop, ...], inside
) -> tuple[int, dict[str, int]] | None:
    """The first value of an index that `inside(value, variables)` refuses, and where it is met."""
    for values in points(sizes, loops):
        value = integer(index, values)
        if not inside(value, values):
            return value, {loop.range.variable: values[loop.range.variable] for loop in loops}
    return None


def at_text(variables: Mapping[str, int]) -> str:
    """` at i = 3, j = 4`, or nothing."""
    if not variables:
        return ""
    return " at " + ", ".join(f"{name} = {value}" for name, value in variables.items())
