"""The table of all kernels: their outputs, return type and meaning.

A new kernel needs a row here, a member in runtime/include/pk/system.h, and a caller.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ..equations import Equations, Hamiltonian, Row
from ..graph.graph import ZERO
from ..middle.derive.sensitivity import JACOBIANS, MOVING
from ..middle.motion import LINEAR_OF_FEW, PARTICLES
from . import jet
from .kernel_spec import KernelSpec, pivot_checks
from .targets import Target

# Kernels of a model that is generated to be embedded, without the runtime's tables.
PLAIN = frozenset(("acceleration", "energy", "force", "mass", "noise", "observe"))
# Kernels of the canonical form, in q and p: `pkgen MODEL.lag --canonical`.
CANONICAL = frozenset(("hamiltonian", "hamilton", "hamilton_force"))
# Kernels with which the runtime keeps constraints: generated even if a user selects other kernels.
_OF_CONSTRAINTS = frozenset(
    ("constraint", "constraint_jacobian", "residual_scale", "inertia", "redundant", "multipliers")
)
# Kernels with which the runtime finds the rates after an impulse.
_OF_IMPULSES = frozenset(("corner", "energy", "unconstrained", "inertia"))


def needed_kernels(
    equations: Equations, wanted: frozenset[str] | None, plain: bool = False, jets: bool = False
) -> frozenset[str]:
    """Returns the kernels of `wanted` (None: all but `jet`) that the model has, with `jets` also
    `jet`, and the kernels that they call; unless `plain`, also the kernels that the runtime itself
    calls."""
    known = {n for n, spec in KERNELS.items() if n != "start" and spec.exists(equations)}
    known -= {f"{name}_free" for name in OF_FLIGHT}
    asked = known - {"jet"} if wanted is None else known & wanted
    asked |= known & {"jet"} if jets else set()
    if wanted is not None and not plain:
        asked |= known & CANONICAL
        asked |= known & _OF_CONSTRAINTS if equations.constraints else set()
        asked |= known & {"linear"} if LINEAR_OF_FEW in wanted else set()
    if not plain:
        asked |= known & {"switching", "marking"}
        asked |= known & _OF_IMPULSES if equations.impulsive else set()
    if "acceleration" in asked and equations.acceleration is None:
        asked |= {"mass", "force"}
    asked |= {event.kernel for event in equations.model.resetting}
    if equations.model.meets:
        asked |= {"meeting", *(f"{name}_free" for name in asked & {*OF_FLIGHT})}
    if equations.sampled:
        asked |= {"sampling", *(block.kernel for block in equations.model.samples)}
    return frozenset(asked)


def _scalar(name: str, says: str) -> KernelSpec:
    """Returns a kernel for a scalar: its value is the field of Equations with the kernel's name. A
    model with only first-order states has none."""

    def values(e: Equations) -> Mapping[str, Row]:
        exists = getattr(e, name) is not None and (e.own > 0 or e.attitudes or e.model.lagrangian)
        return {name: (getattr(e, name),)} if exists else {}

    return KernelSpec(name, says, values, "pk_real")


def _canonical(
    name: str, says: str, values: Callable[[Hamiltonian], Mapping[str, Row]]
) -> KernelSpec:
    """Returns a kernel that depends on q and p; it returns a failure code if M is singular."""
    return KernelSpec(
        name,
        says,
        lambda e: e.hamiltonian and values(e.hamiltonian),
        "int",
        checks=lambda e: pivot_checks(e.graph, "MASS", e.hamiltonian.pivots),
        second="momenta",
    )


def _jacobian(name: str) -> KernelSpec:
    """Returns a kernel of middle/derive/sensitivity.py, which is made only if asked for by name."""
    return KernelSpec(
        name,
        f"the derivatives {JACOBIANS[name]}",
        lambda e: {name: (e.sensitivity or {}).get(name)},
        given=("a",) if name in MOVING else (),
        copies=True,
    )


def _of_flight(name: str) -> KernelSpec:
    """Returns the kernel that another one calls while no contact holds: it is much shorter."""
    says = f"what {name} is while no contact, friction or latch holds"
    return KernelSpec(
        f"{name}_free",
        says,
        lambda e: e.flight and KERNELS[name].values(e.flight),
        KERNELS[name].result,
        checks=lambda e: KERNELS[name].checks(e.flight),
    )


def _pivots(e: Equations) -> list[Target]:
    """Returns the checks of the pivots of M, and that constraint rows are linearly independent."""
    rows = e.constraints.pivots if e.constraints else ()
    found = ("MASS", e.pivots or ()), ("CONSTRAINT", rows)
    return [check for failure, pivots in found for check in pivot_checks(e.graph, failure, pivots)]


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
        copies=True,
    ),
    KernelSpec(
        "linear",
        "derivatives of r = f - M a by q, v and t, with a and the inputs held",
        lambda e: e.linear and vars(e.linear),
        given=("a",),
        copies=True,
    ),
    KernelSpec("jet", jet.SAYS, lambda e: {"c": jet.rows(e)}, "int"),
    KernelSpec("fast", "the part of a that is named fast", lambda e: {"a": e.fast}),
    KernelSpec(
        "noise",
        "white noises: the intensity S of each, and the accelerations by a unit force along it",
        lambda e: e.noise and {"S_out": e.noise.intensities, "G_out": e.noise.accelerations},
    ),
    _scalar("energy", "h = v.p - L"),
    _scalar("lagrangian", "L"),
    _scalar("kinetic", "T"),
    _scalar("potential", "V"),
    KernelSpec(
        "singularity",
        "what the equations divide by, or take a root or a logarithm of: they end where it is 0",
        lambda e: {"out": tuple(singularity.node for singularity in e.singularities)},
    ),
    KernelSpec("observe", "observed outputs", lambda e: {"out": e.observed}),
    KernelSpec("conserve", "quantities claimed to be constant", lambda e: {"out": e.conserved}),
    KernelSpec("event", "functions whose zeros are the events", lambda e: {"out": e.events}),
    KernelSpec(
        "switching",
        "the arguments of step, abs, min and max at whose zeros the equations change",
        lambda e: {"out": tuple(switch.node for switch in e.switches)},
    ),
    KernelSpec(
        "marking",
        "u of exp(u) and the like, which end beyond +-36: where forces may be short",
        lambda e: {"out": tuple(mark.node for mark in e.marks)},
    ),
    KernelSpec(
        "corner",
        "the slopes of the switches at which rates may jump, by q and by t; 0 of others",
        lambda e: (
            e.impulsive
            and {
                "slope": tuple(tuple(x.slope) or (ZERO,) * len(e.coordinates) for x in e.switches),
                "slope_t": tuple(x.slope_t for x in e.switches),
            }
        ),
    ),
    KernelSpec(
        "constraint",
        "phi, which the holonomic constraints keep at 0",
        lambda e: e.constraints and {"phi_out": e.constraints.positions},
    ),
    KernelSpec(
        "constraint_jacobian",
        "the rows J of all constraints, and J v + j0, which they keep at 0",
        lambda e: (
            e.constraints and {"J_out": e.constraints.rows, "residual_out": e.constraints.residual}
        ),
    ),
    KernelSpec(
        "residual_scale",
        "the sizes of the terms of phi and of J v + j0: what both are rounded by, in units of eps",
        lambda e: e.terms and dict(zip(("phi_size", "residual_size"), e.terms, strict=True)),
    ),
    KernelSpec(
        "redundant",
        "what redundant rows are off, phi and then J v + j0, and the sizes of their terms; their J",
        lambda e: (
            e.redundant_terms
            and {
                "off_out": e.constraints.redundant.positions + e.constraints.redundant.residual,
                "off_size": e.redundant_terms,
                "off_rows": e.constraints.redundant_rows,
            }
        ),
    ),
    KernelSpec(
        "meeting",
        "of contacts and frictions, the accelerations of their rows if none holds; their bounds",
        lambda e: e.constraints and {"out": e.constraints.values},
    ),
    KernelSpec(
        "multipliers",
        "lambda, of which J^T lambda are the forces of the constraints",
        lambda e: e.constraints and {"lambda_out": e.constraints.multipliers},
    ),
    KernelSpec(
        "unconstrained",
        "p and pdot without the forces of constraints",
        lambda e: e.unconstrained and dict(zip(("momenta", "pdot"), e.unconstrained, strict=True)),
    ),
    KernelSpec(
        "inertia",
        "dp/dv of what `unconstrained` writes",
        lambda e: e.unconstrained and {"M": e.inertia},
        symmetric=True,
    ),
    _canonical("hamiltonian", "H(q, p), the energy", lambda h: {"H": (h.energy,)}),
    _canonical(
        "hamilton", "dH/dq and dH/dp, which is q'", lambda h: {"dHdq": h.by_q, "dHdp": h.by_p}
    ),
    _canonical(
        "hamilton_force",
        "Q - dD/dv at q and p, which p' has besides -dH/dq",
        lambda h: {"applied": h.applied if {*h.applied} - {ZERO} else ()},
    ),
    KernelSpec(
        "particles",
        "particles: masses m, places r, r' and r'', a = q'' given",
        lambda e: (
            e.particles
            and {
                "m_out": e.particles.masses,
                "r_out": sum(e.particles.places, ()),
                "v_out": sum(e.particles.rates, ()),
                "a_out": sum(e.particles.accelerations, ()),
            }
        ),
        given=("a",),
        copies=True,
    ),
    KernelSpec(
        "sampling",
        "T and T0 of each sample block, and the inputs at the start of a motion",
        lambda e: e.sampled and {"times": e.sample_times, "held": e.held_start},
    ),
    *map(_jacobian, JACOBIANS),
    KernelSpec("start", "initial values", lambda e: {"q": e.start_q, "v": e.start_v}),
)
KERNELS: dict[str, KernelSpec] = {spec.name: spec for spec in _SPECS}
OF_FLIGHT = ("acceleration", "canonical", "event")
KERNELS = {f"{name}_free": _of_flight(name) for name in OF_FLIGHT} | KERNELS


def all_but(*names: str) -> frozenset[str]:
    """Returns the kernels in q and v without `names`, jet and the one of particles."""
    return frozenset(KERNELS) - CANONICAL - {PARTICLES, "jet", *names}


def kernel(name: str) -> KernelSpec:
    """Returns the specification of a kernel. BLOCK_sample, of a sample block, and EVENT_reset are
    in no table."""

    def sample(e: Equations) -> Mapping[str, Row]:
        k = [block.kernel for block in e.model.samples].index(name)
        n = len(e.inputs)
        return {"next": e.sampled[k * n : (k + 1) * n]}

    def reset(e: Equations) -> Mapping[str, Row]:
        row = e.resets[[event.kernel for event in e.model.resetting].index(name)]
        hidden = len(row) - len(e.coordinates) - len(e.inputs)  # with those of body rates
        return {"next": (*row[: e.own], *row[hidden:])}

    if name.endswith("_reset"):
        says = "the motion after the event: next, all of q, then of v, then of u"
        return KernelSpec(name, says, reset)
    says = "a sample, which gives all inputs new values: next, with which the caller replaces u"
    return KERNELS.get(name) or KernelSpec(name, says, sample)
