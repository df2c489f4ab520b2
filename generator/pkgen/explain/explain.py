"""`pkgen explain` as text: the model's statements, its equations, its structure. Nothing here
affects the generated C.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..back.facts import facts, found, invariants, shortened
from ..compiler import Compilation
from ..describe.drawing import shown
from ..equations import ParameterSlot, Quantity
from ..graph.graph import Node, Op
from ..middle.structure import Structure, Symmetries
from ..model import Event, Model
from . import families, flat
from .contents import Contents, section

NOTHING = "no symmetries, for the model is too large"
# In a list of invariants and proofs, the column of invariants is at most this many characters wide.
WIDE = 40


def contents(compilation: Compilation) -> Contents:
    return (flat if compilation.equations.dense else families).contents(compilation)


def explain(compilation: Compilation, costs: bool = False) -> str:
    """Returns the whole report; with `costs`, also the number of operations of each kernel."""
    e, structure, model = compilation.equations, compilation.structure, compilation.model
    c = contents(compilation)
    said = model.name + (f": {model.description}" if model.description else "")
    names = ", ".join(name for name, _ in found(e, structure)) or "none proved"
    rows = [*c.families, *facts(e, structure), ("constants", names)]
    sections = [
        f"{said}\n{c.freedom}",
        *(_quantities(kind, quantities) for kind, quantities in c.declared),
        _parameters(c),
        _quantities("Inputs", e.inputs),
        *(section(title, lines) for title, lines in c.equations),
        section("Outputs", _outputs(c)),
        section("Events", _events(c)),
        section("Sample blocks", _samples(compilation.declared)),
        section("Noise", _noises(compilation.declared)),
        section("Drawing", shown(compilation.declared)),
        section("Structure", (f"{name:<16} {text}" for name, text in rows)),
        constants_text(invariants(e, structure), structure.symmetries),
        section("Reductions", map(str, compilation.report.lines)),
        section(*c.costs) if costs else "",
    ]
    return "\n\n".join(section for section in sections if section) + "\n"


def record(compilation: Compilation) -> dict[str, object]:
    """Returns the report as data, for `--json`."""
    c = contents(compilation)
    return {
        "model": compilation.model.name,
        "description": compilation.model.description,
        **c.record,
        "structure": {
            k: list(v) if isinstance(v, tuple) else v
            for k, v in vars(compilation.structure).items()
            if k not in ("claims", "symmetries")
        },
        **proofs_record(compilation.structure),
        "outputs": {
            f"{name} for {span}" if span else name: c.text(node)
            for name, _, node, span in c.outputs
        },
        "events": [
            {"name": q.name, "unit": q.unit, "description": q.description}
            | {"crosses_zero": c.text(node), "direction": _DIRECTIONS[event.direction]}
            | {"stop": event.stop}
            for q, event, node in named_events(c)
        ],
        "drawing": list(shown(compilation.declared)),
    }


def proofs_record(structure: Structure) -> dict[str, object]:
    """Returns the constants of the motion with their proofs, and those claimed by the author."""
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


def _quantities(title: str, quantities: Sequence[Quantity]) -> str:
    """Returns a section with names, units and descriptions."""
    width = max((len(q.name) for q in quantities), default=0)
    lines = (f"{q.name:<{width}}  {_unit(q.unit):<10} {q.description}" for q in quantities)
    return section(title, lines)


def _samples(model: Model) -> Iterator[str]:
    text = model.source.text
    for block in model.samples:
        line = text[block.head.start : block.head.end].removeprefix("sample").strip()
        sets = ", ".join(x.name for x in model.inputs if x.by == block.name and "." not in x.name)
        yield f"{line}: sets {sets}"


def _noises(model: Model) -> Iterator[str]:
    for item in model.noises:
        yield model.source.text[item.span.start : item.span.end].removeprefix("noise").strip()


def _parameters(c: Contents) -> str:
    rows = [
        (q.name, f"{_constant(c, x.default)} {_unit(q.unit)}".strip(), _bounds(c, x), q.description)
        for x in c.parameters
        for q in [x.quantity]
    ]
    names, defaults, bounds = (max((len(row[i]) for row in rows), default=0) for i in range(3))
    form = f"{{:<{names}}} = {{:<{defaults}}}  {{:<{bounds}}}  {{}}"
    return section("Parameters", (form.format(*row) for row in rows))


def _constant(c: Contents, node: Node) -> str:
    """Returns a constant as a decimal; other nodes as expressions."""
    if c.e.graph.op[node] is Op.NUMBER:
        return f"{float(c.e.graph.data[node]):.15g}"
    return c.text(node)


def _bounds(c: Contents, x: ParameterSlot) -> str:
    if x.lo is None and x.hi is None:
        return ""
    lo = "-inf" if x.lo is None else _constant(c, x.lo)
    hi = "inf" if x.hi is None else _constant(c, x.hi)
    return f"in {'(' if x.lo_open else '['}{lo}, {hi}{')' if x.hi_open else ']'}"


def _unit(unit: str) -> str:
    return f"[{unit}]" if unit else ""


def _valued(c: Contents, unit: str, node: Node) -> str:
    return f"{c.text(node)} {_unit(unit)}".rstrip()


_DIRECTIONS = {1: "rising", -1: "falling", 0: "either"}


def _outputs(c: Contents) -> Iterator[str]:
    for name, unit, node, span in c.outputs:
        yield f"{name} = {_valued(c, unit, node)}" + (f"   for {span}" if span else "")


def named_events(c: Contents) -> Iterator[tuple[Quantity, Event, Node]]:
    return zip(c.e.event_names, c.e.model.events, c.e.events, strict=True)


def _events(c: Contents) -> Iterator[str]:
    for q, event, node in named_events(c):
        how = _DIRECTIONS[event.direction] + " stop" * event.stop
        yield f"{q.name}: {_valued(c, q.unit, node)} {how}"


def constants_text(rows: list[tuple[str, str]], symmetries: Symmetries | None) -> str:
    """Returns the section about constants of the motion; `rows` are (name, proof)."""
    width = min(max((len(name) for name, _ in rows), default=0), WIDE)
    lines = [f"{name:<{width}}  {why}" for name, why in rows]
    if symmetries is not None:
        lines.append(f"(searched: {symmetries.searched or NOTHING})")
        if any(shortened(x.name) != x.name for x in symmetries.invariants):
            lines.append("(long sums are whole in --json)")
    return section("Constants of the motion", lines)
