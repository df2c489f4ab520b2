"""`pkgen explain` as text: what the model says, its equations, its structure.

Equations are shown in SymPy's words, written out and lightly simplified where they are small;
what is large is shown by its size only. The C does not come from here.
"""

from __future__ import annotations

from collections.abc import Iterator

from ..back.c.program import operations_text
from ..back.facts import facts, found, invariants, shortened
from ..compiler import Compilation
from ..describe.drawing import shown
from ..equations import Equations, ParameterSlot, Quantity, Structure, Symmetries
from ..graph.graph import BIT, Kind, Node, Op
from ..middle.analyze import sympy_bridge
from ..middle.loops.loops import Facts
from ..model import Event
from .bound import constraint_rows, freedom, rates_title

SHOWN_OPERATIONS = 300  # a longer expression is not shown
NOTHING = "no symmetries, for the model is too large"
WIDE = 40  # columns of an invariant's formula


def explain(compilation: Compilation) -> str:
    """The whole report."""
    e = compilation.equations
    sections = [
        _title(compilation),
        _quantities("Coordinates", e.seen),
        _quantities("Body rates", e.rates[len(e.seen) :]),
        _quantities("Attitudes", e.states[: e.quaternions]),
        _quantities("States", e.states[e.quaternions :]),
        _parameters(compilation.equations),
        _quantities("Inputs", compilation.equations.inputs),
        _lagrangian(compilation.equations),
        _equations(compilation.equations, compilation.structure),
        _constraints(compilation.equations),
        _rates(compilation.equations),
        _canonical(compilation.equations),
        _outputs(compilation.equations),
        _events(compilation.equations),
        drawing(compilation),
        _structure(compilation),
        _constants(compilation),
        _reductions(compilation),
        _cost(compilation),
    ]
    return "\n\n".join(section for section in sections if section) + "\n"


def record(compilation: Compilation) -> dict[str, object]:
    """The same for `--json`."""
    equations, structure = compilation.equations, compilation.structure
    n = len(equations.coordinates)
    return {
        "model": compilation.model.name,
        "description": compilation.model.description,
        "coordinates": [vars(q) for q in equations.coordinates],
        "parameters": [vars(p.quantity) for p in equations.parameters],
        "lagrangian": _text(equations, equations.lagrangian),
        "mass": [[_text(equations, equations.mass[i][j]) for j in range(n)] for i in range(n)],
        "force": [_text(equations, node) for node in equations.force],
        "states": [
            {**vars(q), "rate": _text(equations, node)}
            for q, node in zip(equations.states, equations.state_rates, strict=True)
        ],
        "canonical": {name: _text(equations, node) for name, node in canonical_rows(equations)},
        "structure": structure_record(structure),
        "conserved": [name for name, _ in found(equations, structure)],
        **proofs_record(structure),
        "constraints": {name: _text(equations, node) for name, node in constraint_rows(equations)},
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
    return "\n".join(["Drawing", *(f"  {line}" for line in shown(compilation.declared))])


def structure_record(structure: Structure | Facts) -> dict[str, object]:
    """The facts; coordinates by number."""
    shown = {k: v for k, v in vars(structure).items() if k not in ("claims", "symmetries")}
    return {k: list(v) if isinstance(v, tuple) else v for k, v in shown.items()}


def proofs_record(structure: Structure | Facts) -> dict[str, object]:
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


def _title(compilation: Compilation) -> str:
    model = compilation.model
    title = model.name + (f": {model.description}" if model.description else "")
    return f"{title}\n{', '.join(freedom(compilation.equations))}"


def _quantities(title: str, quantities: tuple[Quantity, ...]) -> str:
    if not quantities:
        return ""
    width = max(len(q.name) for q in quantities)
    lines = [f"  {q.name:<{width}}  {_unit(q.unit):<10} {q.description}" for q in quantities]
    return "\n".join([title, *(line.rstrip() for line in lines)])


def _parameters(equations: Equations) -> str:
    if not equations.parameters:
        return ""
    rows = [
        (slot.quantity.name, default_text(equations, slot), _bounds(equations, slot), slot.quantity)
        for slot in equations.parameters
    ]
    names, defaults, bounds = (max(len(row[i]) for row in rows) for i in range(3))
    lines = [
        f"  {name:<{names}} = {default:<{defaults}}  {bound:<{bounds}}  {q.description}".rstrip()
        for name, default, bound, q in rows
    ]
    return "\n".join(["Parameters", *lines])


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


def _lagrangian(equations: Equations) -> str:
    if not equations.coordinates:
        return ""
    lines = ["Lagrangian", f"  L = {_text(equations, equations.lagrangian)}"]
    if equations.kinetic is not None and equations.potential is not None:
        lines.append(f"  T = {_text(equations, equations.kinetic)}")
        lines.append(f"  V = {_text(equations, equations.potential)}")
    return "\n".join(lines)


def _equations(equations: Equations, structure: Structure) -> str:
    if not equations.coordinates:
        return ""
    time = ", x" if _of_states(equations) else ""
    time += "" if structure.autonomous else ", t"
    mass = "M" if structure.mass_constant else "M(q" if structure.quadratic else "M(q, q'"
    mass += "" if structure.mass_constant else f"{time})"
    force = "f(q" if structure.separable else "f(q, q'"
    lines = [f"Equations of motion   {mass} q'' = {force}{time})"]
    names, c = equations.moving, equations.constraints
    applied = equations.force if c is None else c.free_force
    if c is not None:
        lines[0] += " + J^T lambda"
    zero = equations.graph.number(0)
    for i, row in enumerate(equations.mass):
        for j in range(i + 1):
            if row[j] != zero:
                lines.append(f"  M[{names[i]}, {names[j]}] = {_text(equations, row[j])}")
    lines += [f"  f[{n}] = {_text(equations, f)}" for n, f in zip(names, applied, strict=True)]
    return "\n".join(lines)


def _constraints(equations: Equations) -> str:
    rows = list(constraint_rows(equations))
    width = max((len(name) for name, _ in rows), default=0)
    lines = [f"  {name:<{width}}  {_text(equations, node)}" for name, node in rows]
    what = "Constraints   0 =, J their derivatives by the rates; and lambda ="
    return "\n".join([what, *lines]) if lines else ""


def _of_states(equations: Equations) -> bool:
    """Whether states have a part in the motion of the coordinates."""
    nodes = [*equations.force, *sum(equations.mass, ())]
    return any(equations.graph.depends[node] & BIT[Kind.STATE] for node in nodes)


def _rates(equations: Equations) -> str:
    lines = [
        f"  {q.name}' = {_text(equations, node)}"
        for q, node in zip(equations.states, equations.state_rates, strict=True)
    ]
    return "\n".join([rates_title(equations), *lines]) if lines else ""


def canonical_rows(equations: Equations) -> list[tuple[str, Node]]:
    """H(q, p) and its gradients, each under its name, if they were asked for."""
    h = equations.hamiltonian
    if h is None:
        return []
    slopes = [
        (f"dH/d({q.name})", node)
        for quantities, row in ((equations.coordinates, h.by_q), (equations.momenta_names, h.by_p))
        for q, node in zip(quantities, row, strict=True)
    ]
    return [("H", h.energy), *slopes]


def _canonical(equations: Equations) -> str:
    lines = [f"  {name} = {_text(equations, node)}" for name, node in canonical_rows(equations)]
    return "\n".join(["Canonical form   q' = dH/dp, p' = -dH/dq + Q", *lines]) if lines else ""


def _outputs(equations: Equations) -> str:
    lines = [
        f"  {q.name} = {_text(equations, node)} {_unit(q.unit)}".rstrip()
        for q, node in (
            *zip(equations.observed_names, equations.observed, strict=True),
            *zip(equations.conserved_names, equations.conserved, strict=True),
        )
    ]
    return "\n".join(["Outputs", *lines]) if lines else ""


_DIRECTIONS = {1: "rising", -1: "falling", 0: "either"}


def named_events(equations: Equations) -> Iterator[tuple[Quantity, Event, Node]]:
    return zip(equations.event_names, equations.model.events, equations.events, strict=True)


def _events(equations: Equations) -> str:
    lines = [
        f"  {q.name}: {_text(equations, node)} {_unit(q.unit)}".rstrip()
        + f" {_DIRECTIONS[event.direction]}{' stop' if event.stop else ''}"
        for q, event, node in named_events(equations)
    ]
    return "\n".join(["Events", *lines]) if lines else ""


def _structure(compilation: Compilation) -> str:
    equations, structure = compilation.equations, compilation.structure
    names = [name for name, _ in found(equations, structure)]
    rows = [
        *_families(compilation),
        *facts(equations, structure),
        ("constants", ", ".join(names) or "none proved"),
    ]
    return "\n".join(["Structure", *(f"  {name:<16} {text}" for name, text in rows)])


def _constants(compilation: Compilation) -> str:
    return constants_text(
        invariants(compilation.equations, compilation.structure), compilation.structure.symmetries
    )


def constants_text(rows: list[tuple[str, str]], symmetries: Symmetries | None) -> str:
    """The section about constants of the motion; the same where families are loops."""
    lines = []
    if rows:
        width = min(max(len(name) for name, _ in rows), WIDE)
        lines = ["Constants of the motion", *(f"  {name:<{width}}  {why}" for name, why in rows)]
    if symmetries is not None:
        lines = lines or ["Constants of the motion"]
        lines.append(f"  (searched: {symmetries.searched or NOTHING})")
        if any(shortened(x.name) != x.name for x in symmetries.invariants):
            lines.append("  (long sums are whole in --json)")
    return "\n".join(lines)


def _families(compilation: Compilation) -> list[tuple[str, str]]:
    model = compilation.model
    if not any(c.range for c in (*model.coordinates, *model.states)):
        return []
    return [("families", f"unrolled: {compilation.equations.unrolled}")]


def _reductions(compilation: Compilation) -> str:
    lines = compilation.report.lines
    return "\n".join(["Reductions", *(f"  {line}" for line in lines)]) if lines else ""


def _cost(compilation: Compilation) -> str:
    lines = ["Kernels"]
    for kernel in compilation.program.kernels:
        lines.append(f"  {kernel.name:<14} {operations_text(kernel.operations)}")
    return "\n".join(lines)


def _text(equations: Equations, node: Node) -> str:
    return sympy_bridge.text(equations, node, SHOWN_OPERATIONS)
