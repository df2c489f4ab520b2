"""Matrices of derivatives as templates see them: which unknowns there are, and their kernels."""

from __future__ import annotations

from typing import Any

from ...middle.loops.loops import LoopEquations
from .loops import Places
from .loops_plan import Plan


def slopes_context(e: LoopEquations, plan: Plan, places: Places) -> dict[str, Any]:
    slopes = plan.slopes_of
    if slopes is None:
        return {"slopes": (), "closed": False, "answered": False, "pulled": False, "pull": ()}
    index = places.index
    unknowns = [
        places.group(g) | {"homed": kind != "lambda", "coordinate": kind == "v"}
        for (kind, _), g in slopes.families
    ]
    rings = [index(g.hi) for _, g in slopes.families if g.periodic]
    return {
        "slopes": plan.slopes,
        "closed": slopes.closed is not None,
        "answered": slopes.answered,
        "pulled": slopes.closed is not None and bool(plan.pull or e.solved),
        "reach": plan.reach,
        "unknowns": unknowns,
        "more_scalars": len(slopes.scalars),
        "rings": list(dict.fromkeys(rings)),
        "pull": plan.pull,
    }
