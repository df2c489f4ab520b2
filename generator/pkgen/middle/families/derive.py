"""Derives Lagrange's equations of a model with loops over the members of families. Raises NotKept
with a reason if the model cannot be compiled to loops."""

from __future__ import annotations

from dataclasses import replace

from ...model import Model
from ...source import Diagnostic, ModelError
from ..derive.samples import sampled
from ..expand.names import entered
from ..quantities import indexed, refuse_constant
from .constraint_rows import bound_of
from .equations import FamilyEquations, Limit
from .expand import FamilyExpander
from .facts import facts_of
from .indexed_ir import Addend, Carried, NotKept, Sum, merged, nodes_of, of_name
from .indices import size_values
from .recurrences import by_places, carried_of, inert
from .rows import Assembler
from .singularities import singularities_of
from .slots import M
from .statements import Outputs, bounds_of, defaults_of, given_of, starts_of
from .switches import switches_of
from .terms import terms

# A model that sets one of these fields is written out; the value is the reason.
_UNROLLED = {
    "fast": "a part of the potential is named fast",
    "hamiltonian": "the model has a Hamiltonian",
    "consistent": "the start is found by the constraints",
    "meets": "the model has contacts, friction or latches",
    "noises": "the model has noise",
}


def derive_families(model: Model) -> FamilyEquations:
    """Returns the equations of motion with loops over the members of all families. Raises
    NotKept."""
    return entered(model, lambda orders: _derive(FamilyExpander(model, orders)))


def _derive(x: FamilyExpander) -> FamilyEquations:
    model, assembler = x.model, Assembler(x)
    _check_kept(x)
    kinetic, potential, stated = (
        assembler.bodies(term for expr in getattr(model, kind) for term in terms(x, expr))
        for kind in ("kinetic", "potential", "lagrangian")
    )
    negative = tuple(Addend(body.over, x.graph.negate(body.node)) for body in potential)
    lagrangian = merged((*kinetic, *negative, *stated), x.graph)
    assembler.lagrangian(lagrangian)
    for expr in model.dissipation:
        assembler.dissipation(assembler.bodies(terms(x, expr)))
    assembler.felt_through()
    _forces(x, assembler)
    _check_rates(x, assembler.quantity("force"))
    _check_apart(assembler)
    bound = bound_of(x, assembler)
    carried = carried_of(x, assembler)
    energy = merged(
        [body for part in (kinetic, negative, stated) for body in assembler.energy(part)], x.graph
    )
    if model.lagrangian:
        kinetic = potential = None
    vectors = {what: assembler.quantity(what) for what in ("gradient", "momenta", "pdot", "force")}
    mass = assembler.quantity("mass")
    _check_inertia(x, mass, carried)
    outputs = Outputs(x, assembler, kinetic, potential, lagrangian, energy, vectors["momenta"])
    observed = outputs.observed()
    conserved = outputs.nodes(model.conserved)
    events = outputs.nodes(model.events)
    refuse_constant(model, x.graph, events)
    of_samples = sampled(x, lambda node, span: node)
    resets = outputs.resets()
    assembler.limits += x.limits_of(None, {})
    x.watched = False
    starts = starts_of(x, assembler)
    defaults = defaults_of(x, assembler)
    result = FamilyEquations(
        model=model,
        graph=x.graph,
        slots=(),
        coordinates=tuple(g for g in x.coordinates.values() if not g.is_carried),
        parameters=tuple(x.parameters.values()),
        orders=x.orders,
        **vectors,
        mass=mass,
        kinetic=kinetic,
        potential=potential,
        lagrangian=lagrangian,
        energy=energy,
        sums=(),
        fixed=frozenset(),
        outputs=observed,
        conserved=conserved,
        events=events,
        **of_samples,
        resets=resets,
        given=given_of(x),
        defaults=defaults,
        bounds=bounds_of(x),
        starts=starts,
        limits=(),
        wraps=assembler.wraps,
        carried=carried,
        extended=bool(carried) and not by_places(x, mass, carried),
        bound=bound,
        solved=_of_states(x, vectors["momenta"], carried),
    )
    switches, whole = switches_of(x, result, assembler.limits)
    facts = facts_of(x, assembler, result)
    facts = replace(facts, switched=whole and not facts.smooth)
    limits = _limits(x, assembler.limits)
    result = replace(result, switches=switches, facts=facts, limits=limits)
    singularities, pivots = singularities_of(x, result)
    if not model.coordinates:
        result = replace(result, kinetic=None, potential=None, lagrangian=None, energy=None)
    return replace(
        result,
        singularities=singularities,
        pivots=pivots,
        sums=tuple(x.totals.all),
        fixed=x.totals.fixed,
        along=x.alongside.passes(),
        summed=x.summed,
        slots=tuple(x.slots.all),
    )


def _check_kept(x: FamilyExpander) -> None:
    """Raises NotKept if the model has no family to keep, or a statement that families have not."""
    model, sized = x.model, size_values(x.model).keys()
    if not any(
        group.is_family and {n for n, _ in group.count.terms} & sized
        for group in x.coordinates.values()
    ):
        raise NotKept("no family of coordinates has a length that depends on a size")
    if model.source.parts:
        raise NotKept("the model has parts")
    for field, why in _UNROLLED.items():
        if getattr(model, field):
            raise NotKept(why)
    if model.lagrangian and not model.coordinates:
        raise NotKept("L is of first degree in the rates")


def _forces(x: FamilyExpander, assembler: Assembler) -> None:
    """Adds the generalized forces and the time derivatives of states to the equations."""
    for item in (*x.model.forces, *x.model.rates):
        lo, hi, loop = x.over(item.range, item.index)
        group = x.coordinates[item.name]
        if lo is not None:
            assembler.limits += [Limit(lo - group.lo, hi - lo), Limit(group.hi - hi, hi - lo)]
        for term in terms(x, item.value, loop):
            assembler.applied_term(group, lo, hi, term)
    for load in x.model.loads:
        lo, hi, loop = x.over(load.range, load.index)
        assembler.load(lo, hi, x.value(load.value, loop), x.value(load.velocity, loop))
    for rotation in x.rotations.all:
        assembler.attitude(rotation)
    for group in x.coordinates.values():
        if group.is_state:
            assembler.state(group)


def _check_apart(assembler: Assembler) -> None:
    """Raises NotKept if a sum over pairs is added to a member other than m."""
    for name in ("momenta", "pdot", "force", "mass"):
        for body in assembler.quantity(name):
            at = body.to[0][1]
            if len(body.over) == 2 and at is not None and not (at - M).is_constant:
                raise NotKept("a sum is added to a member far from its own")


def _check_rates(x: FamilyExpander, force: Sum) -> None:
    """Raises NotKept if the time derivatives of states depend on each other in a cycle."""
    uses = {}
    for group in x.coordinates.values():
        if group.is_state:
            nodes = nodes_of(of_name(force, group.name))
            uses[group.name] = {s.name for s in x.totals.below(*nodes) if s.kind == "a"}
    while uses:
        ready = {name for name, found in uses.items() if not found & uses.keys()}
        if not ready:
            raise NotKept("the rates of states use each other in a circle")
        uses = {name: found for name, found in uses.items() if name not in ready}


def _of_states(x: FamilyExpander, momenta: Sum, carried: tuple[Carried, ...]) -> bool:
    """Returns whether a momentum of a coordinate depends on a state."""
    own = {g.name for g in x.coordinates.values() if g.is_state}
    nodes = [a.node for a in momenta if a.to[0][0] not in own]  # Also those of recurrences.
    nodes += [n for item in carried for piece in item.pieces for n in piece.by.values()]
    return any(slot.kind == "s" for slot in x.totals.below(*nodes))


def _check_inertia(x: FamilyExpander, mass: Sum, carried: tuple[Carried, ...]) -> None:
    findings = []
    found = inert({a.to[0][0] for a in mass if a.to[0] == a.to[1]}, carried)
    for group in x.coordinates.values():
        name, index = group.name, "i" if group.is_family else None
        if name not in found and not group.is_carried:
            shown = indexed(name, index)
            message = f"'{shown}' has no inertia: L does not contain the square of {shown}'"
            help = f"give it a kinetic energy, or make '{name}' a param or an input"
            if group.is_turn:
                message = f"'{indexed(group.shown, index)}' has no inertia: L does not"
                message += " contain its square"
                help = "a body has a moment of inertia about each of its axes"
            findings.append(Diagnostic(message, group.declared.span, help))
    if findings:
        raise ModelError(x.model.source, findings)


def _limits(x: FamilyExpander, found: list[Limit]) -> tuple[Limit, ...]:
    """Returns the conditions `found` on the model's sizes, such as N in q[1..N], and the conditions
    that no family is empty. Leaves out conditions that always hold. Raises NotKept if the sizes
    given in the model do not satisfy them."""
    sizes = size_values(x.model)
    wanted = [Limit(g.count - 1, None) for g in x.coordinates.values() if g.is_family]
    kept: dict[Limit, None] = {}
    for limit in [*wanted, *found]:
        unless = limit.unless
        if unless is not None and unless.is_constant:
            if unless.constant < 0:
                continue
            limit = Limit(limit.needs, None)
            unless = None
        if limit.needs.is_constant and limit.needs.constant >= 0:
            continue
        met = limit.needs.value(sizes) >= 0 or (unless is not None and unless.value(sizes) < 0)
        if not met:
            raise NotKept(f"a sum reaches outside unless {limit.needs.text()} >= 0")
        kept[limit] = None
    plain = {limit.needs for limit in kept if limit.unless is None}
    return tuple(k for k in kept if k.unless is None or k.needs not in plain)
