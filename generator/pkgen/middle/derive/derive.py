"""Derives Lagrange's equations of a model on the expression graph.

One reverse sweep over L gives p = dL/dv and dL/dq. One sparse forward sweep for each rate gives a
column of M = dp/dv. One forward sweep gives (dp/dq) v + dp/dt. For N coordinates, this takes O(N)
operations for f and O(N^2) for M, in addition to the operations of L.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from ... import limits
from ...equations import Equations, Named, ParameterSlot, Quantity, Row
from ...graph.differentiate import gradient
from ...graph.graph import BIT, ONE, ZERO, Kind, Node
from ...graph.solve import SingularMass, solve
from ...graph.substitute import substituted
from ...indices import of_made
from ...model import Model, Parameter
from ...source import Diagnostic, ModelError, Span
from ..analyze.analyze import cyclic_of
from ..expand.expand import Expander
from ..expand.names import entered
from ..motion import PARTICLES, RATES, Energies, Motion, Wanted, with_states
from ..naming import naming
from ..quantities import (
    error,
    families,
    has_bodies,
    indexed,
    input_quantities,
    quantities,
    refuse_constant,
    smaller,
    symbols,
)
from .constrain import CannotConstrain
from .constraint_start import at_the_start
from .constraints import cannot_constrain, define_multipliers, rows_of
from .contacts import define_contacts, with_meetings, with_multipliers, without_latches
from .effective import NAME, NotReduced, effective_potential
from .first_degree import rates_of_first_degree
from .first_order import define_built_in, rates_of_states
from .impulses import check_rates
from .lagrange import Derived, derived, located
from .legendre import hamiltonian_of, lagrangian_of, rates_at_start
from .noise import noise_of
from .resets import resets_of
from .samples import sampled


def derive(model: Model, kernels: frozenset[str] | None = None, unrolled: str = "") -> Equations:
    """Returns the equations of motion. `kernels` are the requested kernels (None: all); costly
    kernels are left out if they are not requested. `unrolled` is the reason why the model cannot be
    compiled to loops over the members of families. The error message about a model that is too
    large gives this reason."""
    _check_size(model, unrolled)
    return entered(model, lambda orders: _derive(model, kernels, orders))


def _derive(model: Model, kernels: frozenset[str] | None, orders: tuple[int, ...]) -> Equations:
    x = Expander(model, orders)
    energies = _energies(x)
    wanted = Wanted(kernels)
    of_first_degree: dict[int, Node] = {}
    if model.lagrangian and not model.coordinates:
        of_first_degree, energies = rates_of_first_degree(x, energies.lagrangian)
    define_contacts(x)
    rates = rates_of_states(x, energies, of_first_degree)
    forces = tuple(substituted(x.graph, _generalized_forces(x), rates))
    parameters = tuple(slot for item in model.parameters for slot in _slots(x, item))
    start_q, start_v, state_start = starts = _starts(x)
    names = x.coordinates
    declared = model.coordinates
    named = Named(
        parameters=parameters,
        coordinates=quantities(declared, names, "{}", "unit"),
        rates=quantities(declared, names, "{}'", "rate_unit", "rate"),
        momenta_names=quantities(declared, names, "p_{}", "momentum_unit", "momentum"),
        inputs=input_quantities(model, orders),
        states=quantities(model.states, x.states, "{}", "unit"),
    )
    declared_rows, left_out = rows_of(x)
    declared_rows, latched = without_latches(x, declared_rows)
    rows, wrong = at_the_start(
        x.graph,
        declared_rows,
        parameters,
        starts,
        energies.lagrangian,
        x.attitudes,
        naming(named),
        model.consistent,
    )
    if wrong:
        raise ModelError(model.source, wrong)
    rows = with_meetings(x, rows, latched)
    bodies = None
    if wanted.named(PARTICLES):
        from ..particles.masses import Given
        from ..particles.particles import particles_of

        bodies = particles_of(x, energies, Given(parameters, start_q, state_start))
    with x.statement(model.span):
        try:
            found = derived(
                x.graph,
                energies,
                forces,
                lambda node: rates.get(x.derivative(node), x.derivative(node)),
                wanted,
                lambda motion: _check_inertia(x, motion),
                tuple(rates.values()),
                x.attitudes,
                rows,
            )
        except SingularMass as singular:
            raise _singular(x, singular.coordinate) from None
        except CannotConstrain as wrong:
            raise cannot_constrain(x, rows, wrong) from None
    if found.solution is None and with_states(x.graph, found.motion.momenta):
        raise error(
            model,
            "a momentum depends on a state, and M is too large to be inverted",
            model.span,
            "with states in the kinetic energy no more than some 20 coordinates can be coupled",
        )
    if model.contacts and rates:  # losses are states whose rates have multipliers
        rates = with_multipliers(x, found.constraints, rates)
        found.fields["state_rates"] = tuple(rates.values())
    # A copy of the nodes whose time derivatives have been taken so far. The time derivatives in
    # outputs, which are taken below, need no check since outputs do not affect the motion.
    primes = x.primes[:]
    equations = Equations(
        model=model,
        graph=x.graph,
        **vars(named),
        **dict.fromkeys(OUTPUTS, ()),
        left_out=left_out,
        event_names=Quantity.each(model.events),
        singularities=(),
        start_q=start_q,
        start_v=start_v,
        state_start=state_start,
        particles=bodies,
        attitudes=x.attitudes,
        **found.fields,
    )
    x.later[NAME] = partial(_effective, x, equations)
    outputs = _outputs(x, found, rates)
    check_rates(model, x.graph, primes, naming(named))
    equations = replace(
        equations,
        **outputs,
        events=_events(x, found),
        **sampled(x, partial(_solved, x, found=found)),
        resets=resets_of(x, partial(_solved, x, found=found)),
        fast=_fast(x, energies.fast, found),
        noise=noise_of(x, found),
    )
    return located(equations, wanted)


# -- the statements ------------------------------------------------------------------------------


def _energies(x: Expander) -> Energies:
    model, g = x.model, x.graph
    x.define_all()
    terms = model.kinetic, model.potential, model.lagrangian, model.dissipation, model.fast
    kinetic, potential, lagrangian, dissipation, fast = map(x.total, terms)
    with x.statement(model.span):
        whole = g.add(g.subtract(kinetic, potential), lagrangian)
        if model.hamiltonian:
            whole = lagrangian_of(x, hamiltonian_of(x))
    stated = bool(model.lagrangian or model.hamiltonian)
    return Energies(
        lagrangian=whole,
        kinetic=None if stated else kinetic,
        potential=None if stated else potential,
        dissipation=dissipation,
        fast=fast,
    )


def _fast(x: Expander, fast: Node, found: Derived) -> Row | None:
    """Returns the accelerations due to the part of V declared as `fast`."""
    if not x.model.fast:
        return None
    if found.constraints is not None:
        message = "a part of the potential is named fast, and there are constraints"
        help = "respa is for models without them: leave the 'fast' out, or choose coordinates"
        raise error(x.model, message, x.model.fast[0].span, help)
    by = gradient(x.graph, fast, BIT[Kind.COORDINATE])
    q = symbols(x.graph, Kind.COORDINATE, len(found.motion.force))
    pull = tuple(x.graph.negate(by.get(symbol, ZERO)) for symbol in q)
    solution = solve(x.graph, found.motion.mass, pull)
    return solution and solution.accelerations


def _slots(x: Expander, item: Parameter) -> list[ParameterSlot]:
    family = x.parameters[item.name]
    slots = []
    with x.statement(item.span):
        for position, index in enumerate(family.members):
            loop = dict(x.sizes)
            if index is not None:
                loop[item.range.variable] = index
            lo, hi = item.bounds.lo, item.bounds.hi
            slots.append(
                ParameterSlot(
                    quantity=Quantity(indexed(item.name, index), item.unit, item.description),
                    family=item.name,
                    position=position,
                    length=0 if index is None else len(family.members),
                    default=x.scalar(item.default, loop),
                    follows=item.follows,
                    lo=None if lo is None else x.scalar(lo, loop),
                    hi=None if hi is None else x.scalar(hi, loop),
                    lo_open=item.bounds.lo_open,
                    hi_open=item.bounds.hi_open,
                )
            )
    return slots


def _starts(x: Expander) -> tuple[Row, Row, Row]:
    """Returns the initial values of the coordinates, of their rates, and of the states."""
    count = x.count
    values = ([ZERO] * count, [ZERO] * count, [ZERO] * x.state_count, [ZERO] * count)
    for item, index, value in x.members_of(x.model.starts):
        is_state, order = item.name in x.states, item.order
        family = (x.states if is_state else x.coordinates).get(item.name)
        if family is None:  # a momentum
            family, order = x.coordinates[of_made("p_", item.name)], 3
        if not family.has(index):
            what = "state" if is_state else "coordinate"
            raise error(x.model, f"no {what} '{indexed(item.name, index)}'", item.span)
        if not x.graph.is_constant(value):
            message = "an initial value may use parameters and numbers only"
            raise error(x.model, message, item.value.span)
        values[2 if is_state else order][family.flat(index)] = value
    q, v, states, momenta = map(tuple, values)
    if x.model.hamiltonian:
        v = rates_at_start(x, q, momenta, states)
    return q, v, states


def _check_size(model: Model, unrolled: str) -> None:
    found = families(model, (*model.coordinates, *model.states))
    count = sum(family.count for family in found.values())
    if count**2 > limits.UNROLLED and found:
        largest = max(found.values(), key=lambda family: family.count)
        what = "coordinates and states" if model.states else "coordinates"
        message = f"{count:,} {what}: M alone has more than {limits.UNROLLED:,} entries"
        why = f", which cannot stay loops: {unrolled}" if unrolled else ""
        raise error(model, message, largest.span, smaller(model) + why)


def _check_inertia(x: Expander, motion: Motion) -> None:
    model = x.model
    findings: dict[str, Diagnostic] = {}
    for (item, index), row in zip(x.members, motion.mass, strict=True):
        if all(entry == ZERO for entry in row) and item.name not in findings:
            name = indexed(item.name, index)
            message = f"'{name}' has no inertia: L does not contain the square of {name}'"
            help = f"give it a kinetic energy, or make '{item.name}' a param or an input"
            if has_bodies(model):
                help = "what hangs on a joint needs a mass, or an inertia about the joint's axis"
            if item.rate:
                message = (
                    f"'{indexed(item.rate, index)}' has no inertia: L does not contain its square"
                )
                help = "a body has a moment of inertia about each of its axes"
            findings[item.name] = Diagnostic(message, item.span, help)
    if findings:
        raise ModelError(model.source, list(findings.values()))


def _singular(x: Expander, coordinate: int) -> ModelError:
    """Returns the error for a mass matrix that is singular because `coordinate` has no inertia of
    its own. An example is x or y in the kinetic energy (x' + y')^2."""
    item, index = x.members[coordinate]
    name = indexed(item.rate or item.name, index)
    message = f"'{name}' has no inertia of its own: the mass matrix is singular"
    help = "the coordinates can move together without kinetic energy: leave one out"
    return error(x.model, message, item.span, help)


def _events(x: Expander, found: Derived) -> Row:
    """Returns the event functions. To be called after _outputs, since events may use outputs."""
    nodes = []
    for item in x.model.events:
        with x.statement(item.span):
            node = _solved(x, x.scalar(item.value), found, item.span)
            if item.mode:  # a number that does not cross 0 while it cannot happen
                on, idle = (x.input(f"{item.mode}.{end}") for end in ("on", "idle"))
                can = on if item.when else x.graph.subtract(ONE, x.graph.add(on, idle))
                node = x.graph.call("select", can, node, x.graph.number(-item.direction or 1))
            nodes.append(node)
    refuse_constant(x.model, x.graph, nodes)
    return tuple(nodes)


def _generalized_forces(x: Expander) -> list[Node]:
    g, forces = x.graph, [ZERO] * x.count
    for item, index, value in x.members_of(x.model.forces):
        family = x.coordinates[item.name]
        if not family.has(index):
            raise error(x.model, f"no coordinate '{indexed(item.name, index)}'", item.span)
        i = family.flat(index)
        with x.statement(item.span):
            forces[i] = g.add(forces[i], value)
    for item in x.model.loads:
        with x.statement(item.span):
            for _, loop in x.unrolled(item.index, item.range):
                # (d velocity/dv)^T load: the generalized forces of a force at a point or a torque
                load, velocity = x.value(item.value, loop), x.value(item.velocity, loop)
                for component, along in zip(load, velocity, strict=True):
                    for rate, slope in gradient(g, along, RATES).items():
                        i = g.data[rate].index
                        forces[i] = g.add(forces[i], g.multiply(component, slope))
    return forces


# -- outputs -------------------------------------------------------------------------------------

# The fields of Equations for statements that may use names of the motion.
OUTPUTS = ("observed_names", "observed", "conserved_names", "conserved")
OUTPUTS += ("events", "sampled", "sample_times", "held_start")


def _effective(x: Expander, e: Equations, span: Span) -> Node:
    cyclic = cyclic_of(e)
    try:
        return effective_potential(e, cyclic, tuple(e.momenta[i] for i in cyclic))
    except NotReduced as why:
        names = ", ".join(e.coordinates[i].name for i in cyclic)
        raise error(x.model, f"'{NAME}' is not known: {names} stay, for {why}", span) from None


def _outputs(x: Expander, derived: Derived, rates: Mapping[Node, Node]) -> dict[str, tuple]:
    """Returns the fields of Equations for outputs: `observed`, `conserved` and their names."""
    define_built_in(x, derived.energies, derived.energy, derived.motion.momenta)
    define_multipliers(x, derived.constraints)
    x.solved = rates
    found: dict[str, tuple] = {}
    for kind in ("observed", "conserved"):
        names, nodes = [], []
        for item, index, value in x.members_of(getattr(x.model, kind)):
            node = _solved(x, value, derived, item.span)
            x.define(item.name, index, node)
            names.append(Quantity(indexed(item.name, index), item.unit, item.description))
            nodes.append(node)
        found |= {f"{kind}_names": tuple(names), kind: tuple(nodes)}
    return found


def _solved(x: Expander, node: Node, found: Derived, span: Span) -> Node:
    """Returns an output in which accelerations and rates of states are replaced by their
    expressions."""
    g, swap = x.graph, x.solved
    if not g.depends[node] & (BIT[Kind.ACCELERATION] | BIT[Kind.STATE]):
        return node
    with x.statement(span):
        if g.depends[node] & BIT[Kind.ACCELERATION]:
            known = found.solution or solve(g, found.motion.mass, found.motion.force)
            if known is None:
                message = "the accelerations of so many coupled coordinates are no outputs"
                help_ = "they are solved for by a loop; see docs/language.md"
                raise error(x.model, message, span, help_)
            a = symbols(g, Kind.ACCELERATION, len(known.accelerations))
            swap = dict(zip(a, known.accelerations, strict=True)) | swap
        return substituted(g, [node], swap)[0]
