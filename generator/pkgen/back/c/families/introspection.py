"""The C tables of a model with loops: names, parameters, outputs, rotations."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import zip_longest
from typing import Any

from ....equations import Quantity
from ....graph.affine import ROW, Affine
from ....indices import indexed
from ....middle.families.equations import FamilyEquations
from ....middle.families.indexed_ir import Bound, Group
from ....middle.families.indices import size_values
from .places import Places
from .plan import Plan


def names(e: FamilyEquations) -> dict[str, Any]:
    """Returns for each table the names, units and descriptions that a run can use."""
    return {
        "coordinates": [_quantity(g, "{}", "unit", "integral of {}") for g in e.coordinates],
        "rates": [_quantity(g, "{}'", "rate_unit", own="rate") for g in e.coordinates],
        "momentum_names": [
            _quantity(g, "p_{}", "momentum_unit", own="momentum") for g in e.coordinates
        ],
        "inputs": e.inputs,
        "observed": e.observed_names,
        "conserved": e.conserved_names,
        "constraints": [_multiplier(rows) for rows in e.bound],
    }


def outputs_of_members(e: FamilyEquations, places: Places, plan: Plan) -> dict[str, Any]:
    """Returns by kernel the values with one per index, and the total length of all outputs."""
    index, count = places.index, places.observed[-1]
    rows = {
        kernel: [
            {"name": terms.name, "first": index(place), "lo": index(lo), "hi": index(hi)}
            | {"count": index(hi - lo + 1)}
            for terms, place in found
            for lo, hi in [terms.over]
        ]
        for kernel, found in plan.written.items()
    }
    of_members = [k for k, x in enumerate(e.outputs) if x.lo is not None]
    found = {
        "written": rows,
        "observed_rows": [*zip(of_members, rows.get("observe", ()), strict=True)],
        "observed_count": index(count),
    }
    sizes = size_values(e.model)
    return found | ({"n_observed": count.value(sizes)} if of_members else {})


def singularities(e: FamilyEquations) -> Iterator[dict[str, str]]:
    """Yields a row of the table for each singularity; pivots of M come first."""
    for g in e.coordinates if e.pivots else ():
        name = f"the pivot of {indexed(g.shown, 'i' if g.is_family else None)}"
        yield _singularity(name, "COORDINATES", (g.lo, g.hi) if g.is_family else ())
    for x in e.singularities:
        yield _singularity(x.name, x.use, x.over)


def _singularity(text: str, use: str, over: tuple[Affine, ...]) -> dict[str, str]:
    found = {"name": text, "kind": f"PK_SINGULARITY_{use}"}
    for key, at in zip_longest(("lo", "hi", "first", "last"), over):
        found[f"{key}_text"] = "" if at is None else at.text({ROW: "i"})
    return found


def parameter(e: FamilyEquations, places: Places, k: int) -> dict[str, Any]:
    """Returns the row of parameter k in the C table."""
    group, bounds = e.parameters[k], e.bounds[k]
    item = group.declared
    return places.group(group) | {
        "unit": item.unit,
        "description": item.description,
        "field": places.fields[item.name],
        "c_name": places.fields[item.name],
        "position": 0,
        "follows": int(item.follows),
        "lo_open": int(item.bounds.lo_open or bounds.lo is None),
        "hi_open": int(item.bounds.hi_open or bounds.hi is None),
    }


def rotations(e: FamilyEquations, places: Places) -> Iterator[dict[str, str]]:
    """Yields for each declared rotation the number of members, and the array indices of the first
    member's body rate and quaternion."""
    for rotation in e.model.rotations:
        turn, number = (e.group(x[0]) for x in (rotation.turns, rotation.quaternion))
        first = (places.index(places.first[g.name]) for g in (turn, number))
        keys = ("count", "rate", "number")
        yield dict(zip(keys, (places.index(turn.count), *first), strict=True))


def _multiplier(rows: Bound) -> Quantity:
    declared = rows.group.declared
    return Quantity(f"lambda_{rows.name}", declared.unit, declared.description)


def _quantity(g: Group, form: str, unit: str, of_state: str = "{}", own: str = "") -> Quantity:
    """Returns the quantity of a family. Its name is `form` filled with the family's name;
    `of_state` replaces `form` for a state, and a body rate has the name in the field `own` of its
    declaration. `unit` is the field of the declaration with the unit."""
    form, unit = (of_state, "unit") if g.is_state else (form, unit)
    name = getattr(g.declared, own) if own and g.is_turn else form.format(g.name)
    return Quantity(name, getattr(g.declared, unit), g.declared.description)
