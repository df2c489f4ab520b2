"""Computes the values of a model's parameters and constants, and of expressions in a scene."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from fractions import Fraction

from ... import limits
from ...defaults import wrong_rtol
from ...indices import integer, unrolled
from ...model import Assignment, Model, Parameter
from ...source import Span
from ...tree import Expr
from .params import within
from .values import NoValue, evaluate

BYTES = 20  # Bytes of a number in a text file, estimated.
Number = Fraction | float
Key = tuple[str, int | None]  # a name, and an index or None


def has_row(t: float, every: float | None, until: float) -> bool:
    """Whether a run in a swarm writes a row of results at the time t. It writes one at the start,
    one at the end `until`, and one at each multiple of `every`."""
    if t in (0, until):
        return True
    if every is None:
        return False
    off = abs(t / every - round(t / every)) * every
    return off <= 8 * sys.float_info.epsilon * until


def too_much(rows: float, numbers: int, members: int | None) -> str:
    """Returns a message if the rows of all `members` runs together have more than limits.WRITTEN
    numbers, else "". A run has `rows` rows of `numbers` numbers."""
    total = rows * numbers * (members or 1)
    if total <= limits.WRITTEN:
        return ""
    each = f"{members:,} members of " if members is not None else ""
    gigabytes = total * BYTES * 1e-9
    count, size = (f"{x:,.0f}" if x < 1e15 else f"{x:.3g}" for x in (rows, gigabytes))
    return f"{each}{count} rows of {numbers:,} numbers are some {size} GB"


def within_bounds(
    model: Model,
    item: Parameter,
    index: int | None,
    value: float,
    others: Mapping[Key, float] | None = None,
) -> bool:
    """Whether a value is in a parameter's bounds; `others` are parameters not at their defaults."""
    values, bounds = Values(model, {**(others or {}), (item.name, index): value}), item.bounds
    loop = {**values.sizes, **({} if index is None else {item.range.variable: index})}
    ends = [e and values.number(item.name, e, loop) for e in (bounds.lo, bounds.hi)]
    return within(value, bounds, ends)


class WrongValue(Exception):
    """An expression of a scene has no value, or a wrong one; `span` is its source position."""

    def __init__(self, message: str, span: Span, help: str = ""):
        super().__init__(message)
        self.span, self.help = span, help


class Values:
    """Values of parameters and constants; values in `given` override values of the scene."""

    def __init__(self, model: Model, given: Mapping[Key, float]):
        self.model, self.given = model, dict(given)
        self.sizes = {size.name: size.value for size in model.sizes}
        self.values: dict[object, Number] = {}
        self.set({})

    def set(self, more: Mapping[Key, float]) -> None:
        """Recomputes all values with those in `more`, except for names that are in `given`."""
        given = {**more, **self.given}
        self.values.clear()
        items = (*self.model.parameters, *self.model.definitions)
        for item in sorted(items, key=lambda x: self.model.source.order(x.span.start)):
            if isinstance(item, Parameter):
                self._parameter(item, given)
            elif item.range is None and item.index is None:
                self._keep(item.name, item.value, self.sizes)

    def members(self, item: Parameter) -> list[tuple[int | None, object]]:
        """Returns (index, key in `values`) for each member of a parameter; [] for too many."""
        if item.range is None:
            return [(None, item.name)]
        lo, hi = (integer(end, self.sizes) for end in (item.range.lo, item.range.hi))
        return [(i, (item.name, i)) for i in range(lo, hi + 1)] if hi - lo < limits.SAMPLED else []

    def _parameter(self, item: Parameter, given: Mapping[Key, float]) -> None:
        for index, key in self.members(item):
            if (item.name, index) in given:
                self.values[key] = given[item.name, index]
            else:
                loop = {} if index is None else {item.range.variable: index}
                self._keep(key, item.default, {**self.sizes, **loop})

    def _keep(self, key: object, expr: Expr, loop: Mapping[str, int]) -> None:
        try:
            self.values[key] = evaluate(expr, self.values, loop)
        except (NoValue, KeyError):  # Not constant, or an error that the C code reports.
            self.values.pop(key, None)

    def assigned(self, item: Assignment) -> list[tuple[int | None, float]]:
        found = unrolled(item, self.sizes)
        return [(index, self.number(item.name, item.value, loop)) for index, loop in found]

    def number(self, name: str, expr: Expr, loop: Mapping[str, int] | None = None) -> float:
        try:
            return float(evaluate(expr, self.values, self.sizes if loop is None else loop))
        except KeyError as missing:
            message = f"{name}: the value of {missing} is not known here"
            raise WrongValue(message, expr.span) from None
        except NoValue as error:
            raise WrongValue(f"{name}: {error}", expr.span) from None

    def positive(self, name: str, expr: Expr | None) -> float | None:
        return self._checked(name, expr, lambda x: x > 0, "must be positive")

    def rtol(self, expr: Expr | None) -> float | None:
        found = self.positive("rtol", expr)
        if found is not None and (why := wrong_rtol(found)):
            raise WrongValue(why, expr.span, "e.g. rtol 1e-9" if found >= 1 else "")
        return found

    def not_negative(self, name: str, expr: Expr | None) -> float | None:
        return self._checked(name, expr, lambda x: x >= 0, "cannot be negative")

    def _checked(self, name: str, expr: Expr | None, good, must: str) -> float | None:
        if expr is None:
            return None
        found = self.number(name, expr)
        if not good(found):
            raise WrongValue(f"{name}: {must}", expr.span)
        return found
