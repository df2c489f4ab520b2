"""Checks that indices and ranges are integers, and that every indexed member exists.

The ends of a family of coordinates, such as q[0] of q[1..N], may be declared below their use, so
indices of coordinates are checked in `finish`. A member of a `let` must be defined above its use,
so its index is checked at once. Interval arithmetic over the loop variables first bounds an index,
which proves nearly every index valid. If it does not, the index is evaluated for each iteration.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import prod

from ... import limits
from ...indices import NotAnInteger, assignments, indexed, integer
from ...source import Span
from ...tree import Add, Expr, Multiply, Name, Negate, Number, Range, Sum, names, within
from ..words import CONSTANTS
from .names import MOVING, Entry, Reporting
from .scope import PLACES, Interval, Loop, Scope


class Indices(Reporting):
    def __init__(self, *given) -> None:
        super().__init__(*given)
        self.waiting: list[tuple[Name, Entry, Scope]] = []
        self.defining: tuple[str, Range] | None = None  # The `let` family being defined.

    def valid(self, index: Expr, scope: Scope) -> bool:
        """Whether an index is an integer expression; reports one that is not."""
        if not self._names_known(index, scope):
            return False
        try:
            integer(index, self._samples(scope))
        except NotAnInteger as error:
            help = "declare it with 'size'" if "not a size" in error.message else ""
            message = error.message
            if scope.place is PLACES["size"]:
                message = message.replace("an index", "a size")
            self.error(message, error, help)
            return False
        return True

    def value(self, expr: Expr, scope: Scope) -> int | None:
        """Returns the value of an index expression outside loops; None after an error."""
        return integer(expr, self.sizes) if self.valid(expr, scope) else None

    def _samples(self, scope: Scope) -> dict[str, int]:
        """Returns one value for each size and loop variable, to test if an index is an integer."""
        return {**self.sizes, **{x.range.variable: x.interval[0] for x in scope.loops}}

    def _names_known(self, index: Expr, scope: Scope) -> bool:
        known = True
        for expr in within(index):
            if not isinstance(expr, Name) or expr.id in scope.variables:
                continue
            entry = self.names.table.get(expr.id)
            if entry is not None:
                entry.used = True
                known &= entry.kind != "poisoned"
            elif expr.id not in CONSTANTS:
                running = f"an index runs in a sum: sum(…, {expr.id} = 1..3)"
                running += f", or where members are declared: f[{expr.id} = 1..3]"
                letter = len(expr.id) == 1 and expr.id.islower()
                help = running if letter else f"declare it: size {expr.id} = 3"
                help = "" if scope.loops else help
                self.names.unknown(expr.id, expr.span, help=help)
                known = False
        return known

    def is_index(self, text: str) -> bool:
        """Whether the text of a unit is probably an index after a space, as in `q [i]`."""
        word = text.split("+")[0].split("-")[0].strip()
        return word.isdigit() or word in self.names.table or len(word) == 1

    # ranges

    def around(self, expr: Sum, scope: Scope) -> Scope:
        """Returns the scope in which a sum is checked. Its `points` is the number of iterations of
        those outer loops whose variables occur in the sum."""
        used = names(expr)
        loops = (loop for loop in scope.loops if loop.range.variable in used)
        return replace(scope, points=prod(max(0, loop.length) for loop in loops))

    def enter(self, ranges: tuple[Range, ...], scope: Scope) -> Scope | None:
        """Returns the scope within loops over `ranges`, or None after an error."""
        for item in ranges:
            loop = self._loop(item, scope)
            if loop is None:
                return None
            scope = replace(
                scope,
                loops=(*scope.loops, loop),
                variables=scope.variables | {item.variable},
                points=scope.points * max(0, loop.length),
            )
            if scope.points > limits.FAMILY:
                self.error(f"more than {limits.FAMILY:,} terms in nested sums", item)
                return None
        return scope

    def _loop(self, item: Range, scope: Scope) -> Loop | None:
        variable = Span(item.span.start, item.span.start + 1)
        if item.variable in scope.variables:
            self.error(f"'{item.variable}' is a loop variable already", variable)
            return None
        entry = self.names.table.get(item.variable)
        if (entry is not None and entry.kind != "poisoned") or item.variable in CONSTANTS:
            message = f"the loop variable '{item.variable}' has another meaning in this model"
            self.error(message, variable, "choose another letter")
            return None
        if not (self.valid(item.lo, scope) & self.valid(item.hi, scope)):
            return None
        known = intervals(self.sizes, scope.loops)
        loop = Loop(item, (bound(item.lo, known)[0], bound(item.hi, known)[1]))
        if loop.length > limits.FAMILY:
            self.error(f"a range of {loop.length:,} values; the limit is {limits.FAMILY:,}", item)
            return None
        return loop

    def family(self, lo: Expr, hi: Expr, span: Span, scope: Scope) -> tuple[int, int] | None:
        """Returns the first and last index of a range; None after an error, e.g. an empty range."""
        if not (self.valid(lo, scope) & self.valid(hi, scope)):
            return None
        first, last = integer(lo, self.sizes), integer(hi, self.sizes)
        if first > last:
            self.error(f"an empty family: {first}..{last}", span)
            return None
        if last - first + 1 > limits.FAMILY:
            self.error(
                f"a family of {last - first + 1:,} members; the limit is {limits.FAMILY:,}", span
            )
            return None
        return first, last

    # members

    def member(self, expr: Name, entry: Entry, scope: Scope) -> bool:
        """Whether the index of `expr` fits its name: it must be an integer for a family, and there
        must be none for any other name. Reports errors."""
        if expr.index is None:
            if entry.members is not None:
                self._no_index(expr, entry, scope)
            return entry.members is None
        if entry.members is None:
            help = f"a unit stands after a space: {expr.id} […]; a product is written with *"
            self.error(f"'{expr.id}' is not a family: it takes no index", expr, help)
            return False
        if not self.valid(expr.index, scope):
            return False
        if entry.kind in MOVING:
            self.waiting.append((expr, entry, scope))
        else:
            self._settle(expr, entry, scope)
        return True

    def _no_index(self, expr: Name, entry: Entry, scope: Scope) -> None:
        first, last = entry.own or (1, "N")
        if entry.own is None and entry.members.intervals:
            first, last = entry.members.intervals[0][0], entry.members.intervals[-1][1]
        apart = re.match(r"[ \t]+(\[[\w +*-]+\])", self.source.text[expr.span.end :])
        if apart and not self.is_family_left(scope):
            help = f"an index touches the name: {expr.id}{apart.group(1)}"
        elif self.is_family_left(scope):
            help = f"write {expr.id}[{first}] = … or {expr.id}[i = {first}..{last}] = …"
        elif scope.place is PLACES["record"]:
            help = f"name its members one by one, e.g. {indexed(expr.id, first)}"
        else:
            text = indexed(expr.id, first), indexed(expr.id, "i")
            help = f"e.g. {text[0]}, or {text[1]} in a sum over i"
        self.error(f"'{expr.id}' is a family: it needs an index", expr, help)

    @staticmethod
    def is_family_left(scope: Scope) -> bool:
        return scope.name == "="

    def finish(self) -> None:
        for expr, entry, scope in self.waiting:
            self._settle(expr, entry, scope)

    def _settle(self, expr: Name, entry: Entry, scope: Scope) -> None:
        if entry.periodic:
            return
        members = entry.members
        recursive = self.defining is not None and self.defining[0] == expr.id
        lo, hi = bound(expr.index, intervals(self.sizes, scope.loops))
        if members.hold(lo, hi):
            return
        for at in points(self.sizes, scope.loops):
            value = integer(expr.index, at)
            if members.hold(value, value):
                continue
            if recursive:  # An index below i in `let x[i = lo..hi]` is of a member defined before.
                own = self.defining[1]
                if integer(own.lo, self.sizes) <= value < at[own.variable]:
                    continue
            at = {x.range.variable: at[x.range.variable] for x in scope.loops}
            self._outside(expr, entry, value, at, recursive)
            return

    def _outside(
        self, expr: Name, entry: Entry, value: int, at: dict[str, int], recursive: bool
    ) -> None:
        member, name = indexed(expr.id, value), expr.id
        there = entry.members.text(name)
        if entry.kind in MOVING:
            lo, hi = entry.members.intervals[0][0], entry.members.intervals[-1][1]
            help = f"shorten the range, or say what lies there: 'fixed {member} = 0'"
            if value in (lo - 1, hi + 1):
                help += f", 'free {member}' or 'periodic {name}'"
        elif entry.kind == "definition":
            help = "members are defined above their use, the lower ones first"
        else:
            help = "shorten the range" if at else ""
        verb = "is not defined yet" if recursive else "is outside the family"
        self.error(f"{member} {verb}: there is {there or 'none'}{at_text(at)}", expr, help)

    def exponent(self, expr: Expr, scope: Scope) -> None:
        """Reports an exponent that contains loop variables and exceeds the limit."""
        try:
            integer(expr, self._samples(scope))
        except NotAnInteger:
            return
        lo, hi = bound(expr, intervals(self.sizes, scope.loops))
        if max(abs(lo), abs(hi)) > limits.EXPONENT:
            for values in points(self.sizes, scope.loops):
                if abs(integer(expr, values)) > limits.EXPONENT:
                    at = {x.range.variable: values[x.range.variable] for x in scope.loops}
                    self.error(f"an exponent beyond {limits.EXPONENT}{at_text(at)}", expr)
                    return


def bound(expr: Expr, variables: Mapping[str, Interval]) -> Interval:
    """Returns an interval that contains all values of an index expression; `variables` has an
    interval for each name in it."""
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
    """Yields the values of sizes and loop variables at each iteration, at most limits.UNROLLED."""
    ranges = tuple(loop.range for loop in loops)
    for number, values in enumerate(assignments(ranges, sizes)):
        if number == limits.UNROLLED:
            return
        yield values


def at_text(variables: Mapping[str, int]) -> str:
    """Returns the values of loop variables as text, such as ` at i = 3, j = 4`; "" if there are
    none."""
    if not variables:
        return ""
    return " at " + ", ".join(f"{name} = {value}" for name, value in variables.items())
