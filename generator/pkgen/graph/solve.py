"""Solving M a = f on the graph: L D L^T without square roots, unrolled, zeros left out.

Structure falls out of the constructors: a constant M makes L and D parameter expressions, which
the C computes once; a diagonal one leaves a division a row. M is positive definite, so any order
of elimination is stable, and the cheapest is taken: constant pivots first, then the row with the
fewest entries left (minimum degree), so that a star or a tree fills in nothing.
Reference: G. Golub, C. Van Loan, Matrix Computations, 4th edition, sections 4.1 and 11.1.
"""

from __future__ import annotations

from ..record import record
from .graph import ZERO, Graph, Node
from .residues import PRIME, Residues

Row = tuple[Node, ...]
Pivots = tuple[tuple[Node, Node], ...]  # each beside what it is small beside: M's diagonal, say

# Up to 20 coordinates with a dense M. There the loop in C is as fast for one state, but unrolled
# code takes lanes several times as fast; beyond, it compiles for too long.
UNROLLED_OPERATIONS = 4_000


class SingularMass(Exception):
    """M is singular at every state; `coordinate` is one that adds no inertia of its own."""

    def __init__(self, coordinate: int):
        super().__init__(coordinate)
        self.coordinate = coordinate


@record
class Solution:
    """By coordinate."""

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
        """z with L z = f, in the order of elimination."""
        found: list[Node] = []
        for i, row in enumerate(self.order):
            entry = force[row]
            for k in range(i):
                entry = g.subtract(entry, g.multiply(self.lower[i][k], found[k]))
            found.append(entry)
        return found

    def beside(self, mass: tuple[Row, ...]) -> Pivots:
        """The pivots by coordinate, each beside its entry of the diagonal of M."""
        pivots = dict(zip(self.order, self.pivots, strict=True))
        return tuple((pivots[i], row[i]) for i, row in enumerate(mass))

    def backward(self, g: Graph, z: list[Node]) -> Row:
        """a with D L^T a = z, by coordinate."""
        result: list[Node] = [ZERO] * len(z)
        for i in reversed(range(len(z))):
            entry = g.multiply(z[i], self.inverses[i])
            for k in range(i + 1, len(z)):
                entry = g.subtract(entry, g.multiply(self.lower[k][i], result[self.order[k]]))
            result[self.order[i]] = entry
        return tuple(result)


def solve(g: Graph, mass: tuple[Row, ...], force: Row) -> Solution | None:
    """The accelerations and the pivots; None if too large to unroll."""
    order, cost = elimination_order(g, mass)
    if cost > UNROLLED_OPERATIONS:
        _check_residues(g, mass)
        return None
    found = factors(g, mass, order)
    if found is None:
        return None
    return Solution(found.backward(g, found.forward(g, force)), found.beside(mass))


def factors(g: Graph, mass: tuple[Row, ...], order: list[int]) -> Factors | None:
    """None where a pivot is zero at every state, and yet M is not singular."""
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
                # With nothing beside it either, M is singular wherever one looks; else it is
                # indefinite, and a pivot fails at run time.
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
    """What is left of a column below its diagonal once the earlier ones are eliminated."""
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
    """Raises SingularMass where M is singular modulo a prime, which M at no state should be."""
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
    """Whether M is too large to be eliminated in straight-line code."""
    return elimination_order(g, mass)[1] > UNROLLED_OPERATIONS


def elimination_order(g: Graph, mass: tuple[Row, ...]) -> tuple[list[int], int]:
    """In which order the coordinates are eliminated, and the operations that this costs."""
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
