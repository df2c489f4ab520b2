"""Finds blocks of coordinates with a constant energy of their own.

Let L be a sum of Lagrangians of blocks that do not influence each other. The energy h of one block
then has the time derivative dh/dt = sum v_i Q_i - dL_b/dt, where L_b is the Lagrangian of this
block, and the sum is over its rates v_i and applied forces Q_i.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

from ...equations import Equations
from ...graph.differentiate import symbols_in
from ...graph.exact import Exact
from ...graph.graph import ONE, Graph, Kind, Node, Symbol
from ...graph.normal import Normal
from ..motion import STATE
from ..structure import Indices, Invariant
from .along import Along
from .proofs import vanishes

BLOCK = "time shift of a block"
# The largest number of products of two terms that are computed for one normal form.
WORK = 20_000
TERMS = 2_000
# The largest number of coordinates in the name of an energy; further ones become "...".
NAMED = 4


def block_energies(
    e: Equations, along: Along, blocks: Indices, known: Collection[str]
) -> Iterator[Invariant]:
    """Yields the constant energies of blocks. `known` has the names of the constants of the motion
    found before: a block of one coordinate is left out if its momentum is one of these."""
    g = along.graph
    for block, lagrangian in _split(g, e.lagrangian, blocks):
        if any(i >= len(e.momenta) for i in block):  # the block contains a first-order variable
            continue
        if len(block) == 1 and e.momenta_names[block[0]].name in known:
            continue
        v = {i: g.symbol(Symbol(Kind.RATE, i)) for i in block}
        power = g.sum(g.multiply(v[i], e.applied[i]) for i in block)
        if vanishes(g, Exact(g), [power, g.negate(along.explicit(lagrangian))]):
            names = [e.coordinates[i].name for i in block]
            shown = names if len(names) <= NAMED else [names[0], "...", names[-1]]
            name = f"energy({', '.join(shown)})"
            virial = g.sum(g.multiply(v[i], e.momenta[i]) for i in block)
            node = g.subtract(virial, lagrangian)
            yield Invariant(name, BLOCK, "d/dt", ((ONE, (name,)),), node)


def _split(g: Graph, lagrangian: Node, blocks: Indices) -> Iterator[tuple[tuple[int, ...], Node]]:
    """Yields each block with its part of L. Leaves out blocks that share a term of L with another
    block. Yields nothing if there is only one block."""
    normal = Normal(g, work=WORK, terms=TERMS)
    polynomial = normal(lagrangian) if len(blocks) > 1 else None
    if polynomial is None:
        return
    of = {i: block for block in blocks for i in block}
    parts: dict[tuple[int, ...], list[Node]] = {block: [] for block in blocks}
    mixed = set()
    for monomial, coefficient in polynomial.items():
        bases = [base for base, _ in monomial]
        found = {of[s.index] for s in symbols_in(g, bases, STATE)}
        for block in found:
            parts[block].append(normal.term(monomial, coefficient))
        mixed |= found if len(found) > 1 else set()
    for block, terms in parts.items():
        if block not in mixed:
            yield block, g.total(terms)
