"""Derivatives on the expression graph, by sparse forward sweeps and by reverse sweeps.

The partial derivatives of each function are in the table in functions/.
Reference: A. Griewank, A. Walther, Evaluating Derivatives, SIAM 2008, chapters 3 and 7.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import TypeVar

from ..functions import FUNCTIONS
from .frames import Torques, Turning
from .graph import ONE, ZERO, Graph, Node, Op, Symbol

Value = TypeVar("Value")


def partials(g: Graph, node: Node) -> tuple[Node, ...]:
    """Returns the derivatives of a node with respect to each of its arguments."""
    op, args = g.op[node], g.args[node]
    if op is Op.ADD:
        return (ONE, ONE)
    if op is Op.MULTIPLY:
        return (args[1], args[0])
    if op is Op.POWER:
        exponent = g.data[node]
        return (g.multiply(g.number(exponent), g.power(args[0], exponent - 1)),)
    return FUNCTIONS[g.data[node]].derivative(g, node, *args)


def reachable(g: Graph, outputs: Iterable[Node], mask: int = -1) -> list[Node]:
    """Returns the outputs and all nodes below them in topological order; only nodes that depend on
    symbols of the kinds in `mask`."""
    args, depends = g.args.__getitem__, g.depends
    seen: set[Node] = set()
    found = set(outputs)
    while found:
        if mask != -1:
            found = {n for n in found if depends[n] & mask}
        seen |= found
        found = set().union(*map(args, found)) - seen  # set operations are faster than a loop
    return sorted(seen)


def unknown(
    args: Callable[[Node], Iterable[Node]], outputs: Iterable[Node], known: Collection[Node]
) -> list[Node]:
    """Returns the outputs and the nodes below them that are not in `known`, in topological order.
    Nodes below known ones are left out. `args` returns the arguments of a node."""
    seen: set[Node] = set()
    found = {node for node in outputs if node not in known}
    while found:
        seen |= found
        found = set().union(*map(args, found)) - seen
        found = {node for node in found if node not in known} if known else found
    return sorted(seen)


def swept(
    g: Graph, nodes: Iterable[Node], value: Callable[[Node, list[Value]], Value]
) -> list[Value]:
    """Returns the values of the nodes, computed from the leaves up; `value` computes a node's value
    from the node and the values of its arguments."""
    nodes, args = list(nodes), g.args
    known: dict[Node, Value] = {}
    for node in reachable(g, nodes):
        known[node] = value(node, [known[a] for a in args[node]])
    return [known[node] for node in nodes]


def symbols_in(g: Graph, nodes: Iterable[Node], mask: int = -1) -> list[Symbol]:
    """Returns the symbols in the nodes that are of the kinds in `mask`, sorted."""
    return sorted(g.data[n] for n in reachable(g, nodes, mask) if g.op[n] is Op.SYMBOL)


class Forward:
    """Tangents (directional derivatives) of nodes, by forward differentiation.

    `leaf` returns the tangent of a symbol; symbols of kinds outside `mask` have tangent 0. Tangents
    are cached, so that later calls for other nodes reuse them.
    """

    def __init__(self, g: Graph, mask: int, leaf: Callable[[Node], Node]):
        self.graph = g
        self.mask = mask
        self.leaf = leaf
        self.known: dict[Node, Node] = {}
        self.turning = Turning(g, self)

    def __call__(self, output: Node) -> Node:
        g, known, mask = self.graph, self.known, self.mask
        entries = g.frames.turning(mask)
        stack = [output]
        while stack:
            node = stack[-1]
            if node in known:
                stack.pop()
                continue
            if not g.depends[node] & mask:
                known[node] = ZERO
                stack.pop()
                continue
            if node in entries:
                known[node] = self.turning(node)
                stack.pop()
                continue
            missing = [a for a in g.args[node] if a not in known]
            if missing:
                stack.extend(missing)
                continue
            stack.pop()
            known[node] = self._tangent(node)
        return known[output]

    def _tangent(self, node: Node) -> Node:
        if self.graph.op[node] is Op.SYMBOL:
            return self.leaf(node)
        return tangent(self.graph, node, [self.known[a] for a in self.graph.args[node]])


def tangent(g: Graph, node: Node, of_arguments: list[Node]) -> Node:
    """Returns the tangent of a node, given the tangents of its arguments."""
    op = g.op[node]
    if op is Op.MULTIPLY:
        (a, b), (of_a, of_b) = g.args[node], of_arguments
        if of_a == ZERO:
            return g.multiply(a, of_b)
        if of_b == ZERO:
            return g.multiply(b, of_a)
        return g.add(g.multiply(b, of_a), g.multiply(a, of_b))
    if op is Op.ADD:
        return g.add(*of_arguments)
    if all(d == ZERO for d in of_arguments):
        return ZERO
    terms = zip(partials(g, node), of_arguments, strict=True)
    return g.sum(g.multiply(p, d) for p, d in terms if d != ZERO)


class Columns:
    """The columns of the Jacobian of some outputs: one sparse forward sweep for each symbol.

    A sweep visits only the nodes on paths from the symbol to the outputs.
    """

    def __init__(self, g: Graph, outputs: Iterable[Node], mask: int):
        self.graph = g
        outputs = list(outputs)
        self.entries = g.frames.turning(mask)
        self.order = reachable(g, outputs, mask)
        self.users: dict[Node, list[Node]] = {node: [] for node in self.order}
        for node in self.order:
            for a in dict.fromkeys(g.args[node]):
                if a in self.users:
                    self.users[a].append(node)
        # For each node, the number of the last output that depends on it.
        self.last = dict.fromkeys(self.order, -1)
        self.last.update((node, i) for i, node in enumerate(outputs))
        for node in reversed(self.order):
            for a in g.args[node]:
                if a in self.users:
                    self.last[a] = max(self.last[a], self.last[node])

    def column(self, symbol: Node, from_output: int = 0) -> Mapping[Node, Node]:
        """Returns the derivatives by `symbol` of the nodes that depend on it.

        Leaves out nodes that only outputs with numbers below `from_output` depend on.
        """
        g, users, last = self.graph, self.users, self.last
        if symbol not in users:
            return {symbol: ONE}
        influenced = {symbol}
        stack = [symbol]
        while stack:
            for user in users[stack.pop()]:
                if user not in influenced and last[user] >= from_output:
                    influenced.add(user)
                    stack.append(user)
        known = {symbol: ONE}
        influenced.remove(symbol)
        args, get = g.args, known.get
        turning, entries = Turning(g, lambda angle: get(angle, ZERO)), self.entries
        for node in sorted(influenced):
            if node in entries:
                known[node] = turning(node)
            else:
                known[node] = tangent(g, node, [get(a, ZERO) for a in args[node]])
        return known


def gradient(g: Graph, output: Node, mask: int) -> dict[Node, Node]:
    """Returns the derivatives of a node by all symbols of the kinds in `mask`, by one reverse
    sweep."""
    adjoint: dict[Node, Node] = {output: ONE}
    result: dict[Node, Node] = {}
    torques, entries = Torques(g), g.frames.turning(mask)
    for node in reversed(reachable(g, [output], mask)):
        for angle, slope in torques.angles(node):
            adjoint[angle] = g.add(adjoint.get(angle, ZERO), slope)
        bar = adjoint.pop(node, ZERO)
        if node in entries:
            if bar != ZERO:
                torques.pull(node, bar)
            continue
        if g.op[node] is Op.SYMBOL:
            result[node] = bar
            continue
        if bar == ZERO:
            continue
        for a, p in zip(g.args[node], partials(g, node), strict=True):
            if g.depends[a] & mask:
                adjoint[a] = g.add(adjoint.get(a, ZERO), g.multiply(bar, p))
    return result
