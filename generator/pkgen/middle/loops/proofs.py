"""Constants of the motion of a model whose families are loops: it is unrolled for the proofs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...equations import Claim, Structure, Symmetries
from ...front.check import check
from ...front.statements import File
from ...model import Model
from ...source import ModelError, Span
from ...tree import Name
from ..analyze import analyze
from ..analyze.proofs import OPEN, PROVED
from ..derive import derive
from ..quantities import families
from .loops import LoopEquations
from .uniform import FEWEST, members_are_alike

Use = Callable[[Model], tuple[Model, object]]  # what a scene makes of a model, and more

UNROLLED = 400  # coordinates up to which claims are proved with all members written out
SEARCHED = 40  # and up to which symmetries are looked for
TRIED = 23  # members with which a proof for any number is tried once more
ENERGY = Name("energy", None, Span(0, 0))
OF = frozenset({"mass", "force", "momenta", "conserve"})


def with_proofs(
    equations: LoopEquations,
    file: File,
    use: Use | None,
    symmetric: bool,
) -> LoopEquations:
    """The equations with the outcome of each claim among their facts; with `symmetric`, also with
    what Noether's theorem gives.

    Claims are proved for the number of members that the model has; or, where these are too many to
    be written out, for any number (middle/loops/uniform.py). Of energy the facts decide.
    """
    model = equations.model
    facts = equations.facts
    if model.conserved:
        facts = replace(facts, claims=_claims(equations, file, use))
    if symmetric:
        facts = replace(facts, symmetries=_symmetries(equations, file, use))
    return replace(equations, facts=facts)


def _claims(equations: LoopEquations, file: File, use: Use | None) -> tuple[Claim, ...]:
    model = equations.model
    count = _count(model)
    if count <= UNROLLED:
        return _structure(model).claims
    tried: list[tuple[Claim, ...]] = []
    if not equations.carried and members_are_alike(model):
        small = [_with_members(file, model, use, few) for few in (FEWEST, FEWEST + 1, TRIED)]
        tried = [_structure(x).claims for x in small if x is not None]
    found = []
    for k, item in enumerate(model.conserved):
        if equations.facts.conservative and item.value == replace(ENERGY, span=item.value.span):
            says = "no time and no force beyond L enters the equations"
            found.append(Claim(item.name, PROVED, says))
        elif len(tried) == 3:
            found.append(_for_any(*(claims[k] for claims in tried)))
        else:
            says = (
                f"{count} coordinates are too many to be written out, and fewer say nothing where "
                "members differ by their index, or read what is not next to them"
            )
            found.append(Claim(item.name, OPEN, says))
    return tuple(found)


def _for_any(*claims: Claim) -> Claim:
    """One that is proved for any number of members, or the first that is not."""
    wrong = next((claim for claim in claims if claim.outcome != PROVED), None)
    if wrong is not None:
        return wrong
    return replace(claims[0], says=f"{claims[0].says}, for {FEWEST} and more members")


def _symmetries(equations: LoopEquations, file: File, use: Use | None) -> Symmetries | None:
    model, conservative = equations.model, equations.facts.conservative
    at = ""
    if _count(model) > SEARCHED:
        if equations.carried or not members_are_alike(model):
            return None
        model = _with_members(file, model, use, FEWEST)
        if model is None:
            return None
        at = f"with {sizes_text(model)}"
    found = _structure(model, symmetric=True).symmetries
    if found is None or not found.searched:
        return found
    kept = [x for x in found.invariants if x.name != "energy" or conservative]
    told = [replace(x, when="" if x.name == "energy" else at) for x in kept]
    searched = f"{found.searched}, {at}" if at else found.searched
    return replace(found, searched=searched, invariants=tuple(told))


def _structure(model: Model, symmetric: bool = False) -> Structure:
    return analyze.analyze(derive.derive(model, OF), symmetric, with_claims=not symmetric)


def _count(model: Model) -> int:
    return sum(f.count for f in families(model, model.coordinates).values())


def _with_members(file: File, model: Model, use: Use | None, few: int) -> Model | None:
    """The model with so few members; None where its text does not allow that."""
    try:
        small, _ = check.check(file, {size.name: few for size in model.sizes})
    except ModelError:
        return None
    return use(small)[0] if use else small


def sizes_text(model: Model) -> str:
    return ", ".join(f"{size.name} = {size.value}" for size in model.sizes)
