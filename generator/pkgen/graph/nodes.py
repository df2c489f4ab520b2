"""The nodes of the expression graph: storage, leaves, and the monomial of each node.

`graph.py` adds the arithmetic, and explains the scale, the rest and the monomial of a node.
"""

from __future__ import annotations

from copy import copy
from fractions import Fraction
from sys import maxsize
from typing import NamedTuple

from ..system.resources import ResourcesExceeded
from .monomials import Factors, Node

Terms = tuple[tuple[Node, Node], ...]  # The terms of a sum, each as (scale, rest).


class Op:
    """The operations of nodes. A node has `args`, its arguments, and `data`. The class is no Enum,
    because lookup of Enum members is slow in Python 3.11."""

    NUMBER = "number"  # The data is a Fraction.
    SYMBOL = "symbol"  # The data is a Symbol.
    ADD = "add"  # The sum of two arguments.
    MULTIPLY = "multiply"  # The product of two arguments; a constant, such as -1, comes first.
    POWER = "power"  # The power of one argument; the data is the exponent, not 0 or 1.
    CALL = "call"  # A function of one or two arguments; the data is its name in functions/.


class Kind:
    """Kinds of symbols."""

    PI = "pi"
    PARAMETER = "parameter"
    COORDINATE = "coordinate"
    RATE = "rate"
    STATE = "state"  # a first-order variable k; index n + k is its rate, if there are n variables
    TIME = "time"
    INPUT = "input"
    ACCELERATION = "acceleration"  # an independent variable in linearised equations
    # A momentum is an independent variable in Hamilton's equations.
    MOMENTUM = "momentum"


KINDS = tuple(value for name, value in vars(Kind).items() if name.isupper())
# The bit of each kind in the masks of `Nodes.depends`.
BIT = {kind: 1 << place for place, kind in enumerate(KINDS)}
CONSTANT = BIT[Kind.PI] | BIT[Kind.PARAMETER]
VARIABLE = ~CONSTANT & ((1 << len(KINDS)) - 1)

# The largest number of factors in the monomial of a node. A longer product is a monomial of a
# single base, itself.
FACTORS = 16
# The largest number of terms of a sum in which like terms are merged.
TERMS = 4
# The domains (see graph.py). The higher of two domains is their bitwise or.
_NUMBERS, _PARAMETERS, WORLD = 0b00, 0b01, 0b11
ZERO: Node = 0
ONE: Node = 1
MINUS_ONE: Node = 2


class Symbol(NamedTuple):
    """A symbol: its kind, and its index (from 0) among the scalar quantities of this kind."""

    kind: str  # one of Kind
    index: int = 0


class TooLarge(ResourcesExceeded):
    """The graph has reached its largest allowed number of nodes."""


SQUARES = {"sin": "cos", "cos": "sin"}


class Nodes:
    """Stores hash-consed nodes. `Graph` adds constructors that simplify, such as `multiply`."""

    def __init__(self, limit: int | None = None) -> None:
        self.op: list[str] = []  # one of Op
        self.args: list[tuple[Node, ...]] = []
        self.data: list[object] = []
        self.depends: list[int] = []  # the kinds of symbols in each node, as a mask of BIT
        self.limit = maxsize if limit is None else limit
        self._numbers: dict[tuple[int, int], Node] = {}
        self._symbols: dict[Symbol, Node] = {}
        self._sums: dict[tuple[Node, Node], Node] = {}
        self._products: dict[tuple[Node, Node], Node] = {}
        self._powers: dict[tuple[tuple[Node], Fraction | int], Node] = {}
        self._calls: dict[tuple[tuple[Node, ...], str], Node] = {}
        self._domain: list[int] = []
        self._scale: list[Node] = []
        self._rest: list[Node] = []
        self._factors: list[Factors] = []
        # A cache of the results of `_terms_of`.
        self._terms: dict[Node, Terms | None] = {}
        # Maps sin(x) to cos(x) and cos(x) to sin(x), where both nodes exist.
        self._partner: dict[Node, Node] = {}
        # Results of frequent operations: sums and products without variables, and negations.
        self._constant_sums: dict[tuple[Node, Node], Node] = {}
        self._constant_products: dict[tuple[Node, Node], Node] = {}
        self._negatives: dict[Node, Node] = {}
        self._reciprocals: dict[Node, tuple[Node, Fraction | int]] = {}
        for value in (0, 1, -1):
            self.number(value)

    def __len__(self) -> int:
        return len(self.op)

    def copy(self) -> Nodes:
        """Returns a copy of the graph, with the same node numbers."""
        result = copy(self)
        for name, value in vars(self).items():
            if isinstance(value, dict | list):
                setattr(result, name, value.copy())
        return result

    def tables(self) -> dict[str, dict[object, Node]]:
        """Returns the tables that find existing nodes: for each operation except symbols a map from
        key to node. The key is (numerator, denominator) for numbers, args for sums and products,
        (args, data) for powers and calls."""
        return {
            Op.NUMBER: dict(self._numbers),
            Op.ADD: dict(self._sums),
            Op.MULTIPLY: dict(self._products),
            Op.POWER: dict(self._powers),
            Op.CALL: dict(self._calls),
        }

    # -- leaves -------------------------------------------------------------------------------

    def number(self, value: Fraction | int) -> Node:
        # The key is two integers, because hashing a Fraction is slow.
        key = value.numerator, value.denominator
        node = self._numbers.get(key)
        if node is None:
            node = self._numbers[key] = self._append(Op.NUMBER, (), Fraction(value), 0, ())
            self._domain[node], self._scale[node], self._rest[node] = _NUMBERS, node, ONE
        return node

    def symbol(self, symbol: Symbol) -> Node:
        node = self._symbols.get(symbol)
        if node is None:
            node = self._append(Op.SYMBOL, (), symbol, BIT[symbol.kind])
            self._symbols[symbol] = node
        return node

    def pi(self) -> Node:
        return self.symbol(Symbol(Kind.PI))

    def value(self, node: Node) -> Fraction | None:
        """Returns the value of a number node, or None for any other node."""
        return self.data[node] if self.op[node] is Op.NUMBER else None

    def is_constant(self, node: Node) -> bool:
        """Whether the node depends on no symbols except parameters and pi."""
        return not self.depends[node] & VARIABLE

    def factors(self, node: Node) -> Factors:
        """Returns all factors of the node, including those of its scale, as pairs (base, exponent).
        A number is a base with exponent 1."""
        found: list[tuple[Node, Fraction | int]] = []
        while node != ONE:
            rest = self._rest[node]
            if rest == ONE:
                found.append((node, 1))
                break
            found.extend(self._factors[rest])
            node = self._scale[node]
        return tuple(found)

    def split(self, node: Node) -> tuple[Node, Node]:
        """Returns (scale, rest) with scale * rest = node. The scale has numbers and parameters
        only; the rest is 1 or contains variables."""
        if self._domain[node] < WORLD:
            return node, ONE
        return self._scale[node], self._rest[node]

    def key(self, rest: Node) -> Factors:
        """Returns the monomial of a node with the scale (constant factor) 1."""
        return self._factors[rest]

    def terms(self, rest: Node) -> Terms | None:
        """Returns the terms of a node with the scale (constant factor) 1; None if they are more
        than TERMS."""
        return self._terms_of(rest, self._domain[rest])

    # -- terms of a node ------------------------------------------------------------------------

    def _terms_of(self, node: Node, domain: int) -> Terms | None:
        if self._domain[node] < domain:
            return ((node, ONE),)
        terms = self._terms.get(node, ())
        if terms == ():
            terms = self._terms[node] = self._found_terms(node, domain)
        return terms

    def _found_terms(self, node: Node, domain: int) -> Terms | None:
        scale, rest = self._scale[node], self._rest[node]
        if self.op[rest] is not Op.ADD:
            return ((scale, rest),)
        if scale != ONE:
            terms = self._terms_of(rest, domain)
            return terms and tuple((self.multiply(scale, p), r) for p, r in terms)
        a, b = self.args[node]
        left, right = self._terms_of(a, domain), self._terms_of(b, domain)
        if left is None or right is None or len(left) + len(right) > TERMS:
            return None
        if len(left) == len(right) == 1:  # the most frequent case, treated first for speed
            same = self._factors[left[0][1]] == self._factors[right[0][1]]
            return None if same else left + right
        # If a monomial occurs twice, such as x in (x + y) + (x + z), merge() would lose a term.
        both = left + right
        return both if len({self._factors[r] for _, r in both}) == len(both) else None

    # -- new nodes ----------------------------------------------------------------------------

    def _append(
        self,
        op: str,
        args: tuple[Node, ...],
        data: object,
        depends: int,
        factors: Factors | None = None,
    ) -> Node:
        """Appends a node of scale 1. Its monomial is `factors`; if None, the node itself to the
        power 1."""
        node = len(self.op)
        if node >= self.limit:
            raise TooLarge(
                f"the equations of the model have more than {self.limit:,} parts; "
                "some kernels may have fewer: pkgen run --method dop853"
            )
        self.op.append(op)
        self.args.append(args)
        self.data.append(data)
        self.depends.append(depends)
        self._domain.append(WORLD if depends & VARIABLE else _PARAMETERS)
        self._scale.append(ONE)
        self._rest.append(node)
        self._factors.append(((node, 1),) if factors is None else factors)
        return node

    def _sum_node(self, a: Node, b: Node) -> Node:
        args = (a, b) if a < b else (b, a)
        node = self._sums.get(args)
        if node is None:
            node = self._append(Op.ADD, args, None, self.depends[a] | self.depends[b])
            self._sums[args] = node
            # The terms are computed now: later, for a long sum, the recursion would be deep.
            self._terms[node] = self._found_terms(node, self._domain[node])
        return node

    def _product_node(self, args: tuple[Node, Node], factors: Factors | None = None) -> Node:
        """Returns the product of two nodes of the same domain; `factors` is its monomial."""
        node = self._products.get(args)
        if node is None:
            depends = self.depends[args[0]] | self.depends[args[1]]
            if factors is not None and len(factors) > FACTORS:
                factors = None
            node = self._products[args] = self._append(Op.MULTIPLY, args, None, depends, factors)
        return node

    def _scaled_node(self, scale: Node, rest: Node) -> Node:
        args = scale, rest
        node = self._products.get(args)
        if node is None:
            depends = self.depends[scale] | self.depends[rest]
            node = self._products[args] = self._append(Op.MULTIPLY, args, None, depends, ())
            self._scale[node], self._rest[node] = args
        return node

    def _power_node(self, base: Node, exponent: Fraction | int) -> Node:
        key = (base,), exponent
        node = self._powers.get(key)
        if node is None:
            factors = None
            if self._scale[base] == ONE:
                factors = ((base, exponent),)
                if exponent.denominator == 1:
                    inner = self._factors[base]
                    factors = tuple((b, e * exponent.numerator) for b, e in inner)
            data = Fraction(exponent)
            node = self._append(Op.POWER, (base,), data, self.depends[base], factors)
            self._powers[key] = node
        return node

    def _call_node(self, function: str, arguments: tuple[Node, ...]) -> Node:
        key = arguments, function
        node = self._calls.get(key)
        if node is None:
            depends = 0
            for a in arguments:
                depends |= self.depends[a]
            factors = ((arguments[0], Fraction(1, 2)),) if function == "sqrt" else None
            node = self._append(Op.CALL, arguments, function, depends, factors)
            self._calls[key] = node
            self._remember(node, function, arguments)
        return node

    def _remember(self, node: Node, function: str, arguments: tuple[Node, ...]) -> None:
        """Records the new call: a sine and a cosine of the same angle as partners, or the argument
        of a reciprocal."""
        if function in SQUARES:
            partner = self._calls.get((arguments, SQUARES[function]))
            if partner is not None:
                self._partner[node], self._partner[partner] = partner, node
        elif function == "reciprocal":
            inner = self._factors[arguments[0]]
            if self._scale[arguments[0]] == ONE and len(inner) == 1:
                self._reciprocals[node] = inner[0]
