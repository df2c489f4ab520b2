"""The expression graph: hash-consed, append-only, its nodes plain integers.

A node's arguments always have smaller numbers, so going through the numbers in order is a
topological sweep; nothing here recurses, and nothing depends on the hash seed.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from fractions import Fraction

Node = int


class Op(IntEnum):
    NUMBER = 0  # data: its Fraction
    SYMBOL = 1  # data: its Symbol
    ADD = 2  # args: two nodes
    MULTIPLY = 3  # args: two nodes; a constant factor comes first, -1 stands for a sign
    POWER = 4  # args: the base; data: the exponent, a Fraction other than 0 and 1
    CALL = 5  # args: one or two nodes; data: a name in functions.FUNCTIONS


class Kind(IntEnum):
    PI = 0
    PARAMETER = 1
    COORDINATE = 2
    RATE = 3
    TIME = 4
    INPUT = 5


@dataclass(frozen=True, slots=True)
class Symbol:
    """`index` counts the flattened quantities of its kind from 0."""

    kind: Kind
    index: int = 0


class Graph:
    """Constructors of nodes; each returns the node that there already is, if there is one."""

    def __init__(self) -> None:
        self.op: list[Op] = []
        self.args: list[tuple[Node, ...]] = []
        self.data: list[object] = []
        self._known: dict[tuple[object, ...], Node] = {}

    def _node(self, op: Op, args: tuple[Node, ...], data: object) -> Node:
        key = (op, args, data)
        node = self._known.get(key)
        if node is None:
            node = len(self.op)
            self.op.append(op)
            self.args.append(args)
            self.data.append(data)
            self._known[key] = node
        return node

    def number(self, value: Fraction | int) -> Node:
        return self._node(Op.NUMBER, (), Fraction(value))

    def symbol(self, symbol: Symbol) -> Node:
        return self._node(Op.SYMBOL, (), symbol)

    def add(self, a: Node, b: Node) -> Node:
        return self._node(Op.ADD, (a, b), None)

    def multiply(self, a: Node, b: Node) -> Node:
        return self._node(Op.MULTIPLY, (a, b), None)

    def power(self, base: Node, exponent: Fraction | int) -> Node:
        return self._node(Op.POWER, (base,), Fraction(exponent))

    def call(self, function: str, *arguments: Node) -> Node:
        return self._node(Op.CALL, arguments, function)
