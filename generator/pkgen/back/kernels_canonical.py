"""The kernels of the canonical form, in q and p: `pkgen MODEL.lag --canonical`."""

from __future__ import annotations

from collections.abc import Callable

from ..equations import Equations, Hamiltonian, Row
from ..graph.graph import ZERO
from .kernel_spec import KernelSpec, pivot_checks

CANONICAL = frozenset(("hamiltonian", "hamilton", "hamilton_force"))


def _canonical(name: str, says: str, rows: Callable[[Hamiltonian], dict[str, Row]]) -> KernelSpec:
    """Returns a kernel that depends on q and p; it returns a failure code if M is singular."""

    def exists(e: Equations) -> bool:
        return e.hamiltonian is not None and any(
            node != ZERO or name != "hamilton_force"
            for row in rows(e.hamiltonian).values()
            for node in row
        )

    return KernelSpec(
        name,
        says,
        lambda e: rows(e.hamiltonian),
        "int",
        exists,
        checks=lambda e: pivot_checks(e.graph, "MASS", e.hamiltonian.pivots),
        second="momenta",
    )


CANONICAL_SPECS = (
    _canonical("hamiltonian", "H(q, p), the energy", lambda h: {"H": (h.energy,)}),
    _canonical(
        "hamilton", "dH/dq and dH/dp, which is q'", lambda h: {"dHdq": h.by_q, "dHdp": h.by_p}
    ),
    _canonical(
        "hamilton_force",
        "Q - dD/dv at q and p, which p' has besides -dH/dq",
        lambda h: {"applied": h.applied},
    ),
)
