"""`conserve` in a model whose families are loops: it is unrolled for the proof."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from .equations import Claim, Structure
from .front import check
from .front.statements import File
from .middle import analyze, derive
from .middle.loops import Facts
from .middle.proofs import OPEN
from .middle.quantities import families
from .model import Model
from .source import Diagnostic, ModelError

PROVED_AT = 40  # coordinates up to which a family is unrolled for the proof of a claim
FEW = 5  # members with which claims about a larger one are tried


def loop_claims(
    file: File, model: Model, use: Callable[[Model], tuple[Model, object]] | None
) -> tuple[Claim, ...]:
    """Of families kept as loops: proved for the sizes that stand in the model, or for few members,
    and the outcome says which; there is no proof for all sizes at once."""
    count = sum(f.count for f in families(model, model.coordinates).values())
    if count > PROVED_AT:
        sizes = {size.name: min(size.value, FEW) for size in model.sizes}
        try:
            model, _ = check.check(file, sizes)
            model = use(model)[0] if use else model
        except ModelError:
            says = f"{count:,} coordinates are too many, and {FEW} members too few for the model"
            return tuple(Claim(item.name, OPEN, says) for item in model.conserved)
    at = ", ".join(f"{size.name} = {size.value}" for size in model.sizes)
    equations = derive.derive(model, frozenset({"mass", "force", "conserve"}))
    found = analyze.claims(equations)
    return tuple(replace(claim, says=f"{claim.says}, with {at}") for claim in found)


def partly_proved(model: Model, facts: Structure | Facts) -> tuple[Diagnostic, ...]:
    """A warning for each claim that is proved for other sizes than the model's."""
    if isinstance(facts, Structure) or not facts.claims:
        return ()
    at = ", ".join(f"{size.name} = {size.value}" for size in model.sizes)
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
