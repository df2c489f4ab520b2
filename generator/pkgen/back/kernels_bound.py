"""Kernels of rotations and constraints: what the runtime keeps a motion on them by."""

from __future__ import annotations

from .kernel_spec import KernelSpec, matrix_stores, optional, stores, symmetric, vector, vectors
from .targets import Output

# Each exists where there is what it writes: see pk/system.h.
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
        lambda e: (
            Output("J_out", len(e.constraints.residual), len(e.coordinates)),
            Output("residual_out", len(e.constraints.residual), 1),
        ),
        lambda e: (
            matrix_stores("J_out", e.constraints.rows)
            + stores("residual_out", e.constraints.residual)
        ),
        exists=lambda e: e.constraints is not None,
    ),
    vectors(
        "residual_scale",
        "the sizes of the terms of phi and of J v + j0: what both are rounded by, in units of eps",
        lambda e: dict(zip(("phi_size", "residual_size"), e.terms, strict=True)),
        exists=lambda e: e.terms is not None,
    ),
    KernelSpec(
        "redundant",
        "what redundant rows are off, phi and then J v + j0, and the sizes of their terms; their J",
        lambda e: (
            Output("off_out", len(e.redundant_terms), 1),
            Output("off_size", len(e.redundant_terms), 1),
            Output("off_rows", len(e.constraints.redundant_rows), len(e.coordinates)),
        ),
        lambda e: (
            stores("off_out", e.constraints.redundant.positions + e.constraints.redundant.residual)
            + stores("off_size", e.redundant_terms)
            + matrix_stores("off_rows", e.constraints.redundant_rows)
        ),
        exists=lambda e: bool(e.redundant_terms),
    ),
    vector(
        "multipliers",
        "lambda, of which J^T lambda are the forces of the constraints",
        "lambda_out",
        lambda e: e.constraints.multipliers,
        exists=lambda e: e.constraints is not None,
    ),
    vectors(
        "unconstrained",
        "p and pdot without the forces of constraints",
        lambda e: dict(zip(("momenta", "pdot"), e.unconstrained, strict=True)),
        exists=lambda e: e.unconstrained is not None,
    ),
    symmetric(
        "inertia",
        "dp/dv of what `unconstrained` writes",
        lambda e: e.inertia,
        exists=lambda e: e.unconstrained is not None,
    ),
)
# Wherever there are constraints.
ALWAYS = frozenset({"constraint", "constraint_jacobian", "residual_scale", "inertia", "redundant"})
