"""Time derivatives along the equations of motion, on a copy of the equations' graph.

Cramer's rule gives the accelerations of each block of M, with one denominator per block: normal
forms can cancel that. Larger blocks are solved as in the C code. If that is too large as well, the
accelerations stay symbols, whose values at a state `solved.py` finds.
"""

from __future__ import annotations

from ...equations import Equations, Indices
from ...graph.differentiate import gradient, partials, reachable
from ...graph.graph import BIT, ONE, VARIABLE, ZERO, Graph, Kind, Node, Op, Symbol
from ...graph.solve import solve
from ...graph.substitute import substituted
from ..points.squares import determinant
from .combination import combination

CRAMER = 4  # largest number of coordinates of a block for Cramer's rule


class Along:
    """d/dt of nodes of `graph`; the nodes of the equations have the same numbers there."""

    def __init__(self, equations: Equations, blocks: Indices):
        self.graph = equations.graph.copy()
        self.equations = equations
        self.block = {i: block for block in blocks for i in block}
        self.known: dict[int, Node] = {}
        self.bound: dict[Node, Node] | None = None  # rates in terms of others, by constraints
        # Momenta and the energy, whose rates have no accelerations: by node without its scale, the
        # scale and the index (None: energy). The graph splits scales off powers and products.
        self.leaves: dict[Node, tuple[Node, int | None]] = {}
        known = [*enumerate(equations.momenta), (None, equations.energy)]
        for i, node in known if equations.momenta else []:
            scale, rest = self.graph.split(node)
            self.leaves[rest] = scale, i

    def terms(self, node: Node) -> list[Node]:
        """Returns the terms of a node's derivative, one by each symbol, momentum and energy."""
        g = self.graph
        slopes = self._slopes(node)
        terms = self._of_large_blocks(slopes)
        terms += [g.multiply(x, self._rate_of(leaf)) for leaf, x in slopes.items() if x != ZERO]
        return [term for term in terms if term != ZERO]

    def on_constraints(self, terms: list[Node]) -> list[Node]:
        """Returns the terms on J v + j0 = 0, with some rates in terms of others; not valid where
        the divisors of these vanish."""
        if self.equations.constraints is None:
            return terms
        if self.bound is None:
            self.bound = rates_bound(self.graph, self.equations)
        return [x for x in substituted(self.graph, terms, self.bound) if x != ZERO]

    def _of_large_blocks(self, slopes: dict[Node, Node]) -> list[Node]:
        """Returns the terms of rates of large blocks that need no accelerations (combination.py),
        and removes the slopes by these rates."""
        g, e, terms = self.graph, self.equations, []
        for block in dict.fromkeys(self.block.values()):
            rates = [g.symbol(Symbol(Kind.RATE, i)) for i in block]
            wanted = [slopes.get(rate, ZERO) for rate in rates]
            if len(block) <= CRAMER or all(x == ZERO for x in wanted):
                continue
            found = combination(g, [[e.mass[i][j] for j in block] for i in block], wanted)
            if found is not None:
                terms += [
                    g.multiply(g.number(x), e.force[i]) for x, i in zip(found, block, strict=True)
                ]
                for rate in rates:
                    slopes.pop(rate, None)
        return terms

    def _slopes(self, output: Node) -> dict[Node, Node]:
        """Returns the derivatives of a node by the symbols, momenta and energy in it."""
        g, leaves = self.graph, self.leaves
        bars, found = {output: ONE}, {}
        for node in reversed(reachable(g, [output], VARIABLE)):
            bar = bars.pop(node, ZERO)
            if g.op[node] is Op.SYMBOL or node in leaves:
                found[node] = bar
            elif bar != ZERO:
                for a, slope in zip(g.args[node], partials(g, node), strict=True):
                    if g.depends[a] & VARIABLE:
                        bars[a] = g.add(bars.get(a, ZERO), g.multiply(bar, slope))
        return found

    def _rate_of(self, leaf: Node) -> Node:
        if self.graph.op[leaf] is Op.SYMBOL:
            return self._rate(self.graph.data[leaf])
        scale, i = self.leaves[leaf]
        rate = self.energy_rate() if i is None else self.equations.pdot[i]
        return self.graph.divide(rate, scale)

    def energy_rate(self) -> Node:
        """Returns dh/dt = v.(Q - dD/dv) - dL/dt, plus (J v).lambda for constraints, J v = -j0."""
        g, e = self.graph, self.equations
        rates = [g.symbol(Symbol(Kind.RATE, i)) for i in range(len(e.applied))]
        applied, c = e.applied, e.constraints
        moved = ZERO
        if c is not None:
            applied = c.free_applied
            offsets = substituted(g, c.residual, dict.fromkeys(rates, ZERO))
            moved = g.sum(map(g.multiply, offsets, c.multipliers))
        power = g.sum(map(g.multiply, rates, applied))
        slopes = self.explicit(e.lagrangian, e.quaternions)
        return g.subtract(g.subtract(power, moved), slopes)

    def explicit(self, node: Node, first: int = 0) -> Node:
        """Returns a node's time derivative at fixed coordinates and rates: through t, inputs, and
        states from index `first` on."""
        g = self.graph
        slopes = gradient(g, node, BIT[Kind.TIME] | BIT[Kind.INPUT] | BIT[Kind.STATE])
        return g.sum(
            g.multiply(slope, self._rate(g.data[s]))
            for s, slope in slopes.items()
            if g.data[s].kind != Kind.STATE or g.data[s].index >= first
        )

    def _rate(self, symbol: Symbol) -> Node:
        g = self.graph
        if symbol.kind is Kind.TIME:
            return ONE
        if symbol.kind is Kind.COORDINATE:
            return g.symbol(Symbol(Kind.RATE, symbol.index))
        if symbol.kind is Kind.RATE:
            return self._acceleration(symbol.index)
        if symbol.kind is Kind.STATE:
            return self.equations.state_rates[symbol.index]
        return g.symbol(Symbol(Kind.INPUT, self._next_input(symbol.index)))

    def _next_input(self, index: int) -> int:
        """Returns the index of an input's next derivative; beyond all inputs if it is unknown."""
        names = [q.name for q in self.equations.inputs]
        following = names[index] + "'" if index < len(names) else ""
        return index + 1 if following in names[index + 1 : index + 2] else index + len(names)

    def _acceleration(self, index: int) -> Node:
        if index not in self.known:
            block = self.block[index]
            if len(block) <= CRAMER:
                self.known |= cramer(self.graph, self.equations, block)
            else:
                self.known |= enumerate(self._solved())
        return self.known[index]

    def _solved(self) -> tuple[Node, ...]:
        g, e = self.graph, self.equations
        if e.acceleration is not None:
            return e.acceleration
        found = solve(g, e.mass, e.force)
        if found is not None:
            return found.accelerations
        return tuple(g.symbol(Symbol(Kind.ACCELERATION, i)) for i in range(len(e.force)))


def rates_bound(g: Graph, equations: Equations) -> dict[Node, Node]:
    """Solves each row of J v + j0 = 0 for one rate; divides by a constant entry of J if possible.
    A proof extends by continuity to states where the entry is 0."""
    c = equations.constraints
    count = len(equations.momenta)
    rates = [g.symbol(Symbol(Kind.RATE, i)) for i in range(count)]
    found: dict[Node, Node] = {}
    offsets = substituted(g, c.residual, dict.fromkeys(rates, ZERO))
    for J, offset in zip(c.rows, offsets, strict=True):
        (row,) = substituted(g, [g.add(g.sum(map(g.multiply, J, rates)), offset)], found)
        by = gradient(g, row, BIT[Kind.RATE])
        entries = sorted(by.items(), key=lambda x: (bool(g.depends[x[1]] & VARIABLE), x[0]))
        pivot, entry = next(((s, x) for s, x in entries if x != ZERO), (None, ZERO))
        if pivot is None:
            continue
        (rest,) = substituted(g, [row], {pivot: ZERO})
        solved = g.negate(g.divide(rest, entry))
        found = dict(zip(found, substituted(g, found.values(), {pivot: solved}), strict=True))
        found[pivot] = solved
    return found


def cramer(g: Graph, equations: Equations, block: tuple[int, ...]) -> dict[int, Node]:
    """Returns the accelerations of one block of M a = f by Cramer's rule."""
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
