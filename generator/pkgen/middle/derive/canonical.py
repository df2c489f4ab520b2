"""Hamilton's equations: derives H(q, p) and its gradients from an L of second degree in the rates.

With L = v.M v/2 + b.v - U, where M, b and U depend on q and t alone,

    p = M v + b,    v = M^-1 (p - b),    H = v.(p - b)/2 + U,
    dH/dp = v,      dH/dq = -dL/dq  at v = M^-1 (p - b).

Reference: L. D. Landau, E. M. Lifshitz, Mechanics, 3rd edition, section 40.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from ...equations import Equations, Hamiltonian
from ...graph.collect import shortened
from ...graph.graph import ZERO, Kind
from ...graph.solve import solve
from ...graph.substitute import substituted
from ..quantities import error, smaller, symbols
from ..structure import Structure


def with_hamiltonian(equations: Equations, structure: Structure) -> Equations:
    """Returns the equations with the field `hamiltonian`. Raises ModelError if H has no closed
    form."""
    model = equations.model
    for found, what, help in (
        (
            () if structure.quadratic else (*model.lagrangian, *model.kinetic),
            "M depends on the rates, so they are no function of q and p that can be written down",
            "H(q, p) needs a Lagrangian of second degree in the rates",
        ),
        (
            model.rotations,
            "body rates are the rates of no coordinates",
            "with Euler angles as coordinates there is one",
        ),
        (
            model.constraints,
            "a constraint leaves q and p no freedom of their own",
            "with coordinates that fulfil it by themselves there is one",
        ),
        (
            equations.states and model.states,
            "states have no momenta",
            "leave out what is a state, or hold it in a scene",
        ),
    ):
        if found:
            raise error(model, f"there is no canonical form: {what}", found[0].span, help)
    g, n = equations.graph, len(equations.coordinates)
    rates, momenta = symbols(g, Kind.RATE, n), symbols(g, Kind.MOMENTUM, n)
    at_rest = dict.fromkeys(rates, ZERO)
    *linear, potential = substituted(g, [*equations.momenta, equations.energy], at_rest)
    excess = tuple(map(g.subtract, momenta, linear))
    solution = solve(g, equations.mass, excess)
    if solution is None:
        raise error(
            model,
            f"there is no canonical form of {n} coordinates that M couples so much: written out"
            " it is too long",
            model.span,
            smaller(model),
        )
    v = solution.accelerations
    twice = g.dot(v, excess)
    energy = g.add(g.multiply(g.number(Fraction(1, 2)), twice), potential)
    moving = dict(zip(rates, v, strict=True))
    forces = [*map(g.negate, equations.gradient), *equations.applied]
    slope_and_applied = substituted(g, forces, moving)
    entries = shortened(g, [*v, *slope_and_applied])
    return replace(
        equations,
        hamiltonian=Hamiltonian(
            energy=shortened(g, [energy])[0],
            by_p=tuple(entries[:n]),
            by_q=tuple(entries[n : 2 * n]),
            applied=tuple(entries[2 * n :]),
            pivots=solution.pivots,
        ),
    )
