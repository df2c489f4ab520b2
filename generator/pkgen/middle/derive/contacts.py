"""Rows of the constraints that hold at times: contacts, friction that sticks, latches.

The row i of a mode o_i, which is 1 while it holds and else 0, has the multiplier

    o_i (J_i a + gamma_i) + (1 - o_i) lambda_i = 0.

A friction that slips in the direction s has the force -s F along its row w. F may be a linear
function of multipliers, F = F_0 + sum f_j lambda_j: the force of row j is then along
J_j - s f_j w. The matrix of the multipliers is that of constrain.py, without symmetry.
"""

from __future__ import annotations

from collections.abc import Iterable

from ...equations import Constraints, Meeting, Quantity, Rows
from ...graph.differentiate import gradient, symbols_in
from ...graph.graph import BIT, VARIABLE, ZERO, Graph, Kind, Node, Symbol
from ...graph.normal import Normal
from ...graph.substitute import substituted
from ...indices import multiplied, multipliers, parted
from ...model import Contact, Friction, Mode
from ...tree import Expr
from ...tree import names as names_in
from ..expand.expand import Expander
from ..quantities import error, symbols

_PUSHES = BIT[Kind.ACCELERATION]  # symbols of multipliers, behind those of the accelerations


def without_latches(x: Expander, rows: Rows | None) -> tuple[Rows | None, Rows | None]:
    """Returns the rows that always hold, and those of modes, which need not hold at the start."""
    latched = {name for mode in x.model.modes for name in mode.constraints}
    if rows is None or not latched:
        return rows, None
    of = [_declared(q.name) in latched for q in rows.names]
    parts = ([k for k, is_latched in enumerate(of) if is_latched == which] for which in (0, 1))
    always, held = (rows.picked(part) if part else None for part in parts)
    return always, held


def with_meetings(x: Expander, rows: Rows | None, latched: Rows | None) -> Rows | None:
    """Returns the rows that always hold with those of contacts, frictions and modes."""
    model = x.model
    if not model.meets:
        return rows
    parts = [part for part in (rows, latched) if part is not None]
    places = [
        row for c in parts for row in zip(c.names, c.positions, c.residual, c.spans, strict=False)
    ]
    for item in model.contacts:
        with x.statement(item.span):
            gap = x.scalar(item.gap)
            places.append((_quantity(item), gap, x.derivative(gap), item.span))
    of_rates = [
        (q, node, node, span)
        for c in parts
        for q, node, span in [*zip(c.names, c.residual, c.spans, strict=True)][c.holonomic :]
    ]
    for item in model.frictions:
        slip = x.defined[f"{item.name}.slip"][None]
        of_rates.append((_quantity(item), slip, slip, item.span))
    names, nodes, residual, spans = zip(*places, *of_rates, strict=True)
    number = {q.name: k for k, q in enumerate(names)}
    meetings = [_contact(x, item, number) for item in model.contacts]
    meetings += [_friction(x, item, number) for item in model.frictions]
    for mode in model.modes:
        of = [k for name, k in number.items() if _declared(name) in mode.constraints]
        meetings += [_latch(x, mode, k) for k in of]
    given = nodes[: len(places)], residual, spans, rows and rows.redundant
    return Rows(names, len(places), *given, tuple(meetings))


def pushes(x: Expander) -> list[Node]:
    """Returns symbols that stand for the multipliers of the contacts until these are known."""
    count = len(x.model.contacts)
    return [x.graph.symbol(Symbol(Kind.ACCELERATION, x.count + k)) for k in range(count)]


def with_multipliers(x: Expander, c: Constraints, rates: dict[Node, Node]) -> dict[Node, Node]:
    """Returns the rates of states with the multipliers in place of their symbols."""
    known = dict(zip((q.name for q in c.names), c.multipliers, strict=True))
    found = [known[multipliers(item.name)[0]] for item in x.model.contacts]
    swap = dict(zip(pushes(x), found, strict=True))
    return dict(zip(rates, substituted(x.graph, rates.values(), swap), strict=True))


def define_contacts(x: Expander) -> None:
    """Defines the multipliers of contacts by symbols, and the slips of frictions."""
    for item, push in zip(x.model.contacts, pushes(x), strict=True):
        x.define(*parted(multipliers(item.name)[0]), push)
    for item in x.model.frictions:
        with x.statement(item.span):
            slip = _tangent(x, item) if item.slip is None else x.scalar(item.slip)
            x.define(f"{item.name}.slip", None, slip)


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
        flag=item.poisson,
    )


def _friction(x: Expander, item: Friction, number: dict[str, int]) -> Meeting:
    g, known = x.graph, pushes(x)
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
        for push, slope in by.items():
            factor = slope
            of = x.model.contacts[known.index(push)].name
        parts = [_without(g, force), factor]
        if ZERO in parts:  # a bound that varies is not below 0
            varies = [g.depends[part] & VARIABLE for part in parts]
            parts = [g.call("max", ZERO, x) if v else x for x, v in zip(parts, varies, strict=True)]
        bounds += parts
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
        flag=mode.begins,
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
