"""The expression graph: hash-consed, append-only, its nodes plain integers.

A node's arguments always have smaller numbers, so going through the numbers in order is a
topological sweep; nothing here recurses over the graph, and nothing depends on the hash seed.

Every node is known as a product `scale * rest`. There are three domains: numbers, what depends
on parameters alone, and the rest of the world. The scale is the part of the product from a
lower domain, so a number for a parameter expression, a parameter expression for any other. It
always stands first, and it is what the rule a x + b x -> (a + b) x adds up; the C hoists it.
A node whose scale is 1 also has `factors`, its canonical monomial ((base, exponent), ...): two
products equal up to order and association have the same, however they were built, and the
structure as built (with what it shares) is kept.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import IntEnum
from fractions import Fraction

from .constants import folded, root, square_part

Node = int
Factors = tuple[tuple[Node, Fraction | int], ...]
Terms = tuple[tuple[Node, Node], ...]  # of a sum: (scale, rest) each


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


# What a node depends on is a mask of these.
BIT = {kind: 1 << kind for kind in Kind}
CONSTANT = BIT[Kind.PI] | BIT[Kind.PARAMETER]
VARIABLE = BIT[Kind.COORDINATE] | BIT[Kind.RATE] | BIT[Kind.TIME] | BIT[Kind.INPUT]

ODD = frozenset({"sin", "tan", "asin", "atan", "sinh", "tanh", "sign", "reciprocal"})
EVEN = frozenset({"cos", "cosh", "abs"})

NUMBER_BITS = 512  # numbers beyond are left to the C as a product
FACTORS = 16  # a product of more is one factor of any larger product
TERMS = 4  # a sum of more is not searched for like terms
ZERO: Node = 0
ONE: Node = 1
MINUS_ONE: Node = 2


@dataclass(frozen=True, slots=True)
class Symbol:
    """`index` counts the flattened quantities of its kind from 0."""

    kind: Kind
    index: int = 0


class TooLarge(Exception):
    """The graph has reached its limit of nodes."""


class Graph:
    """Constructors of nodes; each returns the node that there already is, if there is one."""

    def __init__(self, limit: int | None = None) -> None:
        self.op: list[Op] = []
        self.args: list[tuple[Node, ...]] = []
        self.data: list[object] = []
        self.depends: list[int] = []  # a mask of BIT
        self.limit = limit
        self._known: dict[tuple[object, ...], Node] = {}
        self._domain: list[int] = []
        self._scale: list[Node] = []
        self._rest: list[Node] = []
        self._factors: list[Factors] = []
        self._terms: list[Terms | None] = []
        self._squared: list[bool] = []  # has a factor sin^2 or cos^2
        self._partner: dict[Node, Node] = {}  # sin(x) and cos(x), where both are there
        self._negatives: dict[Node, Node] = {}
        self._reciprocals: dict[Node, tuple[Node, Fraction | int]] = {}
        for value in (0, 1, -1):
            self.number(value)

    def __len__(self) -> int:
        return len(self.op)

    # -- leaves -------------------------------------------------------------------------------

    def number(self, value: Fraction | int) -> Node:
        value = Fraction(value)
        known = self._known.get((Op.NUMBER._value_, (), value))
        return self._node(Op.NUMBER, (), value) if known is None else known

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

    # -- sums ---------------------------------------------------------------------------------

    def add(self, a: Node, b: Node) -> Node:
        if a == ZERO:
            return b
        if b == ZERO:
            return a
        domain = max(self._domain[a], self._domain[b])
        if domain == 0:
            return self._number_or(Op.ADD, a, b, self.data[a] + self.data[b])
        left, right = self._terms_of(a, domain), self._terms_of(b, domain)
        if left is not None and right is not None:
            merged = self._merge(left, right)
            if merged is not None:
                return self.total(self._scaled(p, r) for p, r in merged)
        return self._join(a, b, domain)

    def subtract(self, a: Node, b: Node) -> Node:
        return self.add(a, self.negate(b))

    def negate(self, a: Node) -> Node:
        result = self._negatives.get(a)
        if result is None:
            result = self._negatives[a] = self.multiply(MINUS_ONE, a)
        return result

    def total(self, nodes: Iterable[Node]) -> Node:
        """The sum from left to right, like terms not searched for."""
        result = ZERO
        for node in nodes:
            if node == ZERO:
                continue
            if result == ZERO:
                result = node
            else:
                result = self._join(result, node, max(self._domain[result], self._domain[node]))
        return result

    def sum(self, nodes: Iterable[Node]) -> Node:
        result = ZERO
        for node in nodes:
            result = self.add(result, node)
        return result

    def _join(self, a: Node, b: Node, domain: int) -> Node:
        """a + b, with a scale in common taken out."""
        if domain == 0:
            return self.add(a, b)
        p, r = self._split(a, domain)
        s, u = self._split(b, domain)
        if p != ONE and r != ONE and u != ONE:
            if p == s:
                return self._scaled(p, self._sum_node(r, u))
            if self.negate(s) == p:
                # The sign that saves a negation: (a - b) c rather than -(b - a) c.
                if self._negative(p):
                    return self._scaled(s, self._sum_node(u, self.negate(r)))
                return self._scaled(p, self._sum_node(r, self.negate(u)))
        return self._sum_node(a, b)

    def _sum_node(self, a: Node, b: Node) -> Node:
        return self._node(Op.ADD, (a, b) if a < b else (b, a), None)

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
                return tuple((self.multiply(scale, p), r) for p, r in terms)
        return terms

    def _merge(self, left: Terms, right: Terms) -> list[tuple[Node, Node]] | None:
        """Like terms added, where that leaves no more terms than the longer sum has."""
        terms = {self._factors[r]: (p, r) for p, r in left}
        bound = max(len(left), len(right))
        for p, r in right:
            key = self._factors[r]
            if key in terms:
                p = self.add(terms[key][0], p)
                if p == ZERO:
                    del terms[key]
                else:
                    terms[key] = (p, r)
            elif not self._merge_squares(terms, p, r):
                terms[key] = (p, r)
            if len(terms) > 2 * TERMS:
                return None
        return list(terms.values()) if len(terms) <= bound else None

    def _merge_squares(
        self, terms: dict[Factors, tuple[Node, Node]], scale: Node, rest: Node
    ) -> bool:
        """R sin^2 + R cos^2 -> R and R - R sin^2 -> R cos^2, whatever the factor R is."""
        for other_key, wanted_scale, new_scale, new_rest in self._square_partners(scale, rest):
            if other_key in terms and terms[other_key][0] == wanted_scale:
                del terms[other_key]
                self._merge_into(terms, new_scale, new_rest)
                return True
        for key, (other_scale, other) in terms.items():
            if not self._squared[other] or self.negate(scale) != other_scale:
                continue
            for other_key, wanted_scale, new_scale, new_rest in self._square_partners(
                other_scale, other
            ):
                if other_key == self._factors[rest] and wanted_scale == scale:
                    del terms[key]
                    self._merge_into(terms, new_scale, new_rest)
                    return True
        return False

    def _square_partners(
        self, scale: Node, rest: Node
    ) -> Iterator[tuple[Factors, Node, Node, Node]]:
        """(key, scale) of each term that, added to this one, makes the one (scale, rest)."""
        if not self._squared[rest]:
            return
        factors = self._factors[rest]
        for base, exponent in factors:
            partner = self._partner.get(base)
            if partner is None or exponent < 2:
                continue
            common = _merged(factors, ((base, -2),))
            swapped = _merged(common, ((partner, 2),))
            yield swapped, scale, scale, self._product_of(common)
            yield common, self.negate(scale), self.negate(scale), self._product_of(swapped)

    def _merge_into(
        self, terms: dict[Factors, tuple[Node, Node]], scale: Node, rest: Node
    ) -> None:
        """Add a term that may itself find like terms."""
        scale, rest = self.multiply(scale, self._scale[rest]), self._rest[rest]
        key = self._factors[rest]
        if key in terms:
            scale = self.add(terms.pop(key)[0], scale)
        elif self._merge_squares(terms, scale, rest):
            return
        if scale != ZERO:
            terms[key] = (scale, rest)

    # -- products -----------------------------------------------------------------------------

    def multiply(self, a: Node, b: Node) -> Node:
        if a == ZERO or b == ZERO:
            return ZERO
        if a == ONE:
            return b
        if b == ONE:
            return a
        domain = max(self._domain[a], self._domain[b])
        if domain == 0:
            return self._number_or(Op.MULTIPLY, a, b, self.data[a] * self.data[b])
        p, r = self._split(a, domain)
        s, u = self._split(b, domain)
        scale = self.multiply(p, s)
        if r == ONE or u == ONE:
            return self._scaled(scale, u if r == ONE else r)
        return self._scaled(scale, self._product(r, u))

    def product(self, nodes: Iterable[Node]) -> Node:
        result = ONE
        for node in nodes:
            result = self.multiply(result, node)
        return result

    def divide(self, a: Node, b: Node) -> Node:
        return self.multiply(a, self.power(b, -1))

    def _scaled(self, scale: Node, rest: Node) -> Node:
        """scale * rest, where the scale is of a lower domain or the rest has turned out so."""
        if rest == ONE or scale == ZERO:
            return scale
        if scale == ONE:
            return rest
        if self._domain[rest] <= self._domain[scale] or self._rest[rest] != rest:
            return self.multiply(scale, rest)
        return self._node(Op.MULTIPLY, (scale, rest), None)

    def _product(self, a: Node, b: Node) -> Node:
        """The product of two nodes of one domain, each of scale 1."""
        left, right = self._factors[a], self._factors[b]
        factors = _merged(left, right)
        if self._reciprocals:
            factors = self._without_reciprocals(factors)
        if len(factors) == len(left) + len(right):
            return self._node(Op.MULTIPLY, (a, b) if a < b else (b, a), None)
        return self._product_of(factors)

    def _product_of(self, factors: Factors) -> Node:
        return self.product(self._power_of(base, exponent) for base, exponent in factors)

    def _without_reciprocals(self, factors: Factors) -> Factors:
        """x^k reciprocal(x) -> x^(k-1), which is the same at 0 too unless k is 1."""
        powers = dict(factors)
        for reciprocal, times in factors:
            found = self._reciprocals.get(reciprocal)
            if found is None or times < 1 or times != int(times):
                continue
            base, exponent = found
            there = powers.get(base, 0)
            left = there - times * exponent
            if there < 0 or (left > 0 and there > 0):
                del powers[reciprocal]
                powers[base] = left
        if len(powers) == len(factors):
            return factors
        return tuple(sorted((b, e) for b, e in powers.items() if e))

    # -- powers -------------------------------------------------------------------------------

    def power(self, base: Node, exponent: Fraction | int) -> Node:
        """base^exponent; the base is not zero where the exponent is negative."""
        if exponent == int(exponent):
            exponent = int(exponent)
        if exponent == 0:
            return ONE
        if exponent == 1 or base == ONE:
            return base
        if exponent == Fraction(1, 2):
            return self.call("sqrt", base)
        if self._domain[base] == 0:
            return self._number_power(base, exponent)
        if not isinstance(exponent, int):
            if exponent.denominator == 2:
                return self.power(self.call("sqrt", base), exponent.numerator)
            return self._node(Op.POWER, (base,), exponent)
        scale, rest = self._scale[base], self._rest[base]
        if scale != ONE:
            return self.multiply(self.power(scale, exponent), self.power(rest, exponent))
        factors = self._factors[rest]
        if factors == ((rest, 1),):
            return self._power_of(rest, exponent)
        if len(factors) == 1 or (exponent < 0 and any(e < 0 for _, e in factors)):
            return self.product(self._power_of(b, e * exponent) for b, e in factors)
        return self._integer_power(rest, exponent)

    def _power_of(self, base: Node, exponent: Fraction | int) -> Node:
        """A base, one of a monomial, to a power."""
        if exponent == int(exponent):
            exponent = int(exponent)
            if self._factors[base] != ((base, 1),):
                return self.power(base, exponent)
            return self._integer_power(base, exponent)
        if exponent.denominator == 2:
            return self._integer_power(self.call("sqrt", base), exponent.numerator)
        return self._node(Op.POWER, (base,), exponent)

    def _integer_power(self, base: Node, exponent: int) -> Node:
        """A negative one as a power of the inverse, so that a division is shared."""
        if exponent < 0:
            base, exponent = self._node(Op.POWER, (base,), Fraction(-1)), -exponent
        return base if exponent == 1 else self._node(Op.POWER, (base,), Fraction(exponent))

    def _number_power(self, base: Node, exponent: Fraction | int) -> Node:
        value = self.data[base]
        bits = max(value.numerator.bit_length(), value.denominator.bit_length())
        power = Fraction(exponent)
        if power.denominator == 2 and value >= 0:
            exact = root(value)
            if exact is not None:
                return self.power(self.number(exact), power.numerator)
        if power.denominator == 1 and bits * abs(power.numerator) <= NUMBER_BITS:
            if value or power > 0:
                return self.number(value**power.numerator)
        return self._node(Op.POWER, (base,), power)

    # -- functions ----------------------------------------------------------------------------

    def call(self, function: str, *arguments: Node) -> Node:
        values = [self.value(a) for a in arguments]
        if all(v is not None for v in values):
            exact = folded(function, values)
            if exact is not None:
                return self.number(exact)
        if len(arguments) == 1 and function in _SHAPED:
            argument = arguments[0]
            if function == "sqrt":
                return self._sqrt(argument)
            if function in ODD and self._negative(argument):
                return self.negate(self._call(function, self._opposite(argument)))
            if function in EVEN and self._negative(argument):
                return self._call(function, self._opposite(argument))
        return self._call(function, *arguments)

    def _call(self, function: str, *arguments: Node) -> Node:
        return self._node(Op.CALL, arguments, function)

    def _sqrt(self, argument: Node) -> Node:
        number = argument
        while self._domain[number] > 0:
            number = self._scale[number]
        if self.data[number] > 0:
            outside = square_part(self.data[number])
            if outside != 1:
                inside = self.multiply(self.number(1 / outside**2), argument)
                return self.multiply(self.number(outside), self._call("sqrt", inside))
        return self._call("sqrt", argument)

    def _negative(self, node: Node) -> bool:
        """Whether it is written with a sign in front; of a - b and b - a, one is."""
        while self._domain[node] > 0 and self._scale[node] != ONE:
            node = self._scale[node]
        if self._domain[node] == 0:
            return self.data[node] < 0
        if self.op[node] is Op.ADD:
            first = min(self.args[node], key=self._rest.__getitem__)
            return self.op[first] is not Op.ADD and self._negative(first)
        return False

    def _opposite(self, node: Node) -> Node:
        """-node, of a bare sum with the sign carried to its terms."""
        if self.op[node] is Op.ADD:
            a, b = self.args[node]
            return self._sum_node(self.negate(a), self.negate(b))
        return self.negate(node)

    # -- bookkeeping --------------------------------------------------------------------------

    def _number_or(self, op: Op, a: Node, b: Node, value: Fraction) -> Node:
        if max(value.numerator.bit_length(), value.denominator.bit_length()) > NUMBER_BITS:
            return self._node(op, (a, b), None)
        return self.number(value)

    def _node(self, op: Op, args: tuple[Node, ...], data: object) -> Node:
        key = (op._value_, args, data)
        node = self._known.get(key)
        if node is None:
            node = len(self.op)
            if self.limit is not None and node >= self.limit:
                raise TooLarge
            self._known[key] = node
            self.op.append(op)
            self.args.append(args)
            self.data.append(data)
            depends = BIT[data.kind] if op is Op.SYMBOL else 0
            for a in args:
                depends |= self.depends[a]
            self.depends.append(depends)
            self._enter(node, op, args, data)
        return node

    def _enter(self, node: Node, op: Op, args: tuple[Node, ...], data: object) -> None:
        """The node as scale, rest and monomial; as a sum, its terms."""
        domain = 0 if op is Op.NUMBER else 2 if self.depends[node] & VARIABLE else 1
        self._domain.append(domain)
        scaled = op is Op.MULTIPLY and self._domain[args[0]] < domain > self._domain[args[0]]
        scaled = scaled and self._domain[args[1]] == domain
        self._scale.append(node if domain == 0 else args[0] if scaled else ONE)
        self._rest.append(ONE if domain == 0 else args[1] if scaled else node)
        factors: Factors = ((node, 1),)
        if domain == 0 or scaled:
            factors = ()
        elif op is Op.MULTIPLY and self._domain[args[0]] == self._domain[args[1]] == domain:
            merged = _merged(self._factors[args[0]], self._factors[args[1]])
            if len(merged) <= FACTORS:
                factors = merged
        elif op is Op.POWER and self._domain[args[0]] == domain:
            inner = self._factors[args[0]]
            if self._scale[args[0]] == ONE and data.denominator == 1:
                factors = tuple((b, e * data.numerator) for b, e in inner)
            elif self._scale[args[0]] == ONE:
                factors = ((args[0], data),)
        elif op is Op.CALL and data == "sqrt":
            factors = ((args[0], Fraction(1, 2)),)
        self._factors.append(factors)
        self._squared.append(any(e >= 2 and self.data[b] in _SQUARES for b, e in factors))
        terms: Terms | None = None if scaled else ((ONE, node),)
        if op is Op.ADD and domain:
            left = self._terms_of(args[0], domain)
            right = self._terms_of(args[1], domain)
            terms = None
            if left is not None and right is not None and len(left) + len(right) <= TERMS:
                # The same rest twice, as in (x + y) + (x + z), would be lost when merging.
                if len({self._factors[r] for _, r in left + right}) == len(left + right):
                    terms = left + right
        self._terms.append(terms)
        if op is Op.CALL and data in _SQUARES:
            partner = self._known.get((Op.CALL._value_, args, _SQUARES[data]))
            if partner is not None:
                self._partner[node], self._partner[partner] = partner, node
        if op is Op.CALL and data == "reciprocal":
            inner = self._factors[args[0]]
            if self._scale[args[0]] == ONE and len(inner) == 1:
                self._reciprocals[node] = inner[0]


_SQUARES = {"sin": "cos", "cos": "sin"}
_SHAPED = ODD | EVEN | {"sqrt"}


def _merged(left: Factors, right: Factors) -> Factors:
    """The product of two monomials."""
    if not left:
        return right
    if not right:
        return left
    powers = dict(left)
    for base, exponent in right:
        powers[base] = powers.get(base, 0) + exponent
    return tuple(sorted((b, e) for b, e in powers.items() if e))
