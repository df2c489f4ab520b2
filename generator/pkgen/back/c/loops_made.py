"""Rows that say what carried values are made of: X'' - sum Phi_z z'' = 0.

Where M a = f of a chain is not eliminated place by place, accelerations of carried values X are
unknowns of the band as those of coordinates are, each with such a row C, beside constraints J:

    K = [M + C^T W C  C^T  J^T; C 0 0; J 0 0]

X'' is what the coordinates' accelerations make of it; how X moves besides is in the forces. C^T W C
changes nothing where C x = 0, and makes each leading block of K regular, though coordinates have
inertia by X alone: M is positive where C x = 0, so with it everywhere (P. Finsler, 1937). W is
about the inertia that is there.
"""

from __future__ import annotations

from dataclasses import replace

from ...graph.graph import ONE, Node
from ...middle.loops.loops import LoopEquations
from ...middle.loops.parts import Bound, Carried, Group, Part, Row, Slot
from ...middle.loops.slots import Slots
from .loops import M, Places


def made_of(e: LoopEquations, places: Places, slots: Slots) -> tuple[Bound, ...]:
    """C by carried value, itself first; by level, as they are computed."""
    return tuple(_row(e, item, places, slots) for item in e.carried) if e.extended else ()


def _row(e: LoopEquations, item: Carried, places: Places, slots: Slots) -> Bound:
    own = item.group
    declared = replace(own.declared, name=places.made[own.name])
    carried = [g.name for g in e.carried_groups]

    def part(lo, hi, node: Node) -> Part:
        return Part(lo, hi, node, slots.inside(node, carried))

    entries: dict[tuple[str, int | None], Row] = {
        (own.name, 0): Row(tuple(part(p.lo, p.hi, ONE) for p in item.pieces))
    }
    for slot in dict.fromkeys(z for piece in item.pieces for z in piece.by):
        slopes = [(p, p.by[slot]) for p in item.pieces if slot in p.by]
        parts = tuple(part(p.lo, p.hi, slots.graph.negate(node)) for p, node in slopes)
        entries[slot.name, _shift(slot)] = Row(parts)
    nothing = Row()
    group = Group(declared, own.lo, own.hi)
    return Bound("", group, nothing, nothing, nothing, (nothing, nothing), entries)


def _shift(slot: Slot) -> int | None:
    return None if slot.at is None else (slot.at - M).constant
