"""The equations of a model whose families are loops, typeset: one row stands for all."""

from __future__ import annotations

from collections.abc import Iterable

from ..compiler import Compilation
from ..system import page
from . import mathml
from .loops import beyond, force_lines, mass_lines, name_of, pair_lines, pair_range, total_of
from .rows import EquationLine, Style, Writer

STYLE = Style(
    expression=mathml.expression,
    large=lambda size: mathml.words(f"({size} operations)"),
    total=mathml.total,
    plus=mathml.plus,
)


def loop_sections(compilation: Compilation) -> Iterable[str]:
    e = compilation.equations
    write, plain = Writer(e, STYLE), Writer(e)
    yield page.heading("Coordinates")
    yield page.table(
        ("", "unit", ""),
        [(name_of(write, g), g.declared.unit, g.declared.description) for g in e.coordinates],
    )
    if e.parameters:
        yield page.heading("Parameters")
        rows = [(name_of(write, g), g.declared.unit, g.declared.description) for g in e.parameters]
        yield page.table(("", "unit", ""), rows)
    yield page.heading("Lagrangian")
    energies = [("T", e.kinetic), ("V", e.potential)]
    if e.kinetic is None or e.potential is None:
        energies = [("L", e.lagrangian)]
    for name, total in energies:
        yield mathml.block(mathml.equation(mathml.name(name), total_of(write, total)))
    yield page.heading("Equations of motion")
    for line in (*mass_lines(write), *force_lines(write)):
        yield _line(line)
    for pair in e.force.pairs:
        yield f"<p>and for each pair {pair_range(write, pair)} added:</p>"
        for line in pair_lines(write, pair):
            yield _line(line)
    said = beyond(plain)
    yield page.items(said) if said else ""


def _line(line: EquationLine) -> str:
    parts = [mathml.equation(mathml.name(line.left), line.right)]
    if line.range:
        parts.append(mathml.words(f"   for {line.range}"))
    return mathml.block(mathml.row(*parts))
