"""Derives Lagrange's equations of a model with loops over the members of families. Raises Unrolled
with a reason if the model cannot be compiled to loops."""

from __future__ import annotations

from dataclasses import replace

from ...model import Model
from ...source import Diagnostic, ModelError
from ..expand.names import entered
from ..quantities import indexed, refuse_constant
from .bodies import Gathered
from .constraint_rows import bound_of
from .expand import LoopExpander
from .facts import facts_of, own_nodes, vector_nodes
from .indexed_ir import Band, Carried, Row, Unrolled, Vector
from .indices import size_values
from .loops import Limit, LoopEquations
from .recurrences import by_places, carried_of, inert
from .rows import Gather
from .singularities import singularities_of
from .statements import Outputs, bounds_of, defaults_of, given_of, starts_of
from .switches import switches_of
from .terms import Term, terms

# A model with one of these fields keeps no loops; the value is the reason.
_UNROLLED = {
    "fast": "a part of the potential is named fast",
    "hamiltonian": "the model has a Hamiltonian",
    "tables": "the model has a table of data",
    "consistent": "the start is found by the constraints",
    "samples": "the model has a sample block",
    "resetting": "an event gives values",
    "meets": "the model has contacts, friction or latches",
    "noises": "the model has noise",
    "loads": "a force acts at a point, or a torque in space",
}


def derive_loops(model: Model) -> LoopEquations:
    """Returns the equations of motion with loops over the members of all families. Raises
    Unrolled."""
    return entered(model, lambda orders: _derive(LoopExpander(model, orders)))


def _derive(x: LoopExpander) -> LoopEquations:
    model, gather = x.model, Gather(x)
    sized = size_values(model).keys()
    if not any(
        group.is_family and {n for n, _ in group.count.terms} & sized
        for group in x.coordinates.values()
    ):
        raise Unrolled("no family of coordinates has a length that depends on a size")
    if model.source.parts:
        raise Unrolled("the model has parts")
    for field, why in _UNROLLED.items():
        if getattr(model, field):
            raise Unrolled(why)
    if model.lagrangian and not model.coordinates:
        raise Unrolled("L is of first degree in the rates")
    found: dict[str, list[tuple[Term, int]]] = {}
    for kind, sign in (("kinetic", 1), ("potential", -1), ("lagrangian", 1)):
        found[kind] = []
        for term in (t for expr in getattr(model, kind) for t in terms(x, expr)):
            gather.lagrangian(term, sign)
            found[kind].append((term, 1))
    for expr in model.dissipation:
        for term in terms(x, expr):
            gather.dissipation(term)
    gather.felt_through()
    _forces(x, gather)
    _check_rates(x, gather)
    bound = bound_of(x, gather)
    carried = carried_of(x, gather)
    negative = [(term, -1) for term, _ in found["potential"]]
    whole = [*found["kinetic"], *negative, *found["lagrangian"]]
    energy = gather.energy(whole)
    stated = bool(model.lagrangian)
    kinetic = None if stated else gather.total(found["kinetic"])
    potential = None if stated else gather.total(found["potential"])
    lagrangian = gather.total(whole)
    vectors = {
        what: _vector(x, gather.found, what) for what in ("gradient", "momenta", "pdot", "force")
    }
    mass = _band(gather.found)
    _check_inertia(x, mass, carried)
    outputs = Outputs(x, gather, kinetic, potential, lagrangian, energy, vectors["momenta"])
    observed = outputs.observed()
    conserved = outputs.nodes(model.conserved)
    events = outputs.nodes(model.events)
    refuse_constant(model, x.graph, events)
    x.watched = False
    starts = starts_of(x, gather)
    defaults = defaults_of(x, gather)
    result = LoopEquations(
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
        given=given_of(x),
        defaults=defaults,
        bounds=bounds_of(x),
        starts=starts,
        limits=(),
        wraps=gather.found.wraps,
        carried=carried,
        extended=bool(carried) and not by_places(x, mass, carried),
        bound=bound,
        solved=_of_states(x, vectors["momenta"], carried),
    )
    _check_points(x, result)
    switches, whole = switches_of(x, result, gather.found.limits)
    facts = facts_of(x, gather, result)
    facts = replace(facts, switched=whole and not facts.smooth)
    limits = _limits(x, gather.found.limits)
    result = replace(result, switches=switches, facts=facts, limits=limits)
    singularities, pivots = singularities_of(x, gather, result)
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


def _forces(x: LoopExpander, gather: Gather) -> None:
    """Adds the generalized forces and the time derivatives of states to the equations."""
    for item in (*x.model.forces, *x.model.rates):
        lo, hi, loop = x.over(item.range, item.index)
        group = x.coordinates[item.name]
        if lo is not None:
            gather.found.limits += [Limit(lo - group.lo, hi - lo), Limit(group.hi - hi, hi - lo)]
        for term in terms(x, item.value, loop):
            gather.applied_term(group, lo, hi, term)
    for rotation in x.rotations.all:
        gather.attitude(rotation)
    for group in x.coordinates.values():
        if group.is_state:
            gather.state(group)


def _check_rates(x: LoopExpander, gather: Gather) -> None:
    """Raises Unrolled if the time derivatives of states depend on each other in a cycle."""
    force, uses = _vector(x, gather.found, "force"), {}
    for group in x.coordinates.values():
        if group.is_state:
            nodes = own_nodes(force, group.name)
            uses[group.name] = {s.name for s in x.totals.below(*nodes) if s.kind == "a"}
    while uses:
        ready = {name for name, found in uses.items() if not found & uses.keys()}
        if not ready:
            raise Unrolled("the rates of states use each other in a circle")
        uses = {name: found for name, found in uses.items() if name not in ready}


def _vector(x: LoopExpander, found: Gathered, what: str) -> Vector:
    pairs = list(found.pairs) if what in ("gradient", "pdot", "force") else []
    pairs += found.drags if what in ("pdot", "force") else []
    return Vector(
        rows={
            g.name: Row(tuple(found.rows[what, g.name]))
            for g in x.coordinates.values()
            if g.is_family
        },
        totals={
            g.name: found.totals[what, g.name] for g in x.coordinates.values() if not g.is_family
        },
        pairs=tuple(p for p in pairs if p.by_row or p.by_other or p.by_scalar),
    )


def _of_states(x: LoopExpander, momenta: Vector, carried: tuple[Carried, ...]) -> bool:
    """Returns whether a momentum of a coordinate depends on a state."""
    own = [g.name for g in x.coordinates.values() if g.is_state]
    nodes = vector_nodes(momenta, frozenset(own))  # `nodes` also has the momenta of recurrences
    nodes += [n for item in carried for piece in item.pieces for n in piece.by.values()]
    return any(slot.kind == "s" for slot in x.totals.below(*nodes))


def _band(found: Gathered) -> Band:
    return Band(
        {key: Row(tuple(parts)) for key, parts in found.entries.items() if parts},
        {key: Row(tuple(parts)) for key, parts in found.border.items() if parts},
        dict(found.corner),
    )


def _check_inertia(x: LoopExpander, mass: Band, carried: tuple[Carried, ...]) -> None:
    findings = []
    own = {a for a, b, shift in mass.entries if (a, 0) == (b, shift)}
    found = inert(own | {a for a, b in mass.corner if a == b}, carried)
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


def _limits(x: LoopExpander, found: list[Limit]) -> tuple[Limit, ...]:
    """Returns the conditions `found` on the model's sizes, such as N in q[1..N], and the conditions
    that no family is empty. Leaves out conditions that always hold. Raises Unrolled if the sizes
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
            raise Unrolled(f"a sum reaches outside unless {limit.needs.text()} >= 0")
        kept[limit] = None
    plain = {limit.needs for limit in kept if limit.unless is None}
    return tuple(k for k in kept if k.unless is None or k.needs not in plain)


def _check_points(x: LoopExpander, result: LoopEquations) -> None:
    """Raises Unrolled if a term, such as one with q[7], adds to the equation of a single member far
    from both ends of a family: in C, all these members share the code of one loop."""
    rows = [(name, row) for name, row in result.force.rows.items()]
    rows += [(key[0], row) for key, row in result.mass.entries.items()]
    for name, row in rows:
        group = x.coordinates[name]
        for part in row.parts:
            near = (part.hi - group.lo).is_constant or (group.hi - part.lo).is_constant
            if part.is_point and not near:
                raise Unrolled(f"a term is about {name}[{part.lo.text()}], far from the ends")
