"""Solves M a = f symbolically, by an unrolled, sparse L D L^T factorization without square roots.

The simplification of nodes makes use of structure: if M is constant, L and D contain only
parameters and the C code computes them once; if M is diagonal, each row takes one division. M is
positive definite, so that any order of elimination is stable. The order is chosen for few
operations: constant pivots first, then the row with the fewest entries (minimum degree), so that a
star or a tree causes no fill-in.
Reference: G. Golub, C. Van Loan, Matrix Computations, 4th edition, sections 4.1 and 11.1.
"""

from __future__ import annotations

from ..record import record
from .graph import ZERO, Graph, Node
from .residues import PRIME, Residues

Row = tuple[Node, ...]
# Pairs of a pivot and the value with which its size is compared, such as the diagonal entry of M.
Pivots = tuple[tuple[Node, Node], ...]

# The largest number of operations of unrolled code: about 20 coordinates with a dense M. More takes
# too long to compile; a loop in C is then used. For one state at a time the loop is as fast, but
# with SIMD lanes unrolled code is several times as fast.
UNROLLED_OPERATIONS = 4_000


class SingularMass(Exception):
    """M is singular at every state; `coordinate` is the index of a coordinate whose pivot is 0."""

    def __init__(self, coordinate: int):
        super().__init__(coordinate)
        self.coordinate = coordinate


@record
class Solution:
    """Accelerations and pivots, both in the order of the coordinates."""

    accelerations: Row
    pivots: Pivots


@record
class Factors:
    """The factorization M = L D L^T: `lower` has the entries of L below the diagonal, `pivots` and
    `inverses` the entries of D and their inverses, all in the order of elimination."""

    order: list[int]
    lower: list[list[Node]]
    pivots: list[Node]
    inverses: list[Node]

    def forward(self, g: Graph, force: Row) -> list[Node]:
        """Returns the solution z of L z = f, in the order of elimination."""
        found: list[Node] = []
        for i, row in enumerate(self.order):
            entry = force[row]
            for k in range(i):
                entry = g.subtract(entry, g.multiply(self.lower[i][k], found[k]))
            found.append(entry)
        return found

    def beside(self, mass: tuple[Row, ...]) -> Pivots:
        """Returns pairs (pivot, diagonal entry of M), in the order of the coordinates."""
        pivots = dict(zip(self.order, self.pivots, strict=True))
        return tuple((pivots[i], row[i]) for i, row in enumerate(mass))

    def backward(self, g: Graph, z: list[Node]) -> Row:
        """Returns the solution a of D L^T a = z, in the order of the coordinates."""
        result: list[Node] = [ZERO] * len(z)
        for i in reversed(range(len(z))):
            entry = g.multiply(z[i], self.inverses[i])
            for k in range(i + 1, len(z)):
                entry = g.subtract(entry, g.multiply(self.lower[k][i], result[self.order[k]]))
            result[self.order[i]] = entry
        return tuple(result)


def solve(g: Graph, mass: tuple[Row, ...], force: Row) -> Solution | None:
    """Returns accelerations and pivots; None if M is too large for unrolled code or cannot be
    factorized."""
    order, cost = elimination_order(g, mass)
    if cost > UNROLLED_OPERATIONS:
        _check_residues(g, mass)
        return None
    found = factors(g, mass, order)
    if found is None:
        return None
    return Solution(found.backward(g, found.forward(g, force)), found.beside(mass))


def factors(g: Graph, mass: tuple[Row, ...], order: list[int]) -> Factors | None:
    """Returns the factors of M, or None if a pivot is zero at every state though M is regular.
    Raises SingularMass if M is singular at every state."""
    n = len(mass)
    inverses: list[Node] = []
    pivots: list[Node] = []
    lower: list[list[Node]] = [[ZERO] * n for _ in range(n)]

    def eliminated(i: int, last: int) -> Node:
        """Returns the entry in row i and column `last` after elimination of the columns to its
        left, and sets the entries of `lower` there. Both are numbered in the order of
        elimination."""
        row: list[Node] = []  # l_ij d_j
        for j in range(last + 1):
            entry = mass[order[i]][order[j]]
            for k in range(j):
                entry = g.subtract(entry, g.multiply(row[k], lower[j][k]))
            row.append(entry)
            if j < len(inverses):
                lower[i][j] = g.multiply(entry, inverses[j])
        return row[last]

    for i in range(n):
        pivot = eliminated(i, i)
        if pivot == ZERO:
            # If all entries below this zero pivot are zero too, M is singular at every state.
            # Otherwise M is indefinite, which a check at run time reports.
            if all(eliminated(row, i) == ZERO for row in range(i + 1, n)):
                raise SingularMass(order[i])
            return None
        pivots.append(pivot)
        inverses.append(g.power(pivot, -1))
    return Factors(order, lower, pivots, inverses)


def _check_residues(g: Graph, mass: tuple[Row, ...]) -> None:
    """Raises SingularMass if M is singular modulo a prime at pseudorandom values of its symbols."""
    residue = Residues(g)
    rows = [[residue(entry) for entry in row] for row in mass]
    if any(None in row for row in rows):
        return
    for k, top in enumerate(rows):
        if top[k] == 0:
            if any(row[k] for row in rows[k + 1 :]):
                return  # M is indefinite, which a check at run time reports
            raise SingularMass(k)
        inverse = pow(top[k], -1, PRIME)
        for row in rows[k + 1 :]:
            if row[k]:
                factor = row[k] * inverse % PRIME
                row[k:] = [(x - factor * y) % PRIME for x, y in zip(row[k:], top[k:], strict=True)]


def looped(g: Graph, mass: tuple[Row, ...]) -> bool:
    """Whether M is too large to be factorized in straight-line code."""
    return elimination_order(g, mass)[1] > UNROLLED_OPERATIONS


def elimination_order(g: Graph, mass: tuple[Row, ...]) -> tuple[list[int], int]:
    """Returns the elimination order of the coordinates, and its cost in operations."""
    n = len(mass)
    neighbours = [{j for j in range(n) if j != i and mass[i][j] != ZERO} for i in range(n)]
    settled = [g.is_constant(mass[i][i]) for i in range(n)]
    left = list(range(n))
    order: list[int] = []
    cost = 0
    while left:
        # settled[i]: the pivot i is constant, since only constants were subtracted from the
        # diagonal entry of M.
        chosen = min(left, key=lambda i: (not settled[i], len(neighbours[i]), i))
        left.remove(chosen)
        order.append(chosen)
        around = sorted(neighbours[chosen])
        cost += 1 + 4 * len(around)  # operations of forward and backward substitution
        for i in around:
            neighbours[i].update(around)
            neighbours[i] -= {i, chosen}
            if not (settled[chosen] and g.is_constant(mass[i][chosen])):
                settled[i] = False
                cost += len(around) + 2
    return order, cost
