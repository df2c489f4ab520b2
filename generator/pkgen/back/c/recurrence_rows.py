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

from ...middle.loops.indexed_ir import Bound, Carried, Group, Row
from ...middle.loops.jacobians_recurrences import made
from ...middle.loops.loops import LoopEquations
from ...middle.loops.slots import Slots
from .loops import Places


def made_of(e: LoopEquations, places: Places, slots: Slots) -> tuple[Bound, ...]:
    """C by carried value; by level, as they are computed."""
    return tuple(_row(e, item, places, slots) for item in e.carried)


def _row(e: LoopEquations, item: Carried, places: Places, slots: Slots) -> Bound:
    own, nothing = item.group, Row()
    group = Group(replace(own.declared, name=places.made[own.name]), own.lo, own.hi)
    sizes = nothing, nothing
    return Bound("", group, nothing, nothing, nothing, sizes, made(e, slots, item))
