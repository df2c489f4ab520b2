"""Kernels of rotations and constraints; the runtime uses them to project states."""

from __future__ import annotations

from .kernel_spec import KernelSpec, optional

# A kernel exists if its outputs are not empty; see pk/system_constraints.h and pk/system.h.
BOUND = (
    optional(
        "constraint",
        "phi, which the holonomic constraints keep at 0",
        "phi_out",
        lambda e: e.constraints.positions if e.constraints else (),
    ),
    KernelSpec(
        "constraint_jacobian",
        "the rows J of all constraints, and J v + j0, which they keep at 0",
        lambda e: {"J_out": e.constraints.rows, "residual_out": e.constraints.residual},
        exists=lambda e: e.constraints is not None,
    ),
    KernelSpec(
        "residual_scale",
        "the sizes of the terms of phi and of J v + j0: what both are rounded by, in units of eps",
        lambda e: dict(zip(("phi_size", "residual_size"), e.terms, strict=True)),
        exists=lambda e: e.terms is not None,
    ),
    KernelSpec(
        "redundant",
        "what redundant rows are off, phi and then J v + j0, and the sizes of their terms; their J",
        lambda e: {
            "off_out": e.constraints.redundant.positions + e.constraints.redundant.residual,
            "off_size": e.redundant_terms,
            "off_rows": e.constraints.redundant_rows,
        },
        exists=lambda e: bool(e.redundant_terms),
    ),
    KernelSpec(
        "multipliers",
        "lambda, of which J^T lambda are the forces of the constraints",
        lambda e: {"lambda_out": e.constraints.multipliers},
        exists=lambda e: e.constraints is not None,
    ),
    KernelSpec(
        "unconstrained",
        "p and pdot without the forces of constraints",
        lambda e: dict(zip(("momenta", "pdot"), e.unconstrained, strict=True)),
        exists=lambda e: e.unconstrained is not None,
    ),
    KernelSpec(
        "inertia",
        "dp/dv of what `unconstrained` writes",
        lambda e: {"M": e.inertia},
        exists=lambda e: e.unconstrained is not None,
        symmetric=True,
    ),
)
# Kernels that the runtime calls, so that they are generated even if a user selects other kernels.
ALWAYS = frozenset(
    {
        "constraint",
        "constraint_jacobian",
        "residual_scale",
        "inertia",
        "redundant",
        "multipliers",
    }
)
