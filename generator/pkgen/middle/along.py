"""Time derivatives along the equations of motion, on a copy of the equations' graph.

The accelerations are written by Cramer's rule for each block of M, over one denominator a block:
that is what normal forms can cancel. Of a larger block they are those that `derive` solved for.
"""

from __future__ import annotations

from ..equations import Equations, Indices
from .differentiate import gradient
from .graph import BIT, ONE, VARIABLE, ZERO, Graph, Kind, Node, Symbol

CRAMER = 4  # coordinates of one block


class Along:
    """d/dt of nodes of `graph`; the nodes of the equations have the same numbers there."""

    def __init__(self, equations: Equations, blocks: Indices):
        self.graph = equations.graph.copy()
        self.equations = equations
        self.block = {i: block for block in blocks for i in block}
        self.known: dict[int, Node | None] = {}

    def terms(self, node: Node) -> list[Node] | None:
        """The parts of its derivative, one for each symbol; None where an acceleration that would
        be needed is too large."""
        g = self.graph
        terms = []
        for symbol, slope in gradient(g, node, VARIABLE).items():
            rate = self._rate(g.data[symbol]) if slope != ZERO else ZERO
            if rate is None:
                return None
            terms.append(g.multiply(slope, rate))
        return [term for term in terms if term != ZERO]

    def explicit(self, node: Node) -> Node:
        """Its derivative with the coordinates and rates held: by t, and by what inputs do."""
        g = self.graph
        slopes = gradient(g, node, BIT[Kind.TIME] | BIT[Kind.INPUT])
        return g.sum(g.multiply(slope, self._rate(g.data[s])) for s, slope in slopes.items())

    def _rate(self, symbol: Symbol) -> Node | None:
        g = self.graph
        if symbol.kind is Kind.TIME:
            return ONE
        if symbol.kind is Kind.COORDINATE:
            return g.symbol(Symbol(Kind.RATE, symbol.index))
        if symbol.kind is Kind.RATE:
            return self._acceleration(symbol.index)
        return g.symbol(Symbol(Kind.INPUT, self._next_input(symbol.index)))

    def _next_input(self, index: int) -> int:
        """Of an input's derivative that the equations know, or of one that nobody does."""
        names = [q.name for q in self.equations.inputs]
        following = names[index] + "'" if index < len(names) else ""
        return index + 1 if following in names[index + 1 : index + 2] else index + len(names)

    def _acceleration(self, index: int) -> Node | None:
        if index not in self.known:
            block = self.block[index]
            if len(block) <= CRAMER:
                self.known |= cramer(self.graph, self.equations, block)
            else:
                solved = self.equations.acceleration
                self.known |= {i: solved[i] if solved else None for i in block}
        return self.known[index]


def cramer(g: Graph, equations: Equations, block: tuple[int, ...]) -> dict[int, Node]:
    """M a = f of one block by determinants."""
    rows = [[equations.mass[i][j] for j in block] for i in block]
    inverse = g.power(determinant(g, rows), -1)
    found = {}
    for k, i in enumerate(block):
        replaced = [
            [*row[:k], equations.force[at], *row[k + 1 :]]
            for row, at in zip(rows, block, strict=True)
        ]
        found[i] = g.multiply(determinant(g, replaced), inverse)
    return found


def determinant(g: Graph, rows: list[list[Node]]) -> Node:
    """By the first row."""
    if not rows:
        return ONE
    total = ZERO
    for j, entry in enumerate(rows[0]):
        if entry != ZERO:
            minor = determinant(g, [[*row[:j], *row[j + 1 :]] for row in rows[1:]])
            term = g.multiply(entry, minor)
            total = g.subtract(total, term) if j % 2 else g.add(total, term)
    return total
