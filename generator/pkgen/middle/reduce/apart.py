"""Blocks of coordinates that do not influence one another, each to be integrated by itself: by a
method and steps of its own, and without the work of the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...equations import Equations, Indices, Structure
from ...graph.differentiate import symbols_in
from ...graph.graph import ZERO, Kind
from ...record import record
from ..analyze.analyze import analyze
from ..analyze.coupling import partition
from ..derive.lagrange import derived_again
from ..motion import STATE
from ..quantities import symbols
from ..smaller import smaller


@record
class Subsystem:
    """A block as a system of its own; `coordinates` are their indices in the whole."""

    equations: Equations
    structure: Structure
    coordinates: tuple[int, ...]


def parts_of(
    equations: Equations, structure: Structure, kernels: frozenset[str] | None
) -> tuple[Subsystem, ...]:
    """The parts of a system, or none where it is one block, or something belongs to several."""
    if equations.events or equations.states or equations.constraints:
        return ()
    blocks = _with_whole_bodies(equations, structure.blocks)
    if len(blocks) < 2:
        return ()
    owners = [_owner(blocks, equations, node) for node in equations.quadratures]
    if None in owners:
        return ()
    return tuple(
        _part(equations, kernels, k, block, [i for i, owner in enumerate(owners) if owner == k])
        for k, block in enumerate(blocks)
    )


def _with_whole_bodies(equations: Equations, blocks: Indices) -> Indices:
    """The rates of a body together, though those of a ball do not influence one another."""
    together = (*blocks, *(tuple(a.rates) for a in equations.attitudes))
    return partition(len(equations.coordinates), ((row[0], i) for row in together for i in row))


def _owner(blocks: Sequence[tuple[int, ...]], equations: Equations, node: int) -> int | None:
    """The block that a quadrature depends on; the first, if on none; None, if on several."""
    used = {s.index for s in symbols_in(equations.graph, [node], STATE)}
    found = [k for k, block in enumerate(blocks) if used & set(block)]
    return (found or [0])[0] if len(found) < 2 else None


def _part(
    e: Equations,
    kernels: frozenset[str] | None,
    number: int,
    block: tuple[int, ...],
    quadratures: list[int],
) -> Subsystem:
    """The block as its own system: in L all other coordinates rest at their starts."""
    g, n = e.graph, len(e.coordinates)
    q, v = symbols(g, Kind.COORDINATE, n), symbols(g, Kind.RATE, n)
    others = [i for i in range(n) if i not in block]
    swap = {q[i]: e.start_q[i] for i in others} | {v[i]: ZERO for i in others}
    alone = replace(
        e,
        model=replace(e.model, name=f"{e.model.name}_{number + 1}"),
        observed_names=(),
        observed=(),
        conserved_names=(),
        conserved=(),
        quadrature_names=tuple(e.quadrature_names[i] for i in quadratures),
        quadratures=tuple(e.quadratures[i] for i in quadratures),
        quadrature_start=tuple(e.quadrature_start[i] for i in quadratures),
    )
    alone = smaller(alone, block, swap, e.lagrangian, (e.kinetic, e.potential))
    alone = derived_again(alone, kernels)
    return Subsystem(alone, analyze(alone), tuple(block))
