"""Arithmetic on constants, exact where it can be, and the value of a checked expression.

Nothing here can blow up: a power is refused before it is computed, and a constant that no
double can hold is an error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from fractions import Fraction

from ... import limits
from ...functions import FUNCTIONS
from ...indices import assignments, integer
from ...tree import Add, Call, Component, Expr, Multiply, Name, Negate, Number, Power, Sum, Vector


class NoValue(Exception):
    """A constant that cannot be; the message says why."""


def checked(value: Fraction | float) -> Fraction | float:
    """The value itself, if a double can hold it."""
    try:
        rounded = float(value)
    except OverflowError:
        raise NoValue("this constant is too large for a double") from None
    if not math.isfinite(rounded):
        raise NoValue("this constant is not finite")
    if lost := limits.lost(value, rounded):
        raise NoValue(lost)
    if isinstance(value, Fraction) and _bits(value) > limits.CONSTANT_BITS:
        raise NoValue(f"this constant takes more than {limits.CONSTANT_BITS} bits to write exactly")
    return value


def _bits(value: Fraction) -> int:
    return max(value.numerator.bit_length(), value.denominator.bit_length())


def added(values: list[Fraction | float], signs: tuple[int, ...]) -> Fraction | float:
    total: Fraction | float = Fraction(0)
    for value, sign in zip(values, signs, strict=True):
        total = checked(_mixed(lambda a, b: a + b, total, value if sign > 0 else -value))
    return total


def multiplied(values: list[Fraction | float], exponents: tuple[int, ...]) -> Fraction | float:
    total: Fraction | float = Fraction(1)
    for value, exponent in zip(values, exponents, strict=True):
        if exponent < 0 and value == 0:
            raise NoValue("division by zero")
        if exponent > 0:
            total = checked(_mixed(lambda a, b: a * b, total, value))
        else:
            total = checked(_mixed(lambda a, b: a / b, total, value))
    return total


def _mixed(operation: Callable, a: Fraction | float, b: Fraction | float) -> Fraction | float:
    if isinstance(a, float) or isinstance(b, float):
        return operation(float(a), float(b))
    return operation(a, b)


def raised(base: Fraction | float, exponent: Fraction | float) -> Fraction | float:
    """A power; never computes one that is too large."""
    if base == 0 and exponent < 0:
        raise NoValue("division by zero")
    if abs(exponent) > limits.EXPONENT:
        raise NoValue(f"an exponent beyond {limits.EXPONENT}")
    exact = isinstance(base, Fraction) and isinstance(exponent, Fraction)
    if exact and exponent.denominator == 1 and _bits(base) * abs(exponent) <= limits.CONSTANT_BITS:
        return checked(base ** int(exponent))
    if base < 0 and exponent != int(exponent):
        raise NoValue("a negative number to a power that is no integer is not real")
    try:
        result = float(base) ** float(exponent)
    except OverflowError:
        raise NoValue("this constant is too large for a double") from None
    if lost := limits.lost(base, result):
        raise NoValue(lost)
    return checked(result)


def called(function: str, arguments: list[Fraction | float]) -> float:
    apply = FUNCTIONS[function].real
    try:
        return checked(float(apply(*(float(a) for a in arguments))))
    except ValueError:
        raise NoValue(f"{function} has no real value here") from None
    except OverflowError:
        raise NoValue("this constant is too large for a double") from None


def evaluate(expr: Expr, values: Mapping[object, object], sizes: Mapping[str, int]):
    """The value of a checked expression without derivatives; raises NoValue.

    `values` gives names, and members of families under (name, index).
    """
    match expr:
        case Number(value=value):
            return value
        case Name(id="pi", index=None):
            return math.pi
        case Name(id=name, index=None):
            if name in sizes:
                return Fraction(sizes[name])
            return values[name]
        case Name(id=name, index=index):
            return values[name, integer(index, sizes)]
        case Negate(of=of):
            return _each(lambda x: -x, evaluate(of, values, sizes))
        case Add(terms=terms, signs=signs):
            return _each(
                lambda *xs: added(list(xs), signs), *(evaluate(x, values, sizes) for x in terms)
            )
        case Multiply(factors=factors, exponents=exponents):
            return _each(
                lambda *xs: multiplied(list(xs), exponents),
                *(evaluate(x, values, sizes) for x in factors),
            )
        case Power(base=base, exponent=exponent):
            return raised(evaluate(base, values, sizes), evaluate(exponent, values, sizes))
        case Vector(items=items):
            return tuple(evaluate(x, values, sizes) for x in items)
        case Component(of=of, axis=axis):
            return evaluate(of, values, sizes)[axis]
        case Call(function=function, arguments=arguments):
            return _call(function, [evaluate(x, values, sizes) for x in arguments])
        case Sum(body=body, ranges=ranges):
            terms = [evaluate(body, values, inner) for inner in assignments(ranges, sizes)]
            return _each(lambda *xs: added(list(xs), (1,) * len(xs)), *terms) if terms else 0
    raise NoValue("not a constant")


def _call(function: str, arguments: list):
    if function == "dot":
        return added(
            [multiplied([a, b], (1, 1)) for a, b in zip(*arguments, strict=True)], (1, 1, 1)
        )
    if function == "norm":
        return called("sqrt", [_call("dot", [arguments[0], arguments[0]])])
    if function == "rotate":
        return _rotated(*arguments)
    if function == "cross":
        a, b = arguments
        return tuple(
            added([multiplied([a[j], b[k]], (1, 1)), multiplied([a[k], b[j]], (1, 1))], (1, -1))
            for j, k in ((1, 2), (2, 0), (0, 1))
        )
    return called(function, arguments)


def _rotated(axis: tuple, angle, vector: tuple) -> tuple:
    """As in middle/expand/terms.py."""
    length = _call("norm", [axis])
    n = tuple(multiplied([x, length], (1, -1)) for x in axis)
    c, s = called("cos", [angle]), called("sin", [angle])
    along = multiplied([1 - c, _call("dot", [n, vector])], (1, 1))
    return tuple(
        added([c * x, s * y, multiplied([along, z], (1, 1))], (1, 1, 1))
        for x, y, z in zip(vector, _call("cross", [n, vector]), n, strict=True)
    )


def _each(operation: Callable, *arguments):
    """Applies an operation to numbers, or to each component where there are vectors."""
    if not any(isinstance(a, tuple) for a in arguments):
        return operation(*arguments)
    rows = ([a[i] if isinstance(a, tuple) else a for a in arguments] for i in range(3))
    return tuple(operation(*row) for row in rows)
