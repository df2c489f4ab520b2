"""Which coordinates have to do with which: through M, and through the equations of motion. States
are counted after the coordinates, each a block of M by itself.

Where the accelerations are not solved for, or have no normal form within the work allowed, what
occurs in them counts as having an influence, though it may cancel.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ...equations import Equations, Indices
from ...graph.differentiate import reachable, symbols_in
from ...graph.graph import BIT, ZERO, Graph, Kind, Node, Op
from ...graph.normal import Normal
from ...graph.residues import Residues

STATE = BIT[Kind.COORDINATE] | BIT[Kind.RATE] | BIT[Kind.STATE]
WORK = 4_000  # products of two terms, for all rows
SWEPT = 10_000  # values modulo a prime, of all nodes and for all coordinates


def mass_blocks(equations: Equations) -> Indices:
    """The finest partition of the coordinates such that M has no entry between two parts."""
    n = len(equations.coordinates)
    return partition(
        n + len(equations.states),
        ((i, j) for i in range(n) for j in range(i) if equations.mass[i][j] != ZERO),
    )


def mass_band(equations: Equations) -> int:
    """The largest distance from the diagonal of an entry that is not zero."""
    n = len(equations.coordinates)
    return max(
        (i - j for i in range(n) for j in range(i) if equations.mass[i][j] != ZERO), default=0
    )


def influences(equations: Equations, blocks: Indices) -> Indices:
    """For each coordinate those whose position or rate is in its solved equation of motion, and
    those that a constraint ties to it: their inertia has a part in it, seen there or not. Where
    rates jump each has to do with all: the impulse keeps the energy of them together.

    `blocks` are those of M: within one, each acceleration has all forces and entries of M in it.
    """
    found = _in_motion(equations, blocks)
    if equations.jolted:
        n = len(equations.coordinates)
        found = tuple((*range(n), *row) if i < n else row for i, row in enumerate(found))
    tied = ties(equations)
    return tuple(tuple(sorted({*row, *tied.get(i, ())})) for i, row in enumerate(found))


def ties(equations: Equations) -> dict[int, set[int]]:
    """By coordinate, those that stand with it in the row or the equation of a constraint."""
    c, found = equations.constraints, {}
    if c is None:
        return found
    g, mask = equations.graph, BIT[Kind.COORDINATE] | BIT[Kind.RATE]
    rows = [(*row, c.residual[k], *c.positions[k : k + 1]) for k, row in enumerate(c.rows)]
    more = c.redundant
    rows += zip(more.residual) if more else ()
    for nodes in rows:
        together = {symbol.index for symbol in symbols_in(g, nodes, mask)}
        for i in together:
            found.setdefault(i, set()).update(together)
    return found


def _in_motion(equations: Equations, blocks: Indices) -> Indices:
    g = equations.graph
    n = len(equations.coordinates)
    of_states = [[node] for node in equations.state_rates]
    if equations.acceleration is not None:
        rows = [[node] for node in equations.acceleration]
        normal = Normal(g, work=WORK)
        for i in _doubtful(g, equations.acceleration, n):
            rows[i] = _without_identities(g, normal, equations.acceleration[i])
        return tuple(_occurring(g, rows + of_states, n))
    found: list[tuple[int, ...]] = [()] * n + _occurring(g, of_states, n)
    for block in blocks:
        if block[0] >= n:
            continue
        nodes = [equations.force[i] for i in block]
        nodes += [equations.mass[i][j] for i in block for j in block if j <= i]
        (together,) = _occurring(g, [nodes], n)
        for i in block:
            found[i] = together
    return tuple(found)


def blocks_of(influence: Indices, blocks: Indices) -> Indices:
    """The finest partition such that no coordinate influences one of another part, nor shares an
    entry of M with it: `blocks` are those of M."""
    pairs = [(i, j) for i, row in enumerate(influence) for j in row]
    pairs += [(block[0], j) for block in blocks for j in block]
    return partition(len(influence), pairs)


def partition(n: int, pairs: Iterable[tuple[int, int]]) -> Indices:
    """What is connected by the pairs, each part and the parts in order."""
    of = list(range(n))

    def root(i: int) -> int:
        while of[i] != i:
            of[i] = of[of[i]]
            i = of[i]
        return i

    for i, j in pairs:
        a, b = sorted((root(i), root(j)))
        of[b] = a
    parts: dict[int, list[int]] = {}
    for i in range(n):
        parts.setdefault(root(i), []).append(i)
    return tuple(map(tuple, parts.values()))


def _doubtful(g: Graph, rows: tuple[Node, ...], n: int) -> Iterator[int]:
    """The rows with a coordinate in them that may drop out: modulo a prime nothing changes with it.
    Where there are too many nodes for that, none."""
    if n * len(reachable(g, rows, STATE)) > SWEPT:
        return
    here = Residues(g)
    here.learn(rows)
    there = [Residues(g, STATE, only=j) for j in range(n)]
    for i, found in enumerate(_occurring(g, [[row] for row in rows], n)):
        if any(here(rows[i]) == there[j](rows[i]) is not None for j in found if j < n):
            yield i


def _without_identities(g: Graph, normal: Normal, node: Node) -> list[Node]:
    """The atoms of the normal form; of a node that has none, itself."""
    polynomial = normal(node) if g.depends[node] & STATE else {}
    if polynomial is None:
        return [node]
    return [base for monomial in polynomial for base, _ in monomial]


def _occurring(g: Graph, rows: list[list[Node]], n: int) -> list[tuple[int, ...]]:
    """Which of n coordinates, or their rates, and which states occur in each row of nodes."""
    bits: dict[Node, int] = {}
    for node in reachable(g, [node for row in rows for node in row], STATE):
        if g.op[node] is Op.SYMBOL:
            first = n if g.data[node].kind is Kind.STATE else 0
            bits[node] = 1 << first + g.data[node].index
        else:
            bits[node] = 0
            for a in g.args[node]:
                bits[node] |= bits.get(a, 0)
    result = []
    for row in rows:
        mask = 0
        for node in row:
            mask |= bits.get(node, 0)
        result.append(tuple(i for i in range(mask.bit_length()) if mask >> i & 1))
    return result
