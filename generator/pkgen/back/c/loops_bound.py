"""The order of unknowns in the band matrix K = [M J^T; J 0], and its template variables.

M is the mass matrix, J the matrix of the constraint rows. For each index the band has first the
members of all families with this index, then one row of every family of constraints. A constraint
row belongs to the largest index of a coordinate in it. The factorization K = L D L^T then needs no
pivoting: each leading block of K is regular if the constraint rows are independent. A dense border
follows the band: rows that reach around the end of a ring (a periodic family), then scalar
coordinates and single rows.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...graph.affine import Affine
from ...middle.loops.indexed_ir import Bound, Group
from ...middle.loops.indices import size_values
from ...middle.loops.loops import LoopEquations
from .loops import Places
from .loops_plan import BOUND, Plan, apart, singles

SAYS = {
    "constraint": "phi, which the rows of positions keep at 0",
    "constraint_rates": "J v + j0, which all rows keep at 0",
    "coasting": "The rate of J v + j0 where nothing accelerates but what is given",
    "position_size": "The sizes of the terms of phi, which it is rounded by in units of eps",
    "rate_size": "The sizes of the terms of J v + j0",
}


def _free(g: Group, e: LoopEquations, side: int) -> int:
    """Returns 1 if the end of the family is free (the ghost cell beyond it copies the last member),
    else 0."""
    at = g.lo - 1 if side < 0 else g.hi + 1
    return int(any(end.kind == "free" and index == at for index, end in g.ends))


def _reach(e: LoopEquations, rows: Bound) -> Iterator[tuple[Group, int]]:
    for name, shift in rows.entries:
        if shift is not None:
            yield e.group(name), shift


def _ahead(e: LoopEquations, rows: Bound) -> int:
    """Returns the distance from the index of a constraint row to the largest index of a coordinate
    in the row."""
    return max(shift + _free(g, e, -1) for g, shift in _reach(e, rows))


def shape_of(e: LoopEquations, places: Places, made: tuple[Bound, ...]) -> dict[str, Any]:
    """Returns the shape of K: its half bandwidth, the number of unknowns per index, the first and
    last index of each family, and the size of the border."""
    names = [g.name for g in e.banded]
    banded = [*made, *(rows for rows in e.bound if not rows.is_single)]
    slots = len(names) + len(banded)
    of = {name: (e.group(name), k) for k, name in enumerate(names)}
    found = [apart(of[a], of[b], shift, slots) for a, b, shift in e.mass.entries]
    for k, rows in enumerate(banded, len(names)):
        ahead = _ahead(e, rows)
        found += [
            (ahead - shift + _free(g, e, 1)) * slots + k - names.index(g.name)
            for g, shift in _reach(e, rows)
        ]
    index = places.index
    first = [index(g.lo) for g in e.banded]
    first += [index(rows.group.lo + _ahead(e, rows)) for rows in banded]
    return {
        "width": max(found, default=0),
        "slots": slots,
        "least": first,
        "greatest": [index(g.hi) for g in e.banded],
        "ring": [index(g.hi) for g in e.families if g.periodic],
        "whole": len(e.scalars) + sum(rows.is_single for rows in e.bound) + spares_of(e),
    }


def spares_of(e: LoopEquations) -> int:
    """Returns the number of scalar coordinates in constraint rows of the band. If the columns of
    these coordinates are left out, at most this many more rows become dependent on the others."""
    felt = {name for rows in e.bound for name, shift in rows.entries if shift is None}
    if e.extended and any(not rows.is_single for rows in e.bound):
        of = (z for item in e.carried for piece in item.pieces for z in piece.by)
        felt |= {z.name for z in of if z.at is None}
    return len(felt)


def bound_context(e: LoopEquations, plan: Plan, places: Places) -> dict[str, Any]:
    """Returns the template variables of constraint rows, and of the rows of recurrences."""
    index, rows = places.index, [_row(e, rows, places) for rows in e.bound]
    made = [_row(e, rows, places) for rows in plan.made]
    banded = [*made, *(x for x in rows if not x["single"])]
    for k, x in enumerate(banded, len(e.banded)):
        x["slot"] = k
        x["made"] = k < len(e.banded) + len(made)
    for k, x in enumerate((x for x in rows if x["single"]), len(e.scalars)):
        x["slot"] = k
    sizes = size_values(e.model)
    total = sum((x.group.count for x in e.bound), Affine())
    holonomic = sum((x.group.count for x in e.bound if x.holonomic), Affine())
    known = {
        "bound": rows,
        "made": made,
        "spares": spares_of(e),
        "banded_rows": banded,
        "all_jacobian": [*plan.jacobian.values(), *plan.border.values()],
        "jacobian_sets": plan.jacobian,
    }
    if not e.bound:
        return known | {"single_rows": (), "border_sets": {}, "bound_kernels": ()}
    return known | {
        "single_rows": [x for x in rows if x["single"]],
        "border_sets": {
            places.ids[name]: {"set": s, "rows": [x.group.name for x in singles(e, e.group(name))]}
            for name, s in plan.border.items()
        },
        "bound_sets": plan.bound,
        "bound_kernels": list(BOUND),
        "bound_says": SAYS,
        "n_constraints": total.value(sizes),
        "n_holonomic": holonomic.value(sizes),
        "bound_count": index(total),
        "holonomic_count": index(holonomic),
    }


def _row(e: LoopEquations, rows: Bound, places: Places) -> dict[str, Any]:
    group, index = rows.group, places.index
    found: dict[str, Any] = places.group(group) | {
        "declared": rows.name,
        "single": rows.is_single,
        "holonomic": rows.holonomic,
        "corner": [{"scalar": name, "id": places.ids[name]} for name in rows.corner],
    }
    if rows.is_single:
        return found
    wraps = [(g, shift) for g, shift in _reach(e, rows) if g.periodic]
    least: dict[str, int] = {}
    for g, shift in wraps:
        least[g.name] = min(shift, least.get(g.name, shift))
    ends = [e.group(name).lo - shift for name, shift in least.items()]
    return found | {
        "ahead": _ahead(e, rows),
        # A row with an index below one of these crosses the end of a ring.
        "wraps": [index(end) for end in ends],
        "entries": [
            {"scalar": name} if shift is None else {"other": places.ids[name], "shift": shift}
            for name, shift in rows.entries
        ],
    }
