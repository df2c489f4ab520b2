"""Arithmetic on constants, exact where possible, and values of checked expressions.

All results are bounded: a power that is too large is refused before it is computed, and a constant
outside the range of double is an error.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

from ... import limits
from ...functions import FUNCTIONS
from ...indices import assignments, integer
from ...tree import Add, Call, Component, Expr, Multiply, Name, Negate, Number, Power, Sum, Vector


class NoValue(Exception):
    """A constant has no value; the message gives the reason."""


def checked(value: Fraction | float) -> Fraction | float:
    """Returns the value; raises NoValue if it is outside the range of double."""
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


def added(values: Sequence[Fraction | float], signs: tuple[int, ...]) -> Fraction | float:
    total: Fraction | float = Fraction(0)
    for value, sign in zip(values, signs, strict=True):
        total = checked(_mixed(operator.add, total, value if sign > 0 else -value))
    return total


def multiplied(values: Sequence[Fraction | float], exponents: tuple[int, ...]) -> Fraction | float:
    total: Fraction | float = Fraction(1)
    for value, exponent in zip(values, exponents, strict=True):
        if exponent < 0 and value == 0:
            raise NoValue("division by zero")
        total = checked(_mixed(operator.mul if exponent > 0 else operator.truediv, total, value))
    return total


def _mixed(operation: Callable, a: Fraction | float, b: Fraction | float) -> Fraction | float:
    if isinstance(a, float) or isinstance(b, float):
        return operation(float(a), float(b))
    return operation(a, b)


def raised(base: Fraction | float, exponent: Fraction | float) -> Fraction | float:
    """Returns a power; raises NoValue, before it computes the power, if it would be too large."""
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


class Evaluation:
    """Evaluates checked expressions without derivatives. Subclasses override the operations for
    other number types. The keys of `values` are names, or (name, index) for family members."""

    added, multiplied = staticmethod(added), staticmethod(multiplied)
    raised, called = staticmethod(raised), staticmethod(called)

    def __init__(self, values: Mapping[object, object]) -> None:
        self.values = values

    def value(self, expr: Expr, sizes: Mapping[str, int]):
        """Returns a number, or a tuple for a vector. Raises NoValue, or KeyError for a name without
        a value."""
        match expr:
            case Number(value=value):
                return value
            case Name(id="pi", index=None):
                return math.pi
            case Name(id=name, index=None):
                return Fraction(sizes[name]) if name in sizes else self.values[name]
            case Name(id=name, index=index):
                return self.values[name, integer(index, sizes)]
            case Negate(of=of):
                return _each(lambda x: -x, [self.value(of, sizes)])
            case Add(terms=terms, signs=signs):
                return self._summed([self.value(x, sizes) for x in terms], signs)
            case Multiply(factors=factors, exponents=exponents):
                found = [self.value(x, sizes) for x in factors]
                return _each(lambda *xs: self.multiplied(xs, exponents), found)
            case Power(base=base, exponent=exponent):
                return self.raised(self.value(base, sizes), self.value(exponent, sizes))
            case Vector(items=items):
                return tuple(self.value(x, sizes) for x in items)
            case Component(of=of, axis=axis):
                return self.value(of, sizes)[axis]
            case Call(function=function, arguments=arguments):
                found = [self.value(x, sizes) for x in arguments]
                of_vectors = getattr(self, f"_{function}", None)
                return of_vectors(*found) if of_vectors else self.called(function, found)
            case Sum(body=body, ranges=ranges):
                found = [self.value(body, inner) for inner in assignments(ranges, sizes)]
                return self._summed(found, (1,) * len(found)) if found else 0
        raise NoValue("not a constant")

    def _summed(self, terms: list, signs: tuple[int, ...]):
        return _each(lambda *xs: self.added(xs, signs), terms)

    def _dot(self, a: tuple, b: tuple):
        products = [self.multiplied(pair, (1, 1)) for pair in zip(a, b, strict=True)]
        return self.added(products, (1, 1, 1))

    def _norm(self, a: tuple):
        return self.called("sqrt", [self._dot(a, a)])

    def _cross(self, a: tuple, b: tuple) -> tuple:
        def minor(j: int, k: int):
            products = [self.multiplied(pair, (1, 1)) for pair in ((a[j], b[k]), (a[k], b[j]))]
            return self.added(products, (1, -1))

        return minor(1, 2), minor(2, 0), minor(0, 1)

    def _rotate(self, axis: tuple, angle, vector: tuple) -> tuple:
        """Rotates a vector by Rodrigues' formula, in the same form as middle/expand/terms.py."""
        length = self._norm(axis)
        n = tuple(self.multiplied([x, length], (1, -1)) for x in axis)
        c, s = self.called("cos", [angle]), self.called("sin", [angle])
        along = self.multiplied([1 - c, self._dot(n, vector)], (1, 1))
        return tuple(
            self.added([c * x, s * y, self.multiplied([along, z], (1, 1))], (1, 1, 1))
            for x, y, z in zip(vector, self._cross(n, vector), n, strict=True)
        )


def evaluate(expr: Expr, values: Mapping[object, object], sizes: Mapping[str, int]):
    return Evaluation(values).value(expr, sizes)


def _each(operation: Callable, arguments: list):
    """Applies an operation to numbers; to vectors component by component."""
    if not any(isinstance(a, tuple) for a in arguments):
        return operation(*arguments)
    rows = ([a[i] if isinstance(a, tuple) else a for a in arguments] for i in range(3))
    return tuple(operation(*row) for row in rows)
