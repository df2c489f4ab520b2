"""The comments of generated C: units of outputs, bounds, tables of operations."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from ...equations import Equations, Quantity
from ...indices import parted
from ...middle.derive.sensitivity import JACOBIANS
from ...middle.quantities import per_second
from .names import Names, local_wish
from .program import Field, Kernel, Program, operations_text

_LISTED = 8  # Longer arrays are described without their entries.


def entries(program: Program, kernel: Kernel) -> list[str]:
    """Returns Doxygen lines: the outputs of a kernel (shape, entries, units), its return value."""
    lines = []
    for output in kernel.outputs:
        name, n = output.name, output.rows
        if output.columns > 1 or name in _MATRICES:
            columns = output.columns
            says = _MATRICES[name].format(n=columns)
            lines.append(f"@param[out] {name} [{n}*{columns}]: {says}")
        elif name in _VECTORS:
            listed = _VECTORS[name](program.equations, kernel) if n <= _LISTED else []
            shown = ", ".join(_with_unit(q.name, q.unit) for q in listed)
            lines.append(f"@param[out] {name} [{n}]" + (f": {shown}" if shown else ""))
    if kernel.result == "pk_real":
        unit = "" if program.equations.model.dimensionless else " [J]"
        lines.append(f"@return the value{unit}")
    elif kernel.result == "int":
        names = " and ".join(output.name for output in kernel.outputs)
        written = f"{names} {'are' if kernel.outputs[1:] else 'is'} not written"
        lines.append(f"{_RETURNS[bool(program.equations.constraints)]} Then {written}.")
    if not program.plain:
        lines.append(f"@note {operations_text(kernel.operations)}.")
    return lines


_SINGULAR = (
    "PK_FAILED(PK_FAILURE_MASS, i) where pivot i is not positive: M is singular or indefinite "
    "there, or something is not a number."
)
_RETURNS = {
    False: f"@return 0, or {_SINGULAR}",
    True: "@return 0, PK_FAILED(PK_FAILURE_CONSTRAINT, k) where row k of constraints depends on "
    f"others, or {_SINGULAR}",
}


_MATRICES = {
    "M": "M[i*{n} + j] = dp_i/dv_j, row-major, symmetric; the unit of p_i over that of v_j",
    "p_q": "p_q[i*{n} + j] = dp_i/dq_j",
    "pdot_q": "pdot_q[i*{n} + j] = d(pdot_i)/dq_j",
    "pdot_v": "pdot_v[i*{n} + j] = d(pdot_i)/dv_j",
    "r_q": "r_q[i*{n} + j] = dr_i/dq_j, so that M (da/dq) = r_q where a is the acceleration",
    "r_v": "r_v[i*{n} + j] = dr_i/dv_j",
    **dict.fromkeys(JACOBIANS, "a row of {n} numbers for each quantity"),
    "J_out": "J_out[k*{n} + j] = d(residual_k)/dv_j, row-major",
    "G_out": "G_out[k*{n} + i], the acceleration a_i by a unit force along noise k",
    "off_rows": "off_rows[k*{n} + j], the derivatives by v_j, row-major",
    "slope": "slope[k*{n} + j] = d(switch k)/dq_j, along the axes of a body",
}


def _derivatives(quantities: Sequence[Quantity], e: Equations, name: str) -> list[Quantity]:
    """Returns the time derivatives of quantities. The derivative for a coordinate x is named
    `name.format("x")`, that of a first-order variable z is named z'."""
    names = [name.format(c.name) for c in e.coordinates[: e.own]]
    names += [f"{q.name}'" for q in e.rates[e.own :]]
    per = str if e.model.dimensionless else per_second
    return [Quantity(x, per(q.unit), "") for x, q in zip(names, quantities, strict=True)]


_OUT = {
    "observe": lambda e: e.observed_names,
    "conserve": lambda e: e.conserved_names,
    "event": lambda e: e.event_names,
    "switching": lambda e: tuple(switch.quantity for switch in e.switches),
    "marking": lambda e: tuple(mark.quantity for mark in e.marks),
    "singularity": lambda e: tuple(singularity.quantity for singularity in e.singularities),
    "meeting": lambda e: (),
}
_FORCES = ("f", "pdot", "dLdq", "dHdq", "applied")
_UNLISTED = (
    *("r_t", "phi_out", "residual_out", "phi_size", "residual_size", "slope_t"),
    *("off_out", "off_size"),
)
_VECTORS = {
    **dict.fromkeys(_FORCES, lambda e, _: _derivatives(e.momenta_names, e, "of {}")),
    **dict.fromkeys(_UNLISTED, lambda e, _: ()),
    "a": lambda e, _: _derivatives(e.rates, e, "{}''"),
    "momenta": lambda e, _: e.momenta_names,
    "q": lambda e, _: e.coordinates,
    **dict.fromkeys(("v", "dHdp"), lambda e, _: e.rates),
    "H": lambda e, _: [Quantity("H", "" if e.model.dimensionless else "J", "")],
    "lambda_out": lambda e, _: e.constraints.names,
    "out": lambda e, kernel: _OUT[kernel.name.removesuffix("_free")](e),
}


def _with_unit(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def families(quantities: Sequence[Quantity], first: int = 0) -> list[dict[str, Any]]:
    """Returns a row for each single quantity and each family: its name in C, the index of the
    quantity or of the family's first member, a description. The first quantity has the index
    `first`. A family's description tells how many members have consecutive indices."""
    rows: dict[str, tuple[int, Quantity]] = {}
    counts: dict[str, int] = {}
    for index, quantity in enumerate(quantities, first):
        name = parted(quantity.name)[0]
        if name not in rows:
            rows[name], counts[name] = (index, quantity), 1
        elif index == rows[name][0] + counts[name]:
            counts[name] += 1
    taken = Names(frozenset())
    plain = {name: taken.take(local_wish(name)) for name in rows if "." not in name}
    return [
        {
            "c_name": plain.get(name) or taken.take(local_wish(name)),
            "index": index,
            "says": _says(
                f"{quantity.name}, the first of {counts[name]}" if "[" in quantity.name else "",
                quantity,
            ),
        }
        for name, (index, quantity) in rows.items()
    ]


def field_says(program: Program, field: Field) -> str:
    """Returns the comment of a member of struct NAME_params."""
    quantity = program.equations.parameters[field.first].quantity
    what = _says(f"{quantity.name}, ..." if field.length else "", quantity)
    return " ".join(x for x in (what, bounds_text(program, field.first)) if x)


def _says(member: str, quantity: Quantity) -> str:
    """Returns a text like 'q[1], ...: stretch [m]', without the parts that are empty."""
    what = _with_unit(quantity.description, quantity.unit).strip()
    return ": ".join(x for x in (member, what) if x)


def bounds_text(program: Program, index: int) -> str:
    """Returns a parameter's bounds as text, such as 'in (0, inf)'. Returns '' if it has none, or if
    the code of the bounds declares local variables."""
    slot = program.equations.parameters[index]
    lo, hi = program.bounds[index].lo, program.bounds[index].hi
    if (lo is None and hi is None) or program.bounds[index].statements:
        return ""
    left = "(" if slot.lo_open or lo is None else "["
    right = ")" if slot.hi_open or hi is None else "]"
    return f"in {left}{_plain(lo or '-inf')}, {_plain(hi or 'inf')}{right}"


def _plain(text: str) -> str:
    return re.sub(r"PK_[CF]\((\w[\w.]*)\)", r"\1", text.replace("p->", ""))


def operations_rows(program: Program) -> list[str]:
    """Returns the table of operation counts for a generated file's header, one line per kernel."""
    kernels = (*program.kernels, program.prepare)
    width = max(len(kernel.name) for kernel in kernels)
    return [f"{k.name:{width}}  {operations_text(k.operations)}" for k in kernels]


def labelled(rows: list[tuple[str, str]]) -> list[str]:
    """Returns pairs (label, text) as lines 'label: text' of a comment."""
    return [f"{name}: {text}" for name, text in rows]
