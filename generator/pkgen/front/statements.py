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


class Statement:
    """A statement of a file, or a clause of a scene. It has a `keyword` and a `span`."""


@record
class Named(Statement):
    name: str
    name_span: Span


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
class Head(Named):
    """`model NAME`."""

    keyword: ClassVar[str] = "model"
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
class Param(Statement):
    keyword: ClassVar[str] = "param"
    left: Left
    value: Expr
    interval: Interval | None
    description: str
    span: Span
    given: Expr | None = None  # The value that the user of a part gives in place of `value`.


@record
class Define(Statement):
    """`size`, `const`, `let`, `observe`, `conserve` or `rate` NAME = EXPR."""

    keyword: str
    left: Left
    value: Expr
    description: str
    span: Span


@record
class Accumulate(Define):
    """`observe NAME = integral(EXPR) while CONDITION`. If the value is None, NAME is the time for
    which the condition holds."""

    condition: Expr | None


@record
class Force(Statement):
    """`force NAME = EXPR`, `force NAME at PLACE = EXPR`, or `force B.point([..]) = EXPR`, where
    `left` is None; the same of `torque`."""

    keyword: str
    left: Left | None
    place: Expr | None
    value: Expr
    span: Span


@record
class Declared:
    """A name declared by `coord`, `input`, `state` or `rotation`, `lo..hi` for a family; or the
    column of a table."""

    name: str
    lo: Expr | None
    hi: Expr | None
    unit: UnitText | None
    span: Span
    name_span: Span


@record
class Declare(Statement):
    keyword: str
    items: tuple[Declared, ...]
    description: str
    span: Span


@record
class Pairs(Statement):
    """`fixed q[0] = EXPR, …`, `free q, …`, `periodic q, …`, `exact x = EXPR, … within TOL`; in a
    scene `set p = EXPR, …` or `hold a = EXPR, …`. Names without `= EXPR` have the value None."""

    keyword: str
    items: tuple[tuple[Left, Expr | None], ...]
    span: Span
    within: Expr | None = None


@record
class Single(Statement):
    """`kinetic`, `potential`, `lagrangian` or `dissipation` EXPR; in a scene `until` or `accuracy`
    EXPR."""

    keyword: str
    value: Expr
    span: Span


@record
class Equation(Statement):
    """`constraint NAME: A = B` or `rolling NAME: A = B`."""

    keyword: str
    left: Left
    a: Expr
    b: Expr
    span: Span


@record
class Event(Named):
    keyword: ClassVar[str] = "event"
    value: Expr
    direction: str  # "rising", "falling" or "either"
    stop: bool
    description: str
    span: Span
    limit: bool = False  # Whether a joint's clause `limits` generates the event.
    then: tuple[StartItem, ...] = ()  # the values after it


@record
class Contact(Statement):
    """`impact NAME: GAP falling …` or `contact NAME: A >= B …`, whose `b` is not None."""

    keyword: str
    left: Left
    a: Expr
    b: Expr | None
    restitution: Expr | None
    mu: Expr | None
    along: Expr | None
    poisson: bool
    description: str
    span: Span


@record
class Friction(Statement):
    """`friction NAME = FORCE static FORCE`."""

    keyword: ClassVar[str] = "friction"
    left: Left
    value: Expr
    static: Expr | None
    description: str
    span: Span


@record
class Mode(Named):
    """`mode NAME: constraint a, b on at EVENT off at EVENT`."""

    keyword: ClassVar[str] = "mode"
    constraints: tuple[Left, ...]
    on: Name | None
    off: Name | None
    description: str
    span: Span


@record
class Draw(Statement):
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


def numbered(name: str, of: Left | Name) -> str:
    """Returns `name` with the index of `of`, such as link[3]; only `name` without one."""
    return indexed(name, int(of.index.value) if isinstance(of.index, Number) else None)


@record
class Body(Statement):
    """A body; a family is split into one Body for each member by check/body_families.py."""

    keyword: ClassVar[str] = "body"
    left: Left
    clauses: Clauses
    description: str
    span: Span

    @property
    def name(self) -> str:
        return numbered(self.left.name, self.left)

    @property
    def name_span(self) -> Span:
        return self.left.span


@record
class Joint(Statement):
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
        return numbered(self.left.name, self.left), self.left.span

    @property
    def parent(self) -> Word:
        return numbered(self.ends[0].id, self.ends[0]), self.ends[0].span

    @property
    def child(self) -> Word:
        return numbered(self.ends[1].id, self.ends[1]), self.ends[1].span


@record
class StartItem:
    """An initial value. `function` is "omega" in `start omega(R) = [..]`; `order` counts primes."""

    left: Left
    order: int
    function: str
    value: Expr
    span: Span


@record
class StartAt(Statement):
    """`start a = EXPR, …`, or `start consistent`, whose word is `how`."""

    keyword: ClassVar[str] = "start"
    items: tuple[StartItem, ...]
    span: Span
    how: str = ""


@record
class Use(Statement):
    """`use "FILE" as NAME with PARAMETER = EXPR, …`"""

    keyword: ClassVar[str] = "use"
    file: str
    name: str
    name_span: Span
    given: tuple[tuple[Left, Expr], ...]
    span: Span


@record
class Drive(Statement):
    """An input of a part and the value that a `set` outside of scenes gives it."""

    keyword: ClassVar[str] = "set"
    input: Declared
    value: Expr
    description: str
    span: Span


@record
class Method(Named):
    keyword: ClassVar[str] = "method"
    step: Expr | None
    rtol: Expr | None
    file: str | None  # Path of the tableau file.
    file_span: Span | None
    span: Span


@record
class Record(Statement):
    keyword: ClassVar[str] = "record"
    items: tuple[Expr, ...]
    every: Expr | None
    at: Expr | None
    span: Span


@record
class Table(Named):
    """`table NAME = "FILE" x [m], y [m] WORDS`, or with `-> z [N]` a `grid`. The last column has
    the values."""

    keyword: ClassVar[str] = "table"
    file: str
    file_span: Span
    columns: tuple[Declared, ...]
    grid: bool
    words: tuple[Word, ...]
    description: str
    span: Span


@record
class Swarm(Statement):
    keyword: ClassVar[str] = "swarm"
    range: Range
    span: Span


@record
class Expect(Statement):
    """`expect A = B within TOL at T`; the relation is "=", "<" or ">"."""

    keyword: ClassVar[str] = "expect"
    a: Expr
    relation: str
    b: Expr
    within: Expr | None
    at: Expr | None
    span: Span


@record
class EndOfScene(Statement):
    """`end`, which closes a block; it is dropped after parsing."""

    keyword: ClassVar[str] = "end"
    span: Span


@record
class Scene(Named):
    """`scene NAME`; parse adds the clauses up to `end`."""

    keyword: ClassVar[str] = "scene"
    description: str
    span: Span
    clauses: tuple[Statement, ...] = ()


@record
class Sample(Named):
    """`sample NAME every T offset T0 delay K`; parse adds the statements up to `end`."""

    keyword: ClassVar[str] = "sample"
    every: Expr
    offset: Expr | None
    delay: Expr | None
    description: str
    head: Span
    span: Span
    clauses: tuple[Define | Pairs, ...] = ()


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
