"""What the templates see for lane kernels: W states side by side, each an element of an array."""

from __future__ import annotations

import re
from typing import Any

from .program import Program

_LANES = "const pk_real *t, const pk_real *q, const pk_real *v, const pk_real *u, pk_real *a"


def context(program: Program) -> dict[str, Any]:
    return {
        "lane_arguments": f"const struct {program.equations.model.name}_params *p, {_LANES}",
        "member_arguments": f"const pk_real *P, {_LANES}",
        "used_fields": _used_fields(program),
        "places": _places,
    }


def _places(array: str, count: int) -> str:
    """q[0 * W + l], q[1 * W + l], ..."""
    return ", ".join(f"{array}[{i} * W + l]" for i in range(count))


def _used_fields(program: Program) -> list[tuple[str, int]]:
    """The members of struct NAME_params that the acceleration reads: C text and place."""
    places = {name: k for k, name in enumerate(program.parameter_names)}
    places |= {f"c_[{k}]": len(places) + k for k in range(program.hoisted)}
    kernel = program.kernel("acceleration")
    texts = " ".join(s.text for s in kernel.statements) if kernel else ""
    used = set(re.findall(r"p->(\w+(?:\[\d+\])?)", texts))
    return [(name, k) for name, k in places.items() if name in used]
