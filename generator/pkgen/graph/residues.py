"""Proofs that an expression does vary: its values modulo a prime, in two worlds.

Symbols get residues, sin and cos of an angle a point of the circle x^2 + y^2 = 1 that belongs to
the residue of the angle, any other function a residue that belongs to its arguments'. Every
identity that `normal.py` knows holds between such values. So where two worlds, which differ in
some symbols alone, give an expression different values, its normal form contains one of these
symbols, and need not be computed; equal values prove nothing.
Reference: J. T. Schwartz, Fast probabilistic algorithms for verification of polynomial
identities, J. ACM 27 (1980) 701-717.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from ..functions import FUNCTIONS
from .graph import BIT, Graph, Node, Op
from .nodes import SQUARES

PRIME = 2**61 - 1  # 3 modulo 4, so that -1 has no root and 1 + x^2 is never 0
_PLAIN = {0, 1, PRIME - 1}  # where a function may have an exact value


class Residues:
    """Values of nodes of one graph modulo PRIME; None where there is none.

    `moved` says of which kinds the symbols have other values than in the world with moved = 0;
    `only`, which of their indices.
    """

    def __init__(self, g: Graph, moved: int = 0, only: int | None = None):
        self.graph = g
        self.moved = moved
        self.only = only
        self.known: dict[Node, int | None] = {}

    def __call__(self, output: Node) -> int | None:
        if output not in self.known:
            self.learn([output])
        return self.known[output]

    def learn(self, outputs: Iterable[Node]) -> None:
        """Values of many at once, in one sweep."""
        known, args, ops, data = self.known, self.graph.args, self.graph.op, self.graph.data
        missing = {output for output in outputs if output not in known}
        stack = list(missing)
        while stack:
            for a in args[stack.pop()]:
                if a not in known and a not in missing:
                    missing.add(a)
                    stack.append(a)
        for node in sorted(missing):
            values = [known[a] for a in args[node]]
            op = ops[node]
            if None in values:
                known[node] = None
            elif op is Op.MULTIPLY:
                known[node] = values[0] * values[1] % PRIME
            elif op is Op.ADD:
                known[node] = (values[0] + values[1]) % PRIME
            else:
                known[node] = self._of(op, data[node], values)

    def _of(self, op: str, data, values: list[int]) -> int | None:
        if op is Op.NUMBER:
            return _fraction(data)
        if op is Op.SYMBOL:
            moved = BIT[data.kind] & self.moved and (self.only is None or self.only == data.index)
            return _mixed(BIT[data.kind], data.index, 1 if moved else 0)
        if op is Op.POWER:
            return _power(values[0], data)
        return _call(data, values)


class Varying:
    """Whether nodes of one graph can be seen to vary with symbols of some kinds."""

    def __init__(self, g: Graph):
        self.graph = g
        self.worlds: dict[int, Residues] = {0: Residues(g)}

    def __call__(self, node: Node, mask: int) -> bool:
        """True is a proof that a symbol of the mask is in the normal form; False is none."""
        if not self.graph.depends[node] & mask:
            return False
        here = self.worlds[0](node)
        if here is None:
            return False
        there = self._world(mask)(node)
        return there is not None and here != there

    def learn(self, nodes: list[Node], mask: int) -> None:
        """What is going to be asked about these, in one sweep a world."""
        self.worlds[0].learn(nodes)
        self._world(mask).learn(nodes)

    def _world(self, mask: int) -> Residues:
        if mask not in self.worlds:
            self.worlds[mask] = Residues(self.graph, mask)
        return self.worlds[mask]

    def is_nonzero(self, node: Node) -> bool:
        """True is a proof that the normal form is not 0; False is none."""
        return bool(self.worlds[0](node))


def _fraction(value: Fraction) -> int | None:
    if value.denominator % PRIME == 0:
        return None
    return value.numerator * pow(value.denominator, -1, PRIME) % PRIME


def _mixed(*values: int) -> int:
    """A residue that belongs to these and has no simple relation to them."""
    result = 2385
    for value in values:
        result = pow(result * 48271 + value, 5, PRIME)
    return result


def _power(base: int, exponent: Fraction) -> int | None:
    if exponent.denominator != 1 or (base == 0 and exponent < 0):
        return None  # a root is beyond what is seen here
    return pow(base, exponent.numerator, PRIME)


def _call(function: str, arguments: list[int]) -> int | None:
    """A function is odd or even here where the graph makes it so."""
    if function == "sqrt" or not _PLAIN.isdisjoint(arguments):
        return None
    argument, sign = arguments[0], 1
    parity = FUNCTIONS[function].parity
    if parity and argument > PRIME // 2:
        argument, sign = PRIME - argument, -1 if parity == "odd" else 1
    if function == "reciprocal":
        return sign * pow(argument, -1, PRIME) % PRIME
    if function in SQUARES:
        half = _mixed(0, argument)  # the tangent of half the angle
        scale = pow(1 + half * half, -1, PRIME)
        value = 2 * half if function == "sin" else 1 - half * half
        return sign * value * scale % PRIME
    return sign * _mixed(int.from_bytes(function.encode()), argument, *arguments[1:]) % PRIME
