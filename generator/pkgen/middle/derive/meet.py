"""Solves for the multipliers of constraint rows some of which hold at times; see contacts.py."""

from __future__ import annotations

from collections.abc import Sequence

from ...equations import Matrix, Row, Rows
from ...graph.graph import ONE, ZERO, Graph, Node
from ...graph.solve import Factors, Pivots, Solution
from ..motion import Motion


def met(
    g: Graph, motion: Motion, factored: Factors, rows: Rows, J: Matrix, gamma: Sequence[Node]
) -> tuple[Row, Solution, Pivots, list[Node], Row]:
    """Returns the multipliers, the accelerations with the pivots of M, the pivots of the matrix of
    the multipliers, the forces of the rows, and Constraints.values. The multiplier of a friction
    that slips is its force."""
    count, numbers = len(J), {x.name: x.row for x in rows.meetings}
    on, along, force = [ONE] * count, [*J], motion.force
    for x in rows.meetings:
        on[x.row] = x.mode
        if x.side is None:
            continue
        force = _less(g, force, g.multiply(x.side, x.bounds[0]), J[x.row])
        if x.of:
            j = numbers[x.of]
            along[j] = _less(g, along[j], g.multiply(x.side, x.bounds[1]), J[x.row])
    columns = [factored.forward(g, row) for row in J]
    pushed = [factored.forward(g, row) for row in along]

    def product(a: Sequence[Node], b: Sequence[Node]) -> Node:
        terms = zip(factored.inverses, a, b, strict=True)
        return g.sum(g.multiply(w, g.multiply(x, y)) for w, x, y in terms)

    def wanted(force: Row) -> list[Node]:
        z = factored.forward(g, force)
        pairs = zip(columns, gamma, strict=True)
        return [g.negate(g.add(product(column, z), own)) for column, own in pairs]

    S = [[product(a, b) for b in pushed] for a in columns]
    found, pivots = _solved(g, S, on, wanted(force))
    free, always = wanted(motion.force), [a if a == ONE else ZERO for a in on]
    bound, _ = _solved(g, S, always, free)
    values: list[Node] = []
    for x in rows.meetings:
        held = [g.multiply(a, entry) for a, entry in zip(always, S[x.row], strict=True)]
        values += [g.subtract(g.dot(held, bound), free[x.row]), *x.bounds]
    multipliers = [*found]
    for x in rows.meetings:
        if x.side is not None:
            slide = g.multiply(x.bounds[1], found[numbers[x.of]]) if x.of else ZERO
            slide = g.multiply(x.side, g.add(x.bounds[0], slide))
            multipliers[x.row] = g.subtract(found[x.row], slide)
    binding = [g.dot(column, multipliers) for column in zip(*J, strict=True)]
    z = factored.forward(g, tuple(map(g.add, motion.force, binding)))
    solution = Solution(factored.backward(g, z), factored.beside(motion.mass))
    beside = [_if(g, a, product(c, c), ONE) for a, c in zip(on, columns, strict=True)]
    sizes = tuple(zip(pivots, beside, strict=True))
    return tuple(multipliers), solution, sizes, binding, tuple(values)


def _less(g: Graph, row: Row, factor: Node, other: Row) -> Row:
    """Returns row - factor*other."""
    pairs = zip(row, other, strict=True)
    return tuple(g.subtract(a, g.multiply(factor, b)) for a, b in pairs)


def _if(g: Graph, on: Node, a: Node, b: Node) -> Node:
    """Returns a where `on` is 1, and b where it is 0."""
    return g.add(g.multiply(on, a), g.multiply(g.subtract(ONE, on), b))


def _solved(
    g: Graph, S: Sequence[Sequence[Node]], on: Sequence[Node], wanted: Sequence[Node]
) -> tuple[list[Node], list[Node]]:
    """Returns the solution of S x = wanted among the rows that are on, with x = 0 for the others,
    and the pivots: by Gauss's elimination without exchanges."""
    n = len(on)
    A = [[g.multiply(g.multiply(on[i], on[j]), S[i][j]) for j in range(n)] for i in range(n)]
    for i in range(n):
        A[i][i] = _if(g, on[i], S[i][i], ONE)
    b = [g.multiply(a, x) for a, x in zip(on, wanted, strict=True)]
    for k in range(n):
        inverse = g.power(A[k][k], -1)
        for i in range(k + 1, n):
            factor = g.multiply(A[i][k], inverse)
            b[i] = g.subtract(b[i], g.multiply(factor, b[k]))
            for j in range(k + 1, n):
                A[i][j] = g.subtract(A[i][j], g.multiply(factor, A[k][j]))
    x = [ZERO] * n
    for k in reversed(range(n)):
        x[k] = g.divide(g.subtract(b[k], g.dot(A[k][k + 1 :], x[k + 1 :])), A[k][k])
    return x, [A[k][k] for k in range(n)]
