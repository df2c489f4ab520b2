"""Checks that default values are within their bounds; both are evaluated as in the generated C."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from fractions import Fraction

from ... import limits
from ... import model as m
from ...indices import indexed, integer
from .names import Report
from .values import NoValue, evaluate


def check_bounds(
    parameters: list[m.Parameter],
    definitions: list[m.Definition],
    sizes: Mapping[str, int],
    report: Report,
    order: Callable[[int], tuple[int, ...]],
) -> None:
    """Reports defaults that are not finite or out of bounds, and bounds that admit no value."""
    values: dict[object, object] = {}
    items = sorted([*parameters, *definitions], key=lambda x: order(x.span.start))
    for item in items:
        if isinstance(item, m.Definition):
            with suppress(NoValue, KeyError):  # The `let` is not constant, or has an error.
                values[item.name] = evaluate(item.value, values, sizes)
            continue
        bounds = ends_of(item, values, sizes, report)
        for index in _indices(item, sizes):
            inner = sizes if index is None else {**sizes, item.range.variable: index}
            shown = indexed(item.name, index)
            try:
                value = evaluate(item.default, values, inner)
            except KeyError:
                break  # The default depends on a parameter with an error.
            except NoValue as error:
                report.error(f"the default of {shown}: {error}", item.default)
                value = Fraction(1)
                bounds = None
            values[item.name if index is None else (item.name, index)] = value
            if bounds is not None and not within(value, item.bounds, bounds):
                report.error(
                    f"the default of {shown} is outside its bounds:"
                    f" {number(value, item.unit)} is not in {interval(item.bounds, bounds)}",
                    item.default,
                    f"a bound without a unit is in [{item.unit}]" if item.unit else "",
                )
                bounds = None  # One error for each family is enough.


def _indices(item: m.Parameter, sizes: Mapping[str, int]):
    if item.range is None:
        return [None]
    lo, hi = integer(item.range.lo, sizes), integer(item.range.hi, sizes)
    if hi - lo < limits.SAMPLED:
        return range(lo, hi + 1)
    half = limits.SAMPLED // 2  # Only the first and last members of a long family are checked.
    return [*range(lo, lo + half), *range(hi - half + 1, hi + 1)]


def ends_of(item: m.Parameter, values: dict, sizes: Mapping[str, int], report: Report):
    """Returns the values (lo, hi) of a parameter's bounds; an infinite bound is None. Returns None
    after an error."""
    ends = []
    for end in (item.bounds.lo, item.bounds.hi):
        try:
            ends.append(None if end is None else evaluate(end, values, sizes))
        except KeyError:
            return None
        except NoValue as error:
            report.error(f"a bound of {item.name}: {error}", end)
            return None
    lo, hi = ends
    if lo is None or hi is None:
        return lo, hi
    if lo > hi or (lo == hi and (item.bounds.lo_open or item.bounds.hi_open)):
        message = f"no value of {item.name} lies in {interval(item.bounds, (lo, hi))}"
        help = "the lower bound comes first"
        report.error(message, item.bounds.lo.span.to(item.bounds.hi.span), help)
        return None
    return lo, hi


def within(value, bounds: m.Bounds, ends) -> bool:
    # as doubles, which the C compares: -0.1 is not the fraction -1/10
    value, (lo, hi) = float(value), (end if end is None else float(end) for end in ends)
    above = lo is None or (value > lo if bounds.lo_open else value >= lo)
    below = hi is None or (value < hi if bounds.hi_open else value <= hi)
    return above and below


def number(value, unit: str = "") -> str:
    return f"{float(value):.12g}" + (f" [{unit}]" if unit else "")


def interval(bounds: m.Bounds, ends) -> str:
    lo, hi = ends
    lo, hi = "-inf" if lo is None else number(lo), "inf" if hi is None else number(hi)
    return f"{'(' if bounds.lo_open else '['}{lo}, {hi}{')' if bounds.hi_open else ']'}"
