"""Impulses: jumps of the rates at a surface s(q, t) = 0 where the Lagrangian or a constraint row
jumps.

A jump of L is the limit of ever steeper smooth ramps, during which q is constant. Hamilton's
principle gives the corner conditions of Weierstrass and Erdmann. With p = dL/dv, h = v.p - L and
constraint rows J v + j0 = 0,

    p+ - p- = alpha ds/dq + J^T Lambda,   h+ - h- = -(alpha ds/dt + Lambda.j0),   J v+ + j0 = 0

where - and + denote values before and after, and J and j0 have their values after the surface. For
a surface s(t), alpha is 0 and there is no condition for h. For example, at a kink of a prescribed
motion, v jumps and p does not; at a jump of a potential, the motion is transmitted or reflected.
The runtime solves the conditions (src/events/impulse.c). This module finds the switches (zeros of
expressions, see switches.py) with impulses: there, L, phi or J v + j0 are not proved continuous.

References: I. M. Gelfand, S. V. Fomin, Calculus of Variations, section 15; B. Brogliato,
Nonsmooth Mechanics, 3rd ed., Springer 2016, chapters 1 and 3.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from ...equations import Equations, Quantity, Switch
from ...functions import FUNCTIONS
from ...graph.calls import counts, jumps
from ...graph.differentiate import gradient, reachable
from ...graph.exact import Exact
from ...graph.graph import BIT, ONE, VARIABLE, ZERO, Graph, Kind, Node, Op, Symbol
from ...graph.normal import Normal
from ...graph.residues import Varying
from ...graph.substitute import rebuilt, substituted
from ...graph.surfaces import Surfaces, argument_of
from ...graph.wording import wording
from ...indices import multiplied
from ...model import Model
from ...source import ModelError, Span
from ..attitudes import slopes
from ..quantities import error, symbols
from .switches import free

# Bits of `impulse`, a field of Switch. OF_ENERGY: L or a holonomic constraint row may jump.
# OF_ROLLING: a row of a `rolling` statement may jump.
OF_ENERGY, OF_ROLLING = 1, 2
_PLACES = BIT[Kind.COORDINATE]
SMOOTH = "let it bend, as max(0, x) does, or be steep, as tanh is"


def arguments_of(g: Graph, nodes: Iterable[Node]) -> list[Node]:
    """Returns the arguments of functions in the nodes at whose zeros these functions jump."""
    found = dict.fromkeys(argument_of(g, n) for n in reachable(g, nodes, VARIABLE) if jumps(g, n))
    return [x for x in found if g.depends[x] & VARIABLE]


class Across:
    """Proves whether nodes are continuous at the zeros of an argument. Works on a copy of the
    graph."""

    def __init__(self, g: Graph):
        self.graph = g.copy()
        self.normal = Normal(self.graph)
        self.exact = Exact(self.graph)
        self.varying = Varying(self.graph)
        self.surfaces = Surfaces(self.graph)

    def jump(self, node: Node, argument: Node) -> Node:
        """Returns the jump of a node where the argument vanishes: its limit for positive arguments
        minus its limit for negative ones. Returns ZERO if the node is proved continuous."""
        parts = [self._jump(part, argument) for part in _terms(self.graph, node)]
        total = self.graph.sum(parts)
        return ZERO if self._is_zero(total) else total

    def surely(self, jump: Node, argument: Node) -> bool:
        """Returns whether a jump is proved to be nonzero."""
        g = self.graph
        solved = not g.depends[jump] & VARIABLE or bool(self._zero(argument)[1])
        return solved and (g.value(jump) or self.varying.is_nonzero(jump)) not in (None, 0, False)

    def _is_zero(self, node: Node) -> bool:
        return node == ZERO or self.normal(node) == {} or self.exact.is_zero(node)

    def _jump(self, node: Node, argument: Node) -> Node:
        g = self.graph
        below = reachable(g, [node], VARIABLE)
        if not any(self._side(n, argument) and jumps(g, n) for n in below):
            return ZERO
        known, solved = self._zero(argument)
        try:
            above, under = (self._held(node, argument, side, known | solved) for side in (1, -1))
        except ZeroDivisionError:
            return ONE
        jump = g.subtract(above, under)
        return ZERO if self._is_zero(jump) else jump

    def _side(self, node: Node, argument: Node) -> int:
        """Returns 0 unless the node is a function call such as abs(x) that switches branch where
        the argument vanishes. Returns 1 if the call's own argument has the sign of the argument,
        -1 if it has the opposite sign: abs(-x)."""
        own, sign = self.surfaces.of_call(node)
        if not sign:
            return 0
        surface, side = self.surfaces(argument)
        return sign * side * (own == surface)

    def _zero(self, argument: Node) -> tuple[dict[Node, Node], dict[Node, Node]]:
        """Returns two maps of substitutions that hold where the argument vanishes. The first
        replaces the argument by 0. If the argument is linear in a symbol, the second replaces this
        symbol by the solution of argument = 0; otherwise the second is empty."""
        g = self.graph
        known = {argument: ZERO, g.negate(argument): ZERO}
        by = gradient(g, argument, VARIABLE)
        for symbol, slope in by.items():
            if slope != ZERO and not g.depends[slope] & VARIABLE:
                (rest,) = substituted(g, [argument], {symbol: ZERO})
                return known, {symbol: g.negate(g.divide(rest, slope))}
        return known, {}

    def _held(self, node: Node, argument: Node, side: int, new: dict[Node, Node]) -> Node:
        g = self.graph
        new = dict(new)
        for n in reachable(g, [node]):
            if n in new:
                continue
            args, own = [new[a] for a in g.args[n]], side * self._side(n, argument)
            if own and g.data[n] in ("step", "floor"):  # floor jumps by 1 at each whole number
                new[n] = ONE if own > 0 else ZERO
            elif own and g.data[n] == "sign":
                new[n] = g.number(own)
            elif own:  # abs(0) is 0; min and max of two equal arguments are either of them
                new[n] = args[1] if len(args) > 1 else ZERO
            else:
                same = all(a == b for a, b in zip(args, g.args[n], strict=True))
                new[n] = n if same else rebuilt(g, n, args)
        return new[node]


def _terms(g: Graph, node: Node) -> list[Node]:
    """Returns the terms of a sum, with constant scales multiplied out. Each term contains fewer
    functions that jump than the sum."""
    found, stack = [], [(ONE, node)]
    while stack:
        factor, n = stack.pop()
        scale, rest = g.split(n)
        if g.op[n] is Op.ADD:
            stack += [(factor, a) for a in g.args[n]]
        elif scale != ONE and g.op[rest] is Op.ADD and not g.depends[scale] & VARIABLE:
            stack.append((g.multiply(factor, scale), rest))
        else:
            found.append(g.multiply(factor, n))
    return found


class NoRate(Exception):
    """A derivative of an input is needed for which the equations have no symbol."""


def with_impulses(
    e: Equations,
    known: tuple[Switch, ...],
    name: Callable[[Symbol], str],
    rate_of: Callable[[Node], Node],
) -> tuple[Switch, ...]:
    """Returns the switches `known`, which belong to the equations of motion, followed by new
    switches, at whose zeros only L or a constraint jumps. Sets the field `impulse` of all switches
    with impulses. Raises ModelError if the motion after a jump is undefined."""
    c = e.constraints
    always = _always(e)
    rows = [x for k in always for x in (*c.positions[k : k + 1], c.residual[k], *c.rows[k])]
    jumping = [e.lagrangian, *e.momenta, *rows]
    if not (arguments := arguments_of(e.graph, jumping)):
        return known
    if counted := [x for x in arguments if counts(e.graph, x)]:
        where, help = _where(e.graph, counted[0], name)
        of_energy = counted[0] in arguments_of(e.graph, [e.lagrangian])
        of_row = [
            span
            for node, span in (() if of_energy else ((c.residual[k], c.spans[k]) for k in always))
            if counted[0] in arguments_of(e.graph, [node])
        ]
        raise _refused(e, f"L or a constraint jumps {where}", help, of_row)
    across, found, marked = Across(e.graph), {}, []
    surfaces = across.surfaces
    places = {surfaces(x.node)[0]: x.node for x in known}
    loose = {surfaces.of_call(n)[0] for n in free(across.graph, jumping) if jumps(across.graph, n)}
    for node in arguments_of(across.graph, jumping):
        surface, _ = surfaces(node)
        argument = places.setdefault(surface, node)
        if surface in found:
            continue
        text = wording(across.graph, argument, name)
        kind = _kind(e, across, argument, text)
        if kind and surface in loose:
            raise _refused(
                e,
                f"L or a constraint jumps where {text} vanishes, in a root, a power or a"
                " logarithm: of that neither side is known",
                "put the jump outside of it: sqrt(4*step(x)) is 2*step(x)",
            )
        slope, of_time = _slopes(e, argument, text, rate_of) if kind else ((), ZERO)
        found[surface] = Switch(Quantity(text, "", ""), argument, kind, slope, of_time)
    marked = [replace(found.pop(surfaces(x.node)[0], x), held=x.held) for x in known]
    return (*marked, *(x for x in found.values() if x.impulse))


def _always(e: Equations) -> list[int]:
    """Returns the rows of constraints that always hold. Others jump as contacts do."""
    c = e.constraints
    at_times = {x.row for x in c.meetings} if c is not None else set()
    return [k for k in range(len(c.residual) if c is not None else 0) if k not in at_times]


def _where(g: Graph, argument: Node, name: Callable[[Symbol], str]) -> tuple[str, str]:
    """Returns the places at which functions of an argument jump, and what to write instead."""
    if not counts(g, argument):
        return f"where {wording(g, argument, name)} vanishes", SMOOTH
    (inner,) = g.args[argument]
    text = wording(g, inner, name)
    if g.op[inner] is Op.CALL and FUNCTIONS[g.data[inner]].table:
        help = "interpolate by 'spline' or 'pchip', and continue it by 'linear' or 'periodic'"
        return f"at the knots of {text}", help
    return f"at each whole number {text}", "a force or an output may have floor, ceil, round, mod"


def _kind(e: Equations, across: Across, argument: Node, text: str) -> int:
    g, c = across.graph, e.constraints
    of_rates = bool(g.depends[argument] & BIT[Kind.RATE])
    energies = [e.lagrangian, *(e.momenta if of_rates else ())]
    found = OF_ENERGY if any(across.jump(x, argument) != ZERO for x in energies) else 0
    if found and of_rates:
        raise _refused(
            e,
            f"L or a momentum jumps where {text} vanishes: what its rates do there is not defined",
            "a step or a sign of a rate may stand in a force or a dissipation, not in an energy",
        )
    for k in _always(e):
        row, span = multiplied(c.names[k].name), c.spans[k]
        holonomic = k < c.holonomic
        at = f"where {text} vanishes"
        jump = across.jump(c.positions[k], argument) if holonomic else ZERO
        if jump != ZERO and across.surely(jump, argument):
            message = f"the constraint '{row}' jumps {at}: no motion follows it"
            raise error(e.model, message, span, SMOOTH)
        turns = [ZERO] if holonomic else [across.jump(x, argument) for x in c.rows[k]]
        if any(across.surely(x, argument) for x in turns if x != ZERO):
            message = f"what multiplies the rates in the rolling '{row}' jumps {at}"
            raise error(e.model, f"{message}: what the motion does there depends on how", span)
        if jump != ZERO or any(turns) or across.jump(c.residual[k], argument) != ZERO:
            if of_rates:
                raise error(e.model, f"'{row}' jumps {at}, which has rates in it", span)
            found |= OF_ENERGY if holonomic else OF_ROLLING
    return found


def _slopes(
    e: Equations, argument: Node, text: str, rate_of: Callable[[Node], Node]
) -> tuple[tuple[Node, ...], Node]:
    """Returns two results: the derivatives of the argument by the coordinates (for a rotation,
    along its body axes), and the derivative by t at constant coordinates. If all derivatives by
    coordinates are 0, the derivative by t is returned as 0 too."""
    g, count = e.graph, len(e.coordinates)
    beside = BIT[Kind.TIME] | BIT[Kind.INPUT] | BIT[Kind.STATE]
    by = gradient(g, argument, _PLACES | beside)
    turning = slopes(g, e.attitudes, by)
    places = symbols(g, Kind.COORDINATE, count)
    slope = tuple(turning.get(i, by.get(place, ZERO)) for i, place in enumerate(places))
    rate = ZERO
    for symbol, x in by.items() if any(node != ZERO for node in slope) else ():
        kind, index = g.data[symbol].kind, g.data[symbol].index
        if kind is Kind.COORDINATE or (kind is Kind.STATE and index < e.quaternions):
            continue
        if kind is Kind.STATE:
            message = f"L or a constraint jumps where {text} vanishes, which has a state in it"
            raise _refused(e, message)
        try:
            rate = g.add(rate, g.multiply(x, rate_of(symbol)))
        except NoRate as no:
            raise _refused(
                e,
                f"L or a constraint jumps where {text} vanishes, and the rate of {no} is not known",
                "give the input as a function of t by `set`",
            ) from None
    return slope, rate


def _refused(e: Equations, message: str, help: str = "", of_row: Sequence[Span] = ()) -> ModelError:
    """Returns an error at a constraint row or, if there is none, at the energy."""
    found = (*e.model.potential, *e.model.kinetic, *e.model.lagrangian, e.model)
    return error(e.model, message, (*of_row, found[0].span)[0], help)


def check_rates(
    model: Model, g: Graph, taken: list[tuple[Node, Span]], name: Callable[[Symbol], str]
) -> None:
    """Raises ModelError if an expression may jump whose time derivative was taken. `taken` has all
    such expressions, each with its place in the model's text."""
    if not arguments_of(g, [node for node, _ in taken]):
        return
    across = Across(g)
    for node, span in taken:
        for argument in arguments_of(across.graph, [node]):
            if across.jump(node, argument) != ZERO:
                where, help = _where(across.graph, argument, name)
                raise error(model, f"the rate is taken here of what jumps {where}", span, help)
