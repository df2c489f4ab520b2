"""`--dump=STAGE`: the result of any stage as text, for whoever works on the stages."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from fractions import Fraction

from .back import lower, render
from .equations import Equations
from .front import check, parse
from .middle import analyze, derive, reduce
from .middle.graph import Graph, Op
from .source import Source, Span

Kernels = frozenset[str] | None


def _parse(source: Source, sizes: Mapping[str, int], kernels: Kernels) -> str:
    return as_text(parse.parse(source), source)


def _check(source: Source, sizes: Mapping[str, int], kernels: Kernels) -> str:
    return as_text(check.check_text(source, sizes)[0], source)


def _equations(source: Source, sizes: Mapping[str, int], kernels: Kernels) -> Equations:
    return derive.derive(check.check_text(source, sizes)[0], kernels)


def _derive(source: Source, sizes: Mapping[str, int], kernels: Kernels) -> str:
    return equations_text(_equations(source, sizes, kernels))


def _analyze(source: Source, sizes: Mapping[str, int], kernels: Kernels) -> str:
    return as_text(analyze.analyze(_equations(source, sizes, kernels)), source)


def _reduce(source: Source, sizes: Mapping[str, int], kernels: Kernels) -> str:
    equations = _equations(source, sizes, kernels)
    reduced, report = reduce.reduce(equations, analyze.analyze(equations))
    return as_text(report, source) + "\n" + equations_text(reduced)


def _program(source: Source, sizes: Mapping[str, int], kernels: Kernels) -> lower.Program:
    equations = _equations(source, sizes, kernels)
    structure = analyze.analyze(equations)
    equations, _ = reduce.reduce(equations, structure)
    return lower.lower(equations, structure, kernels)


def _lower(source: Source, sizes: Mapping[str, int], kernels: Kernels) -> str:
    return str(_program(source, sizes, kernels))


def _render(source: Source, sizes: Mapping[str, int], kernels: Kernels) -> str:
    files = render.render(_program(source, sizes, kernels))
    return "\n".join(f"==> {name} <==\n{text}" for name, text in files.items())


STAGES: dict[str, Callable[[Source, Mapping[str, int], Kernels], str]] = {
    "parse": _parse,
    "check": _check,
    "derive": _derive,
    "analyze": _analyze,
    "reduce": _reduce,
    "lower": _lower,
    "render": _render,
}


def equations_text(equations: Equations) -> str:
    """The graph a node a line, then which nodes each result consists of."""
    graph = equations.graph
    lines = [f"%{node} = {_node_text(graph, node)}" for node in range(len(graph.op))]
    for field in fields(equations):
        value = getattr(equations, field.name)
        if field.name not in ("model", "graph"):
            lines.append(f"{field.name}: {value}")
    return "\n".join(lines)


def _node_text(graph: Graph, node: int) -> str:
    arguments = " ".join(f"%{a}" for a in graph.args[node])
    data = graph.data[node]
    match graph.op[node]:
        case Op.SYMBOL:
            return f"{data.kind.name.lower()} {data.index}"
        case Op.NUMBER:
            return str(data)
        case Op.CALL:
            return f"{data} {arguments}"
        case op:
            return f"{op.name.lower()} {arguments}" + (f" {data}" if data is not None else "")


def as_text(value: object, source: Source, indent: int = 0) -> str:
    """A nest of dataclasses as indented text, places as line:column."""
    pad = "  " * indent
    match value:
        case Source():
            return value.path
        case Span():
            line, column = source.position(value.start)
            return f"{line}:{column}"
        case Fraction() | str() | int() | float() | None:
            return str(value)
        case dict():
            rows = [f"{pad}  {k}: {as_text(v, source, indent + 1)}" for k, v in value.items()]
            return "\n".join(["", *rows]) if rows else "{}"
        case tuple() | list():
            rows = [f"{pad}  - {as_text(item, source, indent + 1)}" for item in value]
            return "\n".join(["", *rows]) if rows else "()"
        case _ if is_dataclass(value):
            rows = [
                f"{pad}  {f.name}: {as_text(getattr(value, f.name), source, indent + 1)}"
                for f in fields(value)
            ]
            return "\n".join([type(value).__name__, *rows])
    return repr(value)
