"""Normal forms: expressions are written as polynomials. Two expressions with the same polynomial
are equal.

The variables of the polynomials, called atoms, are symbols (parameters included), function calls
whose arguments are in normal form, inverses of sums, and sums that a policy leaves unexpanded. The
coefficients are fractions. sin^2 becomes 1 - cos^2, and an even power of a square root becomes a
power of its argument, so that terms cancel by these identities: for example, the kinetic energy of
a point that rotates with the angle Omega t has no t in its normal form. The work is bounded: for an
expression that needs more, the normal form is None.
"""

from __future__ import annotations

from fractions import Fraction

from .differentiate import unknown
from .graph import Graph, Node, Op
from .monomials import merged

Monomial = tuple[tuple[Node, int], ...]
# Integer coefficients are stored as int, which is ten times as fast as Fraction.
Polynomial = dict[Monomial, Fraction | int]

# The limit of work for normal forms: products of two terms.
WORK = 5_000
# The largest number of terms of one polynomial.
TERMS = 500
# The largest number of bits of a coefficient.
BITS = 4_096
# The largest exponent for which the power of a sum is expanded.
POWERS = 12


class TooMuch(Exception):
    """A limit of work is reached, or a polynomial that is 0 is inverted."""


class Normal:
    """Normal forms of nodes of one graph. `closed` holds the sums that are not expanded."""

    def __init__(
        self,
        g: Graph,
        closed: frozenset[Node] = frozenset(),
        canonical: bool = True,
        work: int = WORK,
        terms: int = TERMS,
    ):
        self.graph = g
        self.closed = closed
        self.canonical = canonical  # whether sin^2 is replaced by 1 - cos^2
        self.work = work
        self.terms = terms
        self.known: dict[Node, Polynomial] = {}

    def __call__(self, output: Node) -> Polynomial | None:
        """Returns the normal form of the node, or None if it would take too much work."""
        try:
            for node in unknown(self._opened_args, [output], self.known):
                if node not in self.known:
                    self.known[node] = self._polynomial(node)
        except TooMuch:
            return None
        return self.known[output]

    def _opened_args(self, node: Node) -> tuple[Node, ...]:
        """Returns the arguments of a node; () of a sum that stays unexpanded."""
        return () if node in self.closed else self.graph.args[node]

    def _polynomial(self, node: Node) -> Polynomial:
        g = self.graph
        op, args, data = g.op[node], g.args[node], g.data[node]
        if op is Op.NUMBER:
            return {(): _plain_number(data)} if data else {}
        if op is Op.SYMBOL or node in self.closed:
            return {((node, 1),): 1}
        if op is Op.ADD:
            return self.added(self.known[args[0]], self.known[args[1]])
        if op is Op.MULTIPLY:
            return self.multiplied(self.known[args[0]], self.known[args[1]])
        if op is Op.POWER:
            return self._power(self.known[args[0]], data)
        arguments = [self.plain(self.known[a]) for a in args]
        return self._of(g.call(data, *arguments))

    def _of(self, node: Node) -> Polynomial:
        """Returns the polynomial of a node that was made as a function call or a root. The graph
        may have simplified the node to something else, such as a product."""
        g = self.graph
        coefficient: Fraction | int = 1
        monomial: dict[Node, int] = {}
        for base, exponent in g.factors(node):
            value = g.value(base)
            if value is not None and exponent == int(exponent):
                coefficient *= value ** int(exponent)
                continue
            if exponent != int(exponent):
                if exponent.denominator != 2:
                    return {((node, 1),): 1}
                base, exponent = g.call("sqrt", base), exponent.numerator
            monomial[base] = monomial.get(base, 0) + int(exponent)
        return {tuple(sorted(monomial.items())): coefficient}

    # -- arithmetic ---------------------------------------------------------------------------

    def added(self, a: Polynomial, b: Polynomial) -> Polynomial:
        if len(a) < len(b):
            a, b = b, a
        result = dict(a)
        for monomial, coefficient in b.items():
            total = result.get(monomial, 0) + coefficient
            if total:
                result[monomial] = total
            else:
                del result[monomial]
        return result

    def multiplied(self, a: Polynomial, b: Polynomial) -> Polynomial:
        self.work -= len(a) * len(b)
        if self.work < 0:
            raise TooMuch
        result: Polynomial = {}
        again: list[Polynomial] = []
        for m, c in a.items():
            for n, d in b.items():
                if c.numerator.bit_length() + d.numerator.bit_length() > BITS:
                    raise TooMuch
                monomial = merged(m, n)
                reduced = self._reduced(monomial)
                if reduced is not None:
                    again.append({k: x * c * d for k, x in reduced.items()})
                    continue
                total = result.get(monomial, 0) + c * d
                if total:
                    result[monomial] = total
                else:
                    del result[monomial]
        for part in again:
            result = self.added(result, part)
        if len(result) > self.terms:
            raise TooMuch
        return result

    def _reduced(self, monomial: Monomial) -> Polynomial | None:
        """Returns the monomial after replacing sin^2 by 1 - cos^2 or sqrt(u)^2 by u; None if it
        contains neither."""
        g = self.graph
        for base, exponent in monomial:
            if exponent < 2 or g.op[base] is not Op.CALL:
                continue
            if g.data[base] == "sin" and self.canonical:
                cos = g.call("cos", g.args[base][0])
                square: Polynomial = {(): 1, ((cos, 2),): -1}
            elif g.data[base] == "sqrt":
                under = self(g.args[base][0])
                if under is None:
                    raise TooMuch
                square = under
            else:
                continue
            rest = merged(monomial, ((base, -2),))
            return self.multiplied(square, self._monomial(rest))
        return None

    def _monomial(self, monomial: Monomial) -> Polynomial:
        reduced = self._reduced(monomial)
        return {monomial: 1} if reduced is None else reduced

    def _power(self, base: Polynomial, exponent: Fraction) -> Polynomial:
        g = self.graph
        if exponent.denominator != 1:
            return self._of(g.power(self.plain(base), exponent))
        n = int(exponent)
        if len(base) == 1:
            ((monomial, coefficient),) = base.items()
            size = coefficient.numerator.bit_length() + coefficient.denominator.bit_length()
            if abs(n) * size > BITS:
                raise TooMuch
            raised = tuple((b, e * n) for b, e in monomial)
            scale = _plain_number(Fraction(coefficient) ** n)
            return {m: c * scale for m, c in self._monomial(raised).items()}
        if n > 0:
            if n > POWERS:
                raise TooMuch
            result: Polynomial = {(): 1}
            for _ in range(n):
                result = self.multiplied(result, base)
            return result
        if not base:
            raise TooMuch
        # Divide the sum by its leading coefficient: 1/(2x + 2) becomes 1/(x + 1) / 2.
        first = Fraction(base[min(base)])
        inner = self.plain({m: c / first for m, c in base.items()})
        return {((inner, n),): first**n}

    def plain(self, polynomial: Polynomial) -> Node:
        """Converts the polynomial to a node. The terms are in canonical order."""
        g = self.graph
        return g.total(self.term(m, polynomial[m]) for m in sorted(polynomial))

    def term(self, monomial: Monomial, coefficient: Fraction | int) -> Node:
        g = self.graph
        return g.multiply(g.number(coefficient), g.product(g.power(b, e) for b, e in monomial))


def _plain_number(value: Fraction) -> Fraction | int:
    return value.numerator if value.denominator == 1 else value


# -- merging of squared sines and cosines ----------------------------------------------------------


def squares_merged(g: Graph, polynomial: Polynomial) -> Polynomial:
    """Applies R sin^2 + R cos^2 -> R and R - R sin^2 -> R cos^2 as often as possible.

    Unlike the replacement of sin^2 by 1 - cos^2, this never subtracts nearly equal terms.
    """
    terms = dict(polynomial)
    pending = sorted(terms, reverse=True)
    while pending:
        monomial = pending.pop()
        for swapped, common in _square_partners(g, monomial):
            coefficient = terms.get(monomial)
            if coefficient is None:
                break
            if terms.get(swapped) == coefficient:
                gone, result = swapped, common
            elif terms.get(common) == -coefficient:
                gone, result, coefficient = common, swapped, -coefficient
            else:
                continue
            del terms[monomial], terms[gone]
            terms[result] = terms.get(result, 0) + coefficient
            if not terms[result]:
                del terms[result]
            pending.append(result)
    return terms


def _square_partners(g: Graph, monomial: Monomial) -> list[tuple[Monomial, Monomial]]:
    found = []
    for base, exponent in monomial:
        if exponent >= 2 and g.op[base] is Op.CALL and g.data[base] in ("sin", "cos"):
            other = g.call("cos" if g.data[base] == "sin" else "sin", g.args[base][0])
            common = merged(monomial, ((base, -2),))
            found.append((merged(common, ((other, 2),)), common))
    return found
