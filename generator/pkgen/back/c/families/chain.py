"""The C blocks of recurrence values, and their template variables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

from ....middle.families.equations import FamilyEquations
from ....middle.families.indexed_ir import Group
from ..program import operations_text
from .blocks import Block
from .carried import Carrying
from .elimination import Elimination, of_scalars
from .kernels import Builder
from .places import M, Places

# For each kernel, the pass along the chain (see MODES) that it needs.
NEEDS = {"force": "force", "momenta": "force", "gradient": "motion", "canonical": "motion"}


class Chain:
    """The recurrence values of one model; may add nodes to the graph."""

    def __init__(self, e: FamilyEquations, places: Places, make: Builder, hung: bool):
        self.carrying = Carrying(e, places, make)
        self.elimination = None if e.extended else Elimination(self.carrying)
        self.last = of_scalars(self.elimination) if self.elimination else None
        self.hung = {low: self.carrying.hung(low) for low in (False, True)} if hung else {}

    @property
    def operations(self) -> Iterator[str]:
        """Yields the counts of operations per member, as text."""
        rows = [level.terms.block for level in self.carrying.levels["force"]]
        chain, solved = self.elimination, []
        if chain:
            solved = [chain.steps[False], chain.backs[False]]
            solved += [block for rows in chain.mass for block in rows.vector.blocks]
        for name, blocks in (("carried values", rows), ("elimination", solved)):
            if not blocks:
                continue
            total = sum((block.operations for block in blocks), Counter())
            yield f"{name}: {operations_text(total)} a member"

    # -- for the templates --------------------------------------------------------------------

    @property
    def blocks(self) -> Iterator[Block]:
        of = self.carrying
        for levels in of.levels.values():
            for level in levels:
                yield level.terms.block
        for found in (of.gathered, of.moved, self.hung):
            yield from found.values()
        if self.elimination:
            for found in (self.elimination.steps, self.elimination.backs):
                yield from found.values()
            for rows in self.elimination.mass:
                yield from rows.vector.blocks
            yield self.last


def chain_context(chain: Chain | None) -> dict[str, Any] | None:
    """Returns the template variables of a chain."""
    if chain is None:
        return None
    of = chain.carrying
    e, index = of.e, of.places.index
    return {
        "rows": [of.places.group(g) for g in of.groups.values()],
        "groups": [_group(of, g) for g in e.carried_groups],
        "coordinates": [k for k, g in enumerate(of.groups.values()) if not g.is_carried],
        "reach": of.reach,
        "low": of.most(of.low) if of.low else "",
        "lowest": of.least([g.lo for g in of.groups.values()]),
        "highest": of.most([g.hi for g in of.groups.values()]),
        "mutual": of.mutual,
        "clears": list(of.clears),
        "whole": index(of.places.whole),
        "count": index(of.places.whole - e.count),
        "slopes": len(of.slopes),
        "changes": len(of.changes),
        "levels": of.levels,
        "along": {
            mode: (
                of.least([x.terms.over[0] for x in levels]),
                of.most([x.terms.over[1] for x in levels]),
            )
            for mode, levels in of.levels.items()
        },
        "needs": NEEDS,
        "gathered": {low: x.statements for low, x in of.gathered.items()},
        "moved": {low: x.statements for low, x in of.moved.items()},
        "hung": {low: x.statements for low, x in chain.hung.items()},
        "solved": _solved(chain) if chain.elimination else None,
    }


def _group(of: Carrying, g: Group) -> dict[str, Any]:
    """Returns the template variables of a recurrence value: group, number, array indices."""
    found = of.places.group(g) | {"number": of.number[g.name]}
    for kind in ("hung_p", "hung_f"):
        found[kind] = of.places.index(of.places.carried(kind, g.name, M)[1])
    return found


def _solved(chain: Chain) -> dict[str, Any]:
    """Returns the template variables of the elimination of M a = f."""
    of, last = chain.carrying, chain.elimination
    return {
        "kept": len(last.kept),
        "front": len(last.front),
        "bulk": len(last.bulk),
        "steps": {low: x.statements for low, x in last.steps.items()},
        "backs": {low: x.statements for low, x in last.backs.items()},
        "last": chain.last.statements,
        "mass": last.mass,
        "pivots": max(len(last.coordinates), len(of.scalar)),
        "corner": [f"mass_{a}_{b}" for a, b in last.corner],
        "inertia": sum(rows.vector.outputs for rows in last.mass),
    }
