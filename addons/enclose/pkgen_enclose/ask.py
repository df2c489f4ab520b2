"""Reads the options of `run --enclose` as exact numbers, and refuses unsupported models."""

from __future__ import annotations

import argparse
from fractions import Fraction
from typing import NoReturn

from pkgen.compiler import Compilation
from pkgen.front.check.scene_numbers import within_bounds
from pkgen.functions import FUNCTIONS
from pkgen.graph.differentiate import reachable
from pkgen.graph.graph import Graph, Kind, Node, Op, Symbol
from pkgen.indices import hidden, indexed
from pkgen.middle.refused import refuse_statements
from pkgen.run import named
from pkgen.run.values import Values, assignment
from pkgen.scenes import run_settings as parsing
from pkgen.scenes import scene as scenes
from pkgen.source import Span
from pkgen.system.exits import UsageError

from .flow import Ends, Given

DIGITS = 15
MOST_DIGITS = 500
# Options of `pkgen run` that --enclose refuses, by their names in argparse.
FOREIGN = (
    *("method", "step", "max_step", "rtol", "atol", "at", "ensemble", "threads", "diagnose"),
    *("plot", "report", "columns", "phase", "path", "spectrum"),
)


class Exact(Values):
    """Values of options as exact rational numbers, equal to the written decimals."""

    def kept(self, found: Fraction | float) -> Fraction:  # type: ignore[override]
        return decimal(found)


def decimal(value: Fraction | float) -> Fraction:
    """Returns the shortest decimal that denotes a double, as an exact fraction."""
    return value if isinstance(value, Fraction) else Fraction(repr(float(value)))


def digits(text: str | None) -> int:
    if text is None:
        return DIGITS
    if not text.isdecimal() or not 1 <= int(text) <= MOST_DIGITS:
        raise UsageError(f"--digits {text}: give a whole number from 1 to {MOST_DIGITS}")
    return int(text)


def refuse_options(options: argparse.Namespace) -> None:
    for name in FOREIGN:
        if getattr(options, name, None):
            option = "--" + name.replace("_", "-")
            raise UsageError(
                f"{option}: --enclose has a method of its own and one trajectory, and writes rows "
                f"alone: leave {option} out"
            )
    if options.output and options.output != "-" and not options.output.endswith(".csv"):
        raise UsageError(f"-o {options.output}: bounds are written as text: FILE.csv")


def ends(options: argparse.Namespace) -> tuple[argparse.Namespace, argparse.Namespace]:
    """Returns the options twice: with the lower and with the upper ends of values NAME=LO..HI."""
    both = argparse.Namespace(**vars(options)), argparse.Namespace(**vars(options))
    for side, each in enumerate(both):
        for option in ("set", "start"):
            texts = [_end(f"--{option}", text, side) for text in getattr(options, option)]
            setattr(each, option, texts)
    return both


def _end(option: str, text: str, side: int) -> str:
    left, _, value = text.partition("=")
    parts = value.split("..")
    if len(parts) == 1:
        return text
    if len(parts) > 2 or not all(map(str.strip, parts)):
        raise UsageError(f"{option} {text}: bounds are NAME=LO..HI, e.g. {option} {left}=0.9..1.1")
    return f"{left}={parts[side]}"


def given(both: tuple[argparse.Namespace, argparse.Namespace], compilation: Compilation) -> Given:
    """Returns exact data from the options with lower and upper ends. Raises UsageError for
    unsupported models."""
    options, e = both[0], compilation.equations
    chosen = scenes.of(options, compilation.declared)
    settings = parsing.settings(options, compilation, None, chosen)
    columns = _columns(compilation, settings)
    refuse(compilation, [node for _, node in columns])
    exact = Exact(compilation)
    low = _values(exact, options, settings)
    upper = parsing.settings(both[1], compilation, None, chosen)
    parameters, coordinates, rates = map(
        _between, low, _values(exact, both[1], upper), ("--set", "--start", "--start")
    )
    numbers = exact.of_run(options)
    until = numbers.until or decimal(settings.until)
    every = numbers.every or decimal(settings.every)
    if numbers.every is None and (chosen is None or chosen.record is None):
        every = until / round(until / every)
    return Given(
        equations=e,
        parameters=parameters,
        coordinates=coordinates,
        rates=rates,
        names=tuple(name for name, _ in columns),
        columns=tuple(node for _, node in columns),
        until=until,
        every=every,
    )


def _values(exact: Exact, options: argparse.Namespace, settings) -> tuple[dict, dict, dict]:
    """Returns parameters, coordinates and rates by index, equal to the written decimals."""
    parameters = {k: decimal(x) for k, x in settings.parameters}
    sets = [assignment("--set", text) for text in options.set if _number(text)]
    parameters |= exact.assigned(sets)[0]
    start_q, start_v, of_parameters = exact.starts(options.start)
    _refuse_beyond(exact, {k: float(x) for k, x in parameters.items()})
    return parameters | of_parameters, start_q, start_v


def _refuse_beyond(exact: Exact, values: dict[int, float]) -> None:
    declared = {p.name: p for p in exact.model.parameters}
    keys = named.by_key(named.parameters(exact.compilation), values)
    for (name, index), x in keys.items():
        item = declared.get(name)
        if item and not within_bounds(exact.model, item, index, x, keys):
            raise UsageError(f"--set {indexed(name, index)}={x:g}: outside its bounds: {name}")


def _between(low: dict, high: dict, option: str) -> dict[int, Ends]:
    for k, x in low.items():
        if x > high[k]:
            raise UsageError(
                f"{option}: bounds are NAME=LO..HI, and {float(x):g} is above {float(high[k]):g}"
            )
    return {k: (x, high[k]) for k, x in low.items()}


def _number(text: str) -> bool:
    from pkgen.scenes.options import is_motion

    return not is_motion(text)


def _columns(compilation: Compilation, settings) -> list[tuple[str, Node]]:
    e = compilation.equations
    g, n = e.graph, len(e.rates)
    kinds = named.kinds(compilation)
    shown = [(c.kind, c.index, c.name) for c in settings.show] or [
        (kind, known[name][0], name)
        for kind, known in kinds.items()
        for name in (q.name for d in known.declared for q in d.members())
        if not hidden(name)
    ]

    def node(kind: str, i: int) -> Node:
        if kind == "q":
            return g.symbol(Symbol(Kind.COORDINATE, i))
        if kind == "v":
            symbol = Symbol(Kind.RATE, i) if i < n else Symbol(Kind.STATE, i - n)
            return g.symbol(symbol)
        return e.energy if kind == "energy" else e.observed[i]

    return [(name, node(kind, i)) for kind, i, name in shown]


def refuse(compilation: Compilation, columns: list[Node]) -> None:
    """Raises UsageError, with position and advice, if the model has no power series."""
    e, model = compilation.equations, compilation.model

    def wrong(span: Span, why: str, advice: str) -> NoReturn:
        place = model.source.place(span)
        raise UsageError(f"{place}: {why}, and --enclose {advice}")

    refuse_statements(model, "--enclose")
    if model.inputs:
        item = model.inputs[0]
        advice = f"knows no inputs: declare it by param, or --set {item.name}=EXPRESSION of t"
        wrong(item.span, f"'{item.name}' is an input", advice)
    for event in model.events:
        if event.stop:
            advice = "locates no events: leave the event's 'stop' out"
            wrong(event.span, f"event '{event.name}' stops the run", advice)
    if e.acceleration is None:
        advice = "solves them in balls for some 20 coordinates at most: take fewer by --size"
        wrong(model.span, "the accelerations are too large to be written out", advice)
    nodes = [*e.acceleration, *e.state_rates, *columns]
    name = _without_series(e.graph, nodes)
    if name:
        shown = FUNCTIONS[name].table or name
        advice = (
            f"bounds motions by power series, which {shown} has none of where it bends or jumps: "
            f"write the side that the motion is on, or round it off (sqrt(x^2 + d^2) for abs(x))"
        )
        wrong(_place_of(compilation, name), f"the equations have {shown}()", advice)


def _without_series(g: Graph, nodes: list[Node]) -> str:
    """Returns the name of a function in the nodes that has no power series; "" if all have."""
    varying = (n for n in reachable(g, nodes) if not g.is_constant(n))
    calls = [g.data[n] for n in varying if g.op[n] is Op.CALL]
    found = [x for x in calls if not FUNCTIONS[x].smooth or FUNCTIONS[x].enclosed is None]
    # abs has the derivative sign; min and max have the derivative step. Any other function found is
    # one that the author wrote, and is preferred.
    return min(found, key=lambda name: name in ("sign", "step")) if found else ""


def _place_of(compilation: Compilation, name: str) -> Span:
    """Returns the position of a call of the function in the source text; if there is none, the
    position of the model statement."""
    import re

    model = compilation.model
    wanted = {"sign": "sign|abs", "step": "step|min|max|clamp"}.get(name, f"{name}|clamp")
    code = re.sub(r"#[^\n]*", lambda m: " " * len(m[0]), model.source.text)
    match = re.search(rf"\b({wanted})\s*\(", code)
    return model.span if match is None else Span(match.start(1), match.end(1))
