"""Makes the time derivatives of a model's states (first-order variables). They may contain energies
and momenta, and time derivatives of other states."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from graphlib import CycleError

from ...graph.differentiate import gradient
from ...graph.graph import ZERO, Kind, Node, Symbol
from ...graph.normal import Normal
from ...graph.substitute import substituted
from ...indices import made_of
from ...source import Span
from ..expand.expand import Expander
from ..motion import STATE, Energies
from ..quantities import error, indexed, symbols
from .effective import NAME
from .states import resolved


def rates_of_states(
    x: Expander, energies: Energies, solved: Mapping[int, Node]
) -> dict[Node, Node]:
    """Returns the time derivative of each state, in the order of the states, as a map from its
    symbol to its expression. `solved` has the rates that do not stand in the model."""
    if not x.states:
        return {}
    g = x.graph
    by = gradient(g, energies.lagrangian, STATE)
    v = symbols(g, Kind.RATE, x.count)
    momenta = tuple(by.get(rate, ZERO) for rate in v)
    energy = g.subtract(g.dot(v, momenta), energies.lagrangian)
    define_built_in(x, energies, energy, momenta)

    def follows(span: Span) -> Node:
        raise error(x.model, f"'{NAME}' follows from the rates: no rate may use it", span)

    x.later[NAME] = follows
    rates = [solved.get(k, ZERO) for k in range(x.state_count)]
    places: list[Span] = [x.model.span] * x.state_count
    for attitude in x.attitudes:
        for k in attitude.numbers:
            rates[k] = x.derivative(g.symbol(Symbol(Kind.STATE, k)))
    for item, index, value in x.members_of(x.model.rates):
        k = x.states[item.name].flat(index)
        rates[k], places[k] = value, item.span
    try:
        found = resolved(g, tuple(rates))
    except CycleError as wrong:
        of = {f.flat(i): indexed(f.name, i) for f in x.states.values() for i in f.members}
        *circle, _ = reversed(wrong.args[1])  # each state needs the next one
        start = circle.index(min(circle))
        circle = circle[start:] + circle[: start + 1]
        cycle = " needs ".join(f"{of[k]}'" for k in circle)
        raise error(
            x.model,
            f"the rate of '{of[circle[0]]}' is defined by itself: {cycle}",
            places[circle[0]],
            "solve these equations for the rates, and write what comes out",
        ) from None
    return dict(sorted(found.items(), key=lambda pair: g.data[pair[0]].index))


def _energies_of(x: Expander, lagrangian: Node, momenta: tuple[Node, ...]) -> tuple[Node, ...]:
    """Returns T = v.p/2 and V = T - L for L = T - V with T of second degree in the rates v. Returns
    () for any other L, because T - L then depends on v."""
    g = x.graph
    v = symbols(g, Kind.RATE, x.count)
    half = g.number(Fraction(1, 2))
    kinetic = g.multiply(half, g.dot(v, momenta))
    potential = g.subtract(kinetic, lagrangian)
    (at_rest,) = substituted(g, [potential], dict.fromkeys(v, ZERO))
    difference = g.subtract(potential, at_rest)
    return () if Normal(g.copy())(difference) or not momenta else (kinetic, at_rest)


def define_built_in(
    x: Expander, energies: Energies, energy: Node, momenta: tuple[Node, ...]
) -> None:
    """Defines the names T, V, L, energy and those of the momenta. A name that the model defines
    itself keeps its meaning."""
    own = {item.name for item in x.model.definitions}
    whole = energies.lagrangian if energies.whole is None else energies.whole
    built_in = {"L": whole, "energy": energy}
    known = energies.kinetic, energies.potential
    if energies.kinetic is None:
        known = _energies_of(x, energies.lagrangian, momenta)
    built_in |= zip("TV", known, strict=False)
    if not known:
        message = (
            "'{}' is not known: L is not a quadratic form in the rates plus a function without"
        )
        for name in (name for name in "TV" if name not in own):
            x.refuse(name, None, message.format(name) + " rates", "use L or energy")
    for name, node in built_in.items():
        if name not in own:
            x.define(name, None, node)
    for (item, index), momentum in zip(x.members, momenta, strict=True):
        x.define(item.momentum or made_of("p_{}", item.name), index, momentum)
