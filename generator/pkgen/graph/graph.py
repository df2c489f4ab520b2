"""The expression graph: hash-consed and append-only; nodes are plain integers.

A node's arguments always have smaller numbers than the node, so that the order of the numbers is a
topological order. Nothing here recurses over the graph, and nothing depends on the hash seed.

Every node is stored as a product `scale * rest`. There are three domains, from the lowest to the
highest: numbers, expressions of parameters alone, and all other expressions. The scale contains the
factors from lower domains: the scale of an expression of parameters is a number, the scale of an
expression with variables is an expression of parameters. The scale is always the first factor. The
rule a x + b x -> (a + b) x adds the scales a and b. The C code computes scales once per run. A node
whose scale is 1 also has `factors`, its canonical monomial ((base, exponent), ...): two products
that are equal up to order and association have the same monomial. The arguments of a node are kept
as they were given, so that subexpressions stay shared.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from functools import reduce

from ..functions import FUNCTIONS
from .constants import fits, raised, square_part
from .frame_table import Frames
from .like_terms import merge
from .monomials import merged, without_reciprocals
from .nodes import (
    BIT,
    CONSTANT,
    MINUS_ONE,
    ONE,
    VARIABLE,
    WORLD,
    ZERO,
    Factors,
    Kind,
    Node,
    Nodes,
    Op,
    Symbol,
    TooLarge,
)

__all__ = [
    "BIT",
    "CONSTANT",
    "MINUS_ONE",
    "ONE",
    "VARIABLE",
    "ZERO",
    "Factors",
    "Graph",
    "Kind",
    "Node",
    "Op",
    "Symbol",
    "TooLarge",
]

_HALF = Fraction(1, 2)


class Graph(Nodes):
    """Constructors of nodes with simplification. Each returns an existing node if it is equal."""

    def __init__(self, limit: int | None = None) -> None:
        super().__init__(limit)
        self.frames = Frames()

    def copy(self) -> Graph:
        result = super().copy()
        result.frames = self.frames.copy()
        return result

    # -- sums ---------------------------------------------------------------------------------

    def add(self, a: Node, b: Node) -> Node:
        if a == ZERO:
            return b
        if b == ZERO:
            return a
        domain = self._domain[a] | self._domain[b]
        if domain == WORLD:
            return self._added(a, b, domain)
        known = self._constant_sums.get((a, b))
        if known is None:
            known = self._constant_sums[a, b] = self._added(a, b, domain)
        return known

    def _added(self, a: Node, b: Node, domain: int) -> Node:
        if domain == 0:
            value = self.data[a] + self.data[b]
            return self.number(value) if fits(value) else self._sum_node(a, b)
        rest = self._rest[a]
        if rest == self._rest[b] and self.op[rest] is not Op.ADD:
            return self._scaled(self.add(self._scale[a], self._scale[b]), rest)
        if self.data[a] == self.data[b] == "select" and self.args[a][0] == self.args[b][0]:
            (condition, *chosen), (_, *other) = self.args[a], self.args[b]
            return self.call("select", condition, *map(self.add, chosen, other))
        left, right = self._terms_of(a, domain), self._terms_of(b, domain)
        if left is not None and right is not None:
            terms = merge(self, left, right)
            if terms is not None:
                return self.total(self._scaled(p, r) for p, r in terms)
        return self._join(a, b, domain)

    def subtract(self, a: Node, b: Node) -> Node:
        return self.add(a, self.negate(b))

    def negate(self, a: Node) -> Node:
        result = self._negatives.get(a)
        if result is None:
            result = self._negatives[a] = self.multiply(MINUS_ONE, a)
        return result

    def total(self, nodes: Iterable[Node]) -> Node:
        """Returns the sum of the nodes, from left to right, without merging like terms."""
        result = ZERO
        for node in nodes:
            if node == ZERO:
                continue
            if result == ZERO:
                result = node
            else:
                result = self._join(result, node, self._domain[result] | self._domain[node])
        return result

    def sum(self, nodes: Iterable[Node]) -> Node:
        return reduce(self.add, nodes, ZERO)

    def _join(self, a: Node, b: Node, domain: int) -> Node:
        """Returns a + b without merging like terms; a common scale is factored out."""
        if domain == 0:
            return self.add(a, b)
        scales, rests, domains = self._scale, self._rest, self._domain
        p, r = (a, ONE) if domains[a] < domain else (scales[a], rests[a])
        s, u = (b, ONE) if domains[b] < domain else (scales[b], rests[b])
        if p != ONE and r != ONE and u != ONE:
            if p == s:
                return self._scaled(p, self._sum_node(r, u))
            if self.negate(s) == p:
                # Chooses the sign that needs no negation: (a - b) c rather than -(b - a) c.
                if self._negative(p):
                    return self._scaled(s, self._sum_node(u, self.negate(r)))
                return self._scaled(p, self._sum_node(r, self.negate(u)))
        return self._sum_node(a, b)

    # -- products -----------------------------------------------------------------------------

    def multiply(self, a: Node, b: Node) -> Node:
        if a == ZERO or b == ZERO:
            return ZERO
        if a == ONE:
            return b
        if b == ONE:
            return a
        if self._domain[a] == WORLD or self._domain[b] == WORLD:
            return self._multiplied(a, b)
        known = self._constant_products.get((a, b))
        if known is None:
            known = self._constant_products[a, b] = self._multiplied(a, b)
        return known

    def _multiplied(self, a: Node, b: Node) -> Node:
        domain, other = self._domain[a], self._domain[b]
        if domain != other:  # the factor from the lower domain becomes a part of the scale
            if domain > other:
                a, b = b, a
            scale, rest = self._scale[b], self._rest[b]
            scale = a if scale == ONE else self.multiply(a, scale)
            return rest if scale == ONE else self._scaled_node(scale, rest)
        if domain == 0:
            value = self.data[a] * self.data[b]
            if fits(value):
                return self.number(value)
            return self._product_node((a, b) if a < b else (b, a))
        p, s = self._scale[a], self._scale[b]
        scale = s if p == ONE else p if s == ONE else self.multiply(p, s)
        rest = self._product(self._rest[a], self._rest[b])
        return rest if scale == ONE else self._scaled(scale, rest)

    def product(self, nodes: Iterable[Node]) -> Node:
        return reduce(self.multiply, nodes, ONE)

    def dot(self, a: Iterable[Node], b: Iterable[Node]) -> Node:
        """Returns the sum of the products of the elements of two vectors."""
        return self.sum(map(self.multiply, a, b))

    def divide(self, a: Node, b: Node) -> Node:
        return self.multiply(a, self.power(b, -1))

    def _scaled(self, scale: Node, rest: Node) -> Node:
        """Returns scale * rest. Simplification may have left factors in `rest` that belong to the
        scale, or made it an expression without variables. These are merged into the scale."""
        if rest == ONE or scale == ZERO:
            return scale
        if scale == ONE:
            return rest
        if self._domain[rest] <= self._domain[scale] or self._rest[rest] != rest:
            return self.multiply(scale, rest)
        return self._scaled_node(scale, rest)

    def _product(self, a: Node, b: Node) -> Node:
        """Returns the product of two nodes of the same domain with scale 1."""
        args = (a, b) if a < b else (b, a)
        known = self._products.get(args)
        if known is not None:
            return known
        chosen = self._select_of(a, b) or self._select_of(b, a)
        if chosen is not None:
            return chosen
        left, right = self._factors[a], self._factors[b]
        factors = merged(left, right)
        if self._reciprocals:
            factors = without_reciprocals(factors, self._reciprocals)
        if len(factors) == len(left) + len(right):
            return self._product_node(args, factors)
        return self._product_of(factors)

    def _select_of(self, a: Node, b: Node) -> Node | None:
        """Returns the product of a = select(c, x, 0) and b as select(c, x b, 0); None for another
        a. The product is 0 where a is 0, even if b is not finite there."""
        if self.op[a] is not Op.CALL or self.data[a] != "select":
            return None
        condition, *branches = self.args[a]
        if ZERO not in branches:
            return None
        return self.call("select", condition, *(self.multiply(x, b) for x in branches))

    def _product_of(self, factors: Factors) -> Node:
        return self.product(self._power_of(base, exponent) for base, exponent in factors)

    # -- powers -------------------------------------------------------------------------------

    def power(self, base: Node, exponent: Fraction | int) -> Node:
        """Returns base^exponent. With a negative exponent, the base is assumed to be nonzero."""
        if exponent.denominator == 1:
            exponent = exponent.numerator
        elif exponent == _HALF:
            return self.call("sqrt", base)
        if exponent == 0:
            return ONE
        if exponent == 1 or base == ONE:
            return base
        if self._domain[base] == 0:
            exact = raised(self.data[base], Fraction(exponent))
            if exact is not None:
                return self.number(exact)
            return self._power_node(base, Fraction(exponent))
        if not isinstance(exponent, int):
            if exponent.denominator == 2:
                return self.power(self.call("sqrt", base), exponent.numerator)
            return self._power_node(base, exponent)
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
        """Returns base^exponent for a base of a monomial."""
        if exponent.denominator == 1:
            exponent = exponent.numerator
            if self._factors[base] != ((base, 1),):
                return self.power(base, exponent)
            return self._integer_power(base, exponent)
        if exponent.denominator == 2:
            return self._integer_power(self.call("sqrt", base), exponent.numerator)
        return self._power_node(base, exponent)

    def _integer_power(self, base: Node, exponent: int) -> Node:
        """Returns an integer power. A negative power is a power of 1/base, so that several powers
        share one division."""
        if exponent < 0:
            base, exponent = self._power_node(base, -1), -exponent
        return base if exponent == 1 else self._power_node(base, exponent)

    # -- functions ----------------------------------------------------------------------------

    def call(self, function: str, *arguments: Node) -> Node:
        values = [self.value(a) for a in arguments]
        if all(v is not None for v in values):
            exact = FUNCTIONS[function].exact(*values)
            if exact is not None:
                return self.number(exact)
        if function == "sqrt":
            return self._sqrt(*arguments)
        if function == "select" and (values[0] is not None or arguments[1] == arguments[2]):
            return arguments[2 if values[0] == 0 else 1]
        parity = FUNCTIONS[function].parity
        if parity and self._negative(arguments[0]):
            node = self._call_node(function, (self._opposite(arguments[0]),))
            return node if parity == "even" else self.negate(node)
        return self._call_node(function, arguments)

    def _sqrt(self, argument: Node) -> Node:
        number = argument
        while self._domain[number] > 0:
            number = self._scale[number]
        if self.data[number] > 0:
            outside = square_part(self.data[number])
            if outside != 1:
                inside = self.multiply(self.number(1 / outside**2), argument)
                return self.multiply(self.number(outside), self._call_node("sqrt", (inside,)))
        return self._call_node("sqrt", (argument,))

    def _negative(self, node: Node) -> bool:
        """Whether the node has a leading minus sign. Exactly one of a - b and b - a has it."""
        while self._domain[node] > 0 and self._scale[node] != ONE:
            node = self._scale[node]
        if self._domain[node] == 0:
            return self.data[node] < 0
        if self.op[node] is Op.ADD:
            first = min(self.args[node], key=self._rest.__getitem__)
            return self.op[first] is not Op.ADD and self._negative(first)
        return False

    def _opposite(self, node: Node) -> Node:
        """Returns -node. In a sum, each term is negated."""
        if self.op[node] is Op.ADD:
            a, b = self.args[node]
            return self._sum_node(self.negate(a), self.negate(b))
        return self.negate(node)
