"""Removes coordinates from equations, for the reductions.

The symbols of removed coordinates are replaced by expressions, and the remaining coordinates are
renumbered. Afterwards lagrange.derived_again() has to derive the equations of motion again.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from ..equations import Attitude, Constraints, Equations, ParameterSlot, Quantity, Rows
from ..graph.graph import BIT, Graph, Kind, Node, Symbol
from ..graph.substitute import substituted
from ..model import Coordinate, Model, State
from ..record import record
from .quantities import families, indexed, symbols

# The key of an initial value: the coordinate's name, and 0 for the coordinate or 1 for its rate.
Start = tuple[str, int]


@record
class Output:
    """A former coordinate or rate, which is computed from the remaining coordinates."""

    quantity: Quantity
    node: Node


def smaller(
    equations: Equations,
    kept: Sequence[int],
    swap: Mapping[Node, Node],
    lagrangian: Node,
    parts: tuple[Node | None, Node | None],
    outputs: Iterable[Output] = (),
    angles: Mapping[int, tuple[Node, Node]] | None = None,
    kept_states: Sequence[int] | None = None,
) -> Equations:
    """Returns equations with the coordinates `kept` only. Their motion has to be derived again.

    `swap` maps symbols of removed coordinates to expressions. `lagrangian` is the new L, and
    `parts` are the new energies T and V (None if unknown). All these expressions contain the
    symbols of `equations`, before renumbering. The states of the result are `kept_states` (None:
    all), followed by `angles`: former coordinates that no equation uses, each mapped to (rate,
    initial value).
    """
    g = equations.graph
    count, states = len(equations.coordinates), len(equations.states)
    of_states = range(states) if kept_states is None else kept_states
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

    outputs, angles = list(outputs), angles or {}
    constraints = equations.constraints
    if constraints is not None:
        constraints = _fewer(g, constraints, there, pick)
    kinetic, potential = (None if x is None else there([x])[0] for x in parts)
    return replace(
        equations,
        model=_model(
            equations.model,
            {equations.coordinates[i].name for i in kept}
            | {equations.states[i].name for i in of_states},
        ),
        coordinates=pick(equations.coordinates),
        rates=pick(equations.rates),
        momenta_names=pick(equations.momenta_names),
        lagrangian=there([lagrangian])[0],
        kinetic=kinetic,
        potential=potential,
        applied=there(pick(equations.applied)),
        observed_names=(*equations.observed_names, *(o.quantity for o in outputs)),
        observed=there([*equations.observed, *(o.node for o in outputs)]),
        conserved=there(equations.conserved),
        events=there(equations.events),
        start_q=pick(equations.start_q),
        start_v=pick(equations.start_v),
        states=(
            *(equations.states[i] for i in of_states),
            *(equations.coordinates[i] for i in angles),
        ),
        state_rates=there(
            [*(equations.state_rates[i] for i in of_states), *(rate for rate, _ in angles.values())]
        ),
        state_start=(
            *(equations.state_start[i] for i in of_states),
            *(start for _, start in angles.values()),
        ),
        attitudes=_attitudes(equations.attitudes, kept, of_states),
        constraints=constraints,
    )


def _attitudes(
    attitudes: tuple[Attitude, ...], kept: Sequence[int], of_states: Sequence[int]
) -> tuple[Attitude, ...]:
    """Returns the remaining attitudes with new indices. The index `state` is -1 if the quaternion
    is removed."""
    rates, states = ({old: new for new, old in enumerate(row)} for row in (kept, of_states))
    return tuple(
        Attitude(rates[a.rate], states.get(a.state, -1)) for a in attitudes if a.rate in rates
    )


def _fewer(g: Graph, c: Constraints, there, pick) -> Constraints | None:
    """Returns the constraints without the rows that contain no rate after the removal of
    coordinates. Returns None if all rows are left out. The fields that are computed from the rows
    keep their old values, since the constraints are derived again later."""
    own = _moving(g, c.stated, there)
    if own is None:
        return None
    return replace(
        c,
        names=own.names,
        holonomic=own.holonomic,
        positions=own.positions,
        residual=own.residual,
        spans=own.spans,
        redundant=c.redundant and _moving(g, c.redundant, there),
        free_applied=there(pick(c.free_applied)),
    )


def _moving(g: Graph, rows: Rows, there) -> Rows | None:
    residual = there(rows.residual)
    left = [k for k, node in enumerate(residual) if g.depends[node] & BIT[Kind.RATE]]
    if not left:
        return None
    return replace(rows, positions=there(rows.positions), residual=residual).picked(left)


def _model(model: Model, kept: set[str]) -> Model:
    """Returns the model with the remaining coordinates and states. If a family has lost members,
    its remaining members are declared one by one."""
    return replace(
        model,
        coordinates=_left(model, model.coordinates, kept),
        states=_left(model, model.states, kept),
    )


def _left(model: Model, declared: tuple, kept: set[str]) -> tuple:
    found: list[Coordinate | State] = []
    all_families = families(model, declared)
    for item in declared:
        names = [indexed(item.name, index) for index in all_families[item.name].members]
        if all(name in kept for name in names):
            found.append(item)
        else:
            found += [replace(item, name=name, range=None) for name in names if name in kept]
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
