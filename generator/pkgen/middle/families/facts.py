"""Proves facts about the equations of a model with loops, such as a constant mass matrix (see enum
pk_fact). A fact that is False is not proved."""

from __future__ import annotations

from ...graph.calls import jumps, smooth
from ...graph.collect import settled
from ...graph.differentiate import reachable
from ...graph.graph import BIT, ZERO, Kind, Node, Op
from ..analyze.affine import CONSTANT, VARYING, in_rates, is_affine
from ..structure import Structure
from .equations import FamilyEquations
from .expand import FamilyExpander
from .indexed_ir import CELLS, Slot, nodes_of
from .recurrences import nodes_of as nodes_of_recurrences
from .rows import Assembler
from .singularities import moves


def facts_of(x: FamilyExpander, assembler: Assembler, e: FamilyEquations) -> Structure:
    entries, forces = nodes_of(e.mass), nodes_of(e.force)
    states = {g.name for g in e.states}
    own = [a.node for a in e.force if a.to[0][0] not in states]
    energies = nodes_of(e.lagrangian)
    entries += [node for item in e.carried for piece in item.pieces for node in piece.by.values()]
    of_states = any(
        slot.kind in ("s", "a") and slot.name not in x.rotations.numbers
        for slot in x.totals.below(*energies, *own)
    )
    constant = not _kinds(x, entries) & {*CELLS, "t", "input", "w"}
    rows = [node for bound in e.bound for node in bound.nodes]
    steady = not (_kinds(x, energies + forces) & {"t", "input"}) and not assembler.moving
    autonomous = steady and not _kinds(x, rows) & {"t", "input"}
    whole = x.totals.nodes(*energies, *forces, *rows, *nodes_of_recurrences(e.carried))
    below = reachable(x.graph, whole)
    is_smooth = smooth(x.graph, [n for n in below if x.graph.op[n] is Op.CALL and moves(x, n)])
    free = constant and not e.bound
    of_v = _in_rates(x, forces) if free and not (e.states or e.carried) else 0
    coasting = [piece.coasting for item in e.carried for piece in item.pieces]
    coasting += [node for bound in e.bound for node in nodes_of(bound.coasting)]
    slopes = [node for bound in e.bound for node in nodes_of(bound.jacobian)]
    straight = not _kinds(x, slopes) & {*CELLS, "w", "t"}
    jumping = any(
        jumps(x.graph, n) and moves(x, n) for n in reachable(x.graph, x.totals.nodes(*energies))
    )
    return Structure(
        mass_constant=constant,
        mass_diagonal=e.mass_diagonal and not e.carried,
        quadratic="v" not in _kinds(x, entries),
        separable=constant and straight and not _kinds(x, [*forces, *coasting]) & {"v", "s", "a"},
        autonomous=autonomous,
        conservative=bool(x.model.coordinates)
        and not x.model.struck
        and not (assembler.applied or jumping or of_states)
        and steady
        and (autonomous and _workless(x, e) if e.bound else True),
        variational=not (assembler.applied or e.states or e.bound or x.model.struck),
        smooth=is_smooth,
        affine=free and steady and not e.carried and _affine(x, forces),
        linear_drag=of_v == CONSTANT,
        affine_rates=of_v in (CONSTANT, VARYING),
    )


def _workless(x: FamilyExpander, e: FamilyEquations) -> bool:
    """Returns whether j0 = 0 in all constraint rows J v + j0: each row vanishes at v = 0."""

    def rest(slot: Slot) -> Node | None:
        return ZERO if slot.kind == "v" else None

    left = [x.slots.swapped(node, rest) for bound in e.bound for node in nodes_of(bound.rate)]
    return all(node == ZERO for node in settled(x.graph, left))


def _affine(x: FamilyExpander, nodes: list[Node]) -> bool:
    """Returns whether each node, as written, is affine in coordinates, rates and states."""
    g = x.graph
    if _kinds(x, nodes) & {"a"} or x.totals.moving(*nodes):
        return False
    slots = ((node, x.slots.of(node)) for node in reachable(g, nodes) if g.op[node] is Op.SYMBOL)
    symbols = {
        node: slot.kind in (*CELLS, "d")
        for node, slot in slots
        if slot is not None and slot.kind not in ("param", "size", "index", "sum")
    }
    return is_affine(g, nodes, symbols)


def _in_rates(x: FamilyExpander, nodes: list[Node]) -> int:
    slots = {node: x.slots.of(node) for node in reachable(x.graph, nodes)}
    kinds = {node: slot.kind for node, slot in slots.items() if slot is not None}
    if "a" in kinds.values() or x.totals.moving(*nodes):  # may contain rates
        return 0
    same = ("param", "size", "index", "sum")
    return in_rates(x.graph, nodes, frozenset(n for n, kind in kinds.items() if kind in same))


def _kinds(x: FamilyExpander, nodes: list[Node]) -> set[str]:
    found = {slot.kind for slot in x.totals.below(*nodes)} - {"sum"}
    if any(x.graph.depends[node] & BIT[Kind.TIME] for node in x.totals.nodes(*nodes)):
        found.add("t")
    return found
