"""Proves that an expression depends on a symbol, by its values modulo a prime at two assignments.

An assignment gives each symbol a pseudorandom residue. The sine and cosine of an angle are the
coordinates of a point on the circle x^2 + y^2 = 1, which is a hash of the residue of the angle. The
value of any other function is a hash of the residues of its arguments. All identities that
`normal.py` uses hold between such values. If an expression has different values at two assignments
that differ only in certain symbols, its normal form contains one of these symbols. Equal values
prove nothing.
Reference: J. T. Schwartz, Fast probabilistic algorithms for verification of polynomial
identities, J. ACM 27 (1980) 701-717.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from ..functions import FUNCTIONS
from .differentiate import unknown
from .graph import BIT, Graph, Node, Op
from .nodes import SQUARES

# The prime is 3 modulo 4: then -1 has no square root, and 1 + x^2 is never 0.
PRIME = 2**61 - 1
# A function may have an exact value at these arguments, different from the hash; it gets no value.
_PLAIN = {0, 1, PRIME - 1}


class Residues:
    """Values of nodes of one graph modulo PRIME, or None for a node without value.

    Symbols of the kinds in the mask `moved` have other values than in Residues with moved = 0. If
    `only` is an index, this applies only to symbols with this index.
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
        """Computes and caches the values of many nodes in one sweep."""
        known, args, ops, data = self.known, self.graph.args, self.graph.op, self.graph.data
        for node in unknown(args.__getitem__, outputs, known):
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
    """Tests whether nodes of one graph depend on symbols of given kinds."""

    def __init__(self, g: Graph):
        self.graph = g
        self.worlds: dict[int, Residues] = {0: Residues(g)}

    def __call__(self, node: Node, mask: int) -> bool:
        """Returns True only if the node's normal form is proved to contain a symbol of the kinds in
        `mask`."""
        if not self.graph.depends[node] & mask:
            return False
        values = {self.worlds[0](node), self._world(mask)(node)}
        return None not in values and len(values) > 1

    def learn(self, nodes: list[Node], mask: int) -> None:
        """Computes and caches the values of many nodes for later calls, in one sweep for each
        assignment."""
        self.worlds[0].learn(nodes)
        self._world(mask).learn(nodes)

    def _world(self, mask: int) -> Residues:
        if mask not in self.worlds:
            self.worlds[mask] = Residues(self.graph, mask)
        return self.worlds[mask]

    def is_nonzero(self, node: Node) -> bool:
        """Returns True only if the node's normal form is proved to be nonzero."""
        return bool(self.worlds[0](node))


def _fraction(value: Fraction) -> int | None:
    if value.denominator % PRIME == 0:
        return None
    return value.numerator * pow(value.denominator, -1, PRIME) % PRIME


def _mixed(*values: int) -> int:
    """Returns a residue that is a hash of the given integers."""
    result = 2385
    for value in values:
        result = pow(result * 48271 + value, 5, PRIME)
    return result


def _power(base: int, exponent: Fraction) -> int | None:
    if exponent.denominator != 1 or (base == 0 and exponent < 0):
        return None  # roots and divisions by 0 have no value
    return pow(base, exponent.numerator, PRIME)


def _call(function: str, arguments: list[int]) -> int | None:
    """Returns the value of a function call modulo PRIME. The values of odd and even functions have
    the same parity as the functions."""
    if function == "sqrt" or not _PLAIN.isdisjoint(arguments):
        return None
    argument, sign = arguments[0], 1
    parity = FUNCTIONS[function].parity
    if parity and argument > PRIME // 2:
        argument, sign = PRIME - argument, -1 if parity == "odd" else 1
    if function == "reciprocal":
        return sign * pow(argument, -1, PRIME) % PRIME
    if function in SQUARES:
        half = _mixed(0, argument)  # takes the role of tan(angle / 2)
        scale = pow(1 + half * half, -1, PRIME)
        value = 2 * half if function == "sin" else 1 - half * half
        return sign * value * scale % PRIME
    return sign * _mixed(int.from_bytes(function.encode()), argument, *arguments[1:]) % PRIME
