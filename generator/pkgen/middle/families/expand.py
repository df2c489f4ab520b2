"""Converts expressions to nodes for loops. A symbol stands for a member such as q[m+1] of a family,
where m is the index of the equation (row) that is computed."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from itertools import pairwise
from typing import Protocol

from ... import limits
from ...graph.affine import LOOPS, Affine
from ...graph.differentiate import Forward
from ...graph.graph import ONE, VARIABLE, ZERO, Graph, Node
from ...graph.magnitudes import Magnitudes
from ...model import Definition, End, Model
from ...source import Span
from ...tree import Expr, Name, Sum, children
from ..attitudes import body_rates
from ..expand.names import BUILT_IN, Value, next_input
from ..expand.terms import EXPAND
from ..quantities import error, input_index, input_quantities
from .indexed_ir import Group, NotKept, Slot
from .indices import Indices, Loop, size_values
from .rotations import Rotations
from .slots import Slots


class Sums(Protocol):
    """Converts a sum inside an expression to a node."""

    def of(self, expr: Sum, loop: Loop) -> Node: ...


class Totals(Sums, Protocol):
    def rate(self, slot: Slot) -> Node: ...
    def is_fixed(self, slot: Slot) -> bool: ...


class Alongside(Protocol):
    """Converts `let` definitions that only outputs use: `member` returns the value of a member,
    `rate` its time derivative."""

    def member(self, name: str, index: Affine) -> Value: ...
    def rate(self, slot: Slot) -> Node: ...


class FamilyExpander(Indices):
    """The graph, its symbols and the tables of names of one model with loops. Takes the place of
    `Expander` as argument of the functions in expand/terms.py."""

    def __init__(self, model: Model, orders: tuple[int, ...]):
        super().__init__(model, Slots(Graph(limits.UNROLLED)))
        self.orders = orders
        self.primes: list[tuple[Node, Span]] = []
        moving = (*model.coordinates, *model.states)
        self.coordinates = {c.name: self._group(c) for c in moving}
        self.parameters = {p.name: self._group(p) for p in model.parameters}
        self.rotations = Rotations(model, self.slots)
        self.inputs = {item.name: i for i, item in enumerate(model.inputs)}
        self.definitions: dict[str, list[Definition]] = {}
        for item in model.definitions:
            self.definitions.setdefault(item.name, []).append(item)
        # `let` definitions by recurrences (see `Carried`): a Group for each vector component.
        self.carried: dict[str, tuple[Group, ...]] = {}
        # Built-in outputs and the outputs converted so far.
        self.outputs: dict[str, Node] = {}
        # Outputs with a value for each index.
        self.of_members: dict[str, Definition] = {}
        # Maps the names of multipliers to their constraint rows.
        self.multipliers: dict[str, list[Group]] = {}
        # Maps the names of momenta, which only outputs may use, to their coordinates.
        self.momenta: dict[str, Group] = {}
        self.derivative = Forward(self.graph, VARIABLE, self._rate_of)
        # The object that converts sums inside expressions. Assembler (rows.py) sets it.
        self.totals: Totals | None = None
        # The object that converts `let` definitions that only outputs use. Outputs (statements.py)
        # sets it.
        self.alongside: Alongside | None = None
        # The object that converts sums in initial values and parameters. It is None unless an
        # initial value or a parameter is being converted.
        self.once: Sums | None = None
        # The number of sums in initial values and parameters that have been converted.
        self.summed = 0
        # Whether the expressions that are converted are outputs.
        self.watched = False
        self.assigned: dict[str, Value] = {}  # by the current sample block so far
        self._defining: list[str] = []
        self._visits = 0
        self._magnitudes = Magnitudes(self.graph)

    def input_nodes(self) -> tuple[Node, ...]:
        """Returns the symbols of all inputs, those of their derivatives among them."""
        count = len(input_quantities(self.model, self.orders))
        return tuple(self.slots.node("input", str(k)) for k in range(count))

    def statement(self, span: Span) -> AbstractContextManager:
        """Returns a context that does nothing. `Expander` adds the span to errors here; in loops,
        errors raise NotKept with a reason."""
        return nullcontext()

    # -- expressions --------------------------------------------------------------------------

    def scalar(self, expr: Expr, loop: Loop | None = None) -> Node:
        value = self.value(expr, self.sizes if loop is None else loop)
        if isinstance(value, tuple):
            raise NotKept("vectors are summed where loops add numbers")
        return value

    def value(self, expr: Expr, loop: Loop) -> Value:
        self._visits += 1
        if self._visits > limits.VISITS:
            raise NotKept("its expressions are too large")
        if isinstance(expr, Sum):
            return (self.once or self.totals).of(expr, loop)
        value = EXPAND[type(expr)](self, expr, loop)
        for node in value if isinstance(value, tuple) else (value,):
            self.check_magnitude(node, expr.span)
        return value

    def check_magnitude(self, node: Node, span: Span) -> None:
        """Raises ModelError if a constant factor of the node overflows or underflows a double."""
        wrong = self._magnitudes.wrong(node)
        if wrong:
            raise error(self.model, wrong, span)

    def refused(self, message: str, span: Span) -> Exception:
        """Returns the exception for an expression that is not allowed: NotKept, since the unrolled
        model may be valid. For example, an index in an exponent then is a number."""
        return NotKept(message)

    def name(self, expr: Name, loop: Loop) -> Value:
        name = expr.id
        index = None if expr.index is None else self.index(expr.index, loop)
        if index is None and name in loop:
            return self.slots.number(loop[name])
        if name in self.assigned:
            return self.assigned[name]
        if name in self.coordinates:
            return self.coordinate(name, index)
        if name in self.rotations.rates:
            rotation, axis = self.rotations.rates[name]
            return self._rate(rotation.turns[axis], index)
        if name in self.parameters:
            if index is not None:
                group = self.parameters[name]
                self.members.append((group.lo, group.hi, index))
            return self.slots.node("param", name, index)
        if name in self.inputs:
            flat = input_index(self.orders, self.inputs[name])
            return self.slots.node("input", str(flat))
        if name in self.definitions:
            return self._definition(name, index)
        if name in self.of_members:
            item = self.of_members[name]
            lo, hi, _ = self.over(item.range)
            self.members.append((lo, hi, index))
            return self.scalar(item.value, self.sizes | {item.range.variable: index})
        if name in self.outputs:
            return self.outputs[name]
        if name in self.multipliers:
            return self._multiplier(name, index)
        if name in self.momenta and self.watched:
            return self._momentum(self.momenta[name], index)
        if name in BUILT_IN:
            return self.graph.symbol(BUILT_IN[name])
        raise NotKept(f"'{name}' is not known in a loop")

    def _multiplier(self, name: str, index: Affine | None) -> Node:
        """Returns the symbol of a multiplier. Raises NotKept if several statements declare the
        constraint rows of this name."""
        if len(self.multipliers[name]) > 1:
            raise NotKept(f"'{name}' is of rows that are declared piece by piece")
        [group] = self.multipliers[name]
        if index is not None:
            self.members.append((group.lo, group.hi, index))
        return self.slots.node("lambda", group.name, index if group.is_family else None)

    def _momentum(self, group: Group, index: Affine | None) -> Node:
        if index is not None:
            self.members.append((group.lo, group.hi, index))
        return self.slots.node("p", group.name, index)

    def _definition(self, name: str, index: Affine | None) -> Value:
        """Returns the value of a `let` definition at an index. Unless it has a recurrence, its
        expression is converted again for each use."""
        if name in self._defining:
            raise NotKept(f"'{name}' is defined by its own members: a recursion over the index")
        found = self.definitions[name]
        if index is not None and (len(found) > 1 or found[0].index is not None):
            return self._carried(name, index)
        item = found[-1]
        inner = dict(self.sizes)
        if item.range is not None:
            inner[item.range.variable] = index
            lo, hi = self.index(item.range.lo, inner), self.index(item.range.hi, inner)
            self.members.append((lo, hi, index))
        self._defining.append(name)
        try:
            return self.value(item.value, inner)
        finally:
            self._defining.pop()

    def _carried(self, name: str, index: Affine) -> Value:
        """Returns the symbols of a member of a `let` definition that consists of several
        statements, which may form a recurrence. There is one symbol for each vector component."""
        if name not in self.carried:
            if self.watched:
                return self.alongside.member(name, index)
            _, self.carried[name] = self.groups_of(name)
            self.coordinates |= {g.name: g for g in self.carried[name]}
        groups = self.carried[name]
        self.members.append((groups[0].lo, groups[0].hi, index))
        nodes = tuple(self.slots.node("q", g.name, index) for g in groups)
        return nodes if len(nodes) > 1 else nodes[0]

    def groups_of(self, name: str) -> tuple[tuple[str, ...], tuple[Group, ...]]:
        """Returns a name and a Group for each component of an indexed `let` definition. A
        definition that is not a vector has one component."""
        pieces = self.pieces(name)
        (lo, _, first), (_, hi, _) = pieces[0], pieces[-1]
        around, self.members = self.members, []
        value = self.value(first.value, self.loop_of(first))
        self.members = around
        components = ("_x", "_y", "_z") if isinstance(value, tuple) else ("",)
        taken = {*self.coordinates, *self.parameters, *self.inputs, *self.definitions}
        free = "_" * any(name + c in taken for c in components if c)
        groups = tuple(Group(first, lo, hi, component=c + free) for c in components)
        return tuple(g.name for g in groups), groups

    def pieces(self, name: str) -> list[tuple[Affine, Affine, Definition]]:
        """Returns the statements that define a name, as (lo, hi, statement) in the order of their
        index ranges. Raises NotKept if there is a gap between two ranges."""
        sizes, found = size_values(self.model), []
        for item in self.definitions[name]:
            lo, hi, _ = self.over(item.range, item.index)
            found.append((lo, hi, item))
        found.sort(key=lambda piece: piece[0].value(sizes))
        for (_, before, _), (behind, _, _) in pairwise(found):
            if behind - before != Affine(1):
                raise NotKept(f"the pieces of '{name}' lie apart for some sizes")
        return found

    def loop_of(self, item: Definition) -> Loop:
        return self.over(item.range, item.index)[2]

    def plain(self, expr: Expr, loop: Loop | None = None) -> Node:
        """Returns the node of an expression in an initial value, a parameter or the end of a family
        (`fixed q[0] = …`). Raises NotKept if it contains a recurrence (`Carried`), or a sum that
        varies with time."""
        node = self.scalar(expr, loop)
        for slot in self.slots.below(node):
            if slot.name in self.coordinates and self.coordinates[slot.name].is_carried:
                raise NotKept(
                    f"'{slot.name}', which is defined piece by piece, stands in a parameter, a "
                    "start or an end"
                )
            if slot.kind == "sum" and not self.totals.is_fixed(slot):
                raise NotKept("a sum over what moves stands in an end")
        return node

    def coordinate(self, name: str, index: Affine | None) -> Node:
        """Returns the node of a coordinate or a state. If the index is that of a fixed end, returns
        the end's given value."""
        end = self._fixed_at(name, index)
        return self.given(name, index) if end else self._cell(name, index)

    def _rate(self, name: str, index: Affine | None) -> Node:
        """Returns the rate of a coordinate. If the index is that of a fixed end, returns the rate
        of the given value."""
        end = self._fixed_at(name, index)
        return self.given_rate(name, index) if end else self.derivative(self._cell(name, index))

    def _fixed_at(self, name: str, index: Affine | None) -> End | None:
        ends = self.coordinates[name].ends
        return next((end for at, end in ends if at == index and end.kind == "fixed"), None)

    def given(self, name: str, index: Affine) -> Node:
        """Returns the value that the model gives to a member beyond a fixed end. Returns ZERO for a
        coordinate of a rotation, which has no value."""
        value = self._fixed_at(name, index).value
        return ZERO if value is None else self.plain(value)

    def given_rate(self, name: str, index: Affine) -> Node:
        if name not in self.rotations.turns:
            return self.derivative(self.given(name, index))
        rotation, axis = self.rotations.turns[name]
        numbers = tuple(self.given(number, index) for number in rotation.quaternion)
        return body_rates(self.graph, numbers, tuple(map(self.derivative, numbers)))[axis]

    def _cell(self, name: str, index: Affine | None) -> Node:
        """Returns the symbol of a member. If the index is beyond a free or periodic end, returns
        the symbol of the family's member that has the same value."""
        group = self.coordinates[name]
        kind = "s" if group.is_state else "q"
        if index is None or any(index.factor(v) for v in LOOPS):
            return self.slots.node(kind, name, index)
        for at, _ in group.ends:
            if at == index:
                return self.slots.node(kind, name, group.lo if at == group.lo - 1 else group.hi)
        if group.periodic:
            below, above = index - group.lo, group.hi - index
            if below.is_constant and below.constant < 0:
                index = index + group.count
            elif above.is_constant and above.constant < 0:
                index = index - group.count
        self.members.append((group.lo, group.hi, index))
        return self.slots.node(kind, name, index)

    # -- derivatives in time ------------------------------------------------------------------

    def _rate_of(self, node: Node) -> Node:
        slot = self.slots.of(node)
        if slot is None:
            return ONE  # t
        if slot.kind == "q":
            return self.slots.node("v", slot.name, slot.at)
        if slot.kind == "input":
            return self.slots.node("input", str(next_input(self.orders, int(slot.name))))
        if slot.kind == "sum":
            return self.totals.rate(slot)
        if slot.kind == "let":
            return self.alongside.rate(slot)
        if slot.name in self.rotations.numbers:
            rotation, k = self.rotations.numbers[slot.name]
            return self.rotations.moving(rotation, slot.at)[k]
        if slot.kind == "s":
            return self.slots.node("a", slot.name, slot.at)
        if slot.kind == "a":
            raise NotKept("a rate of a state is derived again")
        if slot.kind == "v" and self.watched and not self.carried:
            return self.slots.node("acc", slot.name, slot.at)
        if slot.kind in ("v", "w", "d", "p", "acc"):
            raise NotKept("an output has an acceleration")
        return ZERO


def has_sum(x: FamilyExpander, expr: Expr, seen: frozenset[str] = frozenset()) -> bool:
    """Whether an expression, or a `let` definition in it, contains a sum."""
    if isinstance(expr, Sum):
        return True
    if isinstance(expr, Name):
        if expr.id in x.definitions and expr.id not in seen:
            return any(has_sum(x, d.value, seen | {expr.id}) for d in x.definitions[expr.id])
        return False
    return any(has_sum(x, part, seen) for part in children(expr))


def around(x: FamilyExpander, loop: Loop) -> frozenset[str]:
    """Returns the names whose values depend on a loop variable. `loop` has the values of all names
    that indices may contain."""
    sizes = {name for at in x.sizes.values() for name, _ in at.terms}
    return frozenset(name for name, at in loop.items() if {v for v, _ in at.terms} - sizes)


def independent(x: FamilyExpander, expr: Expr, loop: Loop) -> bool:
    """Returns whether an expression contains no names that depend on loop variables (`loop`)."""
    return not around(x, loop) & free_names(expr)


def free_names(expr: Expr) -> frozenset[str]:
    """Returns the names in an expression, without the variables of sums in it."""
    if isinstance(expr, Sum):
        found, own = frozenset(), frozenset()
        for item in expr.ranges:
            found |= (free_names(item.lo) | free_names(item.hi)) - own
            own |= {item.variable}
        return found | (free_names(expr.body) - own)
    inside = frozenset().union(*map(free_names, children(expr)))
    return inside | {expr.id} if isinstance(expr, Name) else inside
