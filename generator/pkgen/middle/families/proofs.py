"""Proves claims about constants of the motion of models with families: for every length
(constants.py), or by a trial with all members written out.
"""

from __future__ import annotations

from dataclasses import replace

from ...graph.graph import ONE, Graph, Node
from ...model import Definition, Model
from ...tree import Name
from ..analyze import analyze
from ..analyze.proofs import OPEN, PROVED
from ..derive import derive
from ..quantities import families
from ..structure import Claim, Invariant, Structure, Symmetries
from .constants import TimeDerivative, Unknown
from .equations import FamilyEquations

# The largest number of coordinates of a model that is unrolled to apply Noether's theorem.
PROVED_AT = 40
# The largest number of coordinates of a model that is unrolled at its own sizes to prove a claim.
TRIED_AT = 500
LARGE = f"shifts of time only: more than {PROVED_AT} coordinates"


def with_proofs(
    equations: FamilyEquations,
    symmetric: bool,
) -> FamilyEquations:
    """Returns the equations with the outcome of each claim in their facts; with `symmetric`, also
    with constants of the motion by Noether's theorem. A result names the sizes for which
    it is valid."""
    model, facts = equations.model, equations.facts
    if not (model.conserved or symmetric):
        return equations
    count = sum(f.count for f in families(model, (*model.coordinates, *model.states)).values())
    if count <= PROVED_AT:
        structure = _analyzed(model, symmetric)
        found, at = structure.symmetries, f"with {sizes_text(model)}"
        if found is not None and found.searched:
            proved = (replace(x, when="" if x.name == "energy" else at) for x in found.invariants)
            found = replace(found, searched=f"{found.searched}, {at}", invariants=tuple(proved))
        claims = tuple(replace(x, says=f"{x.says}, {at}") for x in structure.claims)
        return replace(equations, facts=replace(facts, claims=claims, symmetries=found))
    if symmetric:
        energy = Invariant("energy", "time shift", "d/dt", ((ONE, ("energy",)),), ONE)
        found = Symmetries(Graph(), (), LARGE, (energy,) if facts.conservative else ())
        facts = replace(facts, symmetries=found)
    if model.conserved:
        facts = replace(facts, claims=_claims(equations, count))
    return replace(equations, facts=facts)


def _claims(e: FamilyEquations, count: int) -> tuple[Claim, ...]:
    """Returns the outcomes of the claims of a model with more than PROVED_AT coordinates: proved
    for every length, else by a trial with the members written out."""
    found = [
        _of_every_length(e, item, node)
        for item, node in zip(e.model.conserved, e.conserved, strict=True)
    ]
    if all(claim.outcome == PROVED for claim in found) or count > TRIED_AT:
        return tuple(found)
    at = f"with {sizes_text(e.model)}"
    tried = (replace(x, says=f"{x.says}, {at}") for x in _analyzed(e.model).claims)
    return tuple(
        one if one.outcome == PROVED else other for one, other in zip(found, tried, strict=True)
    )


def _of_every_length(e: FamilyEquations, item: Definition, node: Node) -> Claim:
    if e.facts.conservative and isinstance(item.value, Name) and item.value.id == "energy":
        return Claim(item.name, PROVED, "neither time nor a force beyond L enters the equations")
    try:
        if TimeDerivative(e).vanishes(node):
            return Claim(
                item.name,
                PROVED,
                "by its normal form, with every length at which no range is empty",
            )
        why = "its rate does not vanish term by term"
    except Unknown as unknown:
        why = str(unknown)
    return Claim(
        item.name, OPEN, f"{why}; more than {TRIED_AT} coordinates are not written out to try it"
    )


def _analyzed(model: Model, symmetric: bool = False) -> Structure:
    unrolled = derive.derive(model, frozenset({"mass", "force", "momenta", "conserve"}))
    return analyze.analyze(unrolled, symmetric, with_claims=True)


def sizes_text(model: Model) -> str:
    return ", ".join(f"{size.name} = {size.value}" for size in model.sizes)
