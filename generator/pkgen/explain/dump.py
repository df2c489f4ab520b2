"""`--dump=STAGE`: the result of a compiler stage as text, for developers of pkgen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from itertools import islice

from ..back.c.program import FamilyProgram, Program
from ..compiler import STAGES, stages
from ..equations import Equations
from ..graph.graph import Graph
from ..source import Diagnostic, Source, Span


def dump(
    stage: str,
    source: Source,
    sizes: Mapping[str, int],
    kernels: frozenset[str] | None,
    libm: bool = False,
) -> str:
    """Returns the result of a stage for a model, as text; later stages do not run."""
    made = next(islice(stages(source, sizes, kernels, libm=libm), STAGES.index(stage), None))
    if stage == "lower":  # the parts of a scene are not dumped
        made, *_ = made
    return as_text(made, source)


def equations_text(equations: Equations) -> str:
    """Returns the expression graph, a node per line, then the nodes in each field of Equations."""
    graph = equations.graph
    lines = [f"%{node} = {_node_text(graph, node)}" for node in range(len(graph.op))]
    for field in fields(equations):
        value = getattr(equations, field.name)
        if field.name not in ("model", "graph"):
            lines.append(f"{field.name}: {value}")
    return "\n".join(lines)


def _node_text(graph: Graph, node: int) -> str:
    arguments = (f"%{a}" for a in graph.args[node])
    words = graph.op[node], graph.data[node], *arguments
    return " ".join(str(word) for word in words if word is not None)


def as_text(value: object, source: Source, indent: int = 0) -> str:
    """Returns nested dataclasses as indented text, with source positions as line:column."""
    pad = "  " * indent
    match value:
        case Source():
            return value.path
        case Equations():
            return equations_text(value)
        case FamilyProgram(context=context):
            return as_text(context, source, indent)
        case Diagnostic():
            return value.text(source)
        case Span():
            line, column = source.position(value.start)
            return f"{line}:{column}"
        case Program():
            return str(value)
        case dict():
            head, empty, rows = "", "{}", [(f"{k}:", v) for k, v in value.items()]
        case tuple() | list():
            head, empty, rows = "", "()", [("-", item) for item in value]
        case _ if is_dataclass(value):
            rows = [(f"{f.name}:", getattr(value, f.name)) for f in fields(value)]
            head = empty = type(value).__name__
        case _:
            return str(value)
    lines = [f"{pad}  {name} {as_text(part, source, indent + 1)}" for name, part in rows]
    return "\n".join([head, *lines]) if lines else empty
