"""Which rows and totals each kernel of a model with loops needs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from ...middle.loops.loops import Group, LoopEquations, Row
from .loops import Block
from .loops_chain import Chain
from .loops_sets import Builder, PairSet, RowSet, TotalSet

TOTALS = ("energy", "lagrangian", "kinetic", "potential")
# Kernels that write a value for each coordinate: outputs, and what they are.
VECTORS = {
    "force": {"f": "force"},
    "canonical": {"momenta": "momenta", "pdot": "pdot"},
    "momenta": {"momenta": "momenta"},
    "gradient": {"dLdq": "gradient"},
}
PAIRED = {"gradient": "gradient", "canonical": "pdot", "force": "force"}  # to the last output


@dataclass
class Plan:
    """By kernel, or by the name of a total."""

    rows: dict[str, list[RowSet]] = field(default_factory=dict)
    band: list[RowSet] = field(default_factory=list)
    totals: dict[str, TotalSet] = field(default_factory=dict)
    pairs: dict[str, list[PairSet]] = field(default_factory=dict)
    singularities: list[TotalSet] = field(default_factory=list)
    chain: Chain | None = None

    @property
    def blocks(self) -> Iterator[Block]:
        sets = [*(s for found in self.rows.values() for s in found), *self.band]
        for found in (*sets, *self.totals.values()):
            yield from found.blocks
        yield from (pair.block for pairs in self.pairs.values() for pair in pairs)
        if self.chain:
            yield from self.chain.blocks


def emitted(e: LoopEquations, wanted: frozenset[str] | None) -> frozenset[str]:
    """The kernels that there are of those wanted (None: all), with those that these call."""
    named = {*VECTORS, *(k for k in TOTALS if getattr(e, k) is not None)}
    if e.carried:
        return frozenset(named if wanted is None else named & wanted | {"force"})
    named |= {"mass", "advance"}
    if wanted is None:
        return frozenset(named)
    alone = e.mass.is_diagonal and not e.force.pairs  # a row of the acceleration is made by itself
    solved = set() if alone else {"force"} if e.mass.is_diagonal else {"force", "mass"}
    return frozenset(named & wanted | solved)


def within(e: LoopEquations) -> dict[str, dict[str, str]]:
    """What these write where L is taken as it stands: of carried values dL/dq takes momenta."""
    return VECTORS | ({"gradient": {"momenta": "momenta", "dLdq": "gradient"}} if e.carried else {})


def planned(e: LoopEquations, make: Builder, kernels: frozenset[str]) -> Plan:
    plan = Plan()

    def total(key: str, of, **how: Any) -> None:
        plan.totals[key] = make.total(key, of, **how)

    vectors = {kernel: outputs for kernel, outputs in within(e).items() if kernel in kernels}
    for kernel, outputs in vectors.items():
        plan.rows[kernel] = [
            make.rows(
                f"{kernel}_{g.name}", g, [getattr(e, x).rows[g.name] for x in outputs.values()]
            )
            for g in e.rows
        ]
    # The acceleration of a coordinate that is no member takes its force by itself.
    for what in sorted({"force", *(x for outputs in vectors.values() for x in outputs.values())}):
        for g in e.scalars:
            total(f"{what}_{g.name}", getattr(e, what).totals[g.name])
    if e.carried:
        plan.chain = Chain(e, make.places, make)
    elif e.mass.is_diagonal:
        plan.rows["mass"] = [make.rows(f"mass_{g.name}", g, [_own(e, g)]) for g in e.families]
        if not e.force.pairs:
            plan.rows["acceleration"] = [
                make.rows(f"acceleration_{g.name}", g, [e.force.rows[g.name], _own(e, g)], True)
                for g in e.families
            ]
    else:
        plan.band = [
            make.rows(f"mass_{g.name}", g, [row for _, row in entries(e, g)], ghosts=False)
            for g in e.families
        ]
    for (a, b), of in e.mass.corner.items():
        total(f"mass_{a}_{b}", of)
    for what in TOTALS:
        if what in kernels:
            total(what, getattr(e, what))
    for k, of in enumerate(e.sums):
        total(f"sum_{k}", of)
    plan.singularities = [
        make.total(f"singularity_{k}", singularity.terms, as_derived=True)
        for k, singularity in enumerate(e.singularities)
    ]
    for kernel, what in PAIRED.items():
        if kernel in kernels:
            plan.pairs[kernel] = [make.pair(pair) for pair in getattr(e, what).pairs]
    return plan


def _own(e: LoopEquations, g: Group) -> Row:
    return e.mass.entries.get((g.name, g.name, 0), Row())


def entries(e: LoopEquations, g: Group) -> list[tuple[dict[str, Any], Row]]:
    """Entries of M in the rows of a family's cells: with cells, then with scalars."""
    found = [
        ({"other": other, "shift": shift}, row)
        for (own, other, shift), row in e.mass.entries.items()
        if own == g.name
    ]
    found += [
        ({"scalar": scalar}, row) for (scalar, own), row in e.mass.border.items() if own == g.name
    ]
    return found
