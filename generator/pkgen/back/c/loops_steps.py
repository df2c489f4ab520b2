"""Fused steps of splitting methods, for families of coordinates that are loops.

A fused step computes accelerations, kicks (v += h a) and drifts (q += h v) in one loop.
"""

from __future__ import annotations

from typing import Any

from ...graph.affine import ROW
from ...middle.loops.loops import LoopEquations
from ...middle.loops.slots import Slots
from .loops import BLOCK, CHUNK, Places
from .loops_plan import Plan

LINE = 8  # Members per cache line; chunks of rows start at boundaries of cache lines.
# Stages of the method in one pass over memory. The data of the stages and a block of members fit in
# 32 KiB of cache.
STAGES = 32


def stepper(e: LoopEquations, plan: Plan, places: Places, slots: Slots) -> dict[str, Any] | None:
    """Returns the template variables of fused steps, or None if the model cannot have them. Each
    acceleration must depend only on t and on the coordinates q of nearby members."""
    rows, index = plan.rows["acceleration"], places.index
    if not e.facts.separable or e.scalars or e.model.inputs:
        return None
    nodes = [node for s in rows for block in s.blocks for node in block.nodes]
    below = slots.below(*nodes)
    if any(s.kind == "sum" and int(s.name) not in e.fixed for s in below):
        return None
    cells = [s.at for s in below if s.kind == "q" and s.at is not None]
    if not all(at.factor(ROW) for at in cells):
        return None  # All rows depend on one fixed member, however far away.
    reach = max((abs(at.constant) for at in cells), default=0)
    if reach > CHUNK or not all((g.lo - e.families[0].lo).is_constant for g in e.families):
        return None
    # A member drifts only after the kicks of all members that need its old position, also through a
    # ghost cell.
    reach = max([1, reach, *(s.span for s in rows)]) + max(max(s.below, s.above) for s in rows)
    trail = -(-reach // LINE) * LINE
    block = max(1, BLOCK // CHUNK // len(e.families)) * CHUNK
    own = [s.at for s in slots.below(*rows[0].inner.nodes) if s.kind == "q"]
    together = not any(g.periodic for g in e.families)
    return {
        "stages": STAGES if together else 1,
        "block": block,
        "line": LINE,
        "trail": trail,
        "together": together,
        # If rows depend on lower members only through bond forces, a member drifts right after its
        # kick.
        "merged": len(rows) == 1
        and bool(rows[0].flux)
        and not rows[0].trig
        and all(at is not None and at.constant >= 0 for at in own),
        "lows": list(dict.fromkeys(x for s in rows for x in s.lows)),
        "highs": list(dict.fromkeys(x for s in rows for x in s.highs)),
        "least": [index(g.lo) for g in e.families],
        "greatest": [index(g.hi) for g in e.families],
    }
