"""Splits a system into blocks of coordinates that do not influence each other. Each block is then
integrated as a separate system, with its own method and step sizes."""

from __future__ import annotations

from dataclasses import replace

from ...equations import Equations
from ..analyze.analyze import analyze
from ..analyze.coupling import partition
from ..derive.lagrange import derived_again
from ..drop_coordinates import without
from ..structure import Indices, Structure
from .reduction import Subsystem


def parts_of(
    equations: Equations, structure: Structure, kernels: frozenset[str] | None
) -> tuple[Subsystem, ...]:
    """Returns the separate parts of a system; () if it has only one part, or has events,
    constraints or sample blocks."""
    if equations.events or equations.constraints or equations.sampled:
        return ()
    blocks = _joined(equations, structure.blocks)
    if len(blocks) < 2:
        return ()
    return tuple(_part(equations, kernels, k, block) for k, block in enumerate(blocks))


def _joined(equations: Equations, blocks: Indices) -> Indices:
    """Returns the blocks after merging some of them. The three rates of a rotation get into one
    block, even if they do not influence each other, as for a body with three equal moments of
    inertia. Blocks that consist of states only are merged with the block of coordinate 0."""
    n = len(equations.coordinates)
    free = tuple(i for block in blocks if block[0] >= n for i in block)
    together = (*blocks, *(tuple(a.rates) for a in equations.attitudes), (0, *free))
    count = n + len(equations.states)
    return partition(count, ((row[0], i) for row in together for i in row))


def _part(
    e: Equations,
    kernels: frozenset[str] | None,
    number: int,
    block: tuple[int, ...],
) -> Subsystem:
    """Returns a block as a separate system. In its L, all other coordinates and states have their
    initial values, and all other rates are 0."""
    alone = replace(
        e,
        model=replace(e.model, name=f"{e.model.name}_{number + 1}"),
        observed_names=(),
        observed=(),
        conserved_names=(),
        conserved=(),
    )
    others = {*range(len(e.coordinates) + len(e.states))} - {*block}
    alone = derived_again(without(alone, others), kernels)
    return Subsystem(alone, analyze(alone), tuple(block))
