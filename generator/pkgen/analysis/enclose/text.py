"""Bounds as text: rows of a middle and a radius a column, and what is said of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from decimal import Decimal
from fractions import Fraction
from typing import Any

from .enclose import Enclosure

SPARE = 3  # digits of a middle beyond its radius


def of_time(value: Fraction) -> str:
    """As the double that is nearest."""
    return repr(float(value)).removesuffix(".0")


def ball(value: Any, digits: int) -> tuple[str, str]:
    """A middle and a radius as decimals; what is inside the ball is within them."""
    middle, radius, exponent = value.mid_rad_10exp(digits)
    return _decimal(int(middle), exponent), _decimal(int(radius), exponent)


def _decimal(whole: Any, exponent: Any) -> str:
    found = Decimal(int(whole)).scaleb(int(exponent)).normalize()
    return f"{found:f}" if not found or -6 <= found.adjusted() <= 20 else f"{found:e}"


def header(names: Iterable[str]) -> str:
    return ",".join(["t", *(f"{name},radius({name})" for name in names)])


def lines(found: Enclosure) -> Iterator[str]:
    yield header(found.names)
    for row in found.rows:
        cells = [of_time(row.t)]
        for value in row.values:
            cells += ball(value, found.wanted + SPARE)
        yield ",".join(cells)


def report(found: Enclosure, time: str) -> list[str]:
    unit = f" {time}" if time else ""
    attempts = "" if found.attempts == 1 else f", at the {_nth(found.attempts)} attempt"
    said = [
        f"enclosed: t = 0 to {of_time(found.reached)}{unit} within {found.steps} steps of order "
        f"{found.order}, {found.bits} bits, {found.seconds:.3g} s of CPU{attempts}",
        f"certified: {found.digits} digits of every number (worst: {found.worst}); "
        f"widest: {found.widest}, {found.width:.2g} from bound to bound",
    ]
    if not found.whole:
        said.append(
            f"pkgen: the bounds end at t = {of_time(found.reached)}{unit}, before "
            f"{of_time(found.until)}: no further step has bounds, since they have become too wide "
            "or the equations end near there; a shorter --until, or more --digits, may help"
        )
    return said


def _nth(count: int) -> str:
    return {2: "second", 3: "third"}.get(count, f"{count}th")


def record(found: Enclosure) -> dict[str, object]:
    """As JSON; numbers are text, since no double holds them."""
    return {
        "status": "done" if found.whole else "bounds-lost",
        "t": of_time(found.reached),
        "until": of_time(found.until),
        "digits": {"wanted": found.wanted, "certified": found.digits, "worst": found.worst},
        "width": {"largest": found.width, "column": found.widest},
        "steps": found.steps,
        "order": found.order,
        "bits": found.bits,
        "seconds": found.seconds,
        "attempts": found.attempts,
        "columns": header(found.names).split(","),
        "rows": [line.split(",") for line in list(lines(found))[1:]],
    }
