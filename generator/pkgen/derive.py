"""Model -> Equations: Lagrange's equations on the expression graph.

One reverse sweep over L gives p = dL/dv and dL/dq; one sparse forward sweep a rate gives a column
of M = dp/dv; one forward product gives (dp/dq) v + dp/dt. So f costs O(N) beyond L and M O(N^2).
"""

from __future__ import annotations

from dataclasses import dataclass

from . import limits
from .collect import THOROUGH, fewest, forms, settled
from .count import operations
from .differentiate import Columns, Forward, gradient, reachable
from .equations import Equations, Matrix, ParameterSlot, Quantity, Row
from .expand import Expander, NeedsDerivative
from .graph import BIT, VARIABLE, ZERO, Graph, Kind, Node
from .model import Model, Parameter
from .quantities import (
    error,
    families,
    indexed,
    input_quantities,
    quantities,
    symbols,
)
from .solve import Solution, solve
from .source import Diagnostic, ModelError

RATES = BIT[Kind.RATE]
STATE = BIT[Kind.COORDINATE] | RATES


def derive(model: Model, kernels: frozenset[str] | None = None) -> Equations:
    """The equations of motion; of the kernels not in `kernels` (None: all) the costly are skipped.

    An input grows a derivative whenever the equations turn out to need one.
    """
    _check_size(model)
    orders = [item.order for item in model.inputs]
    while True:
        try:
            return _derive(model, kernels, tuple(orders))
        except NeedsDerivative as needed:
            orders[needed.position] += 1


def _derive(model: Model, kernels: frozenset[str] | None, orders: tuple[int, ...]) -> Equations:
    x = Expander(model, orders)
    energies = _energies(x)
    with x.statement(model.span):
        wanted = _Wanted(kernels)
        raw = _motion(x, energies)
        _check_inertia(x, raw)
        motion, solution = _settled(x, raw, wanted)
        _check_inertia(x, motion)
        jacobians: tuple[Matrix | None, ...] = (None, None, None)
        if wanted("jacobian"):
            jacobians = _jacobians(x.graph, motion)
        energy = _energy(x.graph, energies, motion, wanted)
    outputs = _outputs(x, energies, motion, energy)
    parameters = _parameters(x)
    start_q, start_v = _starts(x)
    names = x.coordinates
    declared = model.coordinates
    return Equations(
        model=model,
        graph=x.graph,
        parameters=parameters,
        coordinates=quantities(declared, names, "{}", "unit"),
        rates=quantities(declared, names, "{}'", "rate_unit"),
        momenta_names=quantities(declared, names, "p_{}", "momentum_unit"),
        inputs=input_quantities(model, orders),
        observed_names=outputs.observed_names,
        conserved_names=outputs.conserved_names,
        lagrangian=energies.lagrangian,
        kinetic=energies.kinetic,
        potential=energies.potential,
        energy=energy,
        momenta=motion.momenta,
        gradient=motion.gradient,
        applied=motion.applied,
        pdot=motion.pdot,
        mass=motion.mass,
        force=motion.force,
        acceleration=solution[0] if solution else None,
        pivots=solution[1] if solution else None,
        p_q=jacobians[0],
        pdot_q=jacobians[1],
        pdot_v=jacobians[2],
        observed=outputs.observed,
        conserved=outputs.conserved,
        start_q=start_q,
        start_v=start_v,
    )


# -- the statements ------------------------------------------------------------------------------


class _Wanted:
    """Whether any of some kernels is asked for."""

    def __init__(self, kernels: frozenset[str] | None):
        self.kernels = kernels

    def __call__(self, *names: str) -> bool:
        return self.kernels is None or not self.kernels.isdisjoint(names)


@dataclass(frozen=True)
class _Energies:
    lagrangian: Node
    kinetic: Node | None
    potential: Node | None
    dissipation: Node


def _energies(x: Expander) -> _Energies:
    model, g = x.model, x.graph
    for item in model.definitions:
        with x.statement(item.span):
            for index, loop in x.unrolled(item.index, item.range):
                x.define(item.name, index, x.value(item.value, loop))
    totals: dict[str, Node] = {}
    for kind in ("kinetic", "potential", "lagrangian", "dissipation"):
        totals[kind] = ZERO
        for expr in getattr(model, kind):
            with x.statement(expr.span):
                totals[kind] = g.add(totals[kind], x.scalar(expr))
    kinetic, potential = totals["kinetic"], totals["potential"]
    with x.statement(model.span):
        whole = g.add(g.subtract(kinetic, potential), totals["lagrangian"])
    stated = bool(model.lagrangian)
    return _Energies(
        lagrangian=whole,
        kinetic=None if stated else kinetic,
        potential=None if stated else potential,
        dissipation=totals["dissipation"],
    )


def _generalized_forces(x: Expander, count: int) -> list[Node]:
    forces = [ZERO] * count
    for item in x.model.forces:
        with x.statement(item.span):
            for index, loop in x.unrolled(item.index, item.range):
                family = x.coordinates[item.name]
                if not family.has(index):
                    raise error(x.model, f"no coordinate '{indexed(item.name, index)}'", item.span)
                i = family.flat(index)
                forces[i] = x.graph.add(forces[i], x.scalar(item.value, loop))
    return forces


def _parameters(x: Expander) -> tuple[ParameterSlot, ...]:
    return tuple(slot for item in x.model.parameters for slot in _slots(x, item))


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


def _starts(x: Expander) -> tuple[Row, Row]:
    count = _count(x)
    values = ([ZERO] * count, [ZERO] * count)
    for item in x.model.starts:
        with x.statement(item.span):
            for index, loop in x.unrolled(item.index, item.range):
                family = x.coordinates[item.name]
                if not family.has(index):
                    raise error(x.model, f"no coordinate '{indexed(item.name, index)}'", item.span)
                value = x.scalar(item.value, loop)
                if not x.graph.is_constant(value):
                    message = "an initial value may use parameters and numbers only"
                    raise error(x.model, message, item.value.span)
                values[item.order][family.flat(index)] = value
    return tuple(values[0]), tuple(values[1])


def _count(x: Expander) -> int:
    return sum(len(family.members) for family in x.coordinates.values())


# -- the equations -------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Motion:
    momenta: Row
    gradient: Row
    applied: Row
    pdot: Row
    mass: Matrix
    force: Row


def _motion(x: Expander, energies: _Energies) -> _Motion:
    g = x.graph
    count = _count(x)
    q, v = symbols(g, Kind.COORDINATE, count), symbols(g, Kind.RATE, count)
    by = gradient(g, energies.lagrangian, STATE)
    momenta = tuple(by.get(rate, ZERO) for rate in v)
    slope = tuple(by.get(coordinate, ZERO) for coordinate in q)
    drag = gradient(g, energies.dissipation, RATES)
    forces = _generalized_forces(x, count)
    applied = tuple(g.subtract(f, drag.get(rate, ZERO)) for f, rate in zip(forces, v))
    pdot = tuple(map(g.add, slope, applied))
    mass = _mass(g, momenta, v)
    coasting = Forward(g, VARIABLE, lambda node: _coast(x, node))
    force = tuple(g.subtract(there, coasting(p)) for there, p in zip(pdot, momenta))
    return _Motion(momenta, slope, applied, pdot, mass, force)


def _coast(x: Expander, node: Node) -> Node:
    """The time derivative of a symbol where nothing accelerates."""
    if x.graph.data[node].kind is Kind.RATE:
        return ZERO
    return x.derivative(node)


def _mass(g: Graph, momenta: Row, v: Row) -> Matrix:
    """M is symmetric: the triangle j >= i is derived and mirrored."""
    n = len(v)
    rows: list[list[Node]] = [[ZERO] * n for _ in range(n)]
    columns = Columns(g, momenta, RATES)
    for j, rate in enumerate(v):
        column = columns.column(rate)
        for i in range(j + 1):
            rows[i][j] = rows[j][i] = column.get(momenta[i], ZERO)
    return tuple(map(tuple, rows))


def _settled(x: Expander, motion: _Motion, wanted: _Wanted) -> tuple[_Motion, Solution | None]:
    """The same in the form of fewest operations, with M a = f solved if that is wanted."""
    g = x.graph
    n = len(motion.force)
    triangle = [motion.mass[i][j] for i in range(n) for j in range(i, n)]
    outputs = [*triangle, *motion.force]
    canonical = [*motion.momenta, *motion.pdot]
    thorough = len(reachable(g, outputs + canonical)) <= THOROUGH
    slope = list(motion.gradient)
    outputs = settled(g, outputs[:-n]) + (settled(g, outputs[-n:]) if thorough else outputs[-n:])
    if thorough:
        if wanted("canonical", "momenta", "jacobian"):
            canonical = fewest(g, settled(g, canonical))
        if wanted("gradient"):
            slope = fewest(g, settled(g, slope))
    found = []
    for form in forms(g, outputs, thorough):
        mass, force = _symmetric(form, n), tuple(form[-n:])
        solution = solve(g, mass, force) if wanted("acceleration") else None
        cost = operations(g, [*form, *(solution[0] if solution else ())])
        found.append((cost, len(found), mass, force, solution))
    _, _, mass, force, solution = min(found)
    if solution is not None and thorough:
        shorter = fewest(g, [*solution[0], *solution[1]], thorough=False)
        solution = tuple(shorter[:n]), tuple(shorter[n:])
    return _Motion(
        momenta=tuple(canonical[:n]),
        gradient=tuple(slope),
        applied=motion.applied,
        pdot=tuple(canonical[n:]),
        mass=mass,
        force=force,
    ), solution


def _symmetric(triangle: list[Node], n: int) -> Matrix:
    rows = [[ZERO] * n for _ in range(n)]
    entries = iter(triangle)
    for i in range(n):
        for j in range(i, n):
            rows[i][j] = rows[j][i] = next(entries)
    return tuple(map(tuple, rows))


def _jacobians(g: Graph, motion: _Motion) -> tuple[Matrix, Matrix, Matrix]:
    n = len(motion.momenta)
    q, v = symbols(g, Kind.COORDINATE, n), symbols(g, Kind.RATE, n)
    p_q = _matrix(g, motion.momenta, q, BIT[Kind.COORDINATE])
    pdot_q = _matrix(g, motion.pdot, q, BIT[Kind.COORDINATE])
    pdot_v = _matrix(g, motion.pdot, v, RATES)
    entries = [entry for matrix in (p_q, pdot_q, pdot_v) for row in matrix for entry in row]
    if len(reachable(g, entries)) > THOROUGH:
        return p_q, pdot_q, pdot_v
    found = fewest(g, settled(g, entries))
    rows = [tuple(found[i : i + n]) for i in range(0, len(found), n)]
    return tuple(rows[:n]), tuple(rows[n : 2 * n]), tuple(rows[2 * n :])


def _matrix(g: Graph, rows: Row, by: Row, mask: int) -> Matrix:
    columns = Columns(g, rows, mask)
    found = [columns.column(symbol) for symbol in by]
    return tuple(tuple(column.get(row, ZERO) for column in found) for row in rows)


def _energy(g: Graph, energies: _Energies, motion: _Motion, wanted: _Wanted) -> Node:
    """v.p - L, in the cheapest form found; T + V where T is homogeneous of degree 2."""
    kinetic, potential = energies.kinetic, energies.potential
    candidates = []
    if kinetic is not None and degree(g, kinetic) == 2 and not g.depends[potential] & RATES:
        candidates.append(g.add(kinetic, potential))
    v = symbols(g, Kind.RATE, len(motion.momenta))
    work = g.sum(map(g.multiply, v, motion.momenta))
    candidates.append(g.subtract(work, energies.lagrangian))
    if wanted("energy") and len(reachable(g, candidates)) <= THOROUGH:
        candidates += [form for node in candidates for (form,) in forms(g, [node])]
    return min(candidates, key=lambda node: operations(g, [node]))


def degree(g: Graph, output: Node) -> int | None:
    """The degree in the rates of a homogeneous expression; None where it is not seen to be."""
    found: dict[Node, int | None] = {}
    stack = [output]
    while stack:
        node = stack[-1]
        missing = [a for a in g.args[node] if a not in found and g.depends[a] & RATES]
        if missing:
            stack.extend(missing)
            continue
        stack.pop()
        if node not in found:
            found[node] = _degree_of(g, node, [found.get(a, 0) for a in g.args[node]])
    return found[output]


def _degree_of(g: Graph, node: Node, below: list[int | None]) -> int | None:
    if not g.depends[node] & RATES:
        return 0
    if None in below:
        return None
    name = g.op[node].name
    if name == "SYMBOL":
        return 1
    if name == "ADD":
        return below[0] if below[0] == below[1] else None
    if name == "MULTIPLY":
        return below[0] + below[1]
    if name == "POWER":
        power = g.data[node] * below[0]
        return int(power) if power.denominator == 1 and power >= 0 else None
    return None


def _check_size(model: Model) -> None:
    found = families(model, model.coordinates)
    count = sum(len(family.members) for family in found.values())
    if count**2 > limits.UNROLLED and found:
        largest = max(found.values(), key=lambda family: len(family.members))
        message = f"{count:,} coordinates: M alone has more than {limits.UNROLLED:,} entries"
        raise error(model, message, largest.span, "make its families smaller")


def _check_inertia(x: Expander, motion: _Motion) -> None:
    findings = []
    for item in x.model.coordinates:
        family = x.coordinates[item.name]
        for index in family.members:
            row = motion.mass[family.flat(index)]
            if all(entry == ZERO for entry in row):
                name = indexed(item.name, index)
                message = f"'{name}' has no inertia: L does not contain the square of {name}'"
                help = f"give it a kinetic energy, or make '{item.name}' a param or an input"
                findings.append(Diagnostic(message, item.span, help))
                break
    if findings:
        raise ModelError(x.model.source, findings)


# -- outputs -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Outputs:
    observed_names: tuple[Quantity, ...]
    conserved_names: tuple[Quantity, ...]
    observed: Row
    conserved: Row


def _outputs(x: Expander, energies: _Energies, motion: _Motion, energy: Node) -> _Outputs:
    built_in = {"T": energies.kinetic, "V": energies.potential}
    built_in |= {"L": energies.lagrangian, "energy": energy}
    for name, node in built_in.items():
        if node is not None and name not in x.defined:
            x.define(name, None, node)
    for family in x.coordinates.values():
        for index in family.members:
            x.define("p_" + family.name, index, motion.momenta[family.flat(index)])
    found: dict[str, tuple[list[Quantity], list[Node]]] = {}
    for kind in ("observed", "conserved"):
        names, nodes = found[kind] = [], []
        for item in getattr(x.model, kind):
            with x.statement(item.span):
                for index, loop in x.unrolled(item.index, item.range):
                    node = x.scalar(item.value, loop)
                    x.define(item.name, index, node)
                    names.append(Quantity(indexed(item.name, index), item.unit, item.description))
                    nodes.append(node)
    return _Outputs(
        observed_names=tuple(found["observed"][0]),
        conserved_names=tuple(found["conserved"][0]),
        observed=tuple(found["observed"][1]),
        conserved=tuple(found["conserved"][1]),
    )

