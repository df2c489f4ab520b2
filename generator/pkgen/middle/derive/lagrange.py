"""Derives Lagrange's equations from the nodes of L and of the forces.

`derive` calls this module for a model, `reduce` for equations with fewer coordinates.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...equations import Attitude, Constraints, Equations, Row, Rows, Singularity
from ...graph.collect import shortened
from ...graph.count import operations
from ...graph.graph import ZERO, Graph, Node
from ...graph.solve import Solution
from ...record import record
from ..attitudes import lock
from ..dependence import rewritten, without_coordinates
from ..motion import (
    NO_JACOBIANS,
    Energies,
    Motion,
    Wanted,
    energy_of,
    jacobians_of,
    linear_of,
    motion_of,
    rate_of,
    shorter,
    shortest,
)
from ..naming import naming
from ..points.cuts import switched
from ..points.singularities import singularities_of
from .constrain import constrain
from .impulses import NoRate, with_impulses
from .marks import marks_of
from .switches import switches_of


@record
class Derived:
    """The results of derived(). `fields` has them by the names of the fields of Equations."""

    motion: Motion
    solution: Solution | None
    energies: Energies
    energy: Node
    constraints: Constraints | None
    fields: dict[str, object]


def derived(
    g: Graph,
    energies: Energies,
    forces: Row,
    rate_of: Callable[[Node], Node],
    wanted: Wanted,
    check: Callable[[Motion], None] = lambda _: None,
    states: Row = (),
    attitudes: tuple[Attitude, ...] = (),
    rows: Rows | None = None,
) -> Derived:
    """Returns the equations of motion in the form of fewest operations.

    `check` is called twice, with the motion before and after simplification. `states` are the time
    derivatives of the states; if there are any, no Jacobians are made here (see states.py). `rows`
    are the model's constraint rows.

    Raises SingularMass, CannotConstrain, and exceptions of `check`.
    """
    raw = motion_of(g, energies, forces, rate_of, attitudes)
    raw = rewritten(raw, lambda nodes: without_coordinates(g, nodes, len(forces)))
    check(raw)
    bound = bool(states) or rows is not None
    motion, solution = shortest(g, energies.lagrangian, raw, wanted, bound)
    check(motion)
    constraints = None
    if rows is not None:
        motion, solution, constraints = constrain(g, motion, rows, rate_of)
    jacobians, linear = NO_JACOBIANS, None
    if wanted("jacobian") and not states:
        jacobians = jacobians_of(g, motion)
    if wanted.linear(len(forces)) and not states:
        linear = linear_of(g, motion)
    energy = energy_of(g, energies, motion, wanted)
    shown = shorter(g, energies, wanted)
    moving = solution.accelerations if solution else motion.force
    fields = {
        **vars(motion),
        **{name: getattr(shown, name) for name in ("lagrangian", "kinetic", "potential")},
        **jacobians,
        "written": energies.lagrangian,
        "energy": energy,
        "acceleration": solution and solution.accelerations,
        "pivots": solution and solution.pivots,
        "linear": linear,
        "state_rates": min(
            (states, tuple(shortened(g, states))), key=lambda x: operations(g, [*moving, *x])
        ),
        "constraints": constraints,
    }
    return Derived(motion, solution, shown, energy, constraints, fields)


def _singularities(e: Equations) -> tuple[Singularity, ...]:
    g, name, force, acceleration = e.graph, naming(e), e.force, e.acceleration
    if e.constraints is not None:  # singularities due to constraints are found at run time
        force, acceleration = e.constraints.free_force, None
    outputs = [*(acceleration or force), *force, *sum(e.mass, ()), *e.state_rates]
    ends = singularities_of(g, e.parameters, e.pivots or (), outputs, name, e.written)
    apart: dict[str | Node, Singularity] = {}
    for end in ends:
        word = lock(g, end.node, e.attitudes, name)
        quantity = replace(end.quantity, name=word) if word else end.quantity
        apart.setdefault(word or end.node, replace(end, quantity=quantity))
    return tuple(apart.values())  # two angles with the same gimbal lock have one singularity


def located(e: Equations, wanted: Wanted) -> Equations:
    """Returns the equations with the fields `singularities`, `switches` (switches.py, impulses.py)
    and `marks` (marks.py)."""
    forces = [*e.pdot, *e.force, *e.state_rates]
    outputs = [*e.pdot, *e.force, *sum(e.mass, ()), *e.state_rates]
    name, c = naming(e), e.constraints
    meets = [] if c is None else [*(c.residual[x.row] for x in c.meetings), *c.values]
    found = switches_of(e.graph, [*outputs, *meets], name, switched(e, forces))
    if c is not None:
        outputs += [*c.positions, *c.residual]
    return replace(
        e,
        singularities=_singularities(e) if wanted("singularity") else (),
        switches=with_impulses(e, found, name, _rate_of(e)),
        marks=marks_of(e.graph, outputs, name),
    )


def derived_again(equations: Equations, kernels: frozenset[str] | None) -> Equations:
    """Derives the equations of motion again, after a reduction has changed L, the applied forces or
    the coordinates."""
    e, wanted = equations, Wanted(kernels)
    c = e.constraints
    found = derived(
        e.graph,
        Energies(e.lagrangian, e.kinetic, e.potential, ZERO),
        e.applied if c is None else c.free_applied,
        _rate_of(e),
        wanted,
        states=e.state_rates,
        attitudes=e.attitudes,
        rows=c,
    )
    return located(replace(e, **found.fields), wanted)


def _rate_of(e: Equations) -> Callable[[Node], Node]:
    def found(node: Node) -> Node:
        symbol = e.graph.data[node]
        rate = rate_of(e.graph, e, symbol)
        if rate is None:
            raise NoRate(e.inputs[symbol.index].name)
        return rate

    return found
