"""Finds the nodes of the names in a model: coordinates, members of families, ends of families, and
time derivatives.

A value is one node, or a tuple of nodes for a vector. A prime (') is the total time derivative of
an expression.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import accumulate
from typing import TypeVar

from ... import limits
from ...equations import Attitude
from ...graph.differentiate import Forward
from ...graph.graph import ONE, VARIABLE, ZERO, Graph, Kind, Node, Symbol, TooLarge
from ...indices import NotAnInteger, assignments, integer
from ...model import Coordinate, End, Input, Model, Rotation
from ...source import Span
from ...tree import Expr, Name, Range
from ..attitudes import body_rates, rate_of_quaternion
from ..quantities import (
    Family,
    error,
    families,
    has_bodies,
    indexed,
    input_index,
    input_quantities,
    rate_of_state,
    sizes,
    smaller,
    symbols,
    too_deep,
)

Vector3 = tuple[Node, ...]
Value = Node | Vector3
Loop = dict[str, int]
Derived = TypeVar("Derived")
Statement = TypeVar("Statement")  # about NAME, NAME[index] or NAME[i = lo..hi], with a value
BUILT_IN = {"t": Symbol(Kind.TIME), "pi": Symbol(Kind.PI)}


class NeedsDerivative(Exception):
    """A time derivative of an input is needed for which there is no symbol yet."""

    def __init__(self, position: int):
        super().__init__(position)
        self.position = position


def entered(model: Model, derive: Callable[[tuple[int, ...]], Derived]) -> Derived:
    """Returns derive(orders). For each input, `orders` has the number of its time derivatives that
    get symbols. If `derive` needs a further derivative of an input, it raises NeedsDerivative, and
    is called again with one more derivative of this input."""
    orders = [item.order for item in model.inputs]
    for item, order in zip(model.inputs, orders, strict=True):
        if order and item.by:
            raise _held(model, item)
    while True:
        try:
            return derive(tuple(orders))
        except NeedsDerivative as needed:
            item = model.inputs[needed.position]
            if item.by:
                raise _held(model, item) from None
            orders[needed.position] += 1
            if orders[needed.position] > limits.DEPTH:
                raise error(model, f"too many derivatives of '{item.name}'", item.span) from None


def _held(model: Model, item: Input) -> Exception:
    message = f"'{item.name}' is held between samples: it has no derivative"
    return error(model, message, item.span, f"write what needs {item.name}' without it")


def next_input(orders: tuple[int, ...], index: int) -> int:
    """Returns the flat index of the time derivative of the input (or input derivative) at
    `index`."""
    ends = [*accumulate(order + 1 for order in orders)]
    if index + 1 in ends:
        raise NeedsDerivative(ends.index(index + 1))
    return index + 1


class Acceleration(Exception):
    """The time derivative of a rate was taken where accelerations are not allowed."""


class Names(ABC):
    """The graph and the tables of names of one model while its statements are converted to
    nodes."""

    def __init__(self, model: Model, orders: tuple[int, ...]):
        self.model = model
        self.orders = orders
        self.graph = Graph(limits.UNROLLED)
        self.sizes = sizes(model)
        self.coordinates = families(model, model.coordinates, side_by_side=True)
        self.states = families(model, model.states, side_by_side=True)
        self.parameters = families(model, model.parameters)
        self.inputs = {item.name: i for i, item in enumerate(model.inputs)}
        self.attitudes = tuple(
            Attitude(self.coordinates[r.turns[0]].flat(i), self.states[r.quaternion[0]].flat(i))
            for r in model.rotations
            for i in self.coordinates[r.turns[0]].members
        )
        self._attitude_of = {k: a for a in self.attitudes for k in a.numbers}
        self._body_rates = {
            rate: (rotation, axis)
            for rotation in model.rotations
            for axis, rate in enumerate(rotation.rates)
        }
        self.defined: dict[str, dict[int | None, Value]] = {}
        self.assigned: dict[str, Value] = {}  # by the current sample block so far
        # Names whose values are computed where they first occur.
        self.later: dict[str, Callable[[Span], Node]] = {}
        self.refusals: dict[tuple[str, int | None], tuple[str, str]] = {}
        self.derivative = Forward(self.graph, VARIABLE, self._rate_of)
        # Maps the symbol of each state's time derivative to its expression. None while the model's
        # statements must not use accelerations.
        self.solved: Mapping[Node, Node] | None = None
        self._ends = _ends(model, self.coordinates | self.states)
        # The nodes whose time derivatives were taken, with the places in the model's text.
        self.primes: list[tuple[Node, Span]] = []

    @property
    def count(self) -> int:
        """The number of scalar coordinates: each member of a family counts."""
        return sum(family.count for family in self.coordinates.values())

    @property
    def members(self) -> list[tuple[Coordinate, int | None]]:
        """The declaration of each scalar coordinate, with its index in the family, in the order of
        flat indices."""
        found = {
            self.coordinates[item.name].flat(i): (item, i)
            for item in self.model.coordinates
            for i in self.coordinates[item.name].members
        }
        return [found[k] for k in sorted(found)]

    @property
    def state_count(self) -> int:
        return sum(family.count for family in self.states.values())

    # -- statements ---------------------------------------------------------------------------

    @contextmanager
    def statement(self, span: Span) -> Iterator[None]:
        """Converts exceptions raised inside the `with` block to ModelError. The error is at `span`
        unless the exception has a span."""
        try:
            yield
        except TooLarge:
            raise error(
                self.model,
                "the model is too large once its families, sums and bodies are written out"
                if has_bodies(self.model)
                else "the model is too large once its families and sums are unrolled",
                span,
                smaller(self.model),
            ) from None
        except RecursionError:
            raise error(self.model, *too_deep(span)) from None
        except NotAnInteger as wrong:
            raise error(self.model, wrong.message, wrong.span) from None
        except Acceleration:
            raise error(
                self.model,
                "an acceleration cannot be used here",
                span,
                "outputs may use accelerations, all else the first derivatives of coordinates",
            ) from None

    def input_nodes(self) -> tuple[Node, ...]:
        """Returns the symbols of all inputs, those of their derivatives among them."""
        return symbols(self.graph, Kind.INPUT, len(input_quantities(self.model, self.orders)))

    def unrolled(
        self, index: Expr | None, range_: Range | None
    ) -> Iterator[tuple[int | None, Loop]]:
        """Yields the index and the values of loop variables for each member in a statement about
        NAME, NAME[index] or NAME[i = lo..hi]."""
        if range_ is not None:
            for loop in assignments((range_,), self.sizes):
                yield loop[range_.variable], loop
        else:
            yield (None if index is None else integer(index, self.sizes)), self.sizes

    def members_of(
        self, items: Iterable[Statement], scalar: bool = True
    ) -> Iterator[tuple[Statement, int | None, Value]]:
        """Yields (statement, index, value) for each member in each statement. With `scalar` a
        vector is an error."""
        for item in items:
            with self.statement(item.span):
                for index, loop in self.unrolled(item.index, item.range):
                    value = (self.scalar if scalar else self.value)(item.value, loop)
                    yield item, index, value

    def define_all(self) -> None:
        """Defines the names of the model's definitions."""
        for item, index, value in self.members_of(self.model.definitions, scalar=False):
            self.define(item.name, index, value)

    def total(self, exprs: Iterable[Expr]) -> Node:
        """Returns the sum of the expressions."""
        total = ZERO
        for expr in exprs:
            with self.statement(expr.span):
                total = self.graph.add(total, self.scalar(expr))
        return total

    def define(self, name: str, index: int | None, value: Value) -> None:
        self.defined.setdefault(name, {})[index] = value

    def refuse(self, name: str, index: int | None, message: str, help: str) -> None:
        """Declares that the name `name` has no value, and sets the error message for expressions
        that use it."""
        self.refusals[name, index] = message, help

    def scalar(self, expr: Expr, loop: Loop | None = None) -> Node:
        value = self.value(expr, self.sizes if loop is None else loop)
        if isinstance(value, tuple):
            raise error(self.model, "a vector where a single value is needed", expr.span)
        return value

    @abstractmethod
    def value(self, expr: Expr, loop: Loop) -> Value:
        """Returns the value of an expression. `Expander` implements this method."""

    def refused(self, message: str, span: Span) -> Exception:
        """Returns the exception to raise for an expression that cannot be expanded."""
        return error(self.model, message, span)

    # -- names --------------------------------------------------------------------------------

    def name(self, expr: Name, loop: Loop) -> Value:
        name = expr.id
        index = None if expr.index is None else integer(expr.index, loop)
        if index is None and name in loop:
            return self.graph.number(loop[name])
        if name in self.assigned:
            return self.assigned[name]
        if name in self._body_rates:
            return self._body_rate(*self._body_rates[name], index, expr.span)
        if name in self.coordinates or name in self.states:
            return self.coordinate(name, index, expr.span)
        if name in self.parameters:
            family = self._member(self.parameters[name], index, expr.span)
            return self.graph.symbol(Symbol(Kind.PARAMETER, family.flat(index)))
        if name in self.inputs:
            return self.input(name)
        if (name, index) in self.refusals:
            message, help = self.refusals[name, index]
            raise error(self.model, message, expr.span, help)
        if name in self.later and name not in self.defined:
            self.define(name, None, self.later[name](expr.span))
        if name in self.defined:
            members = self.defined[name]
            if index not in members:
                raise error(self.model, f"'{indexed(name, index)}' is not defined", expr.span)
            return members[index]
        if name in BUILT_IN:
            return self.graph.symbol(BUILT_IN[name])
        raise error(self.model, f"unknown name '{name}'", expr.span)

    def input(self, name: str) -> Node:
        flat = input_index(self.orders, self.inputs[name])
        return self.graph.symbol(Symbol(Kind.INPUT, flat))

    def coordinate(self, name: str, index: int | None, span: Span) -> Node:
        """Returns the node of a coordinate or a state. For an index outside the family, returns the
        value that the model declares for this end of the family."""
        kind = Kind.STATE if name in self.states else Kind.COORDINATE
        at = self._place(name, index, span)
        return self.scalar(at.value) if isinstance(at, End) else self.graph.symbol(Symbol(kind, at))

    def _body_rate(self, rotation: Rotation, axis: int, index: int | None, span: Span) -> Node:
        """Returns the node of a body rate. At a fixed end of the family it is computed from the
        prescribed quaternion."""
        at = self._place(rotation.turns[axis], index, span)
        if not isinstance(at, End):
            return self.graph.symbol(Symbol(Kind.RATE, at))
        numbers = tuple(self.coordinate(name, index, span) for name in rotation.quaternion)
        return body_rates(self.graph, numbers, tuple(map(self.derivative, numbers)))[axis]

    def _place(self, name: str, index: int | None, span: Span) -> int | End:
        """Returns the flat index of a coordinate or a state. For an index outside the family at a
        fixed end, returns the declaration of this end."""
        family = self.states[name] if name in self.states else self.coordinates[name]
        if not family.has(index) and index is not None:
            end = self._ends.get((name, index)) or self._ends.get((name, None))
            if end is not None and end.kind == "fixed":
                return end
            if end is not None and end.kind == "periodic":
                index = family.lo + (index - family.lo) % (family.hi - family.lo + 1)
            elif end is not None:
                index = min(max(index, family.lo), family.hi)
        self._member(family, index, span, "say `fixed`, `free` or `periodic` about its ends")
        return family.flat(index)

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
            return self.graph.symbol(Symbol(Kind.INPUT, next_input(self.orders, symbol.index)))
        if symbol.kind is Kind.STATE and symbol.index in self._attitude_of:
            attitude = self._attitude_of[symbol.index]
            return rate_of_quaternion(self.graph, attitude, symbol.index)
        if symbol.kind is Kind.STATE and symbol.index < self.state_count:
            return rate_of_state(self.graph, symbol.index, self.state_count)
        if self.solved is not None and symbol.kind is Kind.RATE:
            return self.graph.symbol(Symbol(Kind.ACCELERATION, symbol.index))
        if self.solved is not None and symbol.kind is Kind.STATE:
            return self.derivative(self.solved[node])
        raise Acceleration


def _ends(model: Model, coordinates: dict[str, Family]) -> dict[tuple[str, int | None], End]:
    """Returns the declarations of the ends of families, by family and index. For a periodic family
    the index is None."""
    result: dict[tuple[str, int | None], End] = {}
    for end in model.ends:
        family = coordinates[end.name]
        if end.index is not None or end.kind == "periodic":
            result[end.name, end.index] = end
        else:
            result[end.name, family.lo - 1] = end
            result[end.name, family.hi + 1] = end
    return result
