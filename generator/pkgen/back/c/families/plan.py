"""Determines the kernels of a model with families, and what these are made of."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace

from ....graph.affine import Affine
from ....middle.families.equations import FamilyEquations
from ....middle.families.indexed_ir import Addend, Bound, Group, NotKept, Slot, Sum, of_name
from ....middle.families.jacobians import Slopes, slopes_of
from ....middle.families.jacobians_recurrences import of_chain
from ....middle.families.slots import M
from ...targets import RETURN
from .blocks import INNER, Block
from .chain import Chain
from .kernels import Builder, Kernel, Terms, Vector
from .places import Places
from .recurrences import made_of
from .switches import terms as switching

TOTALS = ("energy", "lagrangian", "kinetic", "potential")
# Kernels that write a value for each coordinate: {kernel: {output: field of FamilyEquations}}.
VECTORS = {
    "force": {"f": "force"},
    "canonical": {"momenta": "momenta", "pdot": "pdot"},
    "momenta": {"momenta": "momenta"},
    "gradient": {"dLdq": "gradient"},
}
# Kernels with a value for each constraint row.
BOUND: dict[str, Callable[[Bound], Sum]] = {
    "constraint": lambda rows: rows.position,
    "constraint_rates": lambda rows: rows.rate,
    "coasting": lambda rows: rows.coasting,
    "position_size": lambda rows: rows.sizes[0],
    "rate_size": lambda rows: rows.sizes[1],
}
OF_POSITIONS = ("constraint", "position_size")


@dataclass
class Plan:
    """The kernels of a model. Totals, values of outputs, singularities and switches are lists of
    terms with one value each."""

    vectors: dict[str, Vector] = field(default_factory=dict)
    matrices: dict[str, Kernel] = field(default_factory=dict)
    totals: dict[str, list[Terms]] = field(default_factory=dict)
    rates: dict[str, Vector] = field(default_factory=dict)  # of states that others use
    along: dict[int, list[Terms]] = field(default_factory=dict)  # recurrent `let`s of each pass
    # By kernel, the values with one for each index: their terms, and the place of the first.
    written: dict[str, list[tuple[Terms, Affine]]] = field(default_factory=dict)
    singularities: list[Terms] = field(default_factory=list)
    switches: list[Terms] = field(default_factory=list)
    chain: Chain | None = None
    # The mass of each family or scalar, if it is the same for all members and needed; those that
    # may not be positive.
    alike: dict[str, Block] = field(default_factory=dict)
    masses: list[Block] = field(default_factory=list)
    accelerated: tuple[list[Sum], str] = ([], "")  # the outputs and the finish of accelerations
    made: tuple[Kernel, ...] = ()  # the rows of matrices that define carried values
    slopes: Slopes | None = None

    @property
    def terms(self) -> Iterator[Terms]:
        for kernel in self.kernels:
            yield from kernel.terms
        yield from (x for found in (*self.totals.values(), *self.along.values()) for x in found)
        yield from (terms for rows in self.written.values() for terms, _ in rows)
        yield from (*self.singularities, *self.switches)

    @property
    def all_terms(self) -> Iterator[Terms]:
        """The terms, and those of recurrences."""
        yield from self.terms
        if self.chain:
            yield from (x.terms for levels in self.chain.carrying.levels.values() for x in levels)
            elimination = self.chain.elimination
            for rows in elimination.mass if elimination else ():
                yield from rows.vector.terms

    @property
    def kernels(self) -> Iterator[Kernel]:
        found = (self.vectors, self.matrices, self.rates)
        yield from (kernel for kernels in found for kernel in kernels.values())
        yield from self.made

    @property
    def blocks(self) -> Iterator[Block]:
        yield from {terms.name: terms.block for terms in self.terms}.values()
        yield from (*self.alike.values(), *self.masses)
        if self.chain:
            yield from self.chain.blocks


def emitted(e: FamilyEquations, wanted: frozenset[str] | None) -> frozenset[str]:
    """Returns the kernels of `wanted` (None: all) that the model has, and the kernels they call."""
    named = {*VECTORS, *(k for k in TOTALS if getattr(e, k) is not None)}
    watched = {"momenta"} if watches_momenta(e) else set()
    if e.carried:
        named |= {"jacobian"}
        watched |= {"canonical"} if wanted is None or "jacobian" in wanted else set()
        return frozenset(named if wanted is None else named & wanted | {"force"} | watched)
    named |= {"mass", "inertia", "jacobian", "advance"}
    if wanted is None:
        return frozenset(named)
    solved = set() if divides(e) and not e.has_pairs else {"force"}
    return frozenset(named & wanted | solved | watched)


def watches_momenta(e: FamilyEquations) -> bool:
    """Returns whether an output contains a momentum."""
    return any(slot.kind == "p" for slot in e.slots)


def within(e: FamilyEquations) -> dict[str, dict[str, str]]:
    """Returns VECTORS; in models with recurrences the kernel `gradient` has momenta as
    an additional output."""
    return VECTORS | ({"gradient": {"momenta": "momenta", "dLdq": "gradient"}} if e.carried else {})


def divides(e: FamilyEquations) -> bool:
    """Returns whether M is diagonal, so that M a = f takes one division per row."""
    return e.mass_diagonal and not (e.bound or e.carried)


def planned(e: FamilyEquations, make: Builder, kernels: frozenset[str]) -> Plan:
    plan, groups = Plan(), (*e.coordinates, *e.carried_groups)
    for kernel, outputs in within(e).items():
        if kernel in kernels:
            fields = [getattr(e, x) for x in outputs.values()]
            plan.vectors[kernel] = make.vector(kernel, fields, groups)
    if e.carried:
        plan.chain = Chain(e, make.places, make, "jacobian" in kernels)
        for a, b in plan.chain.elimination.corner if plan.chain.elimination else ():
            own = (x for x in e.mass if x.to == ((a, None), (b, None)))
            plan.totals[f"mass_{a}_{b}"] = make.totals(f"mass_{a}_{b}", own)
    elif divides(e):
        _plan_divided(e, make, plan, kernels)
    if e.extended or not (e.carried or divides(e)):
        plan.matrices["inertia"] = make.kernel("inertia", [e.mass])
    if e.extended or (e.carried and "jacobian" in kernels):
        plan.made = made_of(e, make)
    _plan_bound(e, make, plan)
    _plan_written(e, make.places, plan)
    for what in TOTALS:
        if what in kernels:
            plan.totals[what] = make.totals(what, getattr(e, what))
    if "jacobian" in kernels:
        _plan_slopes(e, make, plan)
    plan.singularities = [
        Terms(f"singularity_{k}", x.over, [x.node]) for k, x in enumerate(e.singularities)
    ]
    plan.switches = list(switching(e))
    _plan_before(e, make, plan)
    return plan


def _plan_written(e: FamilyEquations, places: Places, plan: Plan) -> None:
    """Plans outputs, and values after events, that have one value for each index."""

    outputs = zip(e.outputs, places.observed, strict=False)
    found = {"observe": [(x, place) for x, place in outputs if x.lo is not None]}
    for event, given in zip(e.model.resetting, e.resets, strict=True):
        found[event.kernel] = [(x, places.given(x)) for x in given if x.lo != x.hi]
    plan.written = {
        kernel: [
            (Terms(f"{kernel}_{k}", (x.lo, x.hi), [x.node]), place)
            for k, (x, place) in enumerate(rows)
        ]
        for kernel, rows in found.items()
        if rows
    }


def _plan_divided(e: FamilyEquations, make: Builder, plan: Plan, kernels: frozenset[str]) -> None:
    """Plans M, which is diagonal, and the accelerations: the force divided by the mass in terms,
    where the mass is the same for all members; in rows, if the force is no sum over pairs or for a
    scalar; or after all forces. M is left out if nothing reads it and no mass can fail."""
    mass = tuple(Addend(x.over, x.node, x.to[:1]) for x in e.mass)
    same = {g.name: _same_mass(e, make, g) for g in e.coordinates}
    groups, divide = e.coordinates, e.graph.divide
    is_read = {"mass", "inertia"} & kernels or e.pivots
    if e.has_pairs:
        plan.vectors["divide"] = make.vector("divide", [mass], groups, "DIVIDE")
    elif all(node is not None for node in same.values()):
        a = tuple(Addend(x.over, divide(x.node, same[x.to[0][0]]), x.to) for x in e.force)
        plan.accelerated = [a], "STORE"
        plan.vectors["acceleration"] = make.vector("acceleration", [a], groups)
        values = ((node, e.graph.value(node)) for node in dict.fromkeys(same.values()))
        checked = [node for node, value in values if value is None or value <= 0]
        plan.masses = [Block.of(RETURN, "", [node], INNER) for node in checked]
        if checked or is_read:
            plan.alike = {k: Block.of(RETURN, "", [node], INNER) for k, node in same.items()}
        return
    else:
        plan.accelerated = [e.force, mass], "QUOTIENT"
        plan.vectors["acceleration"] = make.vector(
            "acceleration", plan.accelerated[0], groups, "QUOTIENT"
        )
    plan.vectors["mass"] = make.vector("mass", [mass], groups)


def _same_mass(e: FamilyEquations, make: Builder, g: Group):
    """Returns the mass of all members of a family as a node, if it is the same for all and depends
    on parameters and sizes alone; else None."""
    found = [x for x in e.mass if x.to[0][0] == g.name]
    if len(found) != 1:
        return None
    [one] = found
    over = (g.lo, g.hi) if g.is_family else ()
    whole = one.over == over and one.to[0][1] == (M if g.is_family else None)
    slots = make.slots.below(one.node)
    fixed = e.graph.is_constant(one.node) and all(s.kind in ("param", "size") for s in slots)
    return one.node if whole and fixed and all(s.at is None for s in slots) else None


def _plan_before(e: FamilyEquations, make: Builder, plan: Plan) -> None:
    """Plans the values that the planned blocks read: totals, rates of states and `let`s, including
    those that such values read in turn."""
    below, states = make.slots.below, {g.name: g for g in e.states}
    passes = {item.name: k for k, found in enumerate(e.along) for item in found}
    nodes = [node for block in plan.blocks for node in block.nodes]
    nodes += [*e.told, *(n for x in e.given.values() for n in x)]
    seen: set[Slot] = set()
    while nodes:
        found = [slot for slot in below(*nodes) if slot not in seen]
        seen.update(found)
        made: list[Terms] = []
        for slot in found:
            if slot.kind == "sum":
                total = make.totals(f"sum_{slot.name}", e.sums[int(slot.name)])
                plan.totals[f"sum_{slot.name}"] = total
                made += total
            elif slot.kind in ("a", "acc") and slot.name in states and slot.name not in plan.rates:
                key, g = make.places.ids[slot.name], states[slot.name]
                rates = make.vector(f"rate_{key}", [of_name(e.force, slot.name)], [g])
                plan.rates[slot.name] = rates
                made += rates.terms
            elif slot.kind == "let" and passes[slot.name] not in plan.along:
                k = passes[slot.name]
                plan.along[k] = _along(e, k)
                made += plan.along[k]
        nodes = [node for terms in made for node in terms.nodes]


def _along(e: FamilyEquations, k: int) -> list[Terms]:
    return [
        Terms(f"let_{k}_{n}_{i}", x.over, [x.node], sequence=True)
        for n, item in enumerate(e.along[k])
        for i, x in enumerate(item.parts)
    ]


def row_group(rows: Bound) -> Group:
    """Returns the group of constraint rows; a single row counts as a scalar."""
    return replace(rows.group, lo=None, hi=None) if rows.is_single else rows.group


def _plan_bound(e: FamilyEquations, make: Builder, plan: Plan) -> None:
    if not e.bound:
        return
    for name, holonomic in (("jacobian", True), ("rolling", False)):
        found = [x for rows in e.bound if rows.holonomic == holonomic for x in rows.jacobian]
        plan.matrices[name] = make.kernel(name, [found], short=False)
    for kernel, of in BOUND.items():
        rows = [rows for rows in e.bound if rows.holonomic or kernel not in OF_POSITIONS]
        found = [x for each in rows for x in of(each)]
        plan.vectors[kernel] = make.vector(kernel, [found], map(row_group, rows), short=False)


def _plan_slopes(e: FamilyEquations, make: Builder, plan: Plan) -> None:
    """Plans the kernels of M and of the derivatives of p and p', unless the matrices are dense."""
    try:
        found = (of_chain if e.carried else slopes_of)(e, make.slots)
    except NotKept:
        return
    plan.slopes = found
    plan.matrices["slopes_mass"] = make.kernel("slopes_mass", [found.mass])
    if found.closed is not None:
        plan.matrices["slopes_closed"] = make.kernel("slopes_closed", [found.closed])
    outputs = [found.p_q, found.pdot_q, found.pdot_v]
    plan.matrices["slopes_jacobian"] = make.kernel("slopes_jacobian", outputs)


def half_width(found: Iterable[Sum], unknowns: dict, groups: dict, slots: int) -> int:
    """Returns the half bandwidth of matrices: the largest distance of two unknowns with an entry.
    `groups` has the Group of each unknown of the band."""
    width = 0
    for row, column in (x.to for of in found for x in of):
        if row[0] not in groups or column[0] not in groups:
            continue
        a, b = groups[row[0]], groups[column[0]]
        apart = (column[1] - row[1]).constant if None not in (row[1], column[1]) else 0
        distance = abs(apart * slots + unknowns[column[0]] - unknowns[row[0]])
        # An index beyond a free end has the unknown of its neighbour, one index away. If both
        # families have the same ends, this shifts both alike.
        alike = (a.lo, a.hi, _free(a)) == (b.lo, b.hi, _free(b))
        width = max(width, distance + slots * bool((_free(a) or _free(b)) and not alike))
    return width


def _free(g: Group) -> tuple[Affine, ...]:
    return tuple(at for at, end in g.ends if end.kind == "free")
