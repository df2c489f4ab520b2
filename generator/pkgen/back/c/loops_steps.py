"""Fused steps of families kept as loops: whether there are any, and in which blocks."""

from __future__ import annotations

from typing import Any

from ...graph.affine import ROW
from ...middle.loops.loops import LoopEquations
from ...middle.loops.slots import Slots
from .loops import BLOCK, CHUNK, Places
from .loops_plan import Plan

LINE = 8  # members, so that rows begin where a line of memory does
STAGES = 32  # in flight: with a block within 32 KiB


def stepper(e: LoopEquations, plan: Plan, places: Places, slots: Slots) -> dict[str, Any] | None:
    """Fused steps exist where the acceleration of a row needs q of cells near it and t."""
    rows, index = plan.rows["acceleration"], places.index
    if not e.facts.separable or e.scalars or e.model.inputs:
        return None
    nodes = [node for s in rows for block in s.blocks for node in block.nodes]
    below = slots.below(*nodes)
    if any(s.kind == "sum" and int(s.name) not in e.fixed for s in below):
        return None
    cells = [s.at for s in below if s.kind == "q" and s.at is not None]
    if not all(at.factor(ROW) for at in cells):
        return None  # one member is felt by all
    reach = max((abs(at.constant) for at in cells), default=0)
    if reach > CHUNK or not all((g.lo - e.families[0].lo).is_constant for g in e.families):
        return None
    # Behind a drift rows still need cells that have not drifted: theirs, or beyond a free end.
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
        # Rows that find what is behind them in bonds alone drift as they are kicked.
        "merged": len(rows) == 1
        and bool(rows[0].flux)
        and not rows[0].trig
        and all(at is not None and at.constant >= 0 for at in own),
        "lows": list(dict.fromkeys(x for s in rows for x in s.lows)),
        "highs": list(dict.fromkeys(x for s in rows for x in s.highs)),
        "least": [index(g.lo) for g in e.families],
        "greatest": [index(g.hi) for g in e.families],
    }
