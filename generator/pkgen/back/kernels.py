"""The kernels that a model can have: a row each, with outputs, results and what they mean.

A new kernel is a row here, its place in runtime/include/pk/system.h, and its caller.
"""

from __future__ import annotations

from ..equations import Equations, Particles, Row
from ..graph.graph import ZERO, Node
from ..middle.motion import LINEAR_OF_FEW
from .kernel_spec import (
    KernelSpec,
    matrix_stores,
    optional,
    pivot_checks,
    row_checks,
    square,
    stores,
    symmetric,
    vector,
    vectors,
)
from .kernels_bound import ALWAYS, BOUND
from .kernels_canonical import CANONICAL, CANONICAL_SPECS
from .targets import FILL, RETURN, STORE, Output, Target


def needed_kernels(equations: Equations, wanted: frozenset[str] | None) -> frozenset[str]:
    """Those of `wanted` that the model has, and those that these call."""
    names = {n for n, spec in KERNELS.items() if n != "start" and spec.exists(equations)}
    if wanted is not None:
        names &= (
            wanted
            | CANONICAL
            | (ALWAYS if equations.constraints else frozenset())
            | ({"linear"} if LINEAR_OF_FEW in wanted else set())
        )
    for name, needed in (("switching", equations.switches), ("marking", equations.marks)):
        names |= {name} if needed else set()
    if equations.jolted:
        corner = ("corner", "energy", "unconstrained", "inertia")
        names |= {name for name in corner if KERNELS[name].exists(equations)}
    if "acceleration" in names and equations.acceleration is None:
        names |= {"mass", "force"}
    return frozenset(names)


def _has_energy(equations: Equations) -> bool:
    """States alone have none; body rates have."""
    return equations.own > 0 or bool(equations.attitudes)


def _scalar(name: str, says: str) -> KernelSpec:
    """Of an energy, the field of Equations that has its name."""
    return KernelSpec(
        name,
        says,
        lambda e: (),
        lambda e: [Target(RETURN, "", (getattr(e, name),))],
        "pk_real",
        lambda e: getattr(e, name) is not None and _has_energy(e),
    )


def _acceleration_targets(equations: Equations) -> list[Target]:
    """Every pivot is tested before anything is written."""
    if equations.acceleration is None:
        return []
    checks = [*pivot_checks(equations.graph, "MASS", equations.pivots or ())]
    checks += row_checks(equations)
    return checks + stores("a", equations.acceleration)


def _linear(equations: Equations) -> list[Target]:
    linear = equations.linear
    if linear is None:
        return []
    return _copied(
        [
            *matrix_stores("r_q", linear.r_q),
            *matrix_stores("r_v", linear.r_v),
            *stores("r_t", linear.r_t),
        ]
    )


def _jacobian(equations: Equations) -> list[Target]:
    matrices = {name: getattr(equations, name) or () for name in ("p_q", "pdot_q", "pdot_v")}
    return _copied([t for name, matrix in matrices.items() for t in matrix_stores(name, matrix)])


def _copied(targets: list[Target]) -> list[Target]:
    """An entry that is in several places, as the second derivatives of L are, is copied."""
    places: dict[Node, list[str]] = {}
    for target in targets:
        for node in target.nodes:
            places.setdefault(node, []).append(target.where)
    fills = [target for target in targets if target.kind == FILL]
    return fills + [
        Target(STORE, where, (node,), also=tuple(copies))
        for node, (where, *copies) in places.items()
    ]


def _of_particles(particles: Particles) -> dict[str, Row]:
    rows = {
        "r_out": particles.places,
        "v_out": particles.rates,
        "a_out": particles.accelerations,
    }
    return {"m_out": particles.masses} | {name: sum(row, ()) for name, row in rows.items()}


_SPECS = (
    KernelSpec(
        "acceleration",
        "a = q'' with M a = f, by M = L D L^T",
        lambda e: (Output("a", len(e.coordinates), 1),),
        _acceleration_targets,
        "int",
        kept=lambda e: [*(pivot for pivot, _ in e.pivots or ()), *e.force],
    ),
    symmetric("mass", "M = dp/dv", lambda e: e.mass),
    vector("force", "f = pdot - (dp/dq) v - dp/dt", "f", lambda e: e.force),
    vectors(
        "canonical",
        "p = dL/dv and pdot = dL/dq + Q - dD/dv",
        lambda e: {"momenta": e.momenta, "pdot": e.pdot},
    ),
    vector("momenta", "p = dL/dv", "momenta", lambda e: e.momenta),
    vector("gradient", "dL/dq", "dLdq", lambda e: e.gradient),
    KernelSpec(
        "jacobian",
        "dp/dq, d(pdot)/dq, d(pdot)/dv",
        lambda e: (square("p_q", e), square("pdot_q", e), square("pdot_v", e)),
        _jacobian,
        exists=lambda e: e.p_q is not None,
    ),
    KernelSpec(
        "linear",
        "derivatives of r = f - M a by q, v and t, with a and the inputs held",
        lambda e: (square("r_q", e), square("r_v", e), Output("r_t", len(e.force), 1)),
        _linear,
        exists=lambda e: e.linear is not None,
        given=("a",),
    ),
    optional("fast", "the part of a that is named fast", "a", lambda e: e.fast or ()),
    _scalar("energy", "h = v.p - L"),
    _scalar("lagrangian", "L"),
    _scalar("kinetic", "T"),
    _scalar("potential", "V"),
    optional(
        "singularity",
        "what the equations divide by, or take a root or a logarithm of: they end where it is 0",
        "out",
        lambda e: tuple(singularity.node for singularity in e.singularities),
    ),
    optional("observe", "observed outputs", "out", lambda e: e.observed),
    optional("conserve", "quantities claimed to be constant", "out", lambda e: e.conserved),
    optional("event", "functions whose zeros are the events", "out", lambda e: e.events),
    optional(
        "switching",
        "the arguments of step, abs, min and max at whose zeros the equations change",
        "out",
        lambda e: tuple(switch.node for switch in e.switches),
    ),
    optional(
        "marking",
        "u of exp(u) and the like, which end beyond +-36: where forces may be short",
        "out",
        lambda e: tuple(mark.node for mark in e.marks),
    ),
    KernelSpec(
        "corner",
        "the slopes of the switches at which rates may jump, by q and by t; 0 of others",
        lambda e: (
            Output("slope", len(e.switches), len(e.coordinates)),
            Output("slope_t", len(e.switches), 1),
        ),
        lambda e: (
            matrix_stores(
                "slope", tuple(x.slope or (ZERO,) * len(e.coordinates) for x in e.switches)
            )
            + stores("slope_t", tuple(x.slope_t for x in e.switches))
        ),
        exists=lambda e: bool(e.jolted),
    ),
    *BOUND,
    *CANONICAL_SPECS,
    KernelSpec(
        "particles",
        "particles: masses m, places r, r' and r'', a = q'' given",
        lambda e: tuple(
            Output(name, len(row), 1) for name, row in _of_particles(e.particles).items()
        ),
        lambda e: _copied(
            [t for name, row in _of_particles(e.particles).items() for t in stores(name, row)]
        ),
        exists=lambda e: e.particles is not None and bool(e.particles.masses),
        given=("a",),
    ),
    vectors("start", "initial values", lambda e: {"q": e.start_q, "v": e.start_v}),
)
KERNELS: dict[str, KernelSpec] = {spec.name: spec for spec in _SPECS}
