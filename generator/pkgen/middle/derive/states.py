"""First-order variables x with x' = g(t, q, v, x), here called states.

While a model is expanded, the time derivative of state k of n is a symbol with the index n + k, so
that a definition may use it before its expression is known. `resolved` substitutes the expressions.

All integrators of the runtime solve q' = v, M a = f. In C, a state is therefore the rate v of a
dummy coordinate q, which is not used; its acceleration a is x'. `as_rates` appends the dummy
coordinates to those of the model, with M extended by a unit matrix. If a momentum p depends on a
state, such as a rocket's mass, dp/dv would not be symmetric. Then the equations are used in solved
form, with p = v, M = 1 and f = a.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from graphlib import TopologicalSorter

from ...equations import Constraints, Equations, Matrix, Quantity, Row, Switch
from ...graph.differentiate import symbols_in
from ...graph.graph import BIT, ONE, ZERO, Graph, Kind, Node
from ...graph.rounding import sizes
from ...graph.substitute import substituted
from ..motion import NO_JACOBIANS, Motion, Wanted, jacobians_of, linear_of, with_states
from ..quantities import rate_of_state, symbols
from ..structure import Structure
from .sensitivity import sensitivity_of

STATES = BIT[Kind.STATE]


def resolved(g: Graph, rates: Row) -> dict[Node, Node]:
    """Returns the expressions of the time derivatives of states by their symbols. The expressions
    do not contain such symbols. Raises CycleError if that is impossible."""
    count = len(rates)
    used = {
        k: [s.index - count for s in symbols_in(g, [rate], STATES) if s.index >= count]
        for k, rate in enumerate(rates)
    }
    found: dict[Node, Node] = {}
    for k in TopologicalSorter(used).static_order():
        (found[rate_of_state(g, k, count)],) = substituted(g, [rates[k]], found)
    return found


# -- conversion for the C code -------------------------------------------------------------------


def as_rates(
    e: Equations, structure: Structure, kernels: frozenset[str] | None
) -> tuple[Equations, Structure]:
    """Returns equations in which states are the rates of dummy coordinates, and their facts.

    The dummy coordinates come last. For n coordinates and `count` states, n x n matrices become (n
    + count) x (n + count) matrices. If the model has rotations, constraints, or momenta that depend
    on states, the fields `unconstrained`, `inertia` and `terms` of the result are set. The
    equations must not have been converted before."""
    c, solved = e.constraints, with_states(e.graph, e.momenta)
    if not (e.states or e.attitudes):
        whole = lagrange = replace(e, **_terms(e.graph, c))
    else:
        whole, lagrange = _extended(e, Wanted(kernels), solved)
        structure, c = _facts(structure, len(e.states), solved), whole.constraints
    if solved or e.quaternions or c is not None or e.impulsive:
        # In solved form the kernel `canonical` has the rates v in place of p.
        own = lagrange.momenta, lagrange.pdot if c is None else c.free_pdot
        whole = replace(whole, unconstrained=own, inertia=lagrange.mass)
    if c is not None and c.meetings:
        whole = replace(whole, flight=_flight(whole))
    return replace(whole, sensitivity=sensitivity_of(whole, Wanted(kernels))), structure


def _flight(e: Equations) -> Equations:
    """Returns the equations while no contact, friction or latch holds, and nothing slips."""
    c, g = e.constraints, e.graph
    held = (x for m in c.meetings for x in (m.mode, m.side) if x is not None)
    swap = dict.fromkeys(held, ZERO)

    def there(row: Row | None) -> Row | None:
        return row if row is None else tuple(substituted(g, row, swap))

    fields = {name: there(getattr(e, name)) for name in ("acceleration", "force", "pdot", "events")}
    return replace(e, **fields, constraints=replace(c, pivots=tuple(map(there, c.pivots))))


def _extended(e: Equations, wanted: Wanted, solved: bool) -> tuple[Equations, Motion]:
    """Returns the equations of `e`, extended by the equations x' = g of the states x; if `solved`,
    in solved form, v' = a with p = v and M = 1. Returns the extended Lagrange's equations too, in
    which each state has the diagonal entry 1 in M."""
    g, n, count = e.graph, len(e.coordinates), len(e.states)
    v, none = symbols(g, Kind.RATE, n + count), (ZERO,) * count
    own = v[n:]
    swap = dict(zip(symbols(g, Kind.STATE, count), own, strict=True))

    def there(nodes: Iterable[Node]) -> Row:
        return tuple(substituted(g, nodes, swap))

    def wider(rows: Iterable[Row]) -> Matrix:
        return tuple((*there(row), *none) for row in rows)

    def switch(x: Switch) -> Switch:
        node, slope_t, *slope = there((x.node, x.slope_t, *x.slope))
        return replace(x, node=node, slope_t=slope_t, slope=(*slope, *none) if slope else ())

    rates = there(e.state_rates)
    ends = {"momenta": own, "gradient": none, "applied": rates, "pdot": rates, "force": rates}
    a = None if e.acceleration is None else (*there(e.acceleration), *rates)

    def beside() -> Motion:
        return Motion(
            **{x: (*there(getattr(e, x)), *end) for x, end in ends.items()},
            mass=(*wider(e.mass), *((ZERO,) * n + row for row in _unit(count))),
        )

    zeros = (ZERO,) * len(v)
    motion = Motion(v, zeros, a, a, _unit(len(v)), a) if solved else beside()
    jacobians = jacobians_of(g, motion, False) if wanted("jacobian") else NO_JACOBIANS
    single = ("lagrangian", "energy", "written", "kinetic", "potential")
    nodes = {field: getattr(e, field) for field in single if getattr(e, field) is not None}
    nodes = dict(zip(nodes, there(nodes.values()), strict=True))
    lagrange = beside() if solved else motion
    c = e.constraints
    more = c and c.redundant
    constraints = c and replace(
        c,
        free_pdot=(*there(c.free_pdot), *rates),
        positions=there(c.positions),
        rows=wider(c.rows),
        residual=there(c.residual),
        multipliers=there(c.multipliers),
        values=there(c.values),
        pivots=tuple(map(there, c.pivots)),
        redundant=more
        and replace(more, positions=there(more.positions), residual=there(more.residual)),
        redundant_rows=wider(c.redundant_rows),
    )
    unseen = (Quantity(f"integral of {q.name}", "", "of no use: v has the state") for q in e.states)
    whole = replace(
        e,
        fast=None,
        constraints=constraints,
        **_terms(g, constraints),
        coordinates=(*e.coordinates, *unseen),
        rates=(*e.rates, *e.states),
        momenta_names=(*e.momenta_names, *e.states),
        **nodes,
        **vars(motion),
        **jacobians,
        acceleration=a,
        pivots=None if e.pivots is None else (*map(there, e.pivots), *[(ONE, ONE)] * count),
        linear=linear_of(g, motion) if wanted.linear(n + count) else None,
        singularities=tuple(replace(x, node=there([x.node])[0]) for x in e.singularities),
        switches=tuple(map(switch, e.switches)),
        marks=tuple(map(switch, e.marks)),
        **{x: there(getattr(e, x)) for x in ("observed", "conserved", "events", "sampled")},
        resets=tuple(map(there, e.resets)),
        noise=e.noise and replace(e.noise, accelerations=wider(e.noise.accelerations)),
        start_q=(*e.start_q, *none),
        start_v=(*e.start_v, *e.state_start),
        states=(),
        state_rates=(),
        state_start=(),
        n_first_order=count + len(e.turning),
        n_unread=_unread(g, n, motion),
    )
    return whole, lagrange


def _unread(g: Graph, n: int, motion: Motion) -> int:
    """Returns how many states at the end of the list of states occur in no equation. In `motion`,
    the states are the rates with indices from the number n of coordinates on."""
    read = (s.index for s in symbols_in(g, (*motion.momenta[:n], *motion.pdot), BIT[Kind.RATE]))
    return len(motion.pdot) - max(n, *(i + 1 for i in read), 0)


def _terms(g: Graph, constraints: Constraints | None) -> dict[str, tuple]:
    if constraints is None:
        return {}
    c = constraints
    found = sizes(g, (*c.positions, *c.residual))
    more = c.redundant
    return {
        "terms": (found[: c.holonomic], found[c.holonomic :]),
        "redundant_terms": sizes(g, (*more.positions, *more.residual)) if more else (),
    }


def _unit(n: int) -> Matrix:
    return tuple(tuple(ONE if i == j else ZERO for j in range(n)) for i in range(n))


def _facts(structure: Structure, count: int, solved: bool) -> Structure:
    facts = replace(structure, cyclic=(*structure.cyclic, *(False,) * count))
    if not solved:
        return facts
    return replace(
        facts,
        mass_constant=True,
        mass_diagonal=True,
        quadratic=True,
        cyclic=(False,) * len(facts.cyclic),
    )
