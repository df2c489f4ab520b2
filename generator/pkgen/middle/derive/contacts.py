"""Rows of the constraints that hold at times: contacts, friction that sticks, latches.

The row i of a mode o_i, which is 1 while it holds and else 0, has the multiplier

    o_i (J_i a + gamma_i) + (1 - o_i) lambda_i = 0.

A friction that slips in the direction s has the force -s F along its row w. F may be a linear
function of multipliers, F = F_0 + sum f_j lambda_j: the force of row j is then along
J_j - s f_j w. The matrix of the multipliers is that of constrain.py, without symmetry.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ...equations import Meeting, Quantity, Rows
from ...graph.differentiate import gradient, symbols_in
from ...graph.graph import BIT, ZERO, Graph, Kind, Node, Symbol
from ...graph.normal import Normal
from ...graph.substitute import substituted
from ...indices import multiplied, multipliers, parted
from ...model import Contact, Friction, Mode
from ...tree import Expr, names as names_in
from ..expand.expand import Expander
from ..quantities import error, symbols

_PUSHES = BIT[Kind.ACCELERATION]  # symbols of multipliers, behind those of the accelerations


def with_meetings(x: Expander, rows: Rows | None) -> Rows | None:
    """Returns the rows that always hold, and those of contacts and frictions; latches are among
    the former."""
    model = x.model
    if not model.meets:
        return rows
    places: list[tuple] = []
    rates: list[tuple] = []
    pushes = [
        x.graph.symbol(Symbol(Kind.ACCELERATION, x.count + k)) for k in range(len(model.contacts))
    ]
    for item, push in zip(model.contacts, pushes, strict=True):
        with x.statement(item.span):
            gap = x.scalar(item.gap)
            places.append((item, gap, x.derivative(gap)))
        x.define(*parted(multipliers(item.name)[0]), push)
    for item in model.frictions:
        with x.statement(item.span):
            slip = _tangent(x, item) if item.slip is None else x.scalar(item.slip)
            x.define(f"{item.name}.slip", None, slip)
            rates.append((item, slip, slip))
    return _joined(x, rows, places, rates, pushes)


def _joined(x: Expander, rows: Rows | None, places: list, rates: list, pushes: list) -> Rows:
    none = Rows((), 0, (), (), ())
    own, h = rows or none, (rows or none).holonomic
    merged = [*zip(own.names[:h], own.positions, own.residual, own.spans, strict=False)]
    merged += [(_quantity(item), node, rate, item.span) for item, node, rate in places]
    holonomic = len(merged)
    free = zip(own.names[h:], own.residual[h:], own.residual[h:], own.spans[h:], strict=True)
    merged += [*free, *((_quantity(item), node, node, item.span) for item, node, _ in rates)]
    names, nodes, residual, spans = zip(*merged, strict=True)
    number = {q.name: k for k, q in enumerate(names)}
    found = [_contact(x, item, number) for item, *_ in places]
    found += [_friction(x, item, number, pushes) for item, *_ in rates]
    for mode in x.model.modes:
        of = [k for name, k in number.items() if _declared(name) in mode.constraints]
        found += [_latch(x, mode, k) for k in of]
    given = nodes[:holonomic], residual, spans, own.redundant
    return Rows(names, holonomic, *given, tuple(found))


def _declared(name: str) -> str:
    """Returns the name of the constraint of a multiplier, lambda_a[2] or lambda_r.x."""
    own, _ = parted(multiplied(name))
    return own[:-2] if own[-2:-1] == "." else own


def _quantity(item: Contact | Friction) -> Quantity:
    return Quantity(multipliers(item.name)[0], item.unit, item.description)


def _contact(x: Expander, item: Contact, number: dict[str, int]) -> Meeting:
    with x.statement(item.span):
        restitution = ZERO if item.restitution is None else x.scalar(item.restitution)
    return Meeting(
        name=item.name,
        kind="CONTACT",
        row=number[multipliers(item.name)[0]],
        mode=x.input(f"{item.name}.on"),
        events=(item.name, f"1{item.name}"),
        bounds=(restitution, ZERO, ZERO, ZERO),
        poisson=item.poisson,
    )


def _friction(
    x: Expander, item: Friction, number: dict[str, int], pushes: Sequence[Node]
) -> Meeting:
    g = x.graph
    with x.statement(item.span):
        slides = x.scalar(item.value)
        sticks = slides if item.static is None else x.scalar(item.static)
    bounds: list[Node] = []
    of = ""
    for force in (slides, sticks):
        by = gradient(g, force, _PUSHES)
        if any(g.depends[slope] & _PUSHES for slope in by.values()) or len(by) > 1:
            message = "a friction is a linear function of one multiplier"
            raise error(x.model, message, item.span, "friction s = mu*lambda_floor")
        factor = ZERO
        for push, factor in by.items():
            of = x.model.contacts[pushes.index(push)].name
        rest = _without(g, force)
        bounds += [rest, factor]
    return Meeting(
        name=item.name,
        kind="FRICTION",
        row=number[multipliers(item.name)[0]],
        mode=x.input(f"{item.name}.on"),
        events=(f"2{item.name}", f"3{item.name}"),
        bounds=tuple(bounds),
        side=x.input(f"{item.name}.side"),
        of=of,
    )


def _latch(x: Expander, mode: Mode, row: int) -> Meeting:
    return Meeting(
        name=mode.name,
        kind="LATCH",
        row=row,
        mode=x.input(f"{mode.name}.on"),
        events=(mode.on, mode.off),
        bounds=(ZERO,) * 4,
    )


def _without(g: Graph, force: Node) -> Node:
    """Returns a force without its terms in multipliers."""
    gone = {g.symbol(s): ZERO for s in symbols_in(g, [force], _PUSHES)}
    return substituted(g, [force], gone)[0]


def _tangent(x: Expander, item: Friction) -> Node:
    """Returns the slip of a contact without `along`: the rate, along the surface, of the place P in
    a plane by which the gap is given, so that dgap/dq = n dP/dq. It is in the scale of the gap: the
    force lambda |n| at P has friction up to mu lambda |n|."""
    contact = next(c for c in x.model.contacts if c.name == item.of)
    g = x.graph
    gap = x.scalar(contact.gap)
    by = gradient(g, gap, BIT[Kind.COORDINATE])
    for place in _places(x, contact.gap):
        if found := _along(g, by, place, x):
            return found
    message = f"along what '{contact.name}' slips is not clear"
    help = "say it: friction mu along s, of a let s = x' - R*theta', or a gap of one place, P.y"
    raise error(x.model, message, contact.span, help)


def _places(x: Expander, gap: Expr) -> Iterable[tuple[Node, ...]]:
    """Yields places that may slip: those in the gap, those that the model names, all coordinates
    of a plane."""
    mine = names_in(gap)
    lets = sorted(x.model.definitions, key=lambda item: item.name not in mine)
    for item in lets:
        for value in x.defined.get(item.name, {}).values():
            if isinstance(value, tuple):
                yield value
    if x.count == 2:
        yield (*symbols(x.graph, Kind.COORDINATE, 2), ZERO)


def _along(g: Graph, by: dict[Node, Node], place: tuple[Node, ...], x: Expander) -> Node | None:
    slopes = [gradient(g, part, BIT[Kind.COORDINATE]) for part in place]
    if sum(bool(slope) for slope in slopes) != 2:
        return None
    a, b = (k for k in range(3) if slopes[k])
    keys = sorted({*slopes[a], *slopes[b], *by})

    def dot(p: dict, q: dict) -> Node:
        return g.sum(g.multiply(p.get(k, ZERO), q.get(k, ZERO)) for k in keys)

    A, B, C = dot(slopes[a], slopes[a]), dot(slopes[b], slopes[b]), dot(slopes[a], slopes[b])
    u, v = dot(slopes[a], by), dot(slopes[b], by)
    determinant = g.subtract(g.multiply(A, B), g.multiply(C, C))
    if determinant == ZERO or Normal(g)(determinant) == {}:
        return None
    n = [
        g.divide(g.subtract(g.multiply(B, u), g.multiply(C, v)), determinant),
        g.divide(g.subtract(g.multiply(A, v), g.multiply(C, u)), determinant),
    ]
    for k in keys:
        sum_ = g.add(
            g.multiply(n[0], slopes[a].get(k, ZERO)), g.multiply(n[1], slopes[b].get(k, ZERO))
        )
        rest = g.subtract(by.get(k, ZERO), sum_)
        if rest != ZERO and Normal(g)(rest) != {}:
            return None
    rates = [x.derivative(place[k]) for k in (a, b)]
    return g.subtract(g.multiply(n[1], rates[0]), g.multiply(n[0], rates[1]))
