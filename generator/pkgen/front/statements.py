"""The statements of a .lag file as written: what `parse` hands to `check`.

A `Left` is the left side of a definition: NAME, NAME[index] or NAME[i = lo..hi]. Units are
kept as text with their place; `check` reads them.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..source import Diagnostic, Source, Span
from ..tree import Expr, Range


@dataclass(frozen=True, slots=True)
class Left:
    name: str
    index: Expr | None
    range: Range | None
    span: Span


@dataclass(frozen=True, slots=True)
class UnitText:
    """What stands between the brackets of a unit, not read yet."""

    text: str
    span: Span


@dataclass(frozen=True, slots=True)
class ModelName:
    name: str
    name_span: Span
    description: str
    span: Span


@dataclass(frozen=True, slots=True)
class Interval:
    """`in (lo, hi]`."""

    lo: Expr
    hi: Expr
    lo_open: bool
    hi_open: bool
    span: Span


@dataclass(frozen=True, slots=True)
class Param:
    left: Left
    value: Expr
    interval: Interval | None
    description: str
    span: Span


@dataclass(frozen=True, slots=True)
class SizeOf:
    left: Left
    value: Expr
    description: str
    span: Span


@dataclass(frozen=True, slots=True)
class Define:
    """`const`, `let`, `observe`, `conserve` or `rate` (the keyword) NAME = EXPR."""

    keyword: str
    left: Left
    value: Expr
    description: str
    span: Span


@dataclass(frozen=True, slots=True)
class Declared:
    """A name of `coord`, `input`, `state` or `rotation`; `lo..hi` if it is a family."""

    name: str
    lo: Expr | None
    hi: Expr | None
    unit: UnitText | None
    span: Span
    name_span: Span


@dataclass(frozen=True, slots=True)
class Declare:
    keyword: str
    items: tuple[Declared, ...]
    description: str
    span: Span


@dataclass(frozen=True, slots=True)
class Ends:
    """`fixed q[0] = EXPR, …`, `free q, …`, `periodic q, …`; values only if fixed."""

    keyword: str
    items: tuple[tuple[Left, Expr | None], ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Energy:
    """`kinetic`, `potential`, `lagrangian` or `dissipation` EXPR."""

    keyword: str
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class ForceAlong:
    left: Left
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Equation:
    """`constraint NAME: A = B` or `rolling NAME: A = B`."""

    keyword: str
    left: Left
    a: Expr
    b: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Event:
    name: str
    name_span: Span
    value: Expr
    direction: str  # "rising", "falling" or "either"
    stop: bool
    description: str
    span: Span


@dataclass(frozen=True, slots=True)
class StartItem:
    """`function` is "omega" in `start omega(R) = [..]`, else empty; `order` counts primes."""

    left: Left
    order: int
    function: str
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class StartAt:
    items: tuple[StartItem, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Assign:
    """In a scene: `set p = EXPR, …` or `hold a = EXPR, …` (a bare `hold a` has no value)."""

    keyword: str
    items: tuple[tuple[Left, Expr | None], ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Setting:
    """In a scene: `until` or `accuracy` (the keyword) EXPR."""

    keyword: str
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Method:
    name: str
    name_span: Span
    step: Expr | None
    rtol: Expr | None
    span: Span


@dataclass(frozen=True, slots=True)
class Record:
    items: tuple[Expr, ...]
    every: Expr | None
    at: Expr | None
    span: Span


@dataclass(frozen=True, slots=True)
class Swarm:
    range: Range
    span: Span


@dataclass(frozen=True, slots=True)
class Expect:
    """`expect A = B within TOL at T`; the relation is "=", "<" or ">"."""

    a: Expr
    relation: str
    b: Expr
    within: Expr | None
    at: Expr | None
    span: Span


Clause = StartAt | Assign | Setting | Method | Record | Swarm | Expect


@dataclass(frozen=True, slots=True)
class EndOfScene:
    """`end`; consumed while scenes are put together."""

    span: Span


@dataclass(frozen=True, slots=True)
class SceneHead:
    """`scene NAME`; consumed while scenes are put together."""

    name: str
    name_span: Span
    description: str
    span: Span


@dataclass(frozen=True, slots=True)
class Scene:
    name: str
    name_span: Span
    clauses: tuple[Clause, ...]
    description: str
    span: Span


Statement = (
    ModelName
    | Param
    | SizeOf
    | Define
    | Declare
    | Ends
    | Energy
    | ForceAlong
    | Equation
    | Event
    | StartAt
    | Scene
)


@dataclass(frozen=True, slots=True)
class Broken:
    """A statement that could not be parsed, with the names it would have declared."""

    keyword: str  # empty if it starts with no statement word
    names: tuple[str, ...]
    span: Span


@dataclass(frozen=True)
class File:
    """A parsed file. `diagnostics` is empty if nothing is wrong with its syntax; `units` are
    the texts of all units outside scenes."""

    source: Source
    statements: tuple[Statement, ...]
    broken: tuple[Broken, ...]
    diagnostics: tuple[Diagnostic, ...]
    units: tuple[str, ...] = ()
