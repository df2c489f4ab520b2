"""The table of all kernels: their outputs, return type and meaning.

A new kernel needs a row here, a member in runtime/include/pk/system.h, and a caller.
"""

from __future__ import annotations

from ..equations import Equations, Particles, Row
from ..graph.graph import ZERO
from ..middle.motion import LINEAR_OF_FEW
from .kernel_spec import KernelSpec, optional, pivot_checks, row_checks
from .kernels_bound import ALWAYS, BOUND
from .kernels_canonical import CANONICAL, CANONICAL_SPECS
from .targets import Target

# Kernels of a model that is generated to be embedded, without the runtime's tables.
PLAIN = frozenset(("acceleration", "energy", "force", "mass", "observe"))


def needed_kernels(
    equations: Equations, wanted: frozenset[str] | None, plain: bool = False
) -> frozenset[str]:
    """Returns the kernels of `wanted` (None: all) that the model has, and the kernels that they
    call; unless `plain`, also the kernels that the runtime itself calls."""
    names = {n for n, spec in KERNELS.items() if n != "start" and spec.exists(equations)}
    if plain:
        names &= wanted or names
    elif wanted is not None:
        names &= (
            wanted
            | CANONICAL
            | (ALWAYS if equations.constraints else frozenset())
            | ({"linear"} if LINEAR_OF_FEW in wanted else set())
        )
    for name, needed in (("switching", equations.switches), ("marking", equations.marks)):
        names |= {name} if needed and not plain else set()
    if equations.impulsive and not plain:
        corner = ("corner", "energy", "unconstrained", "inertia")
        names |= {name for name in corner if KERNELS[name].exists(equations)}
    if "acceleration" in names and equations.acceleration is None:
        names |= {"mass", "force"}
    return frozenset(names)


def _has_energy(equations: Equations) -> bool:
    """Returns whether the model has an energy; a model with only first-order states has none."""
    return equations.own > 0 or bool(equations.attitudes)


def _scalar(name: str, says: str) -> KernelSpec:
    """Returns a kernel for a scalar: its value is the field of Equations with the kernel's name."""
    return KernelSpec(
        name,
        says,
        lambda e: {name: (getattr(e, name),)},
        "pk_real",
        lambda e: getattr(e, name) is not None and _has_energy(e),
    )


def _pivots(e: Equations) -> list[Target]:
    """Returns the checks of all pivots, which precede all stores."""
    return [*pivot_checks(e.graph, "MASS", e.pivots or ()), *row_checks(e)]


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
        lambda e: {"a": e.acceleration or e.force},  # without e.acceleration a loop solves M a = f
        "int",
        checks=_pivots,
        kept=lambda e: [*(pivot for pivot, _ in e.pivots or ()), *e.force],
    ),
    KernelSpec("mass", "M = dp/dv", lambda e: {"M": e.mass}, symmetric=True),
    KernelSpec("force", "f = pdot - (dp/dq) v - dp/dt", lambda e: {"f": e.force}),
    KernelSpec(
        "canonical",
        "p = dL/dv and pdot = dL/dq + Q - dD/dv",
        lambda e: {"momenta": e.momenta, "pdot": e.pdot},
    ),
    KernelSpec("momenta", "p = dL/dv", lambda e: {"momenta": e.momenta}),
    KernelSpec("gradient", "dL/dq", lambda e: {"dLdq": e.gradient}),
    KernelSpec(
        "jacobian",
        "dp/dq, d(pdot)/dq, d(pdot)/dv",
        lambda e: {name: getattr(e, name) for name in ("p_q", "pdot_q", "pdot_v")},
        exists=lambda e: e.p_q is not None,
        copies=True,
    ),
    KernelSpec(
        "linear",
        "derivatives of r = f - M a by q, v and t, with a and the inputs held",
        lambda e: {name: getattr(e.linear, name) for name in ("r_q", "r_v", "r_t")},
        exists=lambda e: e.linear is not None,
        given=("a",),
        copies=True,
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
        lambda e: {
            "slope": tuple(tuple(x.slope) or (ZERO,) * len(e.coordinates) for x in e.switches),
            "slope_t": tuple(x.slope_t for x in e.switches),
        },
        exists=lambda e: bool(e.impulsive),
    ),
    *BOUND,
    *CANONICAL_SPECS,
    KernelSpec(
        "particles",
        "particles: masses m, places r, r' and r'', a = q'' given",
        lambda e: _of_particles(e.particles),
        exists=lambda e: e.particles is not None and bool(e.particles.masses),
        given=("a",),
        copies=True,
    ),
    KernelSpec("start", "initial values", lambda e: {"q": e.start_q, "v": e.start_v}),
)
KERNELS: dict[str, KernelSpec] = {spec.name: spec for spec in _SPECS}
