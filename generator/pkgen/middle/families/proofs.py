"""Proves claims about constants of the motion for models with loops, by unrolling the model.

Up to TRIED_AT coordinates, a model is unrolled at its own sizes. For a longer family, the claim
that a quantity A is constant is proved with two short families. All members must have the same
expressions in L and the forces, and these expressions must couple members at most K indices apart.
The derivative of dA/dt by one member then depends only on neighbours of this member, and on an end
of the family only if the end is at most 4 K indices away. All such neighbourhoods occur in a family
of n = 8 K + 1 members. If dA/dt vanishes with n members, dA/dt therefore does not depend on the
state with any number of members. The value of dA/dt is then affine in the number of members, so
that dA/dt = 0 for all numbers if it also vanishes with n + 1 members.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...front.check import check
from ...front.statements import File
from ...graph.differentiate import gradient
from ...graph.graph import BIT, ONE, VARIABLE, Graph, Kind
from ...model import Definition, Model
from ...source import ModelError
from ...tree import Name
from ..analyze import analyze
from ..analyze.proofs import OPEN, PROVED, REFUTED
from ..derive import derive
from ..quantities import families
from ..structure import Claim, Invariant, Structure, Symmetries
from .equations import FamilyEquations
from .indexed_ir import nodes_of
from .slots import Slots

# A function that applies a scene to a model, and returns the changed model and further results.
Use = Callable[[Model], tuple[Model, object]]

# The largest number of coordinates of a model that is unrolled to apply Noether's theorem.
PROVED_AT = 40
# The largest number of coordinates of a model that is unrolled at its own sizes to prove a claim.
TRIED_AT = 200
LARGE = f"shifts of time only: more than {PROVED_AT} coordinates"


def with_proofs(
    equations: FamilyEquations,
    file: File,
    use: Use | None,
    symmetric: bool,
) -> FamilyEquations:
    """Returns the equations with the outcome of each claim in their facts; with `symmetric`, also
    with constants of the motion by Noether's theorem. The results are valid for the sizes given in
    the model."""
    model, facts = equations.model, equations.facts
    if not (model.conserved or symmetric):
        return equations
    count = sum(f.count for f in families(model, model.coordinates).values())
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
        claims = _of_large(equations, count, file, use)
        if facts.conservative:
            claims = tuple(map(_of_energy, model.conserved, claims))
        facts = replace(facts, claims=claims)
    return replace(equations, facts=facts)


def _of_energy(item: Definition, claim: Claim) -> Claim:
    """Returns the outcome of a claim for a conservative model: proved if the claim says that the
    energy is constant, else `claim`."""
    if not (isinstance(item.value, Name) and item.value.id == "energy"):
        return claim
    return Claim(item.name, PROVED, "neither time nor a force beyond L enters the equations")


def _analyzed(model: Model, symmetric: bool = False) -> Structure:
    unrolled = derive.derive(model, frozenset({"mass", "force", "momenta", "conserve"}))
    return analyze.analyze(unrolled, symmetric, with_claims=True)


def _of_large(e: FamilyEquations, count: int, file: File, use: Use | None) -> tuple[Claim, ...]:
    """Returns the outcomes of the claims of a model with more than PROVED_AT coordinates, from the
    model unrolled at its own sizes or at smaller sizes."""
    if count <= TRIED_AT:
        at = f"with {sizes_text(e.model)}"
        return tuple(replace(x, says=f"{x.says}, {at}") for x in _analyzed(e.model).claims)
    why, reach = _alike(e)
    few = 8 * reach + 1
    sizes = {size.name: min(size.value, few) for size in e.model.sizes}
    longer = [sizes | {x.name: few + 1} for x in e.model.sizes if x.value > few]
    found: list[tuple[Claim, ...]] = []
    for each in [] if why else [sizes, *longer]:
        try:
            small, _ = check.check(file, each)
        except ModelError:
            return _open(e.model, "few members are too few for it")
        small = use(small)[0] if use else small
        if sum(f.count for f in families(small, small.coordinates).values()) > 2 * PROVED_AT:
            return _open(e.model, f"its terms reach {reach} members: few do not stand for many")
        at = f"with {sizes_text(small)}"
        claims = _analyzed(small).claims
        found.append(tuple(replace(x, says=f"{x.says}, {at}") for x in claims))
    if not found:
        return _open(e.model, f"{why}: few members do not stand for {count}")
    return tuple(map(_worst, zip(*found, strict=True)))


def _worst(claims: tuple[Claim, ...]) -> Claim:
    order = (REFUTED, OPEN, PROVED)
    worst = min(claims, key=lambda x: order.index(x.outcome))
    more = " and more" if worst.outcome == PROVED else ""
    return replace(worst, says=worst.says + more)


def _open(model: Model, says: str) -> tuple[Claim, ...]:
    return tuple(Claim(item.name, OPEN, says) for item in model.conserved)


def _alike(e: FamilyEquations) -> tuple[str, int]:
    """Returns the reason why small sizes prove nothing about larger ones, or "", and the largest
    difference of indices of coupled members."""
    g, slots = e.graph, Slots(e.graph, e.slots)
    motion = nodes_of(e.lagrangian, e.force)
    if e.resets:
        return "an event gives values", 0
    if e.carried or e.bound or e.along or e.wraps or e.scalars or not e.mass_diagonal:
        return "members are coupled by more than the terms near them", 0
    if any(len(x.over) == 4 for of in (e.lagrangian, e.force, *e.sums) for x in of) or any(
        slot.kind == "sum" for node in motion for slot in slots.below(node)
    ):
        return "there are sums over all members in its equations", 0
    for node in e.conserved:
        slopes = gradient(g, node, BIT[Kind.INPUT])
        if any(g.depends[x] & (VARIABLE | BIT[Kind.INPUT]) for x in slopes.values()):
            return "it is no sum of terms", 0
    inside = [*nodes_of(*e.sums), *motion, *e.conserved]
    inside += [node for values in e.given.values() for node in values]
    found = [slot for node in inside for slot in slots.below(node)]
    if any(slot.kind in ("index", "size") for slot in found):
        return "its terms have an index or a size in them", 0
    places = [slot.at for slot in found if slot.at is not None]
    places += [at for of in (e.lagrangian, e.force, *e.sums) for x in of for at in x.over]
    places += [at for x in e.force for _, at in x.to if at is not None]
    if any(len(at.terms) > 1 or any(abs(k) != 1 for _, k in at.terms) for at in places):
        return "its members stand at sums of indices", 0
    return "", max((abs(at.constant) for at in places), default=0)


def sizes_text(model: Model) -> str:
    return ", ".join(f"{size.name} = {size.value}" for size in model.sizes)
