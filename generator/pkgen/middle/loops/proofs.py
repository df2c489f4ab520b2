"""Constants of the motion of a model whose families are loops: it is unrolled for the proofs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...equations import Claim, Facts
from ...front.check import check
from ...front.statements import File
from ...model import Model
from ...source import Diagnostic, ModelError
from ..analyze import analyze
from ..analyze.proofs import OPEN
from ..derive import derive
from ..quantities import families
from .loops import LoopEquations

Use = Callable[[Model], tuple[Model, object]]  # what a scene makes of a model, and more

PROVED_AT = 40  # coordinates up to which a family is unrolled for the proof of a claim
FEW = 5  # members with which claims about a larger one are tried


def with_proofs(
    equations: LoopEquations,
    file: File,
    use: Use | None,
    symmetric: bool,
) -> LoopEquations:
    """The equations with the outcome of each claim among their facts; with `symmetric`, also with
    what Noether's theorem gives.

    All is proved for the sizes that stand in the model, or for few members where those are too
    many, and says which: there is no proof for all sizes at once.
    """
    model = equations.model
    if not (model.conserved or symmetric):
        return equations
    small = _small(file, model, use)
    if small is None:
        says = f"the model is too large to unroll, and {FEW} members are too few for it"
        claims = tuple(Claim(item.name, OPEN, says) for item in model.conserved)
        return replace(equations, facts=replace(equations.facts, claims=claims))
    unrolled = derive.derive(small, frozenset({"mass", "force", "momenta", "conserve"}))
    structure = analyze.analyze(unrolled, symmetric, with_claims=True)
    at = f"with {sizes_text(small)}"
    claims = tuple(replace(x, says=f"{x.says}, {at}") for x in structure.claims)
    found = structure.symmetries
    if found is not None and found.searched:
        proved = (replace(x, when="" if x.name == "energy" else at) for x in found.invariants)
        found = replace(found, searched=f"{found.searched}, {at}", invariants=tuple(proved))
    facts = replace(equations.facts, claims=claims, symmetries=found)
    return replace(equations, facts=facts)


def _small(file: File, model: Model, use: Use | None) -> Model | None:
    count = sum(f.count for f in families(model, model.coordinates).values())
    if count <= PROVED_AT:
        return model
    try:
        small, _ = check.check(file, {size.name: min(size.value, FEW) for size in model.sizes})
    except ModelError:
        return None
    return use(small)[0] if use else small


def sizes_text(model: Model) -> str:
    return ", ".join(f"{size.name} = {size.value}" for size in model.sizes)


def partly_proved(model: Model, facts: Facts) -> tuple[Diagnostic, ...]:
    """A warning for each claim that is proved for other sizes than the model's."""
    at = sizes_text(model)
    return tuple(
        Diagnostic(
            f"that '{claim.name}' is constant is proved {claim.says}, but not with {at}",
            item.span,
            "that many coordinates are not unrolled for a proof",
            "warning",
        )
        for item, claim in zip(model.conserved, facts.claims, strict=True)
        if not claim.says.endswith(f"with {at}")
    )
