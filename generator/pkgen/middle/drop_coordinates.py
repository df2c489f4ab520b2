"""Removes coordinates from equations, for the reductions.

The symbols of removed coordinates are replaced by expressions, and the remaining coordinates are
renumbered. Afterwards lagrange.derived_again() has to derive the equations of motion again.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

from ..equations import Attitude, Constraints, Equations, ParameterSlot, Quantity, Rows
from ..graph.graph import BIT, ZERO, Graph, Kind, Node, Symbol
from ..graph.substitute import substituted
from ..model import Coordinate, Model, State
from .quantities import families, indexed, symbols

# The key of an initial value: the coordinate's name, and 0 for the coordinate or 1 for its rate.
Start = tuple[str, int]


def smaller(
    e: Equations,
    kept: Sequence[int],
    swap: Mapping[Node, Node],
    kept_states: Sequence[int] | None = None,
) -> Equations:
    """Returns equations with the coordinates `kept` and the states `kept_states` (None: all) only.
    Their motion has to be derived again. `swap` maps symbols of removed coordinates and states to
    expressions in the symbols of `e`, before renumbering."""
    g, count, states = e.graph, len(e.coordinates), len(e.states)
    of_states = range(states) if kept_states is None else kept_states
    rates, numbers = ({old: new for new, old in enumerate(row)} for row in (kept, of_states))
    renumbered = {
        old: new
        for kind, many, which in (
            (Kind.COORDINATE, count, kept),
            (Kind.RATE, count, kept),
            (Kind.STATE, states, of_states),
        )
        for old, new in zip(
            (symbols(g, kind, many)[i] for i in which), symbols(g, kind, len(which)), strict=True
        )
    }

    def there(nodes: Iterable[Node]) -> tuple[Node, ...]:
        return tuple(substituted(g, substituted(g, nodes, swap), renumbered))

    def pick(row: Sequence) -> tuple:
        return tuple(row[i] for i in kept)

    energies = {x: getattr(e, x) for x in ("lagrangian", "kinetic", "potential")}
    energies = {x: node for x, node in energies.items() if node is not None}
    picked = ("coordinates", "rates", "momenta_names", "start_q", "start_v")
    found = replace(
        e,
        **dict(zip(energies, there(energies.values()), strict=True)),
        **{x: pick(getattr(e, x)) for x in picked},
        **{x: there(getattr(e, x)) for x in ("observed", "conserved", "events", "sampled")},
        resets=tuple(map(there, e.resets)),
        applied=there(pick(e.applied)),
        states=tuple(e.states[i] for i in of_states),
        state_rates=there(e.state_rates[i] for i in of_states),
        state_start=tuple(e.state_start[i] for i in of_states),
        attitudes=tuple(
            Attitude(rates[a.rate], numbers.get(a.state, -1))  # -1: the quaternion is removed
            for a in e.attitudes
            if a.rate in rates
        ),
        constraints=e.constraints and _fewer(g, e.constraints, there, pick),
    )
    model = replace(
        e.model,
        coordinates=_left(e.model, e.model.coordinates, found.coordinates),
        states=_left(e.model, e.model.states, found.states),
    )
    return replace(found, model=model)


def without(e: Equations, gone: Collection[int]) -> Equations:
    """Returns equations in which the coordinates and states `gone` keep their initial values.
    States are numbered after the coordinates."""
    g, n = e.graph, len(e.coordinates)
    q, v = symbols(g, Kind.COORDINATE, n), symbols(g, Kind.RATE, n)
    places = (*q, *symbols(g, Kind.STATE, len(e.states)))
    starts = (*e.start_q, *e.state_start)
    swap = {places[i]: starts[i] for i in gone} | {v[i]: ZERO for i in gone if i < n}
    left = [i for i in range(len(places)) if i not in gone]
    kept, states = [i for i in left if i < n], [i - n for i in left if i >= n]
    return smaller(e, kept, swap, states)


def _fewer(g: Graph, c: Constraints, there, pick) -> Constraints | None:
    """Returns the constraints without the rows that contain no rate after the removal of
    coordinates. Returns None if all rows are left out. The fields that are computed from the rows
    keep their old values, since the constraints are derived again later."""
    own = _moving(g, c, there)
    redundant = c.redundant and _moving(g, c.redundant, there)
    return own and replace(own, redundant=redundant, free_applied=there(pick(c.free_applied)))


def _moving(g: Graph, rows: Rows, there) -> Rows | None:
    residual = there(rows.residual)
    left = [k for k, node in enumerate(residual) if g.depends[node] & BIT[Kind.RATE]]
    if not left:
        return None
    return replace(rows, positions=there(rows.positions), residual=residual).picked(left)


def _left(
    model: Model, declared: tuple[Coordinate | State, ...], kept: Iterable[Quantity]
) -> tuple[Coordinate | State, ...]:
    """Returns the declarations of the remaining coordinates or states. If a family has lost
    members, its remaining members are declared one by one."""
    left = {quantity.name for quantity in kept}
    found: list[Coordinate | State] = []
    all_families = families(model, declared)
    for item in declared:
        names = [indexed(item.name, index) for index in all_families[item.name].members]
        if left.issuperset(names):
            found.append(item)
        else:
            found += [replace(item, name=name, range=None) for name in names if name in left]
    return tuple(found)


class StartParameters:
    """Adds parameters for initial values, so that constants of the motion can depend on them."""

    def __init__(self, equations: Equations):
        self.equations = equations
        self.slots = list(equations.parameters)
        self.starts: dict[Start, str] = {}
        self.node: dict[Symbol, Node] = {}
        self.taken = {slot.quantity.name for slot in self.slots}

    def of(self, symbol: Symbol) -> Node:
        """Returns a new parameter for the initial value of a coordinate or a rate."""
        rate = symbol.kind is Kind.RATE
        e, i = self.equations, symbol.index
        named = e.rates[i] if rate else e.coordinates[i]
        wish = re.sub(r"\W+", "_", f"start_{e.coordinates[i].name}").strip("_")
        name = self._free(wish + ("_dot" if rate else ""))
        self.starts[e.coordinates[i].name, int(rate)] = name
        says = f"start of {named.name}"
        default = (e.start_v if rate else e.start_q)[i]
        self.node[symbol] = self.add(Quantity(name, named.unit, says), default)
        return self.node[symbol]

    def add(self, quantity: Quantity, default: Node) -> Node:
        g = self.equations.graph
        follows = bool(g.depends[default] & BIT[Kind.PARAMETER])
        slot = ParameterSlot(
            quantity, quantity.name, 0, 0, default, follows, None, None, True, True
        )
        self.slots.append(slot)
        return g.symbol(Symbol(Kind.PARAMETER, len(self.slots) - 1))

    def _free(self, name: str) -> str:
        while name in self.taken:
            name += "_"
        self.taken.add(name)
        return name
