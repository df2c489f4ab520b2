"""The statements of a .lag file as written: the output of `parse`.

A `Left` is the left side of a definition: NAME, NAME[index] or NAME[i = lo..hi]. Units are
kept as text with their place; `check` reads them.
"""

from __future__ import annotations

from typing import ClassVar

from ..indices import indexed
from ..record import record
from ..source import Diagnostic, Source, Span
from ..tree import Expr, Name, Number, Range


@record
class Left:
    name: str
    index: Expr | None
    range: Range | None
    span: Span


@record
class UnitText:
    """The text between the brackets of a unit, not parsed yet."""

    text: str
    span: Span


@record
class Head:
    """`model NAME`, or `scene NAME`; parse merges the latter with its clauses into a Scene."""

    keyword: str
    name: str
    name_span: Span
    description: str
    span: Span


@record
class Interval:
    """`in (lo, hi]`."""

    lo: Expr
    hi: Expr
    lo_open: bool
    hi_open: bool
    span: Span


@record
class Param:
    keyword: ClassVar[str] = "param"
    left: Left
    value: Expr
    interval: Interval | None
    description: str
    span: Span


@record
class Define:
    """`size`, `const`, `let`, `observe`, `conserve`, `rate` or `force` NAME = EXPR."""

    keyword: str
    left: Left
    value: Expr
    description: str
    span: Span


@record
class Declared:
    """A name of `coord`, `input`, `state` or `rotation`; `lo..hi` if it is a family."""

    name: str
    lo: Expr | None
    hi: Expr | None
    unit: UnitText | None
    span: Span
    name_span: Span


@record
class Declare:
    keyword: str
    items: tuple[Declared, ...]
    description: str
    span: Span


@record
class Pairs:
    """`fixed q[0] = EXPR, …`, `free q, …`, `periodic q, …`; in a scene `set p = EXPR, …` or
    `hold a = EXPR, …`. Names without `= EXPR` have the value None."""

    keyword: str
    items: tuple[tuple[Left, Expr | None], ...]
    span: Span


@record
class Single:
    """`kinetic`, `potential`, `lagrangian` or `dissipation` EXPR; in a scene `until` or `accuracy`
    EXPR."""

    keyword: str
    value: Expr
    span: Span


@record
class Equation:
    """`constraint NAME: A = B` or `rolling NAME: A = B`."""

    keyword: str
    left: Left
    a: Expr
    b: Expr
    span: Span


@record
class Event:
    keyword: ClassVar[str] = "event"
    name: str
    name_span: Span
    value: Expr
    direction: str  # "rising", "falling" or "either"
    stop: bool
    description: str
    span: Span
    limit: bool = False  # made of a joint's `limits`


@record
class Draw:
    """`draw SHAPE …` or `view SHAPE …`; `ground y = 0` has the axis "y" and the value as subject.
    `also` is the part after a comma: the range of members, or a level's second coordinate."""

    keyword: str
    shape: str
    subject: Expr | None
    axis: str
    parts: tuple[tuple[str, Span, Expr], ...]
    also: Expr | Range | None
    description: str
    shape_span: Span
    span: Span


Clauses = tuple[tuple[str, Span, tuple[Expr, ...]], ...]  # a word, its place, its values
Word = tuple[str, Span]


def _said(name: str, of: Left | Name) -> Word:
    """Returns the name of a body, a joint, or a member of a family (`link[3]`), and its place."""
    return indexed(name, int(of.index.value) if isinstance(of.index, Number) else None), of.span


@record
class Body:
    """A body; families are split into members before the check (check/body_families.py)."""

    keyword: ClassVar[str] = "body"
    left: Left
    clauses: Clauses
    description: str
    span: Span

    @property
    def name(self) -> str:
        return _said(self.left.name, self.left)[0]

    @property
    def name_span(self) -> Span:
        return self.left.span


@record
class Joint:
    """`joint NAME: PARENT to CHILD KIND AXIS`; `ends` are PARENT and CHILD, `to` a word."""

    keyword: ClassVar[str] = "joint"
    left: Left
    ends: tuple[Name, Name]
    to: Word
    kind: Word
    axis: Expr | None
    clauses: Clauses
    description: str
    span: Span

    @property
    def name(self) -> Word:
        return _said(self.left.name, self.left)

    @property
    def parent(self) -> Word:
        return _said(self.ends[0].id, self.ends[0])

    @property
    def child(self) -> Word:
        return _said(self.ends[1].id, self.ends[1])


@record
class StartItem:
    """`function` is "omega" in `start omega(R) = [..]`, else empty; `order` counts primes."""

    left: Left
    order: int
    function: str
    value: Expr
    span: Span


@record
class StartAt:
    keyword: ClassVar[str] = "start"
    items: tuple[StartItem, ...]
    span: Span


@record
class Method:
    keyword: ClassVar[str] = "method"
    name: str
    name_span: Span
    step: Expr | None
    rtol: Expr | None
    file: str | None  # path of its tableau
    file_span: Span | None
    span: Span


@record
class Record:
    keyword: ClassVar[str] = "record"
    items: tuple[Expr, ...]
    every: Expr | None
    at: Expr | None
    span: Span


@record
class Swarm:
    keyword: ClassVar[str] = "swarm"
    range: Range
    span: Span


@record
class Expect:
    """`expect A = B within TOL at T`; the relation is "=", "<" or ">"."""

    keyword: ClassVar[str] = "expect"
    a: Expr
    relation: str
    b: Expr
    within: Expr | None
    at: Expr | None
    span: Span


Clause = StartAt | Pairs | Single | Method | Record | Swarm | Expect


@record
class EndOfScene:
    """`end`, which closes a scene and is dropped."""

    span: Span


@record
class Scene:
    keyword: ClassVar[str] = "scene"
    name: str
    name_span: Span
    clauses: tuple[Clause, ...]
    description: str
    span: Span


Statement = (
    Head
    | Param
    | Define
    | Declare
    | Pairs
    | Single
    | Equation
    | Event
    | Draw
    | Body
    | Joint
    | Method
    | StartAt
    | Scene
)


@record
class Broken:
    """A statement that could not be parsed, with the names it would have declared."""

    keyword: str  # empty if it starts with no statement word
    names: tuple[str, ...]
    span: Span


@record(eq=False)
class File:
    """A parsed file. `diagnostics` is empty if nothing is wrong with its syntax; `units` are
    the texts of all units outside scenes."""

    source: Source
    statements: tuple[Statement, ...]
    broken: tuple[Broken, ...]
    diagnostics: tuple[Diagnostic, ...]
    units: tuple[str, ...] = ()
