"""Steps of splitting methods in few passes over memory."""

from __future__ import annotations

from ...middle.loops.loops import LoopEquations
from ...middle.loops.slots import Slots
from .loops_plan import Plan


def has_steps(e: LoopEquations, plan: Plan, slots: Slots) -> bool:
    """Returns whether each acceleration depends only on t, parameters and the coordinates of single
    members, so that kicks v += h a and drifts q += h v can be made at once."""
    vector = plan.vectors.get("acceleration")
    if vector is None or not e.facts.separable or e.scalars or e.model.inputs:
        return False
    below = slots.below(*(node for terms in vector.terms for node in terms.nodes))
    return all(int(s.name) in e.fixed for s in below if s.kind == "sum")
