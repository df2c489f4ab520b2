"""Derives Lagrange's equations from the nodes of L and of the forces.

`derive` calls this module for a model, `reduce` for equations with fewer coordinates.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...equations import Attitude, Constraints, Equations, Matrix, Named, Row, Rows, Singularity
from ...graph.collect import shortened
from ...graph.count import operations
from ...graph.graph import ZERO, Graph, Kind, Node, Symbol
from ...graph.solve import Solution
from ...record import record
from ..dependence import without_coordinates
from ..motion import (
    NO_JACOBIANS,
    Energies,
    Motion,
    Wanted,
    energy_of,
    jacobians_of,
    linear_of,
    motion_of,
    shorter,
    shortest,
)
from ..naming import naming
from ..points.cuts import switched
from ..points.locks import lock
from ..points.singularities import singularities_of
from .constrain import constrain
from .impulses import NoRate, with_impulses
from .marks import marks_of
from .switches import switches_of


@record
class Derived:
    """The results of derived(). `fields` returns them by the names of the fields of Equations."""

    motion: Motion
    solution: Solution | None
    energies: Energies
    written: Node  # L before it is rewritten in few operations
    energy: Node
    jacobians: dict[str, Matrix | None]
    linear: object
    state_rates: Row
    free: Motion  # the motion without constraint forces
    constraints: Constraints | None

    def fields(self) -> dict[str, object]:
        energies = vars(self.energies)
        found = self.solution
        return {
            **vars(self.motion),
            **{name: energies[name] for name in ("lagrangian", "kinetic", "potential")},
            **self.jacobians,
            "written": self.written,
            "energy": self.energy,
            "acceleration": found and found.accelerations,
            "pivots": found and found.pivots,
            "linear": self.linear,
            "state_rates": self.state_rates,
            "constraints": self.constraints,
        }


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
    raw = _independent(g, motion_of(g, energies, forces, rate_of, attitudes))
    check(raw)
    bound = bool(states) or rows is not None
    motion, solution = shortest(g, energies.lagrangian, raw, wanted, bound)
    check(motion)
    free, constraints = motion, None
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
    rates = min((states, tuple(shortened(g, states))), key=lambda x: operations(g, [*moving, *x]))
    return Derived(
        motion,
        solution,
        shown,
        energies.lagrangian,
        energy,
        jacobians,
        linear,
        rates,
        free,
        constraints,
    )


def _independent(g: Graph, motion: Motion) -> Motion:
    """Returns the motion after removing coordinates from entries of M and f whose values do not
    depend on them."""
    n = len(motion.force)
    nodes = [*sum(motion.mass, ()), *motion.force]
    made = without_coordinates(g, nodes, n)
    if made == nodes:
        return motion
    mass = tuple(tuple(made[i * n : i * n + n]) for i in range(n))
    return replace(motion, mass=mass, force=tuple(made[n * n :]))


def singularities(
    g: Graph,
    found: Derived,
    e: Named | Equations,
    attitudes: tuple[Attitude, ...],
) -> tuple[Singularity, ...]:
    """Returns the singularities of the equations of motion. `e` has the names of coordinates and
    other quantities, which occur in the names of the singularities."""
    motion = found.free
    solution = found.solution
    acceleration = motion.force
    # singularities due to constraints are found at run time
    if solution and found.constraints is None:
        acceleration = solution.accelerations
    outputs = [*acceleration, *motion.force, *(entry for row in motion.mass for entry in row)]
    outputs += found.state_rates
    pivots = solution.pivots if solution else ()
    name = naming(e)
    ends = singularities_of(g, e.parameters, pivots, outputs, name, found.written)
    apart: dict[str | Node, Singularity] = {}
    for end in ends:
        word = lock(g, end.node, attitudes, name)
        quantity = replace(end.quantity, name=word) if word else end.quantity
        apart.setdefault(word or end.node, replace(end, quantity=quantity))
    return tuple(apart.values())  # two angles with the same gimbal lock have one singularity


def located(equations: Equations) -> Equations:
    """Returns the equations with the fields `switches` (switches.py, impulses.py) and `marks`
    (marks.py)."""
    e = equations
    outputs = [*e.pdot, *e.force, *(entry for row in e.mass for entry in row)]
    outputs += e.state_rates
    name = naming(e)
    forces = [*e.pdot, *e.force, *e.state_rates]
    found = switches_of(e.graph, outputs, name, switched(e, forces))
    switches = with_impulses(e, found, name, _rate_of(e))
    if e.constraints is not None:
        outputs += [*e.constraints.positions, *e.constraints.residual]
    return replace(e, switches=switches, marks=marks_of(e.graph, outputs, name))


def derived_again(equations: Equations, kernels: frozenset[str] | None) -> Equations:
    """Derives the equations of motion again, after a reduction has changed L, the applied forces or
    the coordinates."""
    g, wanted = equations.graph, Wanted(kernels)
    energies = Energies(equations.lagrangian, equations.kinetic, equations.potential, ZERO)
    e = equations
    forces, rows = e.applied, None
    if e.constraints is not None:
        forces, rows = e.constraints.free_applied, e.constraints.stated
    found = derived(
        g, energies, forces, _rate_of(e), wanted, lambda _: None, e.state_rates, e.attitudes, rows
    )
    ends: tuple[Singularity, ...] = ()
    if wanted("singularity"):
        ends = singularities(g, found, e, e.attitudes)
    return located(replace(equations, **found.fields(), singularities=ends))


def _rate_of(equations: Equations) -> Callable[[Node], Node]:
    g = equations.graph
    inputs = {q.name: i for i, q in enumerate(equations.inputs)}

    def rate_of(node: Node) -> Node:
        symbol = g.data[node]
        if symbol.kind is Kind.COORDINATE:
            return g.symbol(Symbol(Kind.RATE, symbol.index))
        if symbol.kind is Kind.TIME:
            return g.number(1)
        if symbol.kind is Kind.STATE:
            return equations.state_rates[symbol.index]
        following = equations.inputs[symbol.index].name + "'"
        if following not in inputs:
            raise NoRate(equations.inputs[symbol.index].name)
        return g.symbol(Symbol(Kind.INPUT, inputs[following]))

    return rate_of
