"""Finer normal forms than `normal.py`, which recognize more equalities: angles, exponents and
roots are taken apart.

The atoms of `normal.py` are sines of whole arguments and inverses of whole sums. Here sin(x + y)
is written in sin(x), cos(x), sin(y) and cos(y), tan as sin/cos, sinh and the like in exp,
pow(x, n - 1) as pow(x, n)/x, abs, min, max and step in sign; several expressions get one common
denominator. The results are polynomials in generators with the relations sin^2 = 1 - cos^2,
sign^2 = 1 and (x^(1/n))^n = x. An expression is zero wherever it is defined if its numerator is 0.
Both reciprocal(x) and sign(x) count as divisions by x: all results hold only where no divisor is
zero, away from kinks and jumps.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import lcm

from ..functions import FUNCTIONS
from .graph import Graph, Kind, Node, Op, Symbol
from .normal import POWERS, Monomial, Normal, Polynomial, TooMuch
from .ranges import Ranges

WORK = 60_000  # limit of products of two terms, about half a second
TERMS = 3_000  # most terms of one polynomial
SUMMANDS = 4  # most summands of an angle or an exponent that is taken apart


class _Finer(Exception):
    """A smaller fraction of a base angle is needed than the one in use: start again."""


class Exact(Normal):
    """Normal forms of nodes of one graph, to which new nodes are added; see above."""

    def __init__(self, g: Graph, work: int = WORK, ranges: Ranges | None = None):
        super().__init__(g, work=work, terms=TERMS)
        self.ranges = ranges  # to drop signs of positive factors
        self.parts: dict[Monomial, int] = {}  # a base angle or exponent is monomial / parts
        self.roots: dict[Node, tuple[int, Node]] = {}  # (n, x) of an atom x^(1/n), n > 2
        self.pi = g.symbol(Symbol(Kind.PI))

    def __call__(self, output: Node) -> Polynomial | None:
        while True:
            try:
                return super().__call__(output)
            except _Finer:
                self.known.clear()

    def all(self, nodes: Sequence[Node]) -> list[Polynomial] | None:
        """Returns normal forms of several nodes in the same atoms; None if it is too much work."""
        while True:
            if any(self(node) is None for node in nodes):
                return None
            if all(node in self.known for node in nodes):
                return [self.known[node] for node in nodes]

    def is_zero(self, node: Node) -> bool:
        """True proves that the node is zero; False proves nothing."""
        numerators = self.numerators([node])
        return numerators is not None and not numerators[0]

    def numerators(self, nodes: Sequence[Node]) -> list[Polynomial] | None:
        """Returns the nodes times one common factor that makes each a polynomial; None as above."""
        try:
            found = self.all(nodes)
            return None if found is None else self.cleared(found)
        except TooMuch:
            return None

    def cleared(self, polynomials: list[Polynomial]) -> list[Polynomial]:
        """Returns the polynomials times one product of powers, without negative exponents."""
        while True:
            least: dict[Node, int] = {}
            for polynomial in polynomials:
                for monomial in polynomial:
                    for base, e in monomial:
                        if e < least.get(base, 0):
                            least[base] = e
            if not least:
                return polynomials
            base = max(least)  # an outer base first: it may contain others
            polynomials = [self._times(p, base, -least[base]) for p in polynomials]

    def _times(self, polynomial: Polynomial, base: Node, power: int) -> Polynomial:
        """Returns the polynomial times base^power, with the base expanded."""
        by_exponent: dict[int, Polynomial] = {}
        for monomial, coefficient in polynomial.items():
            exponents = dict(monomial)
            e = exponents.pop(base, 0) + power
            rest = tuple(sorted(exponents.items()))
            by_exponent.setdefault(e, {})[rest] = coefficient
        whole = self._opened(base)
        result: Polynomial = {}
        for e, part in by_exponent.items():
            for _ in range(e):
                part = self.multiplied(part, whole)
            result = self.added(result, part)
        return result

    def _opened(self, base: Node) -> Polynomial:
        """Returns the polynomial of a base that is a sum; any other base stays an atom."""
        if self.graph.op[base] is not Op.ADD:
            return {((base, 1),): 1}
        found = self(base)
        if found is None:
            raise TooMuch
        return found

    # -- powers and functions -------------------------------------------------------------------

    def _reduced(self, monomial: Monomial) -> Polynomial | None:
        for base, exponent in monomial:
            if self._is_sign(base) and exponent not in (0, 1):
                left = {**dict(monomial), base: exponent % 2}
                return self._monomial(tuple((b, e) for b, e in left.items() if e))
            n, under = self.roots.get(base, (0, 0))
            if n and exponent >= n:
                rest = dict(monomial) | {base: exponent - n}
                square = self(under)
                if square is None:
                    raise TooMuch
                left = tuple(sorted((b, e) for b, e in rest.items() if e))
                return self.multiplied(square, self._monomial(left))
        return super()._reduced(monomial)

    def _is_sign(self, node: Node) -> bool:
        return self.graph.op[node] is Op.CALL and self.graph.data[node] == "sign"

    def sign(self, of: Polynomial) -> Polynomial:
        """Returns the sign of a monomial as the product of its factors' signs, and the sign of a
        sum after division by its first coefficient."""
        if not of:
            return {}
        first, g = of[min(of)], self.graph
        if len(of) > 1:
            signs = [g.call("sign", self.plain({m: c / Fraction(first) for m, c in of.items()}))]
        else:
            odd = [base for base, e in min(of) if e % 2]
            bases = [x for x in odd if not (self.ranges and self.ranges(x).positive)]
            signs = [x if self._is_sign(x) else g.call("sign", x) for x in bases]
        found: Polynomial = {(): 1 if first > 0 else -1}
        for sign in signs:
            found = self.multiplied(found, {((sign, 1),): 1})
        return found

    def _polynomial(self, node: Node) -> Polynomial:
        g = self.graph
        if g.op[node] is Op.CALL:
            found = FUNCTIONS[g.data[node]].opened(self, *(self.known[a] for a in g.args[node]))
            if found is not None:
                return found
        return super()._polynomial(node)

    def _power(self, base: Polynomial, exponent: Fraction) -> Polynomial:
        if exponent.denominator < 3:
            return super()._power(base, exponent)
        under = self.plain(base)
        atom = self.graph._power_node(under, Fraction(1, exponent.denominator))
        self.roots[atom] = exponent.denominator, under
        return super()._power({((atom, 1),): 1}, Fraction(exponent.numerator))

    def inverse(self, polynomial: Polynomial) -> Polynomial:
        return self._power(polynomial, Fraction(-1))

    def multiples(self, polynomial: Polynomial) -> list[tuple[Node, int]] | None:
        """Returns a sum as (base angle, integer multiple) pairs; None if they are too many."""
        if len(polynomial) > SUMMANDS:
            return None
        found = []
        for monomial, coefficient in polynomial.items():
            value = Fraction(coefficient)
            parts = self.parts.get(monomial, 1)
            if parts % value.denominator:
                self.parts[monomial] = lcm(parts, value.denominator)
                raise _Finer
            times = int(value * parts)
            if abs(times) > POWERS:
                return None
            found.append((self.term(monomial, Fraction(1, parts)), times))
        return found

    def circle(self, polynomial: Polynomial) -> tuple[Polynomial, Polynomial] | None:
        """Returns the cosine and the sine of a sum, by the addition theorems."""
        quarter = Fraction(polynomial.get(((self.pi, 1),), 0)) * 2
        turned = {m: c for m, c in polynomial.items() if m != ((self.pi, 1),)}
        if quarter.denominator > 1:
            quarter, turned = Fraction(0), polynomial
        found = self.multiples(turned)
        if found is None:
            return None
        real, imaginary = [({(): 1}, {}), ({}, {(): 1}), ({(): -1}, {}), ({}, {(): -1})][
            int(quarter) % 4
        ]
        for base, times in found:
            cos: Polynomial = {((self.graph.call("cos", base), 1),): 1}
            sin: Polynomial = {((self.graph.call("sin", base), 1),): 1 if times > 0 else -1}
            for _ in range(abs(times)):
                real, imaginary = (
                    self.added(self.multiplied(real, cos), self.minus(imaginary, sin)),
                    self.added(self.multiplied(real, sin), self.multiplied(imaginary, cos)),
                )
        return real, imaginary

    def minus(self, a: Polynomial, b: Polynomial) -> Polynomial:
        """Returns -a b."""
        return {m: -c for m, c in self.multiplied(a, b).items()}

    # -- called by `opened` of the function table; None where the expansion is too large --------

    def cos(self, angle: Polynomial) -> Polynomial | None:
        found = self.circle(angle)
        return found and found[0]

    def sin(self, angle: Polynomial) -> Polynomial | None:
        found = self.circle(angle)
        return found and found[1]

    def quotient(self, a: Polynomial | None, b: Polynomial | None) -> Polynomial | None:
        return None if a is None or b is None else self.multiplied(a, self.inverse(b))

    def exp(self, exponent: Polynomial, sign: int = 1) -> Polynomial | None:
        found = self.multiples(exponent)
        if found is None:
            return None
        powers = {self.graph.call("exp", base): sign * times for base, times in found}
        return {tuple(sorted(powers.items())): 1}

    def hyperbolic(self, exponent: Polynomial, sign: int) -> Polynomial | None:
        """Returns cosh for sign 1, sinh for sign -1."""
        up, down = self.exp(exponent), self.exp(exponent, -1)
        if up is None or down is None:
            return None
        return self.halved(self.added(up, {m: c * sign for m, c in down.items()}))

    def pow(self, base: Polynomial, exponent: Polynomial) -> Polynomial | None:
        """Returns base^exponent, with the integer part of the exponent as a power of its own."""
        whole = Fraction(exponent.get((), 0)) // 1
        rest = self.added(exponent, {(): -whole}) if whole else exponent
        power: Polynomial = {((self.graph.call("pow", self.plain(base), self.plain(rest)), 1),): 1}
        return self.multiplied(power, self._power(base, Fraction(whole))) if whole else power

    def larger(self, a: Polynomial, b: Polynomial, sign: int) -> Polynomial:
        """Returns max(a, b) = (a + b + |a - b|)/2 for sign 1, min(a, b) for sign -1."""
        apart = self.added(a, {m: -c for m, c in b.items()})
        size = {m: sign * c for m, c in self.multiplied(apart, self.sign(apart)).items()}
        return self.halved(self.added(self.added(a, b), size))

    def halved(self, a: Polynomial) -> Polynomial:
        return {m: c * Fraction(1, 2) for m, c in a.items()}
