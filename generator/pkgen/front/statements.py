"""The statements of a .lag file, as data: the output of `parse`.

A `Left` is the left side of a definition: NAME, NAME[index] or NAME[i = lo..hi]. Units are kept as
text with their position; `check` parses them.
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
    """The text between the brackets of a unit; `check` parses it."""

    text: str
    span: Span


@record
class Head:
    """`model NAME` or `scene NAME`; parse merges a scene's head and its clauses into a Scene."""

    keyword: str
    name: str
    name_span: Span
    description: str
    span: Span


@record
class Interval:
    """The bounds of a parameter, such as `in (lo, hi]`."""

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
    given: Expr | None = None  # The value that the user of a part gives in place of `value`.


@record
class Define:
    """`size`, `const`, `let`, `observe`, `conserve` or `rate` NAME = EXPR."""

    keyword: str
    left: Left
    value: Expr
    description: str
    span: Span


@record
class Accumulate:
    """`observe NAME = integral(EXPR) while CONDITION`. Without a value, NAME is the time for which
    the condition holds."""

    keyword: ClassVar[str] = "observe"
    left: Left
    value: Expr | None
    condition: Expr | None
    description: str
    span: Span


@record
class Force:
    """`force NAME = EXPR`, `force NAME at PLACE = EXPR`, or `force B.point([..]) = EXPR`, where
    `left` is None; the same of `torque`."""

    keyword: str
    left: Left | None
    place: Expr | None
    value: Expr
    span: Span


@record
class Declared:
    """A name declared by `coord`, `input`, `state` or `rotation`; `lo..hi` for a family."""

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
    """`fixed q[0] = EXPR, …`, `free q, …`, `periodic q, …`; in a scene `set p = EXPR, …` or `hold a
    = EXPR, …`. Names without `= EXPR` have the value None."""

    keyword: str
    items: tuple[tuple[Left, Expr | None], ...]
    span: Span


@record
class Exact:
    """`exact x = EXPR, … within TOL`."""

    keyword: ClassVar[str] = "exact"
    items: tuple[tuple[Left, Expr], ...]
    within: Expr | None
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
    limit: bool = False  # Whether a joint's clause `limits` generates the event.


@record
class Draw:
    """`draw SHAPE …` or `view SHAPE …`. For `ground y = 0` the axis is "y" and the subject is the
    value 0. `also` is what follows a comma: the range of a drawn family, or the second coordinate
    of the plane of a `level` drawing."""

    keyword: str
    shape: str
    subject: Expr | None
    axis: str
    parts: tuple[tuple[str, Span, Expr], ...]
    also: Expr | Range | None
    description: str
    shape_span: Span
    span: Span


# For each clause: its word, the position of the word, its values.
Clauses = tuple[tuple[str, Span, tuple[Expr, ...]], ...]
Word = tuple[str, Span]


def _said(name: str, of: Left | Name) -> Word:
    """Returns the name of a body or joint, with its index in a family (`link[3]`), and its
    position."""
    return indexed(name, int(of.index.value) if isinstance(of.index, Number) else None), of.span


@record
class Body:
    """A body; a family is split into one Body for each member by check/body_families.py."""

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
    """`joint NAME: PARENT to CHILD KIND AXIS`; `ends` are PARENT and CHILD, `to` the word "to"."""

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
    """An initial value. `function` is "omega" in `start omega(R) = [..]`; `order` counts primes."""

    left: Left
    order: int
    function: str
    value: Expr
    span: Span


@record
class StartAt:
    """`start a = EXPR, …`, or `start consistent`, whose word is `how`."""

    keyword: ClassVar[str] = "start"
    items: tuple[StartItem, ...]
    span: Span
    how: str = ""


@record
class Use:
    """`use "FILE" as NAME with PARAMETER = EXPR, …`"""

    keyword: ClassVar[str] = "use"
    file: str
    name: str
    name_span: Span
    given: tuple[tuple[Left, Expr], ...]
    span: Span


@record
class Drive:
    """An input of a part and the value that a `set` outside of scenes gives it."""

    keyword: ClassVar[str] = "set"
    input: Declared
    value: Expr
    description: str
    span: Span


@record
class Method:
    keyword: ClassVar[str] = "method"
    name: str
    name_span: Span
    step: Expr | None
    rtol: Expr | None
    file: str | None  # Path of the tableau file.
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
class Column:
    """A column of a table's file."""

    name: str
    unit: UnitText | None
    span: Span


@record
class Table:
    """`table NAME = "FILE" x [m], y [m] WORDS`, or with `-> z [N]` a `grid`. The last column has
    the values."""

    keyword: ClassVar[str] = "table"
    name: str
    name_span: Span
    file: str
    file_span: Span
    columns: tuple[Column, ...]
    grid: bool
    words: tuple[Word, ...]
    description: str
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


Clause = StartAt | Pairs | Exact | Single | Method | Record | Swarm | Expect


@record
class EndOfScene:
    """`end`, which closes a scene; it is dropped after parsing."""

    span: Span


@record
class Scene:
    keyword: ClassVar[str] = "scene"
    name: str
    name_span: Span
    clauses: tuple[Clause, ...]
    description: str
    span: Span


@record
class Sample:
    """`sample NAME every T offset T0 delay K`; parse adds the statements up to `end`."""

    keyword: ClassVar[str] = "sample"
    name: str
    name_span: Span
    every: Expr
    offset: Expr | None
    delay: Expr | None
    description: str
    head: Span
    span: Span
    clauses: tuple[Define | Pairs, ...] = ()


Statement = (
    Head
    | Param
    | Define
    | Declare
    | Pairs
    | Exact
    | Single
    | Equation
    | Event
    | Draw
    | Body
    | Joint
    | Table
    | Method
    | StartAt
    | Use
    | Drive
    | Scene
    | Sample
)


@record
class Broken:
    """A statement that does not parse, with the names that it would probably declare."""

    keyword: str  # "" if the statement starts with no keyword.
    names: tuple[str, ...]
    span: Span


@record(eq=False)
class File:
    """A parsed file. `diagnostics` are its syntax errors; `units` are the texts of all units
    outside scenes."""

    source: Source
    statements: tuple[Statement, ...]
    broken: tuple[Broken, ...]
    diagnostics: tuple[Diagnostic, ...]
    units: tuple[str, ...] = ()
