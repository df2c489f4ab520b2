"""Expands families of bodies and joints: `body link[1..N] …`, `joint j[i = 2..N]: link[i-1] to
link[i] …` become one statement for each member, with numbers as indices. The tree of bodies needs
every single body, so these families cannot stay loops."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Container, Mapping
from contextlib import suppress
from dataclasses import fields, replace
from fractions import Fraction

from ... import limits
from ...indices import NotAnInteger, integer
from ...source import Span
from ...tree import Expr, Number, of_member
from .. import statements as st

OfBodies = st.Body | st.Joint
TOO_MANY = f"more than {limits.STATEMENTS:,} statements, families of bodies written out"


def written_out(
    file: st.File,
    given: Mapping[str, int],
    taken: Container[str],
    tell: Callable[[str, Span, str], None],
) -> st.File:
    """Returns the file with one statement for each member of a family. Reports a wrong index
    through the function `tell` and drops its statement. `given` has the sizes set on the command
    line; `taken` has the names that cannot be loop variables."""
    if not any(indices(s) for s in file.statements):
        return file
    sizes = _sizes(file, given)
    statements = Counter((type(s), s.left.name) for s in file.statements if isinstance(s, OfBodies))
    found: list[st.Statement] = []
    broken = [*file.broken]
    told: set[str] = set()
    for statement in file.statements:
        if not isinstance(statement, OfBodies):
            found.append(statement)
            continue
        try:
            shared = statements[type(statement), statement.left.name] > 1
            found += _members(statement, sizes, taken, limits.STATEMENTS - len(found), shared)
        except NotAnInteger as wrong:
            help = "" if "not a size" not in wrong.message else "declare it with 'size'"
            if wrong.message != TOO_MANY or not told:
                tell(wrong.message, wrong.span, help)
            told |= {wrong.message} & {TOO_MANY}
            names = statement.left.name, *(end.id for end in getattr(statement, "ends", ()))
            broken.append(st.Broken(statement.keyword, names, statement.span))
    return replace(file, statements=tuple(found), broken=tuple(broken))


def indices(statement: st.Statement) -> list[Expr]:
    """Returns the index and range expressions of a body or joint, [] for other statements."""
    if not isinstance(statement, OfBodies):
        return []
    ends = statement.ends if isinstance(statement, st.Joint) else ()
    left, of = statement.left, statement.left.range
    found = [left.index, *((of.lo, of.hi) if of is not None else ()), *(e.index for e in ends)]
    return [expr for expr in found if expr is not None]


def _sizes(file: st.File, given: Mapping[str, int]) -> dict[str, int]:
    found: dict[str, int] = {}
    for statement in file.statements:
        if isinstance(statement, st.Define) and statement.keyword == "size":
            with suppress(NotAnInteger):  # Definitions.size reports the error.
                found[statement.left.name] = integer(statement.value, found)
            found |= {k: v for k, v in given.items() if k == statement.left.name}
    return found


def _members(
    statement: OfBodies, sizes: Mapping[str, int], taken: Container[str], most: int, shared: bool
) -> list[OfBodies]:
    """Returns one statement for each member of a family of bodies or joints. `shared` means that
    other statements add members to the same family, so that this one may have an empty range."""
    left = statement.left
    if left.range is None:
        return [_with_numbers(statement, sizes)]
    lo, hi = integer(left.range.lo, sizes), integer(left.range.hi, sizes)
    if lo > hi + shared:
        raise NotAnInteger(f"an empty family: {lo}..{hi}", left.range.span)
    if hi - lo >= most:
        raise NotAnInteger(TOO_MANY, left.range.span)
    variable = left.range.variable
    if variable in taken:
        message = f"the loop variable '{variable}' has another meaning in this model"
        raise NotAnInteger(message, left.range.span)
    found = []
    for k in range(lo, hi + 1):
        number = Number(Fraction(k), left.range.span)
        one = replace(statement, left=replace(left, range=None, index=number))
        found.append(_with_numbers(_at(one, variable, number) if variable else one, sizes))
    return found


def _with_numbers(statement: OfBodies, sizes: Mapping[str, int]) -> OfBodies:
    """Returns the statement with its indices, also those of the joint's two bodies, as numbers."""

    def number(index: Expr | None) -> Number | None:
        return None if index is None else Number(Fraction(integer(index, sizes)), index.span)

    left = replace(statement.left, index=number(statement.left.index))
    if isinstance(statement, st.Body):
        return replace(statement, left=left)
    ends = tuple(replace(end, index=number(end.index)) for end in statement.ends)
    return replace(statement, left=left, ends=ends)


def _at(part: object, variable: str, number: Number) -> object:
    """Returns a statement, or a part of it, with the loop variable replaced by a number."""
    if isinstance(part, Expr):
        return of_member(part, variable, number)
    if isinstance(part, tuple):
        return tuple(_at(item, variable, number) for item in part)
    if isinstance(part, OfBodies):
        of = {f.name: _at(getattr(part, f.name), variable, number) for f in fields(part)}
        return replace(part, **of)
    return part


def family(statements: tuple[st.Statement, ...], kind: type, name: str) -> list[int]:
    """Returns the sorted indices of a family's members; [] if the name is not a family."""
    found = (s.left for s in statements if isinstance(s, kind) and s.left.name == name)
    return sorted(int(left.index.value) for left in found if isinstance(left.index, Number))
