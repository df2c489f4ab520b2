"""Solves M a = f on the graph by an unrolled, sparse L D L^T factorization without square roots.

The constructors of nodes exploit structure: a constant M makes L and D parameter expressions, which
the C computes once; a diagonal M leaves one division per row. M is positive definite, so any order
of elimination is stable, and the cheapest is taken: constant pivots first, then the row with the
fewest entries left (minimum degree), so that a star or a tree causes no fill-in.
Reference: G. Golub, C. Van Loan, Matrix Computations, 4th edition, sections 4.1 and 11.1.
"""

from __future__ import annotations

from ..record import record
from .graph import ZERO, Graph, Node
from .residues import PRIME, Residues

Row = tuple[Node, ...]
Pivots = tuple[tuple[Node, Node], ...]  # (pivot, its reference size, such as M's diagonal entry)

# About 20 coordinates with a dense M. The loop in C is as fast for one state, but unrolled code is
# several times as fast with SIMD lanes; beyond this size it takes too long to compile.
UNROLLED_OPERATIONS = 4_000


class SingularMass(Exception):
    """M is singular at every state; `coordinate` is one whose pivot is zero."""

    def __init__(self, coordinate: int):
        super().__init__(coordinate)
        self.coordinate = coordinate


@record
class Solution:
    """Accelerations and pivots, both by coordinate."""

    accelerations: Row
    pivots: Pivots


@record
class Factors:
    """M = L D L^T, in the order of elimination: l_ij below the diagonal, d_i and their inverses."""

    order: list[int]
    lower: list[list[Node]]
    pivots: list[Node]
    inverses: list[Node]

    def forward(self, g: Graph, force: Row) -> list[Node]:
        """Returns z with L z = f, in the order of elimination."""
        found: list[Node] = []
        for i, row in enumerate(self.order):
            entry = force[row]
            for k in range(i):
                entry = g.subtract(entry, g.multiply(self.lower[i][k], found[k]))
            found.append(entry)
        return found

    def beside(self, mass: tuple[Row, ...]) -> Pivots:
        """Returns (pivot, diagonal entry of M) by coordinate."""
        pivots = dict(zip(self.order, self.pivots, strict=True))
        return tuple((pivots[i], row[i]) for i, row in enumerate(mass))

    def backward(self, g: Graph, z: list[Node]) -> Row:
        """Returns a with D L^T a = z, by coordinate."""
        result: list[Node] = [ZERO] * len(z)
        for i in reversed(range(len(z))):
            entry = g.multiply(z[i], self.inverses[i])
            for k in range(i + 1, len(z)):
                entry = g.subtract(entry, g.multiply(self.lower[k][i], result[self.order[k]]))
            result[self.order[i]] = entry
        return tuple(result)


def solve(g: Graph, mass: tuple[Row, ...], force: Row) -> Solution | None:
    """Returns accelerations and pivots; None if M is too large to unroll or `factors` has none."""
    order, cost = elimination_order(g, mass)
    if cost > UNROLLED_OPERATIONS:
        _check_residues(g, mass)
        return None
    found = factors(g, mass, order)
    if found is None:
        return None
    return Solution(found.backward(g, found.forward(g, force)), found.beside(mass))


def factors(g: Graph, mass: tuple[Row, ...], order: list[int]) -> Factors | None:
    """Returns the factors of M, or None where a pivot is zero at every state though M is regular.
    Raises SingularMass where M is singular at every state."""
    n = len(mass)
    inverses: list[Node] = []
    pivots: list[Node] = []
    # By position in the order: lower[i][j] = l_ij and scaled[i][j] = l_ij d_j.
    lower: list[list[Node]] = [[ZERO] * n for _ in range(n)]
    scaled: list[list[Node]] = [[ZERO] * n for _ in range(n)]
    for i in range(n):
        for j in range(i + 1):
            entry = mass[order[i]][order[j]]
            for k in range(j):
                entry = g.subtract(entry, g.multiply(scaled[i][k], lower[j][k]))
            if j < i:
                scaled[i][j] = entry
                lower[i][j] = g.multiply(entry, inverses[j])
            elif entry == ZERO:
                # If the rest of the column is zero too, M is singular at every state. Otherwise M
                # is indefinite, and a pivot fails at run time.
                if all(rest == ZERO for rest in _below(g, mass, order, lower, i)):
                    raise SingularMass(order[i])
                return None
            else:
                pivots.append(entry)
                inverses.append(g.power(entry, -1))
    return Factors(order, lower, pivots, inverses)


def _below(
    g: Graph,
    mass: tuple[Row, ...],
    order: list[int],
    lower: list[list[Node]],
    column: int,
) -> list[Node]:
    """Returns the entries of a column below its diagonal after the earlier eliminations."""
    found = []
    for row in range(column + 1, len(order)):
        left: list[Node] = []
        for j in range(column + 1):
            entry = mass[order[row]][order[j]]
            for k in range(j):
                entry = g.subtract(entry, g.multiply(left[k], lower[j][k]))
            left.append(entry)
        found.append(left[column])
    return found


def _check_residues(g: Graph, mass: tuple[Row, ...]) -> None:
    """Raises SingularMass where M is singular modulo a prime at pseudorandom values."""
    residue = Residues(g)
    rows = [[residue(entry) for entry in row] for row in mass]
    if any(None in row for row in rows):
        return
    for k, top in enumerate(rows):
        if top[k] == 0:
            if any(row[k] for row in rows[k + 1 :]):
                return  # indefinite: a pivot fails at run time
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
        # A pivot stays constant until something that varies is subtracted from it.
        chosen = min(left, key=lambda i: (not settled[i], len(neighbours[i]), i))
        left.remove(chosen)
        order.append(chosen)
        around = sorted(neighbours[chosen])
        cost += 1 + 4 * len(around)  # of the substitutions
        for i in around:
            neighbours[i].update(around)
            neighbours[i] -= {i, chosen}
            if not (settled[chosen] and g.is_constant(mass[i][chosen])):
                settled[i] = False
                cost += len(around) + 2
    return order, cost
