"""Template variables of a model's quantities: tables of names, indices, parameters."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from textwrap import fill
from typing import Any

from ...equations import AnyEquations, Equations, Quantity
from ...indices import parted
from ...model import Table
from .ctext import WIDTH
from .describe import families, field_says
from .program import Program


def tables(program: Program) -> dict[str, Sequence[Quantity]]:
    """Returns the quantities in each table of names, units and descriptions."""
    e = program.equations
    found = {
        "coordinates": e.coordinates,
        "rates": e.rates,
        "momentum_names": e.momenta_names,
        "inputs": e.inputs,
        "observed": e.observed_names,
        "conserved": e.conserved_names,
        "constraints": e.constraints.names if e.constraints else (),
        "redundant_rows": e.constraints.redundant.names if e.redundant_terms else (),
    }
    return {name: row if has(program, name) else () for name, row in found.items()}


# Table -> the kernel that writes its quantities.
_WRITTEN = {
    "momentum_names": "momenta",
    "observed": "observe",
    "conserved": "conserve",
    "constraints": "constraint_jacobian",
    "redundant_rows": "redundant",
    "events": "event",
}


def has(program: Program, table: str) -> bool:
    """Returns whether the C has a table; embedded C has only tables of quantities that it
    computes."""
    kernel = _WRITTEN.get(table)
    return not program.plain or kernel is None or program.kernel(kernel) is not None


def counts(program: Program) -> list[tuple[str, int, str]]:
    """Returns the numbers of quantities, as (end of the C constant's name, value, comment)."""
    e, names = program.equations, tables(program)
    rows = [
        ("N", len(e.coordinates), "degrees of freedom"),
        ("FIRST_ORDER", e.n_first_order, "the last of them: first-order variables"),
        ("PARAMETERS", len(e.parameters), ""),
        ("INPUTS", len(e.inputs), ""),
        ("OBSERVED", len(names["observed"]), ""),
        ("CONSERVED", len(names["conserved"]), ""),
        ("CONSTRAINTS", len(names["constraints"]), "rows"),
        ("EVENTS", len(events(program.equations)) * has(program, "events"), ""),
    ]
    always = {"N"} if program.plain else {"N", "PARAMETERS", "INPUTS", "OBSERVED", "CONSERVED"}
    return [row for row in rows if row[1] or row[0] in always]


def singularities(program: Program) -> list[dict[str, Any]]:
    """Returns the rows of the table of singularities; [] without the kernel `singularity`."""
    if program.kernel("singularity") is None:
        return []
    return [
        {"name": x.quantity.name, "kind": f"PK_SINGULARITY_{x.use}"}
        for x in program.equations.singularities
    ]


Fields = Iterable[tuple[str, Table]]  # tables of data, with their members of NAME_params


def pointers(model: str, found: Fields) -> list[str]:
    """Returns the assignments of the default tables."""
    values = (
        (field, "NULL" if table.long else f"&{model}_table_{field}") for field, table in found
    )
    return [f"p->{field} = {value};" for field, value in values]


def data(model: str, fields: Fields) -> list[dict[str, Any]]:
    """Returns the arrays and structs of the tables, as C text."""
    found = []
    for field, table in fields:
        if table.long:
            continue
        name, d = f"{model}_table_{field}", table.data
        arrays = [(f"{name}_{of}", a.knots) for of, a in zip("xy", d.axes, strict=False)]
        axes = [
            f"{{{len(a.knots)}, {of}, (pk_real){a.period!r}, {int(a.strict)}}}"
            for (of, _), a in zip(arrays, d.axes, strict=True)
        ]
        arrays.append((f"{name}_c", d.coefficients.ravel()))
        numbers = [
            (of, len(x), fill(", ".join(map(_number, x.tolist())), WIDTH)) for of, x in arrays
        ]
        axes += ["{0, NULL, 0, 0}"] * (2 - len(axes))
        found.append({"name": name, "arrays": numbers, "axes": ", ".join(axes)})
    return found


def _number(x: float) -> str:
    return str(int(x)) if abs(x) < 10 and x == int(x) else f"(pk_real){x!r}"


def events(e: AnyEquations) -> list[dict[str, Any]]:
    return [
        vars(quantity) | {"direction": event.direction, "stop": event.stop + event.limit}
        for quantity, event in zip(e.event_names, e.model.events, strict=True)
    ]


def system_entries(program: Program) -> dict[str, object]:
    """Returns the members of struct pk_system that only some models set."""
    e, own = program.equations, f"{program.equations.model.name}_sys"
    rotations = sum(bool(a.numbers) for a in e.attitudes)
    counts = {"n_first_order": e.n_first_order, "n_unread": e.n_unread, "n_rotations": rotations}
    entries: dict[str, object] = {name: count for name, count in counts.items() if count}
    if program.kernel("particles") is not None:
        entries["particles.n"] = len(e.particles.masses)
    for part, rows in (("switches", e.switches), ("marks", e.marks)):
        if rows:
            entries |= {f"{part}.n": len(rows), f"{part}.names": f"{own}_{part}"}
    if e.switches:
        entries["switches.sides"] = f"offsetof(struct {e.model.name}_params, side_)"
    if e.impulsive:
        entries["switches.impulses"] = f"{own}_impulses"
    if program.kernel("noise") is not None:
        entries |= {"noise.n": len(e.noise.names), "noise.names": f"{own}_noises"}
    if e.model.consistent:
        entries["consistent"] = 1
    if e.counted:
        entries["counted"] = f"{own}_counted"
    for rows, end, names in (
        (e.constraints, "", "constraints"),
        (e.constraints and e.constraints.redundant, "_redundant", "redundant_rows"),
    ):
        if rows:
            entries |= {
                f"constraints.n{end}": len(rows.names),
                f"constraints.n{end}_holonomic": rows.holonomic,
                f"constraints.{end}_names".replace("._", "."): f"{e.model.name}_{names}",
            }
    return entries


def indices(program: Program) -> list[dict[str, Any]]:
    """Returns the rows of the enum of indices: one for each single quantity and for the first
    member of each family."""
    e, names = program.equations, tables(program)
    own = e.own
    parameters = [] if program.plain else [slot.quantity for slot in e.parameters]
    of_states = "into v: a state's value is there, its rate in a; q there has no meaning"
    rows: list[tuple[str, Sequence[Quantity], str]] = [
        ("q", e.coordinates[:own], "into q, v, momenta, ..."),
        ("x", e.rates[own:], of_states),
        ("p", parameters, "into the table of parameters"),
        ("u", e.inputs, "into u"),
        ("o", names["observed"], "into the observed outputs"),
        ("c", names["conserved"], "into the quantities claimed to be constant"),
        ("e", e.event_names if has(program, "events") else (), "into the events"),
    ]
    return [
        {"stem": stem, "says": says, "rows": families(quantities, own if stem == "x" else 0)}
        for stem, quantities, says in rows
        if quantities
    ]


def fields(program: Program) -> list[dict[str, Any]]:
    return [
        {"c_name": field.c_name, "length": field.length, "says": field_says(program, field)}
        for field in program.fields
    ]


def parameters(program: Program) -> list[dict[str, Any]]:
    columns = program.equations.parameters, program.parameter_names, program.bounds
    return [
        vars(slot.quantity)
        | {
            "index": index,
            "c_name": c_name,
            "field": parted(c_name)[0],
            "position": slot.position,
            "follows": int(slot.follows),
            "lo_open": int(slot.lo_open or bounds.lo is None),
            "hi_open": int(slot.hi_open or bounds.hi is None),
        }
        for index, (slot, c_name, bounds) in enumerate(zip(*columns, strict=True))
    ]


def input_rates(inputs: Sequence[Quantity]) -> list[int]:
    """Returns for each input the index of the input that is its time derivative, or -1."""
    places = {quantity.name: i for i, quantity in enumerate(inputs)}
    return [places.get(quantity.name + "'", -1) for quantity in inputs]


def held(e: Equations) -> list[int]:
    """Returns for each input 1 if a sample block sets it, else 0."""
    by = {item.name for item in e.model.inputs if item.by}
    return [int(quantity.name in by) for quantity in e.inputs]


def reset_events(e: Equations) -> list[int]:
    """Returns the numbers of the events that give values."""
    return [k for k, event in enumerate(e.model.events) if event.then]


def meetings(e: Equations) -> list[dict[str, Any]]:
    """Returns the rows of the table of contacts; see struct pk_contact."""
    found = e.constraints.meetings if e.constraints else ()
    places = {x.name: k for k, x in enumerate(found) if x.kind == "CONTACT"}
    events = {q.name: k for k, q in enumerate(e.event_names)}
    return [
        {
            "name": x.name,
            "kind": x.kind,
            "row": x.row,
            "mode": e.graph.data[x.mode].index,
            "of": places.get(x.of, len(found)),
            "events": [events.get(name, len(events)) for name in x.events],
            "flag": int(x.flag),
        }
        for x in found
    ]


def row_modes(e: Equations) -> list[int]:
    """Returns for each row of the constraints 1 + the input that is its mode, or 0."""
    modes = [0] * len(e.constraints.names) if e.constraints and e.constraints.meetings else []
    for x in meetings(e):
        modes[x["row"]] = 1 + x["mode"]
    return modes


def modes(e: Equations) -> list[int]:
    """Returns the inputs that say which rows hold, and which frictions slip."""
    found = e.constraints.meetings if e.constraints else ()
    return [e.graph.data[x].index for m in found for x in (m.mode, m.side) if x is not None]
