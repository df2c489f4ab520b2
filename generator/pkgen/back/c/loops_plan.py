"""Which rows and totals each kernel of a model with loops needs."""

from __future__ import annotations

from typing import Any

from ...middle.loops.loops import Group, LoopEquations, Row
from .loops_sets import Builder

TOTALS = ("energy", "lagrangian", "kinetic", "potential")
# Kernels that write a value for each coordinate: outputs, and what they are.
VECTORS = {
    "force": (("f", "force"),),
    "canonical": (("momenta", "momenta"), ("pdot", "pdot")),
    "momenta": (("momenta", "momenta"),),
    "gradient": (("dLdq", "gradient"),),
}


def emitted(e: LoopEquations, wanted: frozenset[str] | None) -> frozenset[str]:
    """The kernels that there are of those wanted (None: all), with those that these call."""
    named = {*VECTORS, "mass", "advance", *(k for k in TOTALS if getattr(e, k) is not None)}
    if wanted is None:
        return frozenset(named)
    alone = e.mass.is_diagonal and not e.force.pairs  # a row of the acceleration is made by itself
    solved = set() if alone else {"force"} if e.mass.is_diagonal else {"force", "mass"}
    return frozenset(named & wanted | solved)


def planned(e: LoopEquations, plan: Builder, kernels: frozenset[str]) -> dict[str, Any]:
    """By kind (rows, totals, band) and kernel; the graph may still grow."""
    rows: dict[str, list[dict]] = {}
    totals: dict[str, dict] = {}
    vectors = {kernel: outputs for kernel, outputs in VECTORS.items() if kernel in kernels}
    for kernel, outputs in vectors.items():
        rows[kernel] = [
            plan.plan_rows(
                f"{kernel}_{g.name}", g, [getattr(e, what).rows[g.name] for _, what in outputs]
            )
            for g in e.families
        ]
    # The acceleration of a coordinate that is no member takes its force by itself.
    whats = {"force", *(what for outputs in vectors.values() for _, what in outputs)}
    for what in sorted(whats):
        for g in e.scalars:
            key = f"{what}_{g.name}"
            totals[key] = plan.plan_total(key, getattr(e, what).totals[g.name])
    band = []
    if e.mass.is_diagonal:
        rows["mass"] = [plan.plan_rows(f"mass_{g.name}", g, [_own(e, g)]) for g in e.families]
        if not e.force.pairs:
            rows["acceleration"] = [
                plan.plan_rows(
                    f"acceleration_{g.name}",
                    g,
                    [e.force.rows[g.name], _own(e, g)],
                    quotient=True,
                )
                for g in e.families
            ]
    else:
        for g in e.families:
            band.append(plan.plan_rows(f"mass_{g.name}", g, [row for _, row in entries(e, g)]))
    for (a, b), total in e.mass.corner.items():
        totals[f"mass_{a}_{b}"] = plan.plan_total(f"mass_{a}_{b}", total)
    for what in TOTALS:
        total = getattr(e, what)
        if what in kernels:
            totals[what] = plan.plan_total(what, total)
    for k, total in enumerate(e.sums):
        totals[f"sum_{k}"] = plan.plan_total(f"sum_{k}", total)
    singularities = [
        plan.plan_total(f"singularity_{k}", singularity.terms, as_derived=True)
        for k, singularity in enumerate(e.singularities)
    ]
    return {"rows": rows, "totals": totals, "band": band, "singularities": singularities}


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
