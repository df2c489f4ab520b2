"""Typesets the equations of indexed families q[1..N] that are compiled to loops. Each equation is
in terms of the index i."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from pkgen.explain.families import (
    beyond,
    carried_lines,
    carried_says,
    force_lines,
    mass_lines,
    pair_lines,
    rate_lines,
)
from pkgen.explain.rows import EquationLine, Style, Writer
from pkgen.middle.families.equations import FamilyEquations
from pkgen.middle.families.indexed_ir import Group

from . import mathml
from .equations import lets, lines, of_lagrangian
from .mathml import fenced, operator, row
from .tables import heading, lead, listed
from .typeset import Typesetter
from .written import Written

_BREAK = "\0"  # marks positions where a line may break
_ONE = mathml.number("1")
_PLACE = re.compile(r"f\[(.*)\]")


def family_sections(e: FamilyEquations, written: Written) -> Iterator[str]:
    write, plain = Writer(e, _style(e, written)), Writer(e)
    said, lets_there = of_lagrangian(written)
    if e.model.coordinates:
        yield heading("Lagrangian")
    yield from (*lines(said), *lets(lets_there))
    yield heading("Equations of motion")
    yield from _motion(write)
    for over, found in pair_lines(write):
        yield f"<p>and for each pair {mathml.inline(_range(write.over(over)))} added:</p>"
        yield from map(_line, found)
    yield from map(_line, rate_lines(write))
    if e.carried:
        yield f"<p>where {carried_says(plain)}:</p>"
        yield from map(_line, carried_lines(write))
    if e.bound:
        yield lead("Constraints, whose forces are on the right beside f")
        yield from lines(written.constraints())
    said = beyond(plain)
    yield listed(map(_beyond, said)) if said else ""


def _style(e: FamilyEquations, written: Written) -> Style:
    ranked = [x.name for x in (*e.parameters, *e.coordinates)]
    typeset = Typesetter(_Ranks(ranked), _Constants(e.parameters), written.name)
    return Style(
        expression=lambda expr: _BREAK.join(typeset.terms(expr)),
        large=lambda size: mathml.words(f"({size} operations)"),
        total=_total,
        plus=lambda parts: _BREAK.join(
            mathml.binary("+") + part if k else part for k, part in enumerate(parts)
        ),
    )


class _Ranks(dict):
    """Ranks of names for sorting. A member of a family, and a derivative, have the rank of the
    family."""

    def __init__(self, names: Iterable[str]):
        super().__init__((name, k) for k, name in enumerate(names))

    def get(self, name: str, default: int = 0) -> int:
        return super().get(_family(name), default)


class _Constants(frozenset):
    def __new__(cls, groups: Iterable[Group]):
        return super().__new__(cls, (g.name for g in groups))

    def __contains__(self, name: object) -> bool:
        return super().__contains__(_family(str(name)))


def _family(name: str) -> str:
    return name.rstrip("'").partition("[")[0]


def _total(over: str, body: str) -> str:
    inner = body.replace(_BREAK, "")
    return row(_sums(over), fenced(inner) if _BREAK in body else inner)


def _sums(over: str) -> str:
    """Returns a summation sign for each range of a text like "i = 1..N, j = i+1..N"."""
    return "".join(
        mathml.sums(mathml.name(variable), mathml.index(lo), mathml.index(hi))
        for variable, lo, hi in map(_ends, over.split(", "))
    )


def _range(text: str) -> str:
    """Returns the ranges of indices, typeset as i = 1, …, N."""
    shown = []
    for variable, lo, hi in map(_ends, text.split(", ")):
        between = row(operator(","), operator("…"), operator(","))
        ends = row(mathml.index(lo), between, mathml.index(hi))
        shown.append(row(mathml.name(variable), operator("="), ends))
    return row(*(operator(",") + x if k else x for k, x in enumerate(shown)))


def _ends(text: str) -> tuple[str, str, str]:
    variable, _, ends = text.partition(" = ")
    lo, _, hi = ends.partition("..")
    return variable, lo, hi


def _motion(write: Writer) -> Iterator[str]:
    """Yields the rows of M q'' = f. If M is diagonal, with the same index ranges as f, each row is
    one equation; otherwise M and f are listed separately."""
    mass, force = mass_lines(write), force_lines(write)
    inertia = {(line.left, line.range): line.right for line in mass}
    places = [_PLACE.fullmatch(line.left)[1] for line in force]
    own = [(f"M[{at}, {at}]", line.range) for at, line in zip(places, force, strict=True)]
    if write.e.has_pairs or {*own} != {*inertia}:
        yield lead("M q″ = f, by rows")
        yield from map(_line, (*mass, *force))
        return
    for key, at, line in zip(own, places, force, strict=True):
        factor = inertia[key]
        left = mathml.name(f"{at}''")
        if factor != _ONE:
            left = mathml.product([fenced(factor) if _BREAK in factor else factor, left])
        yield _line(line, left)


def _beyond(said: str) -> str:
    """Returns a boundary value like "q[0] = 0 (fixed)", typeset."""
    place, _, rest = said.partition(" = ")
    value, _, kind = rest.rpartition(" (")
    shown = row(mathml.name(place), operator("="), mathml.index(value))
    return f"{mathml.inline(shown)} ({kind}"


def _formula(left: str, right: str, note: str = "") -> str:
    first, *others = right.split(_BREAK)
    return mathml.formula([row(left, operator("="), first), *others], note)


def _line(line: EquationLine, left: str = "") -> str:
    note = f"for {mathml.inline(_range(line.range))}" if line.range else ""
    return _formula(left or mathml.name(line.left), line.right, note)
