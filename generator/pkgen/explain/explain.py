"""`pkgen explain` as text: what the model says, its equations, its structure.

Equations are shown in SymPy's words, written out and lightly simplified where they are small;
what is large is shown by its size only. The C does not come from here.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ..back.c.program import operations_text
from ..back.facts import facts, found, invariants, shortened
from ..compiler import Compilation
from ..describe.drawing import shown
from ..equations import Equations, Facts, ParameterSlot, Quantity, Structure, Symmetries
from ..graph.graph import BIT, Kind, Node, Op
from ..middle.analyze import sympy_bridge
from ..model import Event
from .contents import (
    canonical_rows,
    constraint_rows,
    declared,
    freedom,
    lagrangian_rows,
    motion_rows,
    outputs,
    rate_rows,
    rates_title,
    redundant_names,
    section,
)

SHOWN_OPERATIONS = 300  # a longer expression is not shown
NOTHING = "no symmetries, for the model is too large"
WIDE = 40  # columns of an invariant's formula


def explain(compilation: Compilation) -> str:
    """The whole report."""
    e, structure = compilation.equations, compilation.structure
    sections = [
        title(compilation, ", ".join(freedom(e))),
        *(quantities_text(kind, _table(quantities)) for kind, quantities in declared(e)),
        _parameters(e),
        quantities_text("Inputs", _table(e.inputs)),
        _equal("Lagrangian", e, lagrangian_rows(e)),
        _equal(_motion_title(e, structure), e, motion_rows(e)) if e.coordinates else "",
        _constraints(e),
        _equal(rates_title(e), e, rate_rows(e)),
        _equal("Canonical form   q' = dH/dp, p' = -dH/dq + Q", e, canonical_rows(e)),
        section("Outputs", (f"{q.name} = {_valued(e, q, node)}" for q, node in outputs(e))),
        section("Events", _events(e)),
        drawing(compilation),
        _structure(compilation),
        constants_text(invariants(e, structure), structure.symmetries),
        section("Reductions", map(str, compilation.report.lines)),
        section("Kernels", _costs(compilation)),
    ]
    return "\n\n".join(section for section in sections if section) + "\n"


def record(compilation: Compilation) -> dict[str, object]:
    """The same for `--json`."""
    equations, structure = compilation.equations, compilation.structure

    def texts(nodes: Iterable[Node]) -> list[str]:
        return [_text(equations, node) for node in nodes]

    def named(rows: Iterable[tuple[str, Node]]) -> dict[str, str]:
        return {name: _text(equations, node) for name, node in rows}

    return {
        "model": compilation.model.name,
        "description": compilation.model.description,
        "coordinates": [vars(q) for q in equations.coordinates],
        "parameters": [vars(p.quantity) for p in equations.parameters],
        "lagrangian": _text(equations, equations.lagrangian),
        "mass": [texts(row) for row in equations.mass],
        "force": texts(equations.force),
        "states": [
            {**vars(q), "rate": _text(equations, node)}
            for q, node in zip(equations.states, equations.state_rates, strict=True)
        ],
        "canonical": named(canonical_rows(equations)),
        "structure": structure_record(structure),
        "conserved": [name for name, _ in found(equations, structure)],
        **proofs_record(structure),
        "constraints": named(constraint_rows(equations)),
        "events": [
            {
                **vars(q),
                "crosses_zero": _text(equations, node),
                "direction": _DIRECTIONS[event.direction],
                "stop": event.stop,
            }
            for q, event, node in named_events(equations)
        ],
        "drawing": list(shown(compilation.declared)),
        "operations": {k.name: dict(k.operations) for k in compilation.program.kernels},
    }


def drawing(compilation: Compilation) -> str:
    return section("Drawing", shown(compilation.declared))


def structure_record(structure: Facts) -> dict[str, object]:
    """The facts; coordinates by number."""
    shown = {k: v for k, v in vars(structure).items() if k not in ("claims", "symmetries")}
    return {k: list(v) if isinstance(v, tuple) else v for k, v in shown.items()}


def proofs_record(structure: Facts) -> dict[str, object]:
    """What is constant, and how that is proved."""
    symmetries = structure.symmetries
    return {
        "invariants": [
            {"name": x.name, "by": x.reason, "generator": x.generator}
            | ({"for": x.when} if x.when else {})
            for x in (symmetries.invariants if symmetries else ())
        ],
        "searched": symmetries.searched if symmetries else "",
        "claims": [vars(claim) for claim in structure.claims],
    }


def title(compilation: Compilation, freedom: str) -> str:
    model = compilation.model
    said = model.name + (f": {model.description}" if model.description else "")
    return f"{said}\n{freedom}"


def quantities_text(title: str, rows: list[tuple[str, str, str]]) -> str:
    """Names, units and descriptions."""
    width = max((len(name) for name, _, _ in rows), default=0)
    return section(title, (f"{name:<{width}}  {_unit(u):<10} {says}" for name, u, says in rows))


def _table(quantities: Iterable[Quantity]) -> list[tuple[str, str, str]]:
    return [(q.name, q.unit, q.description) for q in quantities]


def _parameters(equations: Equations) -> str:
    rows = [
        (slot.quantity.name, default_text(equations, slot), _bounds(equations, slot), slot.quantity)
        for slot in equations.parameters
    ]
    names, defaults, bounds = (max((len(row[i]) for row in rows), default=0) for i in range(3))
    return section(
        "Parameters",
        (
            f"{name:<{names}} = {default:<{defaults}}  {bound:<{bounds}}  {q.description}"
            for name, default, bound, q in rows
        ),
    )


def default_text(equations: Equations, slot: ParameterSlot) -> str:
    return f"{_constant(equations, slot.default)} {_unit(slot.quantity.unit)}".strip()


def _constant(equations: Equations, node: Node) -> str:
    """A number as a decimal, which is how its author wrote it; else algebra."""
    if equations.graph.op[node] is Op.NUMBER:
        return f"{float(equations.graph.data[node]):.15g}"
    return _text(equations, node)


def _bounds(equations: Equations, slot: ParameterSlot) -> str:
    if slot.lo is None and slot.hi is None:
        return ""
    lo = "-inf" if slot.lo is None else _constant(equations, slot.lo)
    hi = "inf" if slot.hi is None else _constant(equations, slot.hi)
    return f"in {'(' if slot.lo_open else '['}{lo}, {hi}{')' if slot.hi_open else ']'}"


def _unit(unit: str) -> str:
    return f"[{unit}]" if unit else ""


def _equal(title: str, equations: Equations, rows: Iterable[tuple[str, Node]]) -> str:
    return section(title, (f"{name} = {_text(equations, node)}" for name, node in rows))


def _valued(equations: Equations, quantity: Quantity, node: Node) -> str:
    return f"{_text(equations, node)} {_unit(quantity.unit)}".rstrip()


def _motion_title(equations: Equations, structure: Structure) -> str:
    time = ", x" if _of_states(equations) else ""
    time += "" if structure.autonomous else ", t"
    mass = "M" if structure.mass_constant else "M(q" if structure.quadratic else "M(q, q'"
    mass += "" if structure.mass_constant else f"{time})"
    force = "f(q" if structure.separable else "f(q, q'"
    bound = "" if equations.constraints is None else " + J^T lambda"
    return f"Equations of motion   {mass} q'' = {force}{time}){bound}"


def _constraints(equations: Equations) -> str:
    rows = list(constraint_rows(equations))
    width = max((len(name) for name, _ in rows), default=0)
    what = "Constraints   0 =, J their derivatives by the rates; and lambda ="
    lines = [f"{name:<{width}}  {_text(equations, node)}" for name, node in rows]
    lines += [f"{name:<{width}}  follows: redundant" for name in redundant_names(equations)]
    return section(what, lines)


def _of_states(equations: Equations) -> bool:
    """Whether states have a part in the motion of the coordinates."""
    nodes = [*equations.force, *sum(equations.mass, ())]
    return any(equations.graph.depends[node] & BIT[Kind.STATE] for node in nodes)


_DIRECTIONS = {1: "rising", -1: "falling", 0: "either"}


def named_events(equations: Equations) -> Iterator[tuple[Quantity, Event, Node]]:
    return zip(equations.event_names, equations.model.events, equations.events, strict=True)


def _events(equations: Equations) -> Iterator[str]:
    for q, event, node in named_events(equations):
        how = _DIRECTIONS[event.direction] + " stop" * event.stop
        yield f"{q.name}: {_valued(equations, q, node)} {how}"


def _structure(compilation: Compilation) -> str:
    equations, structure = compilation.equations, compilation.structure
    names = [name for name, _ in found(equations, structure)]
    rows = [
        *_families(compilation),
        *facts(equations, structure),
        ("constants", ", ".join(names) or "none proved"),
    ]
    return section("Structure", (f"{name:<16} {text}" for name, text in rows))


def constants_text(rows: list[tuple[str, str]], symmetries: Symmetries | None) -> str:
    """The section about constants of the motion; the same where families are loops."""
    width = min(max((len(name) for name, _ in rows), default=0), WIDE)
    lines = [f"{name:<{width}}  {why}" for name, why in rows]
    if symmetries is not None:
        lines.append(f"(searched: {symmetries.searched or NOTHING})")
        if any(shortened(x.name) != x.name for x in symmetries.invariants):
            lines.append("(long sums are whole in --json)")
    return section("Constants of the motion", lines)


def _families(compilation: Compilation) -> list[tuple[str, str]]:
    model = compilation.model
    if not any(c.range for c in (*model.coordinates, *model.states)):
        return []
    return [("families", f"unrolled: {compilation.equations.unrolled}")]


def _costs(compilation: Compilation) -> Iterator[str]:
    for kernel in compilation.program.kernels:
        yield f"{kernel.name:<14} {operations_text(kernel.operations)}"


def _text(equations: Equations, node: Node) -> str:
    return sympy_bridge.text(equations, node, SHOWN_OPERATIONS)
