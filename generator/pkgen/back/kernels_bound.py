"""Kernels of rotations and constraints: what the runtime keeps a motion on them by."""

from __future__ import annotations

from collections.abc import Iterator

from ..equations import Equations
from .kernel_spec import KernelSpec, matrix_stores, square, stores, vector
from .targets import Output, Target

BOUND = frozenset(
    {
        "constraint",
        "constraint_jacobian",
        "residual_scale",
        "multipliers",
        "unconstrained",
        "inertia",
    }
)
ALWAYS = BOUND - {"multipliers", "unconstrained"}  # wherever there are constraints


def _constraint_jacobian(e: Equations) -> list[Target]:
    c = e.constraints
    return matrix_stores("J_out", c.rows) + stores("residual_out", c.residual)


def _residual_scale(e: Equations) -> list[Target]:
    positions, rates = e.terms
    return stores("phi_size", positions) + stores("residual_size", rates)


def _unconstrained(e: Equations) -> list[Target]:
    p, pdot = e.unconstrained
    return stores("momenta", p) + stores("pdot", pdot)


def bound_specs() -> Iterator[KernelSpec]:
    """Each exists where there is what it writes: see pk/system.h."""
    yield KernelSpec(
        "constraint",
        "void",
        "phi, which the holonomic constraints keep at 0",
        *vector("phi_out", lambda e: e.constraints.positions),
        exists=lambda e: e.constraints is not None and bool(e.constraints.positions),
    )
    yield KernelSpec(
        "constraint_jacobian",
        "void",
        "the rows J of all constraints, and J v + j0, which they keep at 0",
        lambda e: (
            Output("J_out", len(e.constraints.residual), len(e.coordinates)),
            Output("residual_out", len(e.constraints.residual), 1),
        ),
        _constraint_jacobian,
        exists=lambda e: e.constraints is not None,
    )
    yield KernelSpec(
        "residual_scale",
        "void",
        "the sizes of the terms of phi and of J v + j0: what both are rounded by, in units of eps",
        lambda e: (
            Output("phi_size", len(e.constraints.positions), 1),
            Output("residual_size", len(e.constraints.residual), 1),
        ),
        _residual_scale,
        exists=lambda e: e.terms is not None,
    )
    yield KernelSpec(
        "multipliers",
        "void",
        "lambda, of which J^T lambda are the forces of the constraints",
        *vector("lambda_out", lambda e: e.constraints.multipliers),
        exists=lambda e: e.constraints is not None,
    )
    yield KernelSpec(
        "unconstrained",
        "void",
        "p and pdot without the forces of constraints",
        lambda e: tuple(Output(name, len(e.coordinates), 1) for name in ("momenta", "pdot")),
        _unconstrained,
        exists=lambda e: e.unconstrained is not None,
    )
    yield KernelSpec(
        "inertia",
        "void",
        "dp/dv of what `unconstrained` writes",
        lambda e: (square("M", e),),
        lambda e: matrix_stores("M", e.inertia, symmetric=True),
        exists=lambda e: e.unconstrained is not None,
    )
