"""The order of a Runge-Kutta method, by the order conditions of rooted trees.

A method has order p if for every rooted tree t of up to p nodes

    sum b_i Phi_i(t) = 1 / gamma(t),   Phi_i([t_1 ... t_m]) = prod_k sum_j a_ij Phi_j(t_k).

Here a_ij and b_i are the coefficients of the tableau, Phi_i(t) is the elementary weight of t at
stage i, gamma(t) the density of t, and [t_1 ... t_m] the tree with subtrees t_k at its root. The
error constant is the Euclidean norm of (sum b_i Phi_i - 1/gamma) / sigma over the trees of p + 1
nodes, where sigma(t) is the symmetry of t. Reference: J. C. Butcher, Numerical Methods for Ordinary
Differential Equations, 3rd ed., 31; E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary
Differential Equations I, II.2.

Numbers are stored as integers, which are the numbers times 2^BITS. A coefficient written to 14
digits counts as exact: a condition holds if its error is at most CLOSE times the sum of the
magnitudes of its terms.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cache

from ..record import record

BITS = 256
ONE = 1 << BITS
CLOSE = 1e-12
MOST_ORDER = 10


@record
class Rooted:
    # The subtrees at the root, each as (order, index in trees(order)), in descending order.
    children: tuple[tuple[int, int], ...]
    gamma: int
    sigma: int


@cache
def trees(order: int) -> tuple[Rooted, ...]:
    """Returns the rooted trees with `order` nodes."""
    if order == 1:
        return (Rooted((), 1, 1),)
    return tuple(_rooted(order, children) for children in _forests(order - 1, (order - 1, 10**9)))


def _rooted(order: int, children: tuple[tuple[int, int], ...]) -> Rooted:
    gamma, sigma = order, 1
    for child in dict.fromkeys(children):
        tree, times = trees(child[0])[child[1]], children.count(child)
        gamma *= tree.gamma**times
        sigma *= tree.sigma**times * math.factorial(times)
    return Rooted(children, gamma, sigma)


def _forests(nodes: int, most: tuple[int, int]) -> Iterator[tuple[tuple[int, int], ...]]:
    """Yields all tuples of trees that have `nodes` nodes together. A tree is given by its order and
    its index in trees(order). The trees of a tuple are in descending order, the first is at most
    `most`."""
    if nodes == 0:
        yield ()
        return
    for size in range(min(nodes, most[0]), 0, -1):
        for index in range(len(trees(size)) - 1, -1, -1):
            if (size, index) <= most:
                for rest in _forests(nodes - size, (size, index)):
                    yield ((size, index), *rest)


def scaled(x: Fraction) -> int:
    """Returns x times 2^BITS, rounded down to an integer."""
    return (x.numerator << BITS) // x.denominator


class Conditions:
    """The order conditions for a matrix A. The methods take the weights b as an argument."""

    def __init__(self, a: Sequence[Sequence[Fraction]]):
        self._rows = [[(j, scaled(x)) for j, x in enumerate(row) if x] for row in a]
        self._phi: dict[tuple[int, int], list[int]] = {}
        self._summed: dict[tuple[int, int], list[int]] = {}

    def _of(self, key: tuple[int, int]) -> list[int]:
        """Returns the elementary weight Phi_i of a tree, for each stage i."""
        if key not in self._phi:
            phi = [ONE] * len(self._rows)
            for child in trees(key[0])[key[1]].children:
                phi = [x * y >> BITS for x, y in zip(phi, self._times_a(child), strict=True)]
            self._phi[key] = phi
        return self._phi[key]

    def _times_a(self, key: tuple[int, int]) -> list[int]:
        if key not in self._summed:
            phi = self._of(key)
            self._summed[key] = [sum(x * phi[j] for j, x in row) >> BITS for row in self._rows]
        return self._summed[key]

    def missed(self, b: Sequence[Fraction], order: int) -> tuple[bool, float]:
        """Returns whether the condition of a tree with `order` nodes fails, and the norm of the
        errors of all these conditions."""
        weights, failed, total = [scaled(x) for x in b], False, 0.0
        for index, tree in enumerate(trees(order)):
            terms = [x * y >> BITS for x, y in zip(weights, self._of((order, index)), strict=True)]
            wanted = ONE // tree.gamma
            miss = (sum(terms) - wanted) / ONE
            failed |= abs(miss) > CLOSE * (sum(map(abs, terms)) + wanted) / ONE
            total += (miss / tree.sigma) ** 2
        return failed, math.sqrt(total)

    def order(self, b: Sequence[Fraction]) -> tuple[int, float | None]:
        """Returns the order and the error constant; (MOST_ORDER, None) if all tested conditions
        hold."""
        for p in range(1, MOST_ORDER + 1):
            failed, size = self.missed(b, p)
            if failed:
                return p - 1, size
        return MOST_ORDER, None


def symplectic(a: Sequence[Sequence[Fraction]], b: Sequence[Fraction]) -> bool:
    """Whether b_i a_ij + b_j a_ji = b_i b_j for all i, j; J. M. Sanz-Serna, BIT 28 (1988) 877."""
    s = range(len(b))
    return all(_close(b[i] * a[i][j] + b[j] * a[j][i], b[i] * b[j]) for i in s for j in s)


def symmetric(a: Sequence[Sequence[Fraction]], b: Sequence[Fraction]) -> bool:
    """Whether a_ij + a_(s+1-i)(s+1-j) = b_j; E. Hairer et al., Geometric Num. Integration V.2.1."""
    s = len(b)
    return all(
        _close(a[i][j] + a[s - 1 - i][s - 1 - j], b[j]) for i in range(s) for j in range(s)
    ) and all(_close(b[j], b[s - 1 - j]) for j in range(s))


def _close(x: Fraction, y: Fraction) -> bool:
    return abs(x - y) <= Fraction(CLOSE) * max(abs(x), abs(y), 1)
