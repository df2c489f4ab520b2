"""The nodes of the expression graph: storage, leaves, and each node seen as a monomial.

`graph.py` has the arithmetic on top and says what the parts of a node mean.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

Node = int
Factors = tuple[tuple[Node, Fraction | int], ...]
Terms = tuple[tuple[Node, Node], ...]  # of a sum: (scale, rest) each


class Op:
    """What makes a node: names, not an Enum, whose members Python 3.11 takes long to look up."""

    NUMBER = "number"  # data: its Fraction
    SYMBOL = "symbol"  # data: its Symbol
    ADD = "add"  # args: two nodes
    MULTIPLY = "multiply"  # args: two nodes; a constant factor comes first, -1 stands for a sign
    POWER = "power"  # args: the base; data: the exponent, a Fraction other than 0 and 1
    CALL = "call"  # args: one or two nodes; data: a name in functions.FUNCTIONS


OPS = (Op.NUMBER, Op.SYMBOL, Op.ADD, Op.MULTIPLY, Op.POWER, Op.CALL)


class Kind:
    """What a symbol stands for."""

    PI = "pi"
    PARAMETER = "parameter"
    COORDINATE = "coordinate"
    RATE = "rate"
    TIME = "time"
    INPUT = "input"


KINDS = (Kind.PI, Kind.PARAMETER, Kind.COORDINATE, Kind.RATE, Kind.TIME, Kind.INPUT)
# What a node depends on is a mask of these.
BIT = {kind: 1 << place for place, kind in enumerate(KINDS)}
CONSTANT = BIT[Kind.PI] | BIT[Kind.PARAMETER]
VARIABLE = BIT[Kind.COORDINATE] | BIT[Kind.RATE] | BIT[Kind.TIME] | BIT[Kind.INPUT]

NUMBER_BITS = 512  # numbers beyond are left to the C as a product
FACTORS = 16  # a product of more is one factor of any larger product
TERMS = 4  # a sum of more is not searched for like terms
ZERO: Node = 0
ONE: Node = 1
MINUS_ONE: Node = 2


class Symbol(NamedTuple):
    """`index` counts the flattened quantities of its kind from 0."""

    kind: str  # of Kind
    index: int = 0


class TooLarge(Exception):
    """The graph has reached its limit of nodes."""


SQUARES = {"sin": "cos", "cos": "sin"}


class Nodes:
    """Hash-consed nodes; `Graph` adds the constructors that simplify."""

    def __init__(self, limit: int | None = None) -> None:
        self.op: list[str] = []
        self.args: list[tuple[Node, ...]] = []
        self.data: list[object] = []
        self.depends: list[int] = []  # a mask of BIT
        self.limit = limit
        self._known: dict[str, dict[object, Node]] = {op: {} for op in OPS}
        self._domain: list[int] = []
        self._scale: list[Node] = []
        self._rest: list[Node] = []
        self._factors: list[Factors] = []
        self._terms: list[Terms | None] = []
        self._partner: dict[Node, Node] = {}  # sin(x) and cos(x), where both are there
        self._negatives: dict[Node, Node] = {}
        self._reciprocals: dict[Node, tuple[Node, Fraction | int]] = {}
        for value in (0, 1, -1):
            self.number(value)

    def __len__(self) -> int:
        return len(self.op)

    def tables(self) -> dict[str, dict[object, Node]]:
        """A copy of the nodes by op: a number by (numerator, denominator), what has data by
        (args, data), the rest by args."""
        return {op: dict(nodes) for op, nodes in self._known.items()}

    # -- leaves -------------------------------------------------------------------------------

    def number(self, value: Fraction | int) -> Node:
        # Looked up by two integers, since to hash a fraction is slow.
        key = value.numerator, value.denominator
        known = self._known[Op.NUMBER].get(key)
        return self._new(Op.NUMBER, (), Fraction(value), key) if known is None else known

    def symbol(self, symbol: Symbol) -> Node:
        return self._node(Op.SYMBOL, (), symbol)

    def value(self, node: Node) -> Fraction | None:
        """The number that a node is, or None."""
        return self.data[node] if self.op[node] is Op.NUMBER else None

    def is_constant(self, node: Node) -> bool:
        """Whether it depends on parameters alone (or on nothing)."""
        return not self.depends[node] & VARIABLE

    def factors(self, node: Node) -> Factors:
        """The whole product as (base, exponent), a number as a base of its own."""
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
        """The node as (scale, rest); the scale depends on parameters alone."""
        if self._domain[node] < 2:
            return node, ONE
        return self._scale[node], self._rest[node]

    def key(self, rest: Node) -> Factors:
        """The monomial of a node whose scale is 1."""
        return self._factors[rest]

    def terms(self, rest: Node) -> Terms | None:
        """A node whose scale is 1 as a sum of a few (scale, rest); None if there are too many."""
        return self._terms[rest]

    # -- a node as terms and as scale times rest ------------------------------------------------

    def _split(self, node: Node, domain: int) -> tuple[Node, Node]:
        """Scale and rest with respect to a domain, the node's own or a higher one."""
        if self._domain[node] < domain:
            return node, ONE
        return self._scale[node], self._rest[node]

    def _terms_of(self, node: Node, domain: int) -> Terms | None:
        if self._domain[node] < domain:
            return ((node, ONE),)
        terms = self._terms[node]
        if terms is None:
            scale, rest = self._scale[node], self._rest[node]
            terms = self._terms[rest]
            if terms is not None and scale != ONE:
                if len(terms) == 1 and terms[0][0] == ONE:
                    return ((scale, terms[0][1]),)
                return tuple((self.multiply(scale, p), r) for p, r in terms)
        return terms

    # -- bookkeeping --------------------------------------------------------------------------

    def _number_or(self, op: str, a: Node, b: Node, value: Fraction) -> Node:
        if max(value.numerator.bit_length(), value.denominator.bit_length()) > NUMBER_BITS:
            return self._node(op, (a, b), None)
        return self.number(value)

    def _node(
        self, op: str, args: tuple[Node, ...], data: object, factors: Factors | None = None
    ) -> Node:
        """`factors` is the monomial of a product, where the caller has it already."""
        key = args if data is None else (args, data)
        node = self._known[op].get(key)
        return self._new(op, args, data, key, factors) if node is None else node

    def _new(
        self,
        op: str,
        args: tuple[Node, ...],
        data: object,
        key: object,
        factors: Factors | None = None,
    ) -> Node:
        node = len(self.op)
        if self.limit is not None and node >= self.limit:
            raise TooLarge
        self._known[op][key] = node
        self.op.append(op)
        self.args.append(args)
        self.data.append(data)
        depends = BIT[data.kind] if op is Op.SYMBOL else 0
        for a in args:
            depends |= self.depends[a]
        self.depends.append(depends)
        domain = 0 if op is Op.NUMBER else 2 if depends & VARIABLE else 1
        self._domain.append(domain)
        self._enter(node, op, args, data, domain, factors)
        return node

    def _enter(
        self,
        node: Node,
        op: str,
        args: tuple[Node, ...],
        data: object,
        domain: int,
        factors: Factors | None,
    ) -> None:
        """The node as scale, rest and monomial; as a sum, its terms."""
        scale, rest = ONE, node
        terms: Terms | None = ((ONE, node),)
        product, factors = factors, ((node, 1),)
        if domain == 0:
            scale, rest, factors = node, ONE, ()
        elif op is Op.MULTIPLY:
            left, right = self._domain[args[0]], self._domain[args[1]]
            if left < domain == right:
                (scale, rest), terms, factors = args, None, ()
            elif left == right == domain:
                product = product or merged(self._factors[args[0]], self._factors[args[1]])
                if len(product) <= FACTORS:
                    factors = product
        elif op is Op.ADD:
            terms = self._sum_terms(args, domain)
        elif op is Op.POWER:
            if self._domain[args[0]] == domain and self._scale[args[0]] == ONE:
                factors = ((args[0], data),)
                if data.denominator == 1:
                    inner = self._factors[args[0]]
                    factors = tuple((b, e * data.numerator) for b, e in inner)
        elif op is Op.CALL:
            factors = self._enter_call(node, args, data, factors)
        self._scale.append(scale)
        self._rest.append(rest)
        self._factors.append(factors)
        self._terms.append(terms)

    def _sum_terms(self, args: tuple[Node, ...], domain: int) -> Terms | None:
        left = self._terms_of(args[0], domain)
        right = self._terms_of(args[1], domain)
        if left is None or right is None or len(left) + len(right) > TERMS:
            return None
        # The same rest twice, as in (x + y) + (x + z), would be lost when merging.
        both = left + right
        return both if len({self._factors[r] for _, r in both}) == len(both) else None

    def _enter_call(
        self, node: Node, args: tuple[Node, ...], function: object, factors: Factors
    ) -> Factors:
        """The monomial of a call; what belongs to it is remembered."""
        if function in SQUARES:
            partner = self._known[Op.CALL].get((args, SQUARES[function]))
            if partner is not None:
                self._partner[node], self._partner[partner] = partner, node
        elif function == "sqrt":
            return ((args[0], Fraction(1, 2)),)
        elif function == "reciprocal":
            inner = self._factors[args[0]]
            if self._scale[args[0]] == ONE and len(inner) == 1:
                self._reciprocals[node] = inner[0]
        return factors


def merged(left: Factors, right: Factors) -> Factors:
    """The product of two monomials."""
    if not left:
        return right
    if not right:
        return left
    if left[-1][0] < right[0][0]:
        return left + right
    if right[-1][0] < left[0][0]:
        return right + left
    powers = dict(left)
    for base, exponent in right:
        powers[base] = powers.get(base, 0) + exponent
    return tuple(sorted((b, e) for b, e in powers.items() if e))
