"""Resolves the axes of a plan in the model: names, and ranges or values in SI units."""

from __future__ import annotations

import math
import re

from pkgen import limits
from pkgen.compiler import Compilation
from pkgen.front.check import options_text
from pkgen.front.check.options_text import OptionError
from pkgen.run.ensemble import Column, Settable
from pkgen.system.exits import UsageError
from pkgen.system.near import near

from .plan import Plan
from .sampling import SOBOL_BITS, Axis, Starts, on_grid

_UNIT = re.compile(r"\[[^\[\]]*\]\s*$")


def starts(plan: Plan, compilation: Compilation) -> Starts:
    """Returns the starts of all members. Raises UsageError with the position in the plan."""
    reader = _Reader(plan, compilation)
    names: dict[Column, str] = {}
    axes = []
    for key, value in plan.axes.items():
        axis = reader.axis(key, value)
        if axis.column in names:
            raise plan.wrong(plan.kind, key, f"{names[axis.column]} and {key} are the same")
        names[axis.column] = key
        axes.append(axis)
    members = _members(plan, axes)
    if members > limits.SWEEP or (plan.kind == "sobol" and members > 1 << SOBOL_BITS):
        most = min(limits.SWEEP, 1 << SOBOL_BITS) if plan.kind == "sobol" else limits.SWEEP
        raise plan.wrong("", "members", f"{members:,} members; the limit is {most:,}")
    if plan.kind == "grid" and any(not (x.values or x.points) for x in axes):
        axes = _even(plan, axes, members)
    return Starts(plan.kind, tuple(axes), members, plan.seed)


def _members(plan: Plan, axes: list[Axis]) -> int:
    """Returns the number of members, from the plan's `members`, its grid or its lists."""
    counted = None
    if plan.kind == "list":
        lengths = {len(axis.values) for axis in axes}
        if len(lengths) > 1:
            each = ", ".join(
                f"{key} {len(x.values)}" for key, x in zip(plan.axes, axes, strict=True)
            )
            raise plan.wrong("list", "", f"lists are of one length, a value a member: {each}")
        counted = lengths.pop()
    elif plan.kind == "grid" and all(x.values or x.points for x in axes):
        counted = on_grid(tuple(axes))
    if plan.members is None and counted is None:
        more = ", or the points of each axis" if plan.kind == "grid" else ""
        raise plan.wrong(plan.kind, "", f"how many members? give members = N{more}")
    if None not in (plan.members, counted) and plan.members != counted:
        raise plan.wrong(
            "", "members", f"members = {plan.members}, but [{plan.kind}] has {counted}"
        )
    return counted if plan.members is None else plan.members


def _even(plan: Plan, axes: list[Axis], members: int) -> list[Axis]:
    """Returns the axes of a grid that has `members` points in all. Axes whose number of points is
    not given all get the same number."""
    free = [x for x in axes if not (x.values or x.points)]
    known = on_grid(tuple(x for x in axes if x not in free))
    points = round((members / known) ** (1 / len(free)))
    if known * points ** len(free) != members:
        near_ = [known * k ** len(free) for k in (points, points + 1) if k > 1]
        raise plan.wrong(
            "",
            "members",
            f"{members} members are no grid of {len(axes)} axes",
            f"as many points along each axis: {' or '.join(map(str, near_))} members; "
            'or say how many: x = ["0 .. 1", 50]',
        )
    return [
        Axis(x.column, x.lo, x.hi, points) if x in free else x  # the range includes both ends
        for x in axes
    ]


class _Reader:
    def __init__(self, plan: Plan, compilation: Compilation):
        self.plan = plan
        self.model = compilation.model
        self.sizes = {size.name: size.value for size in self.model.sizes}
        self.known = Settable(compilation)
        self.unread = compilation.report.unused

    def wrong(self, key: str, message: str, help: str = "") -> UsageError:
        return self.plan.wrong(self.plan.kind, key, message, help)

    def axis(self, key: str, value: object) -> Axis:
        column = self.column(key)
        if self.plan.kind == "list":
            if not isinstance(value, list) or not value:
                raise self.wrong(key, f"{key} is a list of values, e.g. [1, 2]")
            return Axis(column, values=tuple(self.value(key, x, column) for x in value))
        if self.plan.kind == "grid" and isinstance(value, list):
            return self.of_grid(key, value, column)
        if not isinstance(value, str):
            raise self.wrong(key, f'{key} is a range, e.g. "0 .. 1", with its unit behind it')
        return Axis(column, *self.range(key, value, column))

    def of_grid(self, key: str, value: list, column: Column) -> Axis:
        """Returns the axis of a list of values, or of a range with its number of points."""
        if len(value) == 2 and isinstance(value[0], str) and ".." in value[0]:
            lo, hi = self.range(key, value[0], column)
            points = value[1]
            if isinstance(points, bool) or not isinstance(points, int) or points < 1:
                raise self.wrong(key, f"{key}: how many points? a whole number behind the range")
            if points > limits.SWEEP:
                raise self.wrong(key, f"{key}: {points:,} points; the limit is {limits.SWEEP:,}")
            return Axis(column, lo, hi, points)
        if not value:
            raise self.wrong(key, f"{key} has no values")
        return Axis(column, values=tuple(self.value(key, x, column) for x in value))

    def column(self, key: str) -> Column:
        try:
            name = options_text.left_side(key, self.sizes).text()
        except OptionError as error:
            raise self.plan.wrong(self.plan.kind, key, error.diagnostic.message) from None
        if name in self.known:
            return self.known[name]
        if name in self.unread:
            scene = self.plan.options.get("scene")
            raise self.wrong(key, f"nothing that scene '{scene}' needs reads {name}")
        said = near(name, list(self.known), "parameter or start")
        raise self.wrong(key, f"the model has no such parameter, input, coordinate or rate; {said}")

    def range(self, key: str, text: str, column: Column) -> tuple[float, float]:
        ends = text.split("..")
        if len(ends) != 2 or not all(end.strip() for end in ends):
            raise self.wrong(key, f'{key} is a range: "LOW .. HIGH", with its unit behind it')
        unit = _UNIT.search(ends[1])  # The unit after the upper end also holds for the lower end.
        more = f" {unit[0]}" if unit and not _UNIT.search(ends[0]) else ""
        lo = self.value(key, ends[0].strip(), column, more)
        hi = self.value(key, ends[1].strip(), column)
        if lo > hi:
            raise self.wrong(key, f"{key}: the range runs backwards", f'"{hi:g} .. {lo:g}", in SI')
        if not math.isfinite(hi - lo):
            raise self.wrong(key, f"{key}: the range is wider than any double")
        return lo, hi

    def value(self, key: str, given: object, column: Column, unit: str = "") -> float:
        if isinstance(given, bool) or not isinstance(given, str | int | float):
            raise self.wrong(key, f"{key}: a value is a number, or a text with its unit")
        text = given if isinstance(given, str) else repr(given)
        try:
            found = float(
                options_text.quantity(
                    text + unit,
                    column.unit,
                    dimensionless=self.model.dimensionless,
                    values=self.sizes,
                    name=column.name,
                )
            )
        except OptionError as error:
            raise self.plan.wrong_within(self.plan.kind, key, text, error.diagnostic) from None
        except OverflowError:
            found = math.inf
        if not math.isfinite(found):
            raise self.wrong(key, f"{key}: {text} is not finite")
        return found
