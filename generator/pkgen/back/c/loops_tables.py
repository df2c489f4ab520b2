"""Rows of the tables in generated C: names of quantities, kernels of struct pk_system."""

from __future__ import annotations

from collections.abc import Iterable

from ...equations import Quantity
from ...middle.loops.loops import Group, LoopEquations
from ...model import Definition


def system_kernels(e: LoopEquations, kernels: frozenset[str]) -> list[tuple[str, str, list[str]]]:
    """Of struct pk_system; M and the Jacobians, which it wants whole, are not among them."""
    found = [("acceleration", "int", ["a"])]
    vectors = {"force": ["f"], "canonical": ["momenta", "pdot"], "gradient": ["dLdq"]}
    found += [(k, "void", outputs) for k, outputs in vectors.items() if k in kernels]
    found += [(k, "pk_real", []) for k in ("energy", "kinetic", "potential") if k in kernels]
    found += [("singularity", "void", ["out"])] if e.singularities or e.pivots else []
    found += [("observe", "void", ["out"])] if e.observed else []
    found += [("conserve", "void", ["out"])] if e.conserved else []
    return found


def quantity(g: Group, mark: str, unit: str) -> dict[str, str]:
    name = mark + g.name if mark.startswith("p") else g.name + mark
    return {
        "name": name,
        "unit": getattr(g.declared, unit),
        "description": g.declared.description,
    }


def named(items: Iterable[Definition]) -> list[Quantity]:
    return [Quantity(item.name, item.unit, item.description) for item in items]


def row(q: Quantity) -> dict[str, str]:
    return {"name": q.name, "unit": q.unit, "description": q.description}
