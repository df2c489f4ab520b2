"""A model's expressions as nodes of the graph: names looked up, families and sums unrolled.

A value is one node, or for a vector a tuple of them. A prime is the total time derivative:
coordinates go over to rates, t to 1, an input to its derivative.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from typing import Union

from . import limits
from .constants import undefined
from .differentiate import Forward
from .graph import ONE, VARIABLE, ZERO, Graph, Kind, Node, Symbol, TooLarge
from .indices import NotAnInteger, assignments, integer
from .model import End, Model
from .quantities import Family, error, families, indexed, input_index, sizes
from .source import Span
from .tree import (
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
    Quantity,
    Range,
    Sum,
    Vector,
)

Value = Union[Node, tuple[Node, ...]]
Loop = dict[str, int]


class NeedsDerivative(Exception):
    """A derivative of an input occurs that has no symbol yet."""

    def __init__(self, position: int):
        super().__init__(position)
        self.position = position


class Acceleration(Exception):
    """The time derivative of a rate."""


class Expander:
    """Holds the graph while the statements of one model are entered into it."""

    def __init__(self, model: Model, orders: tuple[int, ...]):
        self.model = model
        self.orders = orders
        self.graph = Graph(limits.UNROLLED)
        self.sizes = sizes(model)
        self.coordinates = families(model, model.coordinates)
        self.parameters = families(model, model.parameters)
        self.inputs = {item.name: i for i, item in enumerate(model.inputs)}
        self.defined: dict[str, dict[int | None, Value]] = {}
        self.derivative = Forward(self.graph, VARIABLE, self._rate_of)
        self._ends = _ends(model, self.coordinates)
        self._visits = 0

    # -- statements ---------------------------------------------------------------------------

    @contextmanager
    def statement(self, span: Span) -> Iterator[None]:
        """What goes wrong inside is reported, at `span` unless a better place is known."""
        try:
            yield
        except TooLarge:
            raise error(
                self.model,
                f"the model unrolls to more than {limits.UNROLLED:,} operations",
                span,
                "make its families smaller",
            ) from None
        except NotAnInteger as wrong:
            raise error(self.model, wrong.message, wrong.span) from None
        except Acceleration:
            raise error(
                self.model,
                "an acceleration cannot be used here",
                span,
                "only first derivatives of coordinates may occur",
            ) from None

    def unrolled(
        self, index: Expr | None, range_: Range | None
    ) -> Iterator[tuple[int | None, Loop]]:
        """Each member that NAME, NAME[index] or NAME[i = lo..hi] stands for."""
        if range_ is not None:
            for loop in assignments((range_,), self.sizes):
                yield loop[range_.variable], loop
        else:
            yield (None if index is None else integer(index, self.sizes)), self.sizes

    def define(self, name: str, index: int | None, value: Value) -> None:
        self.defined.setdefault(name, {})[index] = value

    def scalar(self, expr: Expr, loop: Loop | None = None) -> Node:
        value = self.value(expr, self.sizes if loop is None else loop)
        if isinstance(value, tuple):
            raise error(self.model, "a vector where a single value is needed", expr.span)
        return value

    def value(self, expr: Expr, loop: Loop) -> Value:
        self._visits += 1
        if self._visits > limits.UNROLLED:
            raise TooLarge
        return _EXPAND[type(expr)](self, expr, loop)

    # -- names --------------------------------------------------------------------------------

    def name(self, expr: Name, loop: Loop) -> Value:
        name = expr.id
        index = None if expr.index is None else integer(expr.index, loop)
        if index is None and name in loop:
            return self.graph.number(loop[name])
        if name in self.coordinates:
            return self.coordinate(name, index, expr.span)
        if name in self.parameters:
            family = self._member(self.parameters[name], index, expr.span)
            return self.graph.symbol(Symbol(Kind.PARAMETER, family.flat(index)))
        if name in self.inputs:
            flat = input_index(self.orders, self.inputs[name], 0)
            return self.graph.symbol(Symbol(Kind.INPUT, flat))
        if name in self.defined:
            members = self.defined[name]
            if index not in members:
                raise error(self.model, f"'{indexed(name, index)}' is not defined", expr.span)
            return members[index]
        if name in _BUILT_IN:
            return self.graph.symbol(_BUILT_IN[name])
        raise error(self.model, f"unknown name '{name}'", expr.span)

    def coordinate(self, name: str, index: int | None, span: Span) -> Node:
        """A coordinate, or what the model says about the ends of its family."""
        family = self.coordinates[name]
        if not family.has(index) and index is not None:
            end = self._ends.get((name, index)) or self._ends.get((name, None))
            if end is not None and end.kind == "fixed":
                return self.scalar(end.value)
            if end is not None and end.kind == "periodic":
                index = family.lo + (index - family.lo) % (family.hi - family.lo + 1)
            elif end is not None:
                index = min(max(index, family.lo), family.hi)
        self._member(family, index, span, "say `fixed`, `free` or `periodic` about its ends")
        return self.graph.symbol(Symbol(Kind.COORDINATE, family.flat(index)))

    def _member(self, family: Family, index: int | None, span: Span, help: str = "") -> Family:
        if family.has(index):
            return family
        if family.lo is None:
            message = f"'{family.name}' is not a family: it takes no index"
        elif index is None:
            message = f"'{family.name}' is a family: it needs an index"
        else:
            message = f"'{family.name}[{index}]' is outside {family.lo}..{family.hi}"
        raise error(self.model, message, span, help if family.lo is not None else "")

    def _rate_of(self, node: Node) -> Node:
        symbol = self.graph.data[node]
        if symbol.kind is Kind.TIME:
            return ONE
        if symbol.kind is Kind.COORDINATE:
            return self.graph.symbol(Symbol(Kind.RATE, symbol.index))
        if symbol.kind is Kind.INPUT:
            return self.next_input(symbol)
        raise Acceleration

    def next_input(self, symbol: Symbol) -> Node:
        """The derivative of an input."""
        last = -1
        for position, order in enumerate(self.orders):
            last += order + 1
            if symbol.index == last:
                raise NeedsDerivative(position)
            if symbol.index < last:
                break
        return self.graph.symbol(Symbol(Kind.INPUT, symbol.index + 1))


_BUILT_IN = {"t": Symbol(Kind.TIME), "pi": Symbol(Kind.PI)}


def _ends(model: Model, coordinates: dict[str, Family]) -> dict[tuple[str, int | None], End]:
    """By family and index; without an index where the whole family wraps."""
    result: dict[tuple[str, int | None], End] = {}
    for end in model.ends:
        family = coordinates[end.name]
        if end.index is not None or end.kind == "periodic":
            result[end.name, end.index] = end
        else:
            result[end.name, family.lo - 1] = end
            result[end.name, family.hi + 1] = end
    return result


# -- expressions: a function a class of node -----------------------------------------------------


def _each(function: Callable[..., Node], *values: Value) -> Value:
    """A function of scalars component by component."""
    if isinstance(values[0], tuple):
        return tuple(function(*items) for items in zip(*values))
    return function(*values)


def _number(x: Expander, expr: Number, loop: Loop) -> Value:
    return x.graph.number(expr.value)


def _prime(x: Expander, expr: Prime, loop: Loop) -> Value:
    value = x.value(expr.of, loop)
    with x.statement(expr.span):
        return _each(x.derivative, value)


def _component(x: Expander, expr: Component, loop: Loop) -> Value:
    value = x.value(expr.of, loop)
    if not isinstance(value, tuple) or expr.axis >= len(value):
        raise error(x.model, f"there is no component .{'xyz'[expr.axis]} here", expr.span)
    return value[expr.axis]


def _negate(x: Expander, expr: Negate, loop: Loop) -> Value:
    return _each(x.graph.negate, x.value(expr.of, loop))


def _add(x: Expander, expr: Add, loop: Loop) -> Value:
    result: Value | None = None
    for term, sign in zip(expr.terms, expr.signs):
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


def _multiply(x: Expander, expr: Multiply, loop: Loop) -> Value:
    g = x.graph
    result: Value = ONE
    for factor, exponent in zip(expr.factors, expr.exponents):
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


def _power(x: Expander, expr: Power, loop: Loop) -> Value:
    g = x.graph
    base, exponent = x.scalar(expr.base, loop), x.scalar(expr.exponent, loop)
    constant = g.value(exponent)
    if constant is None:
        return g.call("pow", base, exponent)
    if abs(constant) > limits.EXPONENT:
        raise error(
            x.model, f"an exponent beyond {limits.EXPONENT:,} in magnitude", expr.exponent.span
        )
    number = g.value(base)
    if number == 0 and constant < 0:
        raise error(x.model, "division by zero", expr.span)
    if number is not None and number < 0 and constant.denominator != 1:
        raise error(x.model, "a negative number has no real power like this", expr.span)
    return g.power(base, constant)


def _call(x: Expander, expr: Call, loop: Loop) -> Value:
    values = [x.value(argument, loop) for argument in expr.arguments]
    if expr.function in _VECTOR:
        for value, argument in zip(values, expr.arguments):
            if _size(value) == 0 or _size(value) != _size(values[0]):
                raise error(x.model, f"{expr.function} takes vectors", argument.span)
        if expr.function == "cross" and _size(values[0]) != 3:
            raise error(x.model, "cross takes vectors of three components", expr.span)
        return _VECTOR[expr.function](x.graph, *values)
    for value, argument in zip(values, expr.arguments):
        if isinstance(value, tuple):
            raise error(x.model, "a vector where a single value is needed", argument.span)
    numbers = [x.graph.value(value) for value in values]
    if None not in numbers:
        wrong = undefined(expr.function, numbers)
        if wrong:
            raise error(x.model, wrong, expr.span)
    return x.graph.call(expr.function, *values)


def _dot(g: Graph, a: tuple[Node, ...], b: tuple[Node, ...]) -> Node:
    return g.sum(g.multiply(i, j) for i, j in zip(a, b))


def _cross(g: Graph, a: tuple[Node, ...], b: tuple[Node, ...]) -> tuple[Node, ...]:
    return tuple(
        g.subtract(g.multiply(a[i], b[j]), g.multiply(a[j], b[i]))
        for i, j in ((1, 2), (2, 0), (0, 1))
    )


def _norm(g: Graph, a: tuple[Node, ...]) -> Node:
    return g.call("sqrt", _dot(g, a, a))


def _sum(x: Expander, expr: Sum, loop: Loop) -> Value:
    result: Value | None = None
    for inner in assignments(expr.ranges, loop):
        value = x.value(expr.body, inner)
        result = value if result is None else _each(x.graph.add, result, value)
    return ZERO if result is None else result


def _vector(x: Expander, expr: Vector, loop: Loop) -> Value:
    return tuple(x.scalar(item, loop) for item in expr.items)


def _quantity(x: Expander, expr: Quantity, loop: Loop) -> Value:
    raise AssertionError("check folds units in")


_VECTOR = {"dot": _dot, "cross": _cross, "norm": _norm}
_EXPAND: dict[type, Callable[[Expander, Expr, Loop], Value]] = {
    Number: _number,
    Name: Expander.name,
    Prime: _prime,
    Component: _component,
    Negate: _negate,
    Add: _add,
    Multiply: _multiply,
    Power: _power,
    Call: _call,
    Sum: _sum,
    Vector: _vector,
    Quantity: _quantity,
}

__all__ = ["Expander", "Fraction", "NeedsDerivative", "Value"]
