"""Converts expressions to nodes. EXPAND has a function for each expression class of `tree.py`."""

from __future__ import annotations

from collections.abc import Callable

from ... import limits
from ...functions import FUNCTIONS
from ...functions.tables import called
from ...graph.frames import DEEP, columns, combined, cross
from ...graph.graph import ONE, ZERO, Graph, Node
from ...graph.surfaces import protected
from ...indices import assignments
from ...tree import (
    COMPONENTS,
    Add,
    Call,
    Component,
    Expr,
    Multiply,
    Name,
    Negate,
    Number,
    Power,
    Prime,
    Sum,
    Vector,
)
from ..attitudes import rotated
from ..quantities import error
from .names import Loop, Names, Value, Vector3


def _each(function: Callable[..., Node], *values: Value) -> Value:
    """Applies a function of scalars to scalar values, or to vectors, component by component."""
    if isinstance(values[0], tuple):
        return tuple(function(*items) for items in zip(*values, strict=True))
    return function(*values)


def _prime(x: Names, expr: Prime, loop: Loop) -> Value:
    value = x.value(expr.of, loop)
    x.primes += [(node, expr.span) for node in (value if isinstance(value, tuple) else (value,))]
    with x.statement(expr.span):
        return _each(x.derivative, value)


def _component(x: Names, expr: Component, loop: Loop) -> Value:
    value = x.value(expr.of, loop)
    if not isinstance(value, tuple) or expr.axis >= len(value):
        raise error(x.model, f"there is no component .{COMPONENTS[expr.axis]} here", expr.span)
    return value[expr.axis]


def _add(x: Names, expr: Add, loop: Loop) -> Value:
    result: Value | None = None
    for term, sign in zip(expr.terms, expr.signs, strict=True):
        value = x.value(term, loop)
        if sign < 0:
            value = _each(x.graph.negate, value)
        if result is None:
            result = value
            continue
        if _size(result) != _size(value):
            raise error(x.model, "a vector can only be added to one of its length", term.span)
        result = _each(x.graph.add, result, value)
    return result


def _size(value: Value) -> int:
    return len(value) if isinstance(value, tuple) else 0


def _multiply(x: Names, expr: Multiply, loop: Loop) -> Value:
    g = x.graph
    result: Value = ONE
    for factor, exponent in zip(expr.factors, expr.exponents, strict=True):
        value = x.value(factor, loop)
        if isinstance(value, tuple) and (isinstance(result, tuple) or exponent < 0):
            raise error(
                x.model, "vectors are multiplied by dot or cross, and never divided by", factor.span
            )
        if exponent < 0:
            if value == ZERO:
                raise error(x.model, "division by zero", factor.span)
            value = g.power(value, -1)
        if isinstance(value, tuple):
            result, value = value, result
        result = _each(lambda a, b=value: g.multiply(a, b), result)
    return result


def _power(x: Names, expr: Power, loop: Loop) -> Value:
    g = x.graph
    base, exponent = x.scalar(expr.base, loop), x.scalar(expr.exponent, loop)
    constant = g.value(exponent)
    number = g.value(base)
    if constant is None:
        # The derivative of a power with a variable exponent contains the logarithm of the base.
        if number is not None and (number < 0 or (number == 0 and not g.is_constant(exponent))):
            what = "zero" if number == 0 else "a negative number"
            raise x.refused(f"{what} to a power that varies is not differentiable", expr.span)
        return g.call("pow", base, exponent)
    if abs(constant) > limits.EXPONENT:
        raise error(
            x.model, f"an exponent beyond {limits.EXPONENT:,} in magnitude", expr.exponent.span
        )
    if number == 0 and constant < 0:
        raise error(x.model, "division by zero", expr.span)
    if number is not None and number < 0 and constant.denominator != 1:
        raise error(x.model, "a negative number has no real power like this", expr.span)
    return g.power(base, constant)


def _turned(x: Names, expr: Call, loop: Loop) -> Vector3:
    """Returns a vector after the nested rotations of an expression. A long chain of rotations about
    fixed axes is computed as a matrix, which other vectors with the same rotations share."""
    g, turns = x.graph, []
    inner: Expr = expr
    while isinstance(inner, Call) and inner.function == "rotate":
        axis, angle = x.value(inner.arguments[0], loop), x.value(inner.arguments[1], loop)
        if all(item == ZERO for item in axis):
            raise error(x.model, "the axis of a rotation has no length", expr.span)
        turns.append((_unit(g, axis), angle))
        inner = inner.arguments[2]
    vector = x.value(inner, loop)
    if len(turns) >= DEEP and all(g.is_constant(i) for axis, _ in turns for i in axis):
        return combined(g, columns(g, tuple(turns), _rotate), vector)
    for axis, angle in reversed(turns):
        vector = _rotate(g, axis, angle, vector)
    return vector


def _call(x: Names, expr: Call, loop: Loop) -> Value:
    if expr.function == "rotate":
        return _turned(x, expr, loop)
    values = [x.value(argument, loop) for argument in expr.arguments]
    if expr.function == "attitude":
        return rotated(x.graph, *values)
    if expr.function in _VECTOR:
        for value, argument in zip(values, expr.arguments, strict=True):
            if _size(value) == 0 or _size(value) != _size(values[0]):
                raise error(x.model, f"{expr.function} takes vectors", argument.span)
        if expr.function == "cross" and _size(values[0]) != 3:
            raise error(x.model, "cross takes vectors of three components", expr.span)
        return _VECTOR[expr.function](x.graph, *values)
    for value, argument in zip(values, expr.arguments, strict=True):
        if isinstance(value, tuple):
            raise error(x.model, "a vector where a single value is needed", argument.span)
    numbers = [x.graph.value(value) for value in values]
    if None not in numbers:
        wrong = FUNCTIONS[expr.function].undefined(*numbers)
        if wrong:
            raise error(x.model, wrong, expr.span)
    if FUNCTIONS[expr.function].table:
        key = expr.function.partition(":")[0]
        data = next(item.data for item in x.model.tables if item.key == key)
        return called(x.graph, key, data, values)
    if expr.function == "select":
        g, (c, a, b) = x.graph, values
        values = [c, protected(g, a, c), protected(g, b, g.subtract(ONE, c))]
    return x.graph.call(expr.function, *values)


def _norm(g: Graph, a: Vector3) -> Node:
    return g.call("sqrt", g.dot(a, a))


def _unit(g: Graph, axis: Vector3) -> Vector3:
    length = g.power(_norm(g, axis), -1)
    return tuple(g.multiply(length, i) for i in axis)


def _rotate(g: Graph, n: Vector3, angle: Node, a: Vector3) -> Vector3:
    """Returns a vector a, rotated about the unit vector n, by Rodrigues' formula: c a + s (n x a) +
    (1 - c) (n.a) n, with c and s the cosine and sine of the angle."""
    c, s = g.call("cos", angle), g.call("sin", angle)
    along = g.multiply(g.subtract(ONE, c), g.dot(n, a))
    return tuple(
        g.sum((g.multiply(c, i), g.multiply(s, j), g.multiply(along, k)))
        for i, j, k in zip(a, cross(g, n, a), n, strict=True)
    )


def _sum(x: Names, expr: Sum, loop: Loop) -> Value:
    result: Value | None = None
    for inner in assignments(expr.ranges, loop):
        value = x.value(expr.body, inner)
        result = value if result is None else _each(x.graph.add, result, value)
    return ZERO if result is None else result


_VECTOR = {"dot": Graph.dot, "cross": cross, "norm": _norm}
EXPAND: dict[type, Callable[[Names, Expr, Loop], Value]] = {
    Number: lambda x, expr, loop: x.graph.number(expr.value),
    Name: lambda x, expr, loop: x.name(expr, loop),
    Prime: _prime,
    Component: _component,
    Negate: lambda x, expr, loop: _each(x.graph.negate, x.value(expr.of, loop)),
    Add: _add,
    Multiply: _multiply,
    Power: _power,
    Call: _call,
    Sum: _sum,
    Vector: lambda x, expr, loop: tuple(x.scalar(item, loop) for item in expr.items),
}  # there is no entry for units: the checker has replaced them by numbers
