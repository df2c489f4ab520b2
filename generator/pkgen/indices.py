"""Integer expressions: sizes, indices and the ends of ranges; names of family members."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from .source import Span
from .tree import COMPONENTS, Add, Expr, Multiply, Name, Negate, Number, Range

_MEMBER = re.compile(r"([^\[]+)\[(-?\d+)\](.*)")
# Behind a dot stand components, quantities of a body, and else the names of a part.
OF_BODIES = """
    com origin R omega mass point held place e f g X Y Z
    lower upper at axis inertia products turn velocity speed field
"""
DOTTED = frozenset((*COMPONENTS, *OF_BODIES.split()))
_TAIL = re.compile(rf"(\.({'|'.join(DOTTED)}))*$|\).*")


class NotAnInteger(Exception):
    """An index expression is not an integer; `span` is the position of the part that is not."""

    def __init__(self, message: str, span: Span):
        super().__init__(message)
        self.message = message
        self.span = span


def integer(expr: Expr, values: Mapping[str, int]) -> int:
    """Returns the value of an index expression; `values` has sizes and loop variables."""
    match expr:
        case Number(value=value):
            if value.denominator != 1:
                raise NotAnInteger("an index must be an integer", expr.span)
            return int(value)
        case Name(id=name, index=None):
            if name not in values:
                raise NotAnInteger(f"'{name}' is not a size or a loop variable", expr.span)
            return values[name]
        case Negate(of=of):
            return -integer(of, values)
        case Add(terms=terms, signs=signs):
            return sum(s * integer(x, values) for x, s in zip(terms, signs, strict=True))
        case Multiply(factors=factors, exponents=exponents) if all(e == 1 for e in exponents):
            product = 1
            for factor in factors:
                product *= integer(factor, values)
            return product
    raise NotAnInteger("an index may use integers, sizes, loop variables, + - *", expr.span)


def assignments(ranges: tuple[Range, ...], values: Mapping[str, int]) -> Iterator[dict[str, int]]:
    """Yields `values` with each assignment of the ranges' variables, the last varying fastest."""
    if not ranges:
        yield dict(values)
        return
    first, rest = ranges[0], ranges[1:]
    for i in range(integer(first.lo, values), integer(first.hi, values) + 1):
        yield from assignments(rest, {**values, first.variable: i})


def unrolled(item: Any, values: Mapping[str, int]) -> Iterator[tuple[int | None, dict[str, int]]]:
    """Yields the index of each member that a statement is about, or None if it has no index, and
    `values` with the value of its loop variable."""
    if item.range is None:
        yield None if item.index is None else integer(item.index, values), dict(values)
        return
    for loop in assignments((item.range,), values):
        yield loop[item.range.variable], loop


def indexed(name: str, index: int | str | None) -> str:
    """Returns the name of a family member: q[3]; for a vector component r.x it is r[3].x, for a
    body rate omega(R).x it is omega(R[3]).x."""
    if index is None:
        return name
    end = _TAIL.search(name).start()
    return f"{name[:end]}[{index}]{name[end:]}"


def in_parts(name: str) -> tuple[str, str]:
    """Splits a name into that of what is declared and the rest: link.com into link and com."""
    at = _TAIL.search(name).start()
    return name[:at], name[at + 1 :]


def made_of(form: str, name: str) -> str:
    """Returns the name of what is made of a name: for "p_{}" and left.x it is left.p_x."""
    part, dot, own = name.rpartition(".")
    return part + dot + form.format(own)


def of_made(prefix: str, name: str) -> str:
    """Returns the name of which another is made: for "p_" and left.p_x it is left.x. Returns "" for
    a name without the prefix."""
    part, dot, own = name.rpartition(".")
    return part + dot + own.removeprefix(prefix) if own.startswith(prefix) else ""


def multipliers(name: str) -> tuple[str, str]:
    """Returns two names of a constraint's multiplier: if unique, and if of least norm."""
    own, vector, axis = name, "", ""
    if name[-2:-1] == ".":  # A component of a vector.
        own, vector, axis = name.rpartition(".")
    return tuple(made_of(form, own) + vector + axis for form in ("lambda_{}", "least_lambda_{}"))


def multiplied(name: str) -> str:
    """Returns the name of the constraint that has the multiplier `name`."""
    return re.sub(r"(^|\.)lambda_", r"\1", name, count=1)


def parted(name: str) -> tuple[str, int | None]:
    """Splits a member's name into the family's name, with primes, and the index or None."""
    member = _MEMBER.fullmatch(name)
    return (member[1] + member[3], int(member[2])) if member else (name, None)


def hidden(name: str) -> bool:
    return name[0].isdigit()
