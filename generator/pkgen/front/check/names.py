"""The table of a model's names, the facts about expressions, and the report of findings."""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from collections.abc import Collection
from dataclasses import dataclass, field
from fractions import Fraction

from ... import limits
from ...functions import FUNCTIONS, MEANT, VECTOR_FUNCTIONS, WRITTEN_OUT
from ...indices import DOTTED, indexed, made_of, of_made
from ...record import record
from ...source import Diagnostic, Source, Span
from ...system.near import meant
from ...tree import COMPONENTS, Expr
from .. import foreign
from ..units import Dimension
from ..words import reserved

NOTHING: frozenset[str] = frozenset()
NO_INPUTS: dict[str, int] = {}
_UNITS = frozenset(("kg", "cm", "mm", "km", "Hz", "Pa", "rad", "deg", "ohm", "N", "J", "W"))
BUILT_IN = ("T", "V", "L", "energy", "V_eff")
ROTATIONS = frozenset(("omega", "rot", "inverse", "euler", "tait_bryan"))
NAMED = ("omega", "power", "error", "loss")  # functions of a name, whose calls are columns
EVENTS = ("event", "contact")  # kinds of names that are events
SPECIAL = ROTATIONS | {"sum", "drift", "time", "power", "error", "loss", "if", "integral"}


def callable_names() -> frozenset[str]:
    """Returns the names of the functions that a model may call, without those in SPECIAL, which
    have checks of their own."""
    rows = (name for name, row in [*FUNCTIONS.items()] if not row.internal)
    return frozenset(rows) | VECTOR_FUNCTIONS.keys() | WRITTEN_OUT.keys()


@record
class Turn:
    """A factor of a product of rotations. It has one of four forms: the `axis` and `angle` of a
    rot(...); the `quaternion` of a declared rotation, with its `name` and `index` unless it is
    inverted; the `columns` of a rotation matrix, as vectors; or the `rows` of the inverse of a
    rotation matrix."""

    axis: Expr | None = None
    angle: Expr | None = None
    quaternion: Expr | None = None
    columns: tuple[Expr, ...] = ()
    rows: tuple[Expr, ...] = ()
    name: str = ""
    index: Expr | None = None


Turns = tuple[Turn, ...]


@dataclass(slots=True)
class Facts:
    """Properties of an expression; treated as immutable, since expressions share them."""

    dimension: Dimension | None  # None: every dimension fits (a literal 0, a wrong name).
    vector: bool | None = False  # None: an error leaves it unknown.
    value: Fraction | float | None = None  # Value of a constant, else None.
    bare: bool = False  # The expression has only literals, pi, sizes and loop variables.
    united: bool = False  # The expression has a name or number with a declared unit.
    known: bool = True  # False: the expression has an error.
    time: bool = False  # The expression contains the time t.
    coordinates: frozenset[str] = NOTHING
    rates: frozenset[str] = NOTHING
    # Name of an input in the expression -> order of its highest derivative there.
    inputs: dict[str, int] = field(default_factory=lambda: NO_INPUTS)
    states: frozenset[str] = NOTHING
    state_rates: frozenset[str] = NOTHING
    rough: str = ""  # First non-smooth function of the motion in the expression, or "".
    turns: Turns = ()  # The factors, if the expression is a rotation.
    accelerations: bool = False  # The expression has accelerations or second derivatives of states.

    @property
    def moves(self) -> bool:
        return bool(self.coordinates or self.rates or self.states or self.inputs or self.time)


UNKNOWN = Facts(None, None, known=False)


def joined(dimension: Dimension | None, vector: bool | None, parts: list[Facts]) -> Facts:
    """Returns the facts of an expression made of `parts`; the fact `value` stays None."""
    found = Facts(dimension, vector, bare=True)
    for part in parts:
        found.bare &= part.bare
        found.united |= part.united
        found.known &= part.known
        found.time |= part.time
        found.rough = found.rough or part.rough
        found.accelerations |= part.accelerations
        if part.coordinates:
            found.coordinates |= part.coordinates
            found.rates |= part.rates
        if part.states:
            found.states |= part.states
            found.state_rates |= part.state_rates
        if part.inputs:
            both = (*found.inputs, *part.inputs)
            found.inputs = {n: max(found.inputs.get(n, 0), part.inputs.get(n, 0)) for n in both}
    return found


class Members:
    """The indices of a family's members: disjoint closed intervals, in order."""

    def __init__(self, *intervals: tuple[int, int]) -> None:
        self.intervals: list[tuple[int, int]] = []
        for lo, hi in intervals:
            self.add(lo, hi)

    def add(self, lo: int, hi: int) -> None:
        # The intervals that overlap or adjoin lo..hi are consecutive; they are merged with it.
        first = bisect_left(self.intervals, lo - 1, key=lambda x: x[1])
        last = bisect_right(self.intervals, hi + 1, key=lambda x: x[0])
        for a, b in self.intervals[first:last]:
            lo, hi = min(lo, a), max(hi, b)
        self.intervals[first:last] = [(lo, hi)]

    def hold(self, lo: int, hi: int) -> bool:
        """Whether each integer in lo..hi is the index of a member."""
        at = bisect_left(self.intervals, hi, key=lambda x: x[1])
        return at < len(self.intervals) and self.intervals[at][0] <= lo

    def touch(self, lo: int, hi: int) -> bool:
        """Whether any integer in lo..hi is the index of a member."""
        at = bisect_left(self.intervals, lo, key=lambda x: x[1])
        return at < len(self.intervals) and self.intervals[at][0] <= hi

    def text(self, name: str) -> str:
        ends = [f"{a}" if a == b else f"{a}..{b}" for a, b in self.intervals[:4]]
        shown = [indexed(name, end) for end in ends]
        return ", ".join(shown) + (", …" if len(self.intervals) > 4 else "")


@dataclass
class Entry:
    """A declared name. `kind` is a key of KIND_TEXT."""

    name: str
    kind: str
    facts: Facts
    span: Span
    members: Members | None = None  # Indices of a family, with its ends (q[0]).
    own: tuple[int, int] | None = None  # Range of a family without its ends.
    periodic: bool = False  # Every index is valid (True also after an error).
    used: bool = False
    # For rotations of a family of bodies: index of a body -> facts of its rotation.
    turning: dict[int, Facts] | None = None


KIND_TEXT = {
    "model": "the model's name",
    "size": "a size",
    "parameter": "a parameter",
    "constant": "a constant",
    "coordinate": "a coordinate",
    "state": "a state",
    "rotation": "a rotation",
    "constraint": "a constraint",
    "contact": "a contact",
    "mode": "a mode",
    "multiplier": "the multiplier of a constraint",
    "definition": "a definition",
    "table": "a table",
    "input": "an input",
    "memory cell": "a memory cell",
    "sample": "a sample block",
    "output": "an output",
    "scene": "a scene",
    "event": "an event",
    "force": "a force",
    "body": "a body",
    "joint": "a joint",
    "part": "a part",
    "loop variable": "a loop variable",
    "poisoned": "a name with an error",
    "time": "the time",
    "built-in": "built in",
}
# Kinds of names whose families can have ends, such as q[0] of q[1..N].
MOVING = ("coordinate", "state", "rotation")


# A position, or a part of the text that has one in its attribute `span`.
Place = object


class Wrong(Exception):
    """An error in the current expression, or in its part `at`. An empty message means that the
    error has been reported. The expression's facts become UNKNOWN."""

    def __init__(self, message: str = "", help: str = "", at: Place | None = None) -> None:
        self.message, self.help, self.at = message, help, at


class Report:
    """Collects errors and warnings, each at a position or at a part of the text that has one."""

    def __init__(self) -> None:
        self.errors: list[Diagnostic] = []
        self.warnings: list[Diagnostic] = []

    def error(self, message: str, at: Place, help: str = "") -> None:
        self.errors.append(Diagnostic(message, getattr(at, "span", at), help))

    @property
    def count(self) -> int:
        return len(self.errors)

    @property
    def full(self) -> bool:
        """Whether there are more errors than will be shown. No hint is then computed for a further
        error."""
        return self.count > limits.DIAGNOSTICS

    def warn(self, message: str, at: Place, help: str = "") -> None:
        self.warnings.append(Diagnostic(message, getattr(at, "span", at), help, "warning"))


class Names:
    """The table of a model's names, filled in the order of the file."""

    def __init__(self, report: Report, line_of, declared: Collection[tuple[str, Span, str]] = ()):
        """`declared` has all names that the file declares, with position and keyword."""
        self.report, self.error = report, report.error
        self.line_of = line_of  # A function: source position -> line number.
        self.later = {name: span for name, span, _ in declared}
        self.coordinates, self.states, self.rotations = (
            frozenset(name for name, _, word in declared if word == keyword)
            for keyword in ("coord", "state", "rotation")
        )
        self.hamiltonian = False  # whether the model has a statement `hamiltonian`
        self.table: dict[str, Entry] = {}
        self.reported: set[str] = set()

    def declare(self, entry: Entry) -> bool:
        """Adds a name to the table; reports a name that is taken, reserved or misleading. Returns
        False if the name is taken or reserved."""
        name, span = entry.name, entry.span
        why = reserved(name)
        before = self.table.get(name)
        if why:
            self.error(f"'{name}' {why} and cannot be a name", span, "choose another name")
        elif before is not None and before.kind != "poisoned":
            at = f"{KIND_TEXT[before.kind]} in line {self.line_of(before.span)}"
            self.error(f"'{name}' is declared already: {at}", span, "choose another name")
            return False
        elif (moving := of_made("p_", name)) in self.moving:
            what = "coordinate" if moving in self.coordinates else "rotation"
            of = f"the momentum of the {what} '{moving}'"
            message = f"'{name}' is {of}; it needs no declaration"
            self.error(message, span, "choose another name")
        part, _, own = name.rpartition(".")
        constrains = entry.kind == "constraint" and own in [*COMPONENTS]
        if part in self.parts and (constrains or (entry.members and own in DOTTED)):
            message = f"in a part, no family or constraint can be called '{own}'"
            self.error(message, span, "choose another name")
        self.table[name] = entry
        return not why

    loose: frozenset[str] = NOTHING  # Bodies not connected to the ground.
    parts: frozenset[str] = NOTHING  # Names of parts.

    @property
    def moving(self) -> frozenset[str]:
        """The names of coordinates and rotations, which have a second-order equation of motion."""
        return self.coordinates | self.rotations

    # The hint for an unknown name if there is no better one.
    missing = "declare it, e.g. 'param {name} = 1' or 'let {name} = …'"

    def unknown(
        self,
        name: str,
        span: Span,
        called: bool = False,
        help: str = "",
        missing: str = "",
        built_in: bool = False,
    ) -> None:
        """Reports an unknown name, unless it has been reported. The hint is a similar name, else
        `missing`. With `built_in`, the similar names include built-in ones, such as p_q, the
        momentum of q. With `missing` (in scenes), no hint reads mg as the product m*g."""
        of = self.table.get(name.partition(".")[0])
        if name in self.reported or (of is not None and of.kind == "poisoned"):
            return
        if any(name.startswith(f"{body}.") for body in self.loose):
            return
        self.reported.add(name)
        place = self.later.get(name)
        if place is not None and not called:
            line = self.line_of(place)
            if line == self.line_of(span):
                message = f"'{name}' is used in its own definition"
            else:
                message = f"'{name}' is used before its definition in line {line}"
            self.error(message, span, "a name is defined above its first use")
        else:
            what = "function" if called else "name"
            message = f"unknown {what} '{name}'"
            if called and name in self.table:
                message = f"'{name}' is {KIND_TEXT[self.table[name].kind]}, not a function"
            self.error(message, span, help or self._hint(name, called, missing, built_in))

    def _hint(self, name: str, called: bool, missing: str, built_in: bool) -> str:
        if self.report.full:
            return ""
        if called and name in self.table:
            return f"a product is written {name}*(…)"
        if not called and name in callable_names() | SPECIAL:
            return f"'{name}' is a function: write {name}(…)"
        if other := (foreign.FUNCTIONS if called else foreign.NAMES).get(name):
            return other
        if called and name in MEANT:
            return f"write {MEANT[name]}(…)"
        if not called and (rate := self._rate(name)):
            return rate
        known = sorted(callable_names() | {"sum"}) if called else [*self.table, "t", "pi"]
        if built_in:
            known += [*BUILT_IN, *(made_of("p_{}", name) for name in sorted(self.moving))]
        if not called and name in _UNITS:
            return f"a unit stands in square brackets after a value: 2 [{name}]"
        near = meant(name, known)
        product = None if called or missing else self._product(name)
        if product and (not near or len(name) <= 3):
            return f"did you mean {product}? a product needs its *"
        if near:
            return near
        part = self.table.get(name.rpartition(".")[0])
        if part is not None and part.kind == "part":
            return f"the file of the part '{part.name}' declares no such name"
        if "." in name:
            return f"declare it: body {name.partition('.')[0]} mass …, and its joint"
        if called:
            return "functions: " + " ".join(sorted(callable_names() | {"sum"}))
        return (missing or self.missing).format(name=name)

    def _rate(self, name: str) -> str:
        """Returns a hint for a misspelt derivative (`xdot`, `x_dot`, `dx`, `dt`), else ""."""
        moving = self.moving | self.states
        if name == "dt" and moving:
            return f"a rate is written with a prime: {min(moving)}'"
        for form, primes in ((r"(\w+?)_?dot|d(\w+)", 1), (r"(\w+?)_?ddot|dd(\w+)", 2)):
            found = re.fullmatch(form, name)
            of = found and (found[1] or found[2])
            if of in moving:
                why = "; pkgen derives it: energies take coordinates and rates"
                return f"that is written {of}" + "'" * primes + why * (primes > 1)
        return ""

    def _product(self, name: str) -> str:
        """Returns `m*g` for the unknown name `mg` if m and g are names, else ""."""
        for i in range(1, len(name)):
            if name[:i] in self.table and name[i:] in self.table:
                return f"{name[:i]}*{name[i:]}"
        return ""


class Reporting:
    """Base class of what checks expressions and reports errors in them."""

    def __init__(self, source: Source, report: Report, names: Names, sizes: dict[str, int]) -> None:
        self.source, self.report, self.names, self.sizes = source, report, names, sizes
        self.error, self.warn = report.error, report.warn
