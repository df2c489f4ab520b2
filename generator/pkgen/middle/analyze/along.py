"""Time derivatives of expressions along the solutions of the equations of motion.

For the accelerations, small blocks of M are solved by Cramer's rule: all accelerations of a block
then have the same denominator, which normal forms can cancel. Larger blocks are solved by L D L^T
as in the C code. If the expressions would be too large, the accelerations stay symbols;
`accelerations` of points/samples.py finds their values at a given state.
"""

from __future__ import annotations

from fractions import Fraction

from ...equations import Equations
from ...graph.differentiate import gradient, partials, reachable
from ...graph.graph import BIT, ONE, VARIABLE, ZERO, Graph, Kind, Node, Op, Symbol
from ...graph.normal import Normal
from ...graph.nullspace import Eliminated
from ...graph.residues import PRIME, Residues
from ...graph.solve import solve
from ...graph.substitute import substituted
from ..motion import rate_of
from ..points.squares import determinant
from ..quantities import symbols
from ..structure import Indices

# The largest numerator, and the denominators, of rational combinations that are tried.
LARGEST, DENOMINATORS = 1_000, range(1, 13)
CRAMER = 4  # the largest number of coordinates of a block that is solved by Cramer's rule


class Along:
    """Makes time derivatives of nodes in `graph`, a copy of the equations' graph."""

    def __init__(self, equations: Equations, blocks: Indices):
        self.graph = equations.graph.copy()
        self.equations = equations
        self.block = {i: block for block in blocks for i in block}
        self.known: dict[int, Node] = {}
        # The rates that constraints determine, mapped to expressions in the other rates.
        self.bound: dict[Node, Node] | None = None
        # The momenta and the energy, whose time derivatives are known without accelerations. Each
        # node is split into a numeric scale and the rest. Maps the rest to the scale and the index
        # of the momentum, which is None for the energy.
        self.leaves: dict[Node, tuple[Node, int | None]] = {}
        known = [*enumerate(equations.momenta), (None, equations.energy)]
        for i, node in known if equations.momenta else []:
            scale, rest = self.graph.split(node)
            self.leaves[rest] = scale, i

    def terms(self, node: Node) -> list[Node]:
        """Returns the time derivative of a node as a list of terms: one for each symbol, momentum
        or energy in the node, by the chain rule."""
        g = self.graph
        slopes = self._slopes(node)
        terms = self._of_large_blocks(slopes)
        terms += [g.multiply(x, self._rate_of(leaf)) for leaf, x in slopes.items() if x != ZERO]
        return [term for term in terms if term != ZERO]

    def on_constraints(self, terms: list[Node]) -> list[Node]:
        """Returns the terms for motions that satisfy the constraints J v + j0 = 0: some rates are
        replaced by expressions in the others. Not valid where divisors of these expressions
        vanish."""
        if self.equations.constraints is None:
            return terms
        if self.bound is None:
            self.bound = rates_bound(self.graph, self.equations)
        return [x for x in substituted(self.graph, terms, self.bound) if x != ZERO]

    def _of_large_blocks(self, slopes: dict[Node, Node]) -> list[Node]:
        """Returns the terms of a node's time derivative that are due to the rates of large blocks,
        if these terms can be written without accelerations (combination()). `slopes` has the
        derivatives of the node by its symbols; those by the rates of such blocks are removed."""
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
        """Returns the partial derivatives of a node by the symbols, momenta and energy in it."""
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
        """Returns the time derivative of the energy h, dh/dt = v.(Q - dD/dv) - dL/dt, with the
        rates v, the applied forces Q and the dissipation D. Constraints J v + j0 = 0 with the
        multipliers lambda add the power (J v).lambda = -j0.lambda."""
        g, e = self.graph, self.equations
        rates = symbols(g, Kind.RATE, len(e.applied))
        applied, c = e.applied, e.constraints
        moved = ZERO
        if c is not None:
            applied = c.free_applied
            offsets = substituted(g, c.residual, dict.fromkeys(rates, ZERO))
            moved = g.dot(offsets, c.multipliers)
        power = g.dot(rates, applied)
        slopes = self.explicit(e.lagrangian, e.quaternions)
        return g.subtract(g.subtract(power, moved), slopes)

    def explicit(self, node: Node, first: int = 0) -> Node:
        """Returns a node's time derivative at constant coordinates and rates. States whose index is
        below `first` are held constant too."""
        g = self.graph
        slopes = gradient(g, node, BIT[Kind.TIME] | BIT[Kind.INPUT] | BIT[Kind.STATE])
        return g.sum(
            g.multiply(slope, self._rate(g.data[s]))
            for s, slope in slopes.items()
            if g.data[s].kind != Kind.STATE or g.data[s].index >= first
        )

    def _rate(self, symbol: Symbol) -> Node:
        if symbol.kind is Kind.RATE:
            return self._acceleration(symbol.index)
        found = rate_of(self.graph, self.equations, symbol)
        if found is None:  # an input without a symbol for its derivative: a symbol of no input
            beyond = symbol.index + len(self.equations.inputs)
            return self.graph.symbol(Symbol(Kind.INPUT, beyond))
        return found

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
        return symbols(g, Kind.ACCELERATION, len(e.force))


def rates_bound(g: Graph, equations: Equations) -> dict[Node, Node]:
    """Solves each constraint row J v + j0 = 0 for one of the rates v, and returns the solutions,
    keyed by rate. Divides by a constant entry of J if possible. Another divisor may vanish at some
    states; what is proved at all other states then holds at these states by continuity."""
    c = equations.constraints
    rates = symbols(g, Kind.RATE, len(equations.momenta))
    found: dict[Node, Node] = {}
    offsets = substituted(g, c.residual, dict.fromkeys(rates, ZERO))
    for J, offset in zip(c.rows, offsets, strict=True):
        (row,) = substituted(g, [g.add(g.dot(J, rates), offset)], found)
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
    """Returns the accelerations of the coordinates in one block of M, by Cramer's rule."""
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


def combination(g: Graph, rows: list[list[Node]], wanted: list[Node]) -> list[Fraction] | None:
    """Returns rational numbers x with M x = w, where M is `rows` and w is `wanted`. Finds x modulo
    a prime, and proves the equation by normal forms. Returns None if no x is found, or if the proof
    fails.

    From M a = f follows w.a = x.f, which avoids solving for the accelerations a. For example, the
    total momentum has a time derivative of the form w.a + ..., with such a w.
    """
    found = _solved(Residues(g), rows, wanted)
    numbers = [_number(x) for x in found or ()]
    if found is None or None in numbers:
        return None
    normal = Normal(g)
    for row, entry in zip(rows, wanted, strict=True):
        made = g.sum(g.multiply(g.number(x), m) for x, m in zip(numbers, row, strict=True))
        if normal(g.subtract(entry, made)) != {}:
            return None
    return numbers


def _solved(residue: Residues, rows: list[list[Node]], wanted: list[Node]) -> list[int] | None:
    n, done = len(rows), Eliminated({}, [])
    for k, (row, right) in enumerate(zip(rows, wanted, strict=True)):
        values = [residue(entry) for entry in (*row, right)]
        if None in values:
            return None
        done.add({column: x for column, x in enumerate(values) if x}, k)
    if done.rows.keys() != set(range(n)):
        return None
    return [done.rows[k].get(n, 0) for k in range(n)]


def _number(residue: int) -> Fraction | None:
    for denominator in DENOMINATORS:
        top = residue * denominator % PRIME
        top = top - PRIME if top > PRIME // 2 else top
        if abs(top) <= LARGEST:
            return Fraction(top, denominator)
    return None
