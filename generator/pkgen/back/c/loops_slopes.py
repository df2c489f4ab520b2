"""Template variables of the Jacobians of M a and f: the order of the unknowns, and the kernels that
write the Jacobians."""

from __future__ import annotations

from typing import Any

from ...middle.loops.loops import LoopEquations
from .loops import Places
from .loops_plan import Plan


def slopes_context(e: LoopEquations, plan: Plan, places: Places) -> dict[str, Any]:
    slopes = plan.slopes_of
    if slopes is None:
        none = dict.fromkeys(("closed", "answered", "pulled"), False)
        return none | {"slopes": (), "pull": (), "hung": ()}
    index = places.index
    unknowns = [
        places.group(g) | {"homed": kind in ("v", "a"), "coordinate": kind == "v"}
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
        "hung": _hung(e, plan, places) if e.carried else (),
    }


def _hung(e: LoopEquations, plan: Plan, places: Places) -> list[dict[str, Any]]:
    """Returns the template variables of the matrix rows of recurrences: C text of the index of each
    row and of its columns."""
    families = [unknown for unknown, _ in plan.slopes_of.families]
    carried = {g.name for g in e.carried_groups}

    def place(kind: str, name: str, shift: int | None) -> str:
        if shift is None:
            scalar = plan.slopes_of.scalars.index((kind, name))
            return f"{e.model.name}_slopes_places(p) + {scalar}"
        return f"{e.model.name}_slopes_row_{families.index((kind, name))}(p, m + {shift})"

    found = []
    for item, rows in zip(e.carried, plan.made, strict=True):
        columns = [place("rate" if n in carried else "v", n, shift) for n, shift in rows.entries]
        own = {"row": place("hung_p", item.group.name, 0), "columns": columns}
        found.append(places.group(item.group) | own | {"set": plan.jacobian[rows.group.name]})
    return found
