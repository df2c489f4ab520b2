"""The order of unknowns in the band matrix K = [M J^T; J 0] and in matrices of derivatives, as
tables for members_band.h, and the template variables of constraint rows.

A constraint row belongs to the largest index of a coordinate in it. In a ring (a periodic family)
the rows that reach around its end lie behind all others.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ....graph.affine import Affine
from ....graph.graph import ZERO
from ....middle.families.equations import FamilyEquations
from ....middle.families.indexed_ir import Addend, Group, Sum
from ....middle.families.indices import size_values
from ....middle.families.jacobians import Slopes
from ....middle.families.slots import M
from .numbers import Numbers
from .places import Places
from .plan import BOUND, Plan, half_width
from .text import table

SAYS = {
    "constraint": "phi, which the rows of positions keep at 0",
    "constraint_rates": "J v + j0, which all rows keep at 0",
    "coasting": "The rate of J v + j0 where nothing accelerates but what is given",
    "position_size": "The sizes of the terms of phi, which it is rounded by in units of eps",
    "rate_size": "The sizes of the terms of J v + j0",
}


@dataclass
class Layout:
    """The order of unknowns. `unknowns` maps names of cells to numbers. The band's
    numbers come before the border's."""

    name: str
    unknowns: dict[Any, int] = field(default_factory=dict)
    groups: dict[Any, Group] = field(default_factory=dict)  # of unknowns in the band
    rows: list[str] = field(default_factory=list)  # of struct pk_unknown
    slots: int = 0
    width: int = 0
    spares: int = 0
    carried: bool = False

    def enter(
        self, key: Any, kind: str, family: int, homed: bool, ahead: int = 0, wraps=(0, 0)
    ) -> None:
        self.unknowns[key] = len(self.rows)
        numbers = ", ".join(map(str, (family, int(homed), ahead, *wraps)))
        self.rows.append(f"{{PK_{kind}, {numbers}}}")

    def text(self, model: str) -> str:
        stem, border = f"{model}_{self.name}", len(self.rows) - self.slots
        rows = table("struct pk_unknown", f"{stem}_unknowns", self.rows)
        numbers = ", ".join(
            map(str, (self.slots, border, self.width, self.spares, int(self.carried)))
        )
        unknowns = f"{stem}_unknowns" if self.rows else "NULL"
        members = f"{model}_families, {unknowns}, {numbers}"
        return f"{rows}static const struct pk_layout {stem}_layout = {{\n    {members}}};\n\n"


def layout_of_k(e: FamilyEquations, plan: Plan, numbers: Numbers) -> Layout:
    """Returns the order of unknowns in K: at each index the members of families, then one row of
    each recurrence and of each family of constraints."""
    found, families = Layout("K"), numbers.families
    for g in e.banded:
        found.groups[g.name] = g
        found.enter(g.name, "COORDINATE", families[g.name, ""], True)
    made: list[tuple[Any, Group, Sum]] = []
    for item, kernel in zip(e.carried, plan.made, strict=True) if e.extended else ():
        entries = tuple(Addend(goal.terms.over, ZERO, goal.to) for goal in kernel.goals)
        made.append((("made", item.group.name), item.group, entries))
    made += [(x.group.name, x.group, x.jacobian) for x in e.bound if not x.is_single]
    for key, group, entries in made:
        is_made = isinstance(key, tuple)
        ahead, wraps = _ahead(e, entries), _wraps(e, entries)
        at = (numbers.range(*wraps), len(wraps)) if wraps else (0, 0)
        found.groups[key] = group
        own = families[(key[1], "") if is_made else (key, "lambda")]
        found.enter(key, "NONE" if is_made else "ROW", own, False, ahead, at)
    found.slots = len(found.rows)
    for g in e.scalars:
        found.enter(g.name, "COORDINATE", families[g.name, ""], True)
    for x in e.bound:
        if x.is_single:
            found.enter(x.group.name, "ROW", families[x.group.name, "lambda"], False)
    found.spares = spares_of(e)
    for k in range(found.spares):
        found.enter(("spare", k), "NONE", 0, False)
    found.carried = e.extended
    found.width = max(
        half_width([e.mass], found.unknowns, found.groups, found.slots),
        *(_behind(e, found, key, entries) for key, _, entries in made),
        0,
    )
    return found


def _behind(e: FamilyEquations, layout: Layout, key: Any, entries: Sum) -> int:
    """Returns the largest distance of a row from the coordinates in it."""
    ahead, own = _ahead(e, entries), layout.unknowns[key]
    return max(
        (ahead - shift + _free(g, 1)) * layout.slots + own - layout.unknowns[g.name]
        for g, shift in _reach(e, entries)
    )


def _reach(e: FamilyEquations, entries: Sum) -> list[tuple[Group, int]]:
    """Returns the families in constraint rows, with the distances of members from the row's
    index."""
    columns = [x.to[1] for x in entries if x.to[1][1] is not None]
    return [(e.group(name), (at - M).constant) for name, at in columns]


def _ahead(e: FamilyEquations, entries: Sum) -> int:
    """Returns the distance from the index of a constraint row to the largest index of a coordinate
    in the row."""
    return max(shift + _free(g, -1) for g, shift in _reach(e, entries))


def _wraps(e: FamilyEquations, entries: Sum) -> list[Affine]:
    """Returns the indices below which a row reaches around the end of a ring, for each ring."""
    least: dict[str, int] = {}
    for g, shift in _reach(e, entries):
        if g.periodic:
            least[g.name] = min(shift, least.get(g.name, shift))
    return [e.group(name).lo - shift for name, shift in least.items()]


def _free(g: Group, side: int) -> int:
    """Returns 1 if the end of the family is free (beyond it stands the last member), else 0."""
    at = g.lo - 1 if side < 0 else g.hi + 1
    return int(any(end.kind == "free" and index == at for index, end in g.ends))


def layout_of_slopes(e: FamilyEquations, slopes: Slopes, numbers: Numbers) -> Layout:
    found, families = Layout("slopes"), numbers.families
    carried = {g.name for g in e.carried_groups}
    for unknown, g in slopes.families:
        kind, name = unknown
        found.groups[unknown] = g
        of = "COORDINATE" if kind == "v" else "OTHER"
        homed = kind in ("v", "a") and name not in carried
        found.enter(unknown, of, families[name, "lambda" if kind == "lambda" else ""], homed)
    found.slots = len(found.rows)
    scalars = {g.name for g in e.scalars}
    for kind, name in slopes.scalars:
        of = "COORDINATE" if kind == "v" else "OTHER"
        family = families[name, ""] if name in scalars else 0
        found.enter((kind, name), of, family, False)
    found.width = half_width(slopes.all, found.unknowns, found.groups, found.slots)
    return found


def spares_of(e: FamilyEquations) -> int:
    """Returns the number of scalar coordinates in constraint rows of the band. If the columns of
    these coordinates are left out, at most this many more rows become dependent on the others."""
    banded = [x for x in e.bound if not x.is_single]
    felt = {x.to[1][0] for rows in banded for x in rows.jacobian if x.to[1][1] is None}
    if e.extended and banded:
        of = (z for item in e.carried for piece in item.pieces for z in piece.by)
        felt |= {z.name for z in of if z.at is None}
    return len(felt)


def bound_context(e: FamilyEquations, places: Places) -> dict[str, Any]:
    """Returns the template variables of constraint rows."""
    index, sizes = places.index, size_values(e.model)
    rows = [places.group(x.group) | {"declared": x.name, "holonomic": x.holonomic} for x in e.bound]
    if not e.bound:
        return {"bound": (), "bound_kernels": ()}
    total = sum((x.group.count for x in e.bound), Affine())
    holonomic = sum((x.group.count for x in e.bound if x.holonomic), Affine())
    return {
        "bound": rows,
        "bound_kernels": list(BOUND),
        "bound_says": SAYS,
        "n_constraints": total.value(sizes),
        "n_holonomic": holonomic.value(sizes),
        "bound_count": index(total),
        "holonomic_count": index(holonomic),
    }
