"""Rearranges one kernel's expressions for straight-line code.

- A power becomes operations of C: repeated multiplication (shared), a reciprocal, a square root, or
  pow().
- In a product the factors that depend on parameters alone are grouped, and in a sum such terms:
  `m*(l^2*(x*y))` becomes `(m*l^2)*x*y`, whose bracket `lower` hoists. A product keeps its sign
  outermost, so that x and -x share their work.

Only nodes with one use are taken apart, so no value is computed twice. The code uses loops, not
recursion, since a chain of terms may be as deep as the model is long.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from math import prod

from ...functions import SIDE as SIDE_OF
from ...graph.differentiate import unknown
from ...graph.graph import MINUS_ONE, Graph, Node, Op, Symbol
from .constant_range import Constants

_ONE = Fraction(1)
_MINUS_ONE = Fraction(-1)
SIDE = "side"  # The kind of a symbol that is the side of a switch; only used here.


class Workspace:
    """A private copy of the expression graph, to which nodes are added without simplification.
    `fixed` tells whether a node depends on parameters alone."""

    def __init__(self, graph: Graph) -> None:
        self.op, self.args, self.data = list(graph.op), list(graph.args), list(graph.data)
        self.fixed = [graph.is_constant(node) for node in range(len(graph))]
        self._known = graph.tables()
        self.sides: dict[Node, Node] = {}  # call -> the side that selects its branch
        self._side_leaves: dict[Symbol, Node] = {}
        self.constants = Constants(self)

    def side(self, call: Node, switch: Symbol, sign: int) -> None:
        """Makes a function call depend on a side: that of the switch if sign > 0, otherwise the
        opposite one."""
        if switch not in self._side_leaves:
            leaf = self._side_leaves[switch] = len(self.op)
            self.op.append(Op.SYMBOL)
            self.args.append(())
            self.data.append(switch)
            self.fixed.append(False)
        leaf = self._side_leaves[switch]
        self.sides[call] = leaf if sign > 0 else self.multiply(MINUS_ONE, leaf)

    def node(self, op: str, args: tuple[Node, ...], data: object = None) -> Node:
        key = args if data is None else (args, data)
        known = self._known[op].get(key)
        return self._new(op, args, data, key) if known is None else known

    def _new(self, op: str, args: tuple[Node, ...], data: object, key: object) -> Node:
        node = self._known[op][key] = len(self.op)
        self.op.append(op)
        self.args.append(args)
        self.data.append(data)
        self.fixed.append(all(self.fixed[a] for a in args))
        return node

    def find(self, op: str, args: tuple[Node, ...], data: object) -> Node | None:
        return self._known[op].get((args, data))

    def number(self, value: Fraction) -> Node:
        key = value.numerator, value.denominator
        known = self._known[Op.NUMBER].get(key)
        return self._new(Op.NUMBER, (), value, key) if known is None else known

    def add(self, a: Node, b: Node) -> Node:
        return self.node(Op.ADD, (a, b))

    def multiply(self, a: Node, b: Node) -> Node:
        return self.node(Op.MULTIPLY, (a, b))

    def reciprocal(self, a: Node) -> Node:
        return self.node(Op.POWER, (a,), Fraction(-1))

    def is_leaf(self, node: Node) -> bool:
        return self.op[node] is Op.NUMBER or self.op[node] is Op.SYMBOL

    def negated(self, node: Node) -> Node | None:
        """Returns x if the node is (-1)*x, else None."""
        if self.op[node] is Op.MULTIPLY and self.args[node][0] == MINUS_ONE:
            return self.args[node][1]
        return None

    def reachable(self, roots: Iterable[Node]) -> list[Node]:
        """Returns the roots and all nodes below them; arguments come before their users."""
        return unknown(self.args.__getitem__, roots, ())


def rewrite(work: Workspace, roots: list[Node], gather: bool = True) -> dict[Node, Node]:
    """Returns a map from every node at or below the roots to its replacement. With `gather`,
    factors of products and terms of sums are grouped if they depend on parameters alone."""
    order = work.reachable(roots)
    absorbed = _absorbed(work, order, roots, gather)
    signed = _normal_signs(work, order) if gather else {}
    ops, fixed = work.op, work.fixed
    new: dict[Node, Node] = {}
    for node in order:
        if node in absorbed or (gather and fixed[node]):
            # The node stays unchanged if its user takes it apart. A constant is hoisted without its
            # sign.
            new[node] = node
            if node not in absorbed and ops[node] is not Op.NUMBER:
                sign, plain = signed[node]
                new[node] = plain if sign > 0 else work.multiply(MINUS_ONE, plain)
            continue
        op = ops[node]
        if op is Op.ADD:
            new[node] = _sum(work, [new[x] for x in _terms(work, node, absorbed)], gather)
        elif op is Op.MULTIPLY:
            new[node] = _product(work, _factors(work, node, absorbed), new, gather)
        elif op is Op.POWER:
            exponent = work.data[node]
            new[node] = power(work, new[work.args[node][0]], exponent)
        elif op is Op.CALL:
            arguments, called = tuple(new[a] for a in work.args[node]), work.data[node]
            if node in work.sides:
                arguments, called = (work.sides[node], *arguments), SIDE_OF + str(called)
            new[node] = work.node(op, arguments, called)
        else:
            new[node] = node
    return new


def _absorbed(work: Workspace, order: list[Node], roots: list[Node], gather: bool) -> set[Node]:
    """Returns the nodes that are merged into their only user: a sum into a sum, a product or a
    reciprocal into a product."""
    uses: dict[Node, int] = dict.fromkeys(order, 0)
    user: dict[Node, Node] = {}
    for root in roots:
        uses[root] += 1
    args = work.args
    for node in order:
        for a in args[node]:
            uses[a] += 1
            user[a] = node
    absorbed: set[Node] = set()
    for node in reversed(order):  # users first
        if uses[node] != 1 or node not in user or (gather and work.fixed[node]):
            continue
        op, above = work.op[node], work.op[user[node]]
        if (
            (op is above and (op is Op.ADD or op is Op.MULTIPLY))
            or (_is_reciprocal(work, node) and above is Op.MULTIPLY)
            or (op is Op.MULTIPLY and user[node] in absorbed and above is Op.POWER)
        ):
            absorbed.add(node)
    return absorbed


def _normal_signs(work: Workspace, order: Iterable[Node]) -> dict[Node, tuple[int, Node]]:
    """Returns for each constant a pair (sign, node) with constant = sign * node. Both x and -x have
    the same node, and so have a - b and b - a. The first term of a sum is positive."""
    signed: dict[Node, tuple[int, Node]] = {}
    for node in order:
        if not work.fixed[node]:
            continue
        op, args = work.op[node], work.args[node]
        value = work.data[node]
        sign, plain = 1, node
        if op is Op.NUMBER and value < 0:
            sign, plain = -1, work.number(-value)
        elif op is Op.MULTIPLY or (op is Op.POWER and value == _MINUS_ONE):
            sign = prod(signed[a][0] for a in args)
            parts = tuple(signed[a][1] for a in args)
            if op is Op.POWER:
                plain = work.reciprocal(*parts)
            elif work.op[parts[0]] is Op.NUMBER and work.data[parts[0]] == 1:
                plain = parts[1]
            else:
                plain = work.multiply(*parts)
        elif op is Op.ADD:
            (sign, a), (other, b) = (signed[x] for x in args)
            if sign != other and b < a:
                sign, a, other, b = other, b, sign, a
            plain = work.add(a, b if sign == other else work.multiply(MINUS_ONE, b))
        signed[node] = sign, plain
    return signed


def _is_reciprocal(work: Workspace, node: Node) -> bool:
    return work.op[node] is Op.POWER and work.data[node] == -1


def _terms(work: Workspace, node: Node, absorbed: set[Node]) -> Iterator[Node]:
    """Yields the terms of a sum, left to right."""
    stack = [node]
    while stack:
        x = stack.pop()
        if x == node or (x in absorbed and work.op[x] is Op.ADD):
            stack.extend(reversed(work.args[x]))
        else:
            yield x


def _factors(work: Workspace, node: Node, absorbed: set[Node]) -> Iterator[tuple[Node, bool]]:
    """Yields the factors of a product, left to right, as (node, whether it is a divisor)."""
    stack = [(node, False)]
    while stack:
        x, divides = stack.pop()
        if x == node or (x in absorbed and work.op[x] is Op.MULTIPLY):
            stack.extend((a, divides) for a in reversed(work.args[x]))
        elif x in absorbed and _is_reciprocal(work, x):
            stack.append((work.args[x][0], not divides))
        else:
            yield x, divides


def _sum(work: Workspace, terms: list[Node], gather: bool) -> Node:
    if gather:
        fixed = [x for x in terms if work.fixed[x]]
        if len(fixed) > 1:
            at = terms.index(fixed[0])
            terms = [x for x in terms if not work.fixed[x]]
            terms.insert(at, _chain(work.add, fixed))
    return _chain(work.add, terms)


def _product(
    work: Workspace, factors: Iterable[tuple[Node, bool]], new: dict[Node, Node], gather: bool
) -> Node:
    ops, args = work.op, work.args
    sign, magnitude = 1, _ONE
    fixed: list[Node] = []
    above: list[Node] = []
    below: list[Node] = []
    for old, divides in factors:
        x = new[old]
        while ops[x] is Op.MULTIPLY and args[x][0] == MINUS_ONE:
            sign, x = -sign, args[x][1]
        if ops[x] is Op.NUMBER:
            value = work.data[x]
            assert isinstance(value, Fraction)
            if value < 0:
                sign, value = -sign, -value
            magnitude = magnitude / value if divides and value else magnitude * value
        elif gather and work.fixed[x]:
            fixed.append(power(work, x, Fraction(-1)) if divides else x)
        else:
            (below if divides else above).append(x)
    number = [] if magnitude is _ONE or magnitude == 1 else [work.number(magnitude)]
    if fixed:
        # Sorted, so that products of the same constants in any order are the same node.
        above.insert(0, _chain(work.multiply, number + sorted(fixed)))
    elif number or not (above or below):
        above.insert(0, work.number(magnitude))
    if below:
        above.append(work.reciprocal(_chain(work.multiply, below)))
    product = _chain(work.multiply, above)
    return work.multiply(work.number(_MINUS_ONE), product) if sign < 0 else product


def _chain(join, items: list[Node]) -> Node:
    result = items[0]
    for item in items[1:]:
        result = join(result, item)
    return result


def power(work: Workspace, base: Node, exponent: Fraction) -> Node:
    """Returns base^exponent, made of multiplications, a reciprocal and sqrt, or by pow."""
    if exponent < 0:
        return work.reciprocal(power(work, base, -exponent))
    if exponent.denominator > 2:
        return work.node(Op.CALL, (base, work.number(exponent)), "pow")
    whole = int(exponent)
    root = [work.node(Op.CALL, (base,), "sqrt")] if exponent.denominator == 2 else []
    if not whole:
        return root[0]
    # Binary powering, which starts with the exponent's highest bit.
    result = base
    for bit in bin(whole)[3:]:
        result = work.multiply(result, result)
        result = work.multiply(base, result) if bit == "1" else result
    return _chain(work.multiply, [result, *root])
