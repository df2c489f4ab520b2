"""Steps of splitting methods in few passes over memory."""

from __future__ import annotations

from ....graph.affine import ROW
from ....middle.families.equations import FamilyEquations
from ....middle.families.slots import M, Slots
from .kernels import Vector, added, chunk_of, halo_of, reach, rows_beyond
from .plan import Plan

LINE = 8  # Members per cache line.
MOST_LAG = 64  # Stages in flight stay in cache up to this.
MOST_CARRIED = 64  # as in members_steps.h


def has_steps(e: FamilyEquations, plan: Plan, slots: Slots) -> bool:
    """Returns whether each acceleration depends only on t, parameters and the coordinates of single
    members, so that kicks v += h a and drifts q += h v can be made at once."""
    vector = plan.vectors.get("acceleration")
    if vector is None or not e.facts.separable or e.scalars or e.model.inputs:
        return False
    below = slots.below(*(node for terms in vector.terms for node in terms.nodes))
    return all(int(s.name) in e.fixed for s in below if s.kind == "sum")


def lag_of(e: FamilyEquations, vector: Vector, slots: Slots, block: int) -> int:
    """Returns by how many members a stage of a step trails the one before it, so that both are made
    in one pass over memory: terms of rows from m on must read no rows before m. 0 if they do, or a
    single term is far from its row. Minus the number for rings, whose steps are made one by one."""
    low, halo = reach(vector)[0], halo_of(vector)
    shifts = [0]
    for terms in vector.terms:
        for s in slots.below(*terms.nodes):
            if s.kind not in ("q", "w") or s.at is None:
                continue
            at = s.at - M
            if not terms.over or s.at.factor(ROW) != 1 or not at.is_constant:
                return 0
            shifts.append(at.constant)
    carried = sum(len(terms.nodes) for terms in vector.of(2)) * halo
    if min(shifts) < low or carried > MOST_CARRIED or not _close(e):
        return 0
    same = all((g.lo, g.hi) == (e.families[0].lo, e.families[0].hi) for g in e.families)
    if not same and any(sum(rows_beyond(vector, g, e)) for g in e.families):
        return 0  # Rows beyond the end of a shorter family would read members that have drifted.
    lag = max(shifts) - low + 1 + halo + added(vector, e)
    lag = -(-lag // LINE) * LINE
    if any(g.periodic for g in e.families):
        lag = -lag if same and all(g.periodic for g in e.families) else 0
    return lag if abs(lag) <= min(MOST_LAG, chunk_of(vector, block) - 1) else 0


def _close(e: FamilyEquations) -> bool:
    """Returns whether all families begin within a constant distance of each other."""
    return all((g.lo - e.families[0].lo).is_constant for g in e.families)
