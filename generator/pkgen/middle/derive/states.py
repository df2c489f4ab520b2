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

from ...equations import Constraints, Equations, Matrix, Quantity, Row, Structure, Switch
from ...graph.differentiate import symbols_in
from ...graph.graph import BIT, ONE, ZERO, Graph, Kind, Node
from ...graph.rounding import sizes
from ...graph.substitute import substituted
from ..motion import NO_JACOBIANS, Motion, Wanted, jacobians_of, linear_of, with_states
from ..quantities import rate_of_state, symbols

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
    if not e.states and not e.attitudes:
        own = _unconstrained(e.graph, e, tuple, ())
        if own is None:
            return e, structure
        terms = _terms(e.graph, e.constraints)
        return replace(e, unconstrained=own, inertia=e.mass, **terms), structure
    g, count = e.graph, len(e.states)
    n = len(e.coordinates)
    own = symbols(g, Kind.RATE, n + count)[n:]
    swap = dict(zip(symbols(g, Kind.STATE, count), own, strict=True))

    def there(nodes: Iterable[Node]) -> Row:
        return tuple(substituted(g, nodes, swap))

    rates = there(e.state_rates)
    solved = with_states(g, e.momenta)
    acceleration = None if e.acceleration is None else (*there(e.acceleration), *rates)
    motion = _beside(g, _solved(e) if solved else e, rates, there)
    wanted = Wanted(kernels)
    jacobians = NO_JACOBIANS
    if wanted("jacobian"):
        jacobians = jacobians_of(g, motion, lagrangian=False)
    single = ("lagrangian", "energy", "written", "kinetic", "potential")
    nodes = {field: getattr(e, field) for field in single if getattr(e, field) is not None}
    own = _unconstrained(g, e, there, rates, solved)
    constraints = _constraints(e.constraints, there, count)
    unseen = (Quantity(f"integral of {q.name}", "", "of no use: v has the state") for q in e.states)
    whole = replace(
        e,
        fast=None,
        unconstrained=own,
        constraints=constraints,
        **_terms(g, constraints),
        coordinates=(*e.coordinates, *unseen),
        rates=(*e.rates, *e.states),
        momenta_names=(*e.momenta_names, *e.states),
        **dict(zip(nodes, there(nodes.values()), strict=True)),
        **vars(motion),
        **jacobians,
        acceleration=acceleration,
        pivots=None if e.pivots is None else (*map(there, e.pivots), *[(ONE, ONE)] * count),
        inertia=_with_unit(map(there, e.mass), count) if solved or own else None,
        linear=linear_of(g, motion) if wanted.linear(n + count) else None,
        singularities=tuple(replace(x, node=there([x.node])[0]) for x in e.singularities),
        switches=tuple(_switch(x, there, count) for x in e.switches),
        marks=tuple(_switch(x, there, count) for x in e.marks),
        **{x: there(getattr(e, x)) for x in ("observed", "conserved", "events")},
        start_q=(*e.start_q, *[ZERO] * count),
        start_v=(*e.start_v, *e.state_start),
        states=(),
        state_rates=(),
        state_start=(),
        n_first_order=count + len(e.turning),
        n_unread=_unread(g, n, motion),
    )
    return whole, _facts(structure, count, solved)


def _unread(g: Graph, n: int, motion: Motion) -> int:
    """Returns how many states at the end of the list of states occur in no equation. In `motion`,
    the states are the rates with indices from the number n of coordinates on."""
    nodes = (*motion.momenta[:n], *motion.pdot)
    read = (s.index for s in symbols_in(g, nodes, BIT[Kind.RATE]))
    return len(motion.pdot) - max(n, *(i + 1 for i in read), 0)


def _switch(x: Switch, there, count: int) -> Switch:
    node, slope_t, *slope = there((x.node, x.slope_t, *x.slope))
    slope += [ZERO] * count if slope else []
    return replace(x, node=node, slope_t=slope_t, slope=tuple(slope))


def _solved(e: Equations) -> Equations:
    """Returns the solved form, v' = a, as Lagrange's equations with p = v and M = 1."""
    n, a = len(e.coordinates), e.acceleration
    v, none = symbols(e.graph, Kind.RATE, n), (ZERO,) * n
    return replace(e, momenta=v, gradient=none, applied=a, pdot=a, mass=_unit(n), force=a)


def _beside(g: Graph, e: Equations, rates: Row, there) -> Motion:
    """Returns Lagrange's equations of `e`, extended by the equations x' = g of the states x. The
    right-hand sides g are `rates`. In M, each state gets the diagonal entry 1."""
    n, count = len(e.coordinates), len(rates)
    none = (ZERO,) * count
    return Motion(
        (*there(e.momenta), *symbols(g, Kind.RATE, n + count)[n:]),
        (*there(e.gradient), *none),
        (*there(e.applied), *rates),
        (*there(e.pdot), *rates),
        _with_unit(map(there, e.mass), count),
        (*there(e.force), *rates),
    )


def _with_unit(rows: Iterable[Row], count: int) -> Matrix:
    """Returns M extended by a unit matrix of size `count`."""
    mass = [(*row, *(ZERO,) * count) for row in rows]
    return (*mass, *((ZERO,) * len(mass) + row for row in _unit(count)))


def _unconstrained(
    g: Graph, e: Equations, there, rates: Row, solved: bool = False
) -> tuple[Row, Row] | None:
    """Returns the momenta p and their time derivatives without constraint forces. Returns None
    unless there are rotations, constraints or impulses, or the equations are in solved form
    (`solved`). In solved form the kernel `canonical` has the rates v in place of p."""
    if not solved and not e.quaternions and e.constraints is None and not e.impulsive:
        return None
    pdot = e.pdot if e.constraints is None else e.constraints.free_pdot
    n, count = len(e.coordinates), len(rates)
    own = symbols(g, Kind.RATE, n + count)[n:]
    return (*there(e.momenta), *own), (*there(pdot), *rates)


def _constraints(constraints: Constraints | None, there, count: int) -> Constraints | None:
    if constraints is None:
        return None
    c = constraints
    more = c.redundant
    return replace(
        c,
        positions=there(c.positions),
        rows=tuple((*there(row), *(ZERO,) * count) for row in c.rows),
        residual=there(c.residual),
        multipliers=there(c.multipliers),
        pivots=tuple(map(there, c.pivots)),
        redundant=more
        and replace(more, positions=there(more.positions), residual=there(more.residual)),
        redundant_rows=tuple((*there(row), *(ZERO,) * count) for row in c.redundant_rows),
    )


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
