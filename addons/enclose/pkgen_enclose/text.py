"""Writes bounds as text: rows with midpoint and radius per column, and a report."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from decimal import Decimal, localcontext
from fractions import Fraction
from math import ceil
from typing import Any

from .enclose import Enclosure

SPARE = 10  # A midpoint has at most this many digits more than requested.


def of_time(value: Fraction) -> str:
    """Returns the nearest double as text."""
    return repr(float(value)).removesuffix(".0")


def ball(value: Any, digits: int) -> tuple[str, str]:
    """Returns a midpoint and a radius, as decimals, of an interval that contains the ball. The
    midpoint has one digit more than the radius, but at most SPARE digits more than the requested
    number `digits`."""
    middle, radius = exact(value.mid()), exact(value.rad())
    place = (_exponent(middle) if middle else 0) - digits - SPARE
    place = max(place, _exponent(radius) - 2) if radius else place
    shown = Fraction(round(middle * Fraction(10) ** -place)) * Fraction(10) ** place
    radius += abs(middle - shown)
    middle_text = _decimal(shown, place)
    if not radius:
        return middle_text, "0"
    place = _exponent(radius) - 1
    return middle_text, _decimal(
        Fraction(10) ** place * ceil(radius / Fraction(10) ** place), place
    )


def exact(value: Any) -> Fraction:
    """Returns the exact value of a ball whose radius is 0."""
    man, exponent = value.man_exp()
    return int(man) * Fraction(2) ** int(exponent)


def _exponent(value: Fraction) -> int:
    """Returns the decimal exponent of the first digit of `value`, or that exponent minus one."""
    return len(str(value.numerator)) - len(str(value.denominator)) - 1


def _decimal(value: Fraction, place: int) -> str:
    """Returns the decimal text of a multiple of 10^place."""
    whole = int(value * Fraction(10) ** -place)
    found = Decimal((int(whole < 0), tuple(map(int, str(abs(whole)))), place))
    with localcontext() as context:
        context.prec = len(str(abs(whole))) + 1
        found = found.normalize()
    return f"{found:f}" if not found or -6 <= found.adjusted() <= 20 else f"{found:e}"


def header(names: Iterable[str]) -> str:
    return ",".join(["t", *(f"{name},radius({name})" for name in names)])


def lines(found: Enclosure) -> Iterator[str]:
    yield header(found.names)
    for row in found.rows:
        cells = [of_time(row.t)]
        for value in row.values:
            cells += ball(value, found.wanted)
        yield ",".join(cells)


def report(found: Enclosure, time: str) -> list[str]:
    unit = f" {time}" if time else ""
    attempts = "" if found.attempts == 1 else f", at the {_nth(found.attempts)} attempt"
    of_all = " of all motions between the ends given" if found.several else ""
    said = [
        f"enclosed: t = 0 to {of_time(found.reached)}{unit} within {found.steps} steps of order "
        f"{found.order}, {found.bits} bits, {found.seconds:.3g} s of CPU{attempts}",
        f"certified{of_all}: {found.digits} digits of every number (worst: {found.worst}); "
        f"widest: {found.widest}, {found.width:.2g} from bound to bound",
    ]
    if found.interrupted:
        said.append(f"pkgen: interrupted: the bounds go to t = {of_time(found.reached)}{unit}")
    elif not found.whole:
        help = "ends that are closer" if found.several else "more --digits"
        said.append(
            f"pkgen: the bounds end at t = {of_time(found.reached)}{unit}, before "
            f"{of_time(found.until)}: no further step has bounds, since they have become too wide "
            "or the equations end near there; a shorter --until, or "
            f"{help}, may help"
        )
    return said


def _nth(count: int) -> str:
    return {2: "second", 3: "third"}.get(count, f"{count}th")


def record(found: Enclosure) -> dict[str, object]:
    """Returns the result for JSON; numbers are text, since they have more digits than doubles."""
    status = "done" if found.whole else "bounds-lost"
    status = "interrupted" if found.interrupted else status
    return {
        "status": status,
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
