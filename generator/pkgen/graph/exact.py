"""Normal forms that recognize more equal expressions than `normal.py`: functions are expanded.

In `normal.py`, sin(x + y) is an indivisible atom. Here it is expanded in sin(x), cos(x), sin(y) and
cos(y). Likewise tan becomes sin/cos; sinh, cosh and tanh become sums and quotients of exp;
pow(x, n - 1) becomes pow(x, n)/x; abs, min, max and step are written with sign. Several expressions
get one common denominator. The results are polynomials in generators with the relations
sin^2 = 1 - cos^2, sign^2 = 1 and (x^(1/n))^n = x. An expression is zero wherever it is defined if
its numerator is 0. All results hold only where no divisor is zero, and away from kinks and jumps:
reciprocal(x) and sign(x) are treated as if they were divisions by x.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import lcm

from ..functions import FUNCTIONS
from .graph import Graph, Node, Op
from .normal import POWERS, Monomial, Normal, Polynomial, TooMuch
from .ranges import Ranges

# The limit of work for a normal form: products of two terms, which take about half a second.
WORK = 60_000
# The largest number of terms of one polynomial.
TERMS = 3_000
# The largest number of summands of an angle or exponent that is expanded.
SUMMANDS = 4


class _Finer(Exception):
    """An angle is not an integer multiple of its base angle: for example, x/2 occurs after x became
    a base angle. All normal forms must then be computed again with a smaller base angle."""


class Exact(Normal):
    """Normal forms of nodes of one graph. Adds nodes to the graph."""

    def __init__(self, g: Graph, work: int = WORK, ranges: Ranges | None = None):
        super().__init__(g, work=work, terms=TERMS)
        # The ranges show which factors are positive: their signs are 1.
        self.ranges = ranges
        # For each monomial in an angle or exponent, an integer. The base angle is the monomial
        # divided by this integer, so that all occurring angles are integer multiples of base
        # angles.
        self.parts: dict[Monomial, int] = {}
        # The pair (n, x) of each atom x^(1/n) with n > 2.
        self.roots: dict[Node, tuple[int, Node]] = {}
        self.pi = g.pi()

    def __call__(self, output: Node) -> Polynomial | None:
        while True:
            try:
                return super().__call__(output)
            except _Finer:
                self.known.clear()

    def all(self, nodes: Sequence[Node]) -> list[Polynomial] | None:
        """Returns the normal forms of the nodes, with common base angles; None if they take too
        much work."""
        while True:
            if any(self(node) is None for node in nodes):
                return None
            if all(node in self.known for node in nodes):
                return [self.known[node] for node in nodes]

    def is_zero(self, node: Node) -> bool:
        """Returns True only if the node is proved to be zero."""
        numerators = self.numerators([node])
        return numerators is not None and not numerators[0]

    def numerators(self, nodes: Sequence[Node]) -> list[Polynomial] | None:
        """Returns the numerators of the nodes after they are brought to a common denominator, as
        polynomials; None if they take too much work."""
        try:
            found = self.all(nodes)
            return None if found is None else self.cleared(found)
        except TooMuch:
            return None

    def cleared(self, polynomials: list[Polynomial]) -> list[Polynomial]:
        """Returns the polynomials multiplied by a common denominator, so that no exponent is
        negative."""
        while True:
            least: dict[Node, int] = {}
            for polynomial in polynomials:
                for monomial in polynomial:
                    for base, e in monomial:
                        if e < least.get(base, 0):
                            least[base] = e
            if not least:
                return polynomials
            base = max(least)  # the newest node: its expansion may contain older ones
            polynomials = [self._times(p, base, -least[base]) for p in polynomials]

    def _times(self, polynomial: Polynomial, base: Node, power: int) -> Polynomial:
        """Returns the polynomial times base^power; remaining powers of a base that is a sum are
        expanded."""
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
        """Returns a base that is a sum as its polynomial, any other base as an atom."""
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
        """Returns the sign of the polynomial. For a monomial it is the product of the signs of its
        factors. A sum is first divided by its leading coefficient, whose sign is a separate
        factor."""
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
        """Returns pairs (base angle, integer) whose products add up to the polynomial; None if it
        has too many terms or too large integers."""
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
        """Returns the cosine and the sine of the polynomial, expanded by the addition theorems;
        None if the expansion is too large."""
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
                    self.added(
                        self.multiplied(real, cos), self.negated(self.multiplied(imaginary, sin))
                    ),
                    self.added(self.multiplied(real, sin), self.multiplied(imaginary, cos)),
                )
        return real, imaginary

    # -- functions for `opened` of the function table; None if the expansion is too large --------

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
        """Returns cosh(exponent) for sign 1, sinh(exponent) for sign -1, written with exp."""
        up, down = self.exp(exponent), self.exp(exponent, -1)
        if up is None or down is None:
            return None
        return self.halved(self.added(up, {m: c * sign for m, c in down.items()}))

    def pow(self, base: Polynomial, exponent: Polynomial) -> Polynomial | None:
        """Returns base^exponent as the product of an integer power and pow(base, rest)."""
        whole = Fraction(exponent.get((), 0)) // 1
        rest = self.added(exponent, {(): -whole}) if whole else exponent
        power: Polynomial = {((self.graph.call("pow", self.plain(base), self.plain(rest)), 1),): 1}
        return self.multiplied(power, self._power(base, Fraction(whole))) if whole else power

    def larger(self, a: Polynomial, b: Polynomial, sign: int) -> Polynomial:
        """Returns (a + b + sign |a - b|)/2: max(a, b) for sign 1, min(a, b) for sign -1."""
        apart = self.added(a, {m: -c for m, c in b.items()})
        size = {m: sign * c for m, c in self.multiplied(apart, self.sign(apart)).items()}
        return self.halved(self.added(self.added(a, b), size))

    def negated(self, a: Polynomial) -> Polynomial:
        return {m: -c for m, c in a.items()}

    def halved(self, a: Polynomial) -> Polynomial:
        return {m: c * Fraction(1, 2) for m, c in a.items()}
