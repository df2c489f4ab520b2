"""Model -> LoopEquations: Lagrange's equations with families as loops, or Unrolled with a reason."""

from __future__ import annotations

from collections.abc import Iterable

from .. import limits
from ..functions import FUNCTIONS
from ..model import Definition, Model
from ..source import Diagnostic, ModelError
from .affine import LOOPS, ROW, Affine, variable
from .differentiate import reachable
from .expand import NeedsDerivative
from .graph import BIT, CONSTANT, ZERO, Kind, Node, Op
from .loops import (
    Assigned,
    Band,
    Bounded,
    Facts,
    Limit,
    LoopEquations,
    Part,
    Row,
    Total,
    Unrolled,
    Vector,
)
from .loops_expand import LoopExpander, size_values
from .loops_rows import RATES, Gather, Gathered, slots_of
from .loops_terms import Term, terms
from .quantities import error, indexed

TIME_OR_INPUT = BIT[Kind.TIME] | BIT[Kind.INPUT]


def derive_loops(model: Model) -> LoopEquations:
    """The equations of motion with every family kept as a loop. Raises Unrolled."""
    sized = set(size_values(model))
    orders = [item.order for item in model.inputs]
    while True:
        try:
            x = LoopExpander(model, tuple(orders))
            if not any(
                group.is_family and {n for n, _ in group.count.terms} & sized
                for group in x.coordinates.values()
            ):
                raise Unrolled("no family of coordinates has a length that depends on a size")
            return _derive(x)
        except NeedsDerivative as needed:
            item = model.inputs[needed.position]
            orders[needed.position] += 1
            if orders[needed.position] > limits.DEPTH:
                raise error(model, f"too many derivatives of '{item.name}'", item.span) from None


def _derive(x: LoopExpander) -> LoopEquations:
    model, gather = x.model, Gather(x)
    found: dict[str, list[tuple[Term, int]]] = {}
    for kind, sign in (("kinetic", 1), ("potential", -1), ("lagrangian", 1)):
        found[kind] = []
        for expr in getattr(model, kind):
            with x.statement(expr.span):
                for term in terms(x, expr):
                    gather.lagrangian(term, sign)
                    found[kind].append((term, 1))
    for expr in model.dissipation:
        with x.statement(expr.span):
            for term in terms(x, expr):
                gather.dissipation(term)
    _forces(x, gather)
    stated = bool(model.lagrangian)
    negative = [(term, -1) for term, _ in found["potential"]]
    whole = [*found["kinetic"], *negative, *found["lagrangian"]]
    energy = Total()
    for term, sign in whole:
        if len(term.ranges) == 2:
            opposite = gather.total([(term, -sign)])
            energy = Total(energy.constant, energy.parts, (*energy.pairs, *opposite.pairs))
        else:
            energy = gather.with_energy(energy, term, sign)
    kinetic = None if stated else gather.total(found["kinetic"])
    potential = None if stated else gather.total(found["potential"])
    lagrangian = gather.total(whole)
    vectors = {
        what: _vector(x, gather.found, what) for what in ("gradient", "momenta", "pdot", "force")
    }
    mass = _band(gather.found)
    _check_inertia(x, mass)
    outputs = _Outputs(x, gather, kinetic, potential, lagrangian, energy, vectors["momenta"])
    observed = outputs.nodes(model.observed)
    conserved = outputs.nodes(model.conserved)
    starts = _starts(x, gather)
    defaults = _defaults(x, gather)
    result = LoopEquations(
        model=model,
        graph=x.graph,
        slots=(),
        coordinates=tuple(x.coordinates.values()),
        parameters=tuple(x.parameters.values()),
        orders=x.orders,
        gradient=vectors["gradient"],
        momenta=vectors["momenta"],
        pdot=vectors["pdot"],
        force=vectors["force"],
        mass=mass,
        kinetic=kinetic,
        potential=potential,
        lagrangian=lagrangian,
        energy=energy,
        sums=tuple(outputs.totals),
        observed=observed,
        conserved=conserved,
        given=_given(x, gather),
        defaults=defaults,
        bounds=_bounds(x),
        starts=starts,
        limits=_limits(x, gather.found.limits),
        wraps=gather.found.wraps,
    )
    _check_points(x, result)
    values = vars(result) | {"slots": tuple(x.slots), "facts": _facts(x, gather, result)}
    return LoopEquations(**values)


def _forces(x: LoopExpander, gather: Gather) -> None:
    for item in x.model.forces:
        with x.statement(item.span):
            lo = hi = None
            loop = dict(x.sizes)
            if item.range is not None:
                lo, hi = x.index(item.range.lo, loop), x.index(item.range.hi, loop)
                loop[item.range.variable] = variable(ROW)
            elif item.index is not None:
                lo = hi = x.index(item.index, loop)
            node = x.scalar(item.value, loop)
            at = {} if lo is None else {ROW: (lo, hi)}
            gather.found.limits += x.limits_of(None if lo is None else hi - lo, at)
            if lo is not None:
                group = x.coordinates[item.name]
                gather.found.limits += [
                    Limit(lo - group.lo, hi - lo), Limit(group.hi - hi, hi - lo)
                ]
            gather.force(item.name, lo, hi, node)


def _vector(x: LoopExpander, found: Gathered, what: str) -> Vector:
    rows = getattr(found, what)
    pairs = list(found.pairs) if what in ("gradient", "pdot", "force") else []
    pairs += found.drags if what in ("pdot", "force") else []
    return Vector(
        rows={g.name: Row(tuple(rows[g.name])) for g in x.coordinates.values() if g.is_family},
        totals={
            g.name: found.of_scalar.get((what, g.name), Total())
            for g in x.coordinates.values()
            if not g.is_family
        },
        pairs=tuple(pairs),
    )


def _band(found: Gathered) -> Band:
    return Band(
        {key: Row(tuple(parts)) for key, parts in found.entries.items() if parts},
        {key: Row(tuple(parts)) for key, parts in found.border.items() if parts},
        dict(found.corner),
    )


def _check_inertia(x: LoopExpander, mass: Band) -> None:
    findings = []
    for group in x.coordinates.values():
        name = group.name
        there = (
            (name, name, 0) in mass.entries if group.is_family else (name, name) in mass.corner
        )
        if not there:
            shown = indexed(name, None) + ("[i]" if group.is_family else "")
            message = f"'{shown}' has no inertia: L does not contain the square of {shown}'"
            help = f"give it a kinetic energy, or make '{name}' a param or an input"
            findings.append(Diagnostic(message, group.declared.span, help))
    if findings:
        raise ModelError(x.model.source, findings)


class _Outputs:
    """`observe` and `conserve`: expressions in which sums are values computed before."""

    def __init__(self, x, gather, kinetic, potential, lagrangian, energy, momenta):
        self.x, self.gather = x, gather
        self.totals: list[Total] = []
        x.sums = self.totals
        x.make_total = self._total
        named = {"T": kinetic, "V": potential, "L": lagrangian, "energy": energy}
        named |= {"p_" + name: total for name, total in momenta.totals.items()}
        used = {name for item in (*x.model.observed, *x.model.conserved) for name in _names(item)}
        for name, total in named.items():
            if total is not None and name in used:
                self.totals.append(total)
                x.outputs[name] = x.slot("sum", str(len(self.totals) - 1))

    def _total(self, expr) -> Total:
        return self.gather.total([(term, 1) for term in terms(self.x, expr)])

    def nodes(self, items: tuple[Definition, ...]) -> tuple[Node, ...]:
        found = []
        for item in items:
            with self.x.statement(item.span):
                if item.range is not None or item.index is not None:
                    raise Unrolled(f"'{item.name}' is an output for each index")
                node = self.x.scalar(item.value)
                for slot in slots_of(self.x, [node]):
                    self.gather.found.limits += self.x.limits_of(None, {})
                    assert slot.at is None or not any(slot.at.factor(v) for v in LOOPS)
                self.x.outputs[item.name] = node
                found.append(node)
        return tuple(found)


def _names(item: Definition) -> Iterable[str]:
    from ..tree import Name, children

    waiting = [item.value]
    while waiting:
        expr = waiting.pop()
        waiting.extend(children(expr))
        if isinstance(expr, Name):
            yield expr.id


def _starts(x: LoopExpander, gather: Gather) -> tuple[Assigned, ...]:
    found = []
    for item in x.model.starts:
        with x.statement(item.span):
            lo = hi = None
            loop = dict(x.sizes)
            if item.range is not None:
                lo, hi = x.index(item.range.lo, loop), x.index(item.range.hi, loop)
                loop[item.range.variable] = variable(ROW)
            elif item.index is not None:
                lo = hi = x.index(item.index, loop)
            node = x.scalar(item.value, loop)
            bad = [s for s in slots_of(x, [node]) if s.kind in ("q", "v", "input", "sum")]
            if bad or x.graph.depends[node] & BIT[Kind.TIME]:
                message = "an initial value may use parameters and numbers only"
                raise error(x.model, message, item.value.span)
            group = x.coordinates[item.name]
            if lo is not None:
                x.members.append((group.lo, group.hi, lo, item.span))
                x.members.append((group.lo, group.hi, hi, item.span))
            at = {} if lo is None else {ROW: (lo, hi)}
            gather.found.limits += x.limits_of(None if lo is None else hi - lo, at)
            found.append(Assigned(item.name, item.order, lo, hi, node))
    return tuple(found)


def _defaults(x: LoopExpander, gather: Gather) -> tuple[Assigned, ...]:
    found = []
    for group in x.parameters.values():
        item = group.declared
        with x.statement(item.span):
            loop = dict(x.sizes)
            if group.is_family:
                loop[item.range.variable] = variable(ROW)
            node = x.scalar(item.default, loop)
            at = {ROW: (group.lo, group.hi)} if group.is_family else {}
            gather.found.limits += x.limits_of(None, at)
            found.append(Assigned(group.name, 0, group.lo, group.hi, node))
    return tuple(found)


def _bounds(x: LoopExpander) -> tuple[Bounded, ...]:
    found = []
    for group in x.parameters.values():
        item = group.declared
        loop = dict(x.sizes)
        if group.is_family:
            loop[item.range.variable] = variable(ROW)
        ends = [
            None if end is None else x.scalar(end, loop)
            for end in (item.bounds.lo, item.bounds.hi)
        ]
        found.append(Bounded(*ends))
    x.members.clear()
    return tuple(found)


def _given(x: LoopExpander, gather: Gather) -> dict[tuple[str, Affine], tuple[Node, Node, Node]]:
    """Values of fixed ends, with the derivatives that rows at the ends may ask for."""
    far = {slot.name for slot in x.slots if slot.kind in ("v", "d", "w") and slot.at is not None
           and slot.at != variable(ROW)}
    found = {}
    for group in x.coordinates.values():
        for at, end in group.ends:
            if end.kind != "fixed":
                continue
            with x.statement(end.span):
                value = x.scalar(end.value)
                rate = x.derivative(value) if group.name in far else ZERO
                needed = any(s.kind == "w" and s.name == group.name for s in x.slots)
                found[group.name, at] = (value, rate, x.derivative(rate) if needed else ZERO)
    return found


def _limits(x: LoopExpander, found: list[Limit]) -> tuple[Limit, ...]:
    """What a size must fulfil, as far as it is not plain; families have a member at least."""
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


# -- facts ---------------------------------------------------------------------------------------


def _check_points(x: LoopExpander, result: LoopEquations) -> None:
    """A term about one member is kept out of the interior, so it must be near an end."""
    rows = [(name, row) for name, row in result.force.rows.items()]
    rows += [(key[0], row) for key, row in result.mass.entries.items()]
    for name, row in rows:
        group = x.coordinates[name]
        for part in row.parts:
            near = (part.hi - group.lo).is_constant or (group.hi - part.lo).is_constant
            if part.is_point and not near:
                raise Unrolled(f"a term is about {name}[{part.lo.text()}], far from the ends")


def _facts(x: LoopExpander, gather: Gather, e: LoopEquations) -> Facts:
    entries = [part.node for row in (*e.mass.entries.values(), *e.mass.border.values())
               for part in row.parts]
    entries += _total_nodes(e.mass.corner.values())
    forces = [*_vector_nodes(e.force)]
    energies = _total_nodes([e.lagrangian])
    applied = bool(x.model.forces or x.model.dissipation)
    constant = not _kinds(x, entries) & {"q", "v", "t", "input", "w"}
    steady = not (_kinds(x, energies + forces) & {"t", "input"}) and not gather.moving
    smooth = all(
        FUNCTIONS[x.graph.data[node]].smooth
        for node in reachable(x.graph, [*energies, *forces])
        if x.graph.op[node] is Op.CALL
    )
    jumps = any(
        x.graph.op[node] is Op.CALL and x.graph.data[node] in ("step", "sign")
        for node in reachable(x.graph, energies)
    )
    return Facts(
        mass_constant=constant,
        mass_diagonal=e.mass.is_diagonal,
        quadratic="v" not in _kinds(x, entries),
        separable=constant and "v" not in _kinds(x, forces),
        autonomous=steady,
        conservative=not applied and steady and not jumps,
        variational=not applied,
        smooth=smooth,
    )


def _kinds(x: LoopExpander, nodes: list[Node]) -> set[str]:
    found = {slot.kind for slot in slots_of(x, nodes)}
    if any(x.graph.depends[node] & BIT[Kind.TIME] for node in nodes):
        found.add("t")
    return found


def _total_nodes(totals: Iterable[Total]) -> list[Node]:
    found = []
    for total in totals:
        found += [total.constant, *(p.node for p in total.parts), *(p.node for p in total.pairs)]
    return found


def _vector_nodes(vector: Vector) -> list[Node]:
    found = [part.node for row in vector.rows.values() for part in row.parts]
    found += _total_nodes(vector.totals.values())
    for pair in vector.pairs:
        found += [node for side in (pair.by_row, pair.by_other, pair.by_scalar)
                  for _, node in side]
    return found


__all__ = ["CONSTANT", "RATES", "Part", "derive_loops"]
