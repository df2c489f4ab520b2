"""Finds which coordinates are coupled by entries of the mass matrix M, and which by the equations
of motion.

States are numbered after the coordinates; each state is a block of M by itself. Some of the
couplings found may not exist, since the terms with a coordinate in an acceleration may cancel. This
is not detected where the accelerations are not solved for, or are too large for normal forms.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ...equations import Equations
from ...graph.differentiate import reachable, symbols_in
from ...graph.graph import BIT, ZERO, Graph, Kind, Node, Op
from ...graph.normal import Normal
from ...graph.residues import Residues
from ..structure import Indices

STATE = BIT[Kind.COORDINATE] | BIT[Kind.RATE] | BIT[Kind.STATE]
# Limit of work: products of two terms that the expansion of all expressions may compute.
WORK = 4_000
# The largest number of values modulo a prime that are computed: nodes times coordinates.
SWEPT = 10_000


def mass_blocks(equations: Equations) -> Indices:
    """Returns the blocks of M: the finest partition of the coordinates such that all entries of M
    between different blocks are zero."""
    count = len(equations.coordinates) + len(equations.states)
    return partition(count, _off_diagonal(equations))


def mass_band(equations: Equations) -> int:
    """Returns the bandwidth of M: the largest distance of a nonzero entry from the diagonal."""
    return max((i - j for i, j in _off_diagonal(equations)), default=0)


def _off_diagonal(e: Equations) -> list[tuple[int, int]]:
    rows = enumerate(e.mass[: len(e.coordinates)])
    return [(i, j) for i, row in rows for j in range(i) if row[j] != ZERO]


def influences(equations: Equations, blocks: Indices) -> Indices:
    """Returns for each coordinate the coordinates that influence it: their positions or rates occur
    in its acceleration, or a constraint contains both. If the system has impulses, all coordinates
    influence each other, since an impulse conserves only the total energy.

    `blocks` are the blocks of the mass matrix M. The acceleration of a coordinate depends on all
    forces and all entries of M in the block of the coordinate.
    """
    found = _in_motion(equations, blocks)
    if equations.impulsive:
        n = len(equations.coordinates)
        found = tuple((*range(n), *row) if i < n else row for i, row in enumerate(found))
    tied = ties(equations)
    return tuple(tuple(sorted({*row, *tied.get(i, ())})) for i, row in enumerate(found))


def ties(equations: Equations) -> dict[int, set[int]]:
    """Returns for each coordinate the coordinates that occur with it in a constraint."""
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
            rows[i] = atoms(normal, equations.acceleration[i])
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
    """Returns the finest partition of the coordinates such that coordinates of different parts do
    not influence each other and are in different blocks of M (`blocks`)."""
    pairs = [(i, j) for i, row in enumerate(influence) for j in row]
    pairs += [(block[0], j) for block in blocks for j in block]
    return partition(len(influence), pairs)


def partition(n: int, pairs: Iterable[tuple[int, int]]) -> Indices:
    """Returns the connected components of the graph with vertices 0..n-1 and edges `pairs`, in
    ascending order."""
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
    """Yields the numbers of the expressions `rows` in which the terms with some coordinate may
    cancel: the value of the expression modulo a prime does not change with the coordinate. Yields
    nothing if the computation takes too much work."""
    if n * len(reachable(g, rows, STATE)) > SWEPT:
        return
    here = Residues(g)
    here.learn(rows)
    there = [Residues(g, STATE, only=j) for j in range(n)]
    for i, found in enumerate(_occurring(g, [[row] for row in rows], n)):
        if any(here(rows[i]) == there[j](rows[i]) is not None for j in found if j < n):
            yield i


def atoms(normal: Normal, node: Node) -> list[Node]:
    """Returns the atoms (variables) of a node's normal form. If the node has no normal form,
    returns the node itself."""
    polynomial = normal(node)
    if polynomial is None:
        return [node]
    return sorted({base for monomial in polynomial for base, _ in monomial})


def _occurring(g: Graph, rows: list[list[Node]], n: int) -> list[tuple[int, ...]]:
    """Returns for each row (a list of nodes) the numbers of the coordinates and states that occur
    in it. A coordinate also counts if only its rate occurs. State k has the number n + k."""
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
