"""Energies of blocks of coordinates that do not influence each other.

If L is a sum of terms that each depend on one block, time may be shifted for one block alone. The
energy h of the block has dh/dt = sum v_i Q_i - dL/dt over the block, whatever the other blocks do.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

from ...equations import Equations, Indices, Invariant
from ...graph.differentiate import symbols_in
from ...graph.exact import Exact
from ...graph.graph import ONE, Graph, Kind, Node, Symbol
from ...graph.normal import Normal
from ..motion import STATE
from .along import Along
from .proofs import vanishes

BLOCK = "time shift of a block"
WORK = 20_000  # budget of a normal form: products of two terms
TERMS = 2_000
NAMED = 4  # largest number of coordinates in a name


def block_energies(
    e: Equations, along: Along, blocks: Indices, known: Collection[str]
) -> Iterator[Invariant]:
    """Yields the constant energies of blocks, except of a coordinate with a `known` momentum."""
    g = along.graph
    for block, lagrangian in _split(g, e.lagrangian, blocks):
        if any(i >= len(e.momenta) for i in block):  # a state: forces do no work along it
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
    """Yields the part of L of each block that has one, if there are several blocks."""
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
