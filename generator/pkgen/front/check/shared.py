"""State and helpers that all checks of statements share: tables, collected results, left sides."""

from __future__ import annotations

from dataclasses import replace

from ...indices import integer
from ...source import Span
from ...system.near import meant
from ...tree import Expr, Name, Negate, Quantity, Range, replaced
from .. import statements as st
from .. import units
from ..table import STATEMENTS
from ..units import NONE, Dimension, si_text
from .expr import Expressions, Target
from .names import KIND_TEXT, MOVING, UNKNOWN, Entry, Facts, Members
from .scope import PLACES, Scope
from .written import written

ORIGIN = "O"


class Shared:
    """State shared by all checks of one model; they add their results to `parts`. It has the
    attributes of `expressions` too, such as `names`, `indices` and `error`."""

    def __init__(self, expressions: Expressions, given: dict[str, int]) -> None:
        vars(self).update(vars(expressions))
        self.expressions = expressions
        self.checked, self.factor = expressions.check, expressions.factor
        self.wanted, self.wanted_vector = expressions.wanted, expressions.wanted_vector
        self.text, self.common = expressions.text, expressions.common
        self.given_sizes = given  # Sizes set on the command line.
        self.parts: dict[str, list] = {row.fills: [] for row in STATEMENTS.values()}
        # An input that a sample block sets, or a memory cell -> the name of the block.
        self.sampled: dict[str, str] = {}
        self.queues: list[tuple[str, str]] = []  # (input with a delay, name of a value in waiting)
        self.energies: list[Facts] = []  # The facts of each energy statement.
        self.inputs: dict[str, int] = {}  # name of an input -> order of its highest derivative
        self.driven: dict[str, Span] = {}  # name of an input -> the `set` that gives it
        # Source positions of parameters and constants without an error.
        self.sound: set[Span] = set()


class Checks:
    """Base class of the classes that check statements."""

    def __init__(self, shared: Shared) -> None:
        self.shared = shared
        vars(self).update(vars(shared))

    @property
    def moving(self) -> tuple[str, ...]:
        """The kinds of names in this model that have initial values."""
        others = {"state": self.names.states, "rotation": self.names.rotations}
        return ("coordinate", *(kind for kind, names in others.items() if names))

    def origin(self, value: Expr) -> Expr:
        """Replaces the name O in an expression by the zero vector, the position of the origin,
        unless the model declares an O."""
        if ORIGIN in self.names.table or ORIGIN in self.names.later:
            return value

        def zero(part: Expr) -> Expr | None:
            if isinstance(part, Name) and part.id == ORIGIN and part.index is None:
                return written("[0, 0, 0]", part.span)
            return None

        return replaced(value, zero)

    def use_inputs(self, facts: Facts) -> None:
        for name, order in facts.inputs.items():
            self.inputs[name] = max(order, self.inputs.get(name, 0))

    def left_scope(self, left: st.Left, place: str) -> tuple[Scope, Members | None]:
        """Returns the scope of a definition's right side, and the indices that its left side
        defines, None if this has no index."""
        scope = Scope(PLACES[place], name=left.name)
        if left.range is not None:
            inner = self.indices.enter((left.range,), scope)
            if inner is None:
                return scope, Members()
            lo, hi = inner.loops[0].interval
            return inner, Members((lo, hi)) if lo <= hi else Members()
        if left.index is None:
            return scope, None
        if place == "param":
            self._no_family(left)
            return scope, None
        index = self.indices.value(left.index, scope)
        return scope, Members((index, index)) if index is not None else Members()

    def _no_family(self, left: st.Left) -> None:
        """Reports a declaration that has an index in place of a range: `param m[kg] = 1`, `param
        m[1] = 1`."""
        name, index = left.name, left.index
        if isinstance(index, Name) and units.parsed(index.id) is not None:
            message = f"'{name}[{index.id}]': a bracket that touches a name is an index"
            help = f"a unit stands after the value: param {name} = 1 [{index.id}]"
            self.error(message, left, help)
        else:
            message = "a family of parameters is declared with its range"
            self.error(message, left, f"e.g. param {name}[i = 1..N] = …")

    def variable(
        self, item: st.Declared, unit: units.Unit | None, kind: str, **own: frozenset[str]
    ) -> tuple[bool, Range | None, str, str] | None:
        """Declares a coordinate or a state; `own` is the field of Facts that contains the
        variable's name. Returns whether the name was free, the range of its indices (None if it is
        no family), and the units in which its value and its rate are shown; None after an error."""
        dimension = None if unit is None else unit.dimension
        united = dimension is not None and unit is not units.ONE
        facts = Facts(dimension, united=united, known=unit is not None, **own)
        found = self.declared(item, kind, facts)
        if found is None:
            return None
        (family, new), unit = found, unit or units.ONE
        per_time = units.over(unit.dimension, self.time_dimension)
        return new, family, unit.shown, si_text(per_time, unit.angle)

    def declared(
        self, item: st.Declared, kind: str, facts: Facts
    ) -> tuple[Range | None, bool] | None:
        """Declares a name. Returns its range, None if it is no family, and whether the name was
        free. Returns None after an error."""
        ends = members = family = None
        if item.lo is not None:
            ends = self.indices.family(item.lo, item.hi, item.span, Scope(PLACES["size"]))
            if ends is None:
                self.names.declare(Entry(item.name, "poisoned", UNKNOWN, item.name_span))
                return None
            members, family = Members(ends), Range("i", item.lo, item.hi, item.span)
        new = self.names.declare(Entry(item.name, kind, facts, item.name_span, members, ends))
        return family, new

    def members_of(self, left: st.Left) -> tuple[int, int] | None:
        """Returns the first and last index of a left side: (0, 0) if it has no index, None if its
        range is empty."""
        if left.range is not None:
            lo, hi = (integer(end, self.sizes) for end in (left.range.lo, left.range.hi))
            return (lo, hi) if lo <= hi else None
        index = 0 if left.index is None else integer(left.index, self.sizes)
        return index, index

    def wanted_of(
        self, left: st.Left, value: Expr, what: str, kinds: tuple[str, ...], place: str
    ) -> tuple[Entry, Scope] | None:
        """Returns the entry of the name on a statement's left side, and the scope of the value. The
        name must be of one of `kinds`; `what` describes the statement in messages. After an error,
        checks the value without a required dimension and returns None."""
        entry = self.named(left, what, kinds)
        scope = self.member_scope(left, entry, Scope(PLACES[place]))
        if entry is not None and scope is not None and entry.facts.dimension is not None:
            return entry, scope
        self.checked(value, scope or Scope(PLACES[place]))
        return None

    def named(
        self, left: st.Left, what: str, kinds: tuple[str, ...] = ("coordinate",)
    ) -> Entry | None:
        """Returns the entry of the name on a left side, and reports a name that is of none of
        `kinds`. `what` describes the statement in messages."""
        entry = self.names.table.get(left.name)
        if entry is None:
            near = {n: e.kind for n, e in self.names.table.items() if e.kind in kinds}
            noun = " or ".join(k for k in kinds if k in near.values()) or kinds[0]
            if left.name in self.names.later:
                self.names.unknown(left.name, name_span(left))
            elif left.name not in self.names.reported:
                self.names.reported.add(left.name)
                message = f"unknown {noun} '{left.name}'"
                self.error(message, name_span(left), _nearest(left.name, list(near), noun))
            return None
        if entry.kind == "poisoned":
            return None
        if entry.kind not in kinds:
            self.error(
                f"'{left.name}' is {KIND_TEXT[entry.kind]}: {what} is for"
                f" {' and '.join(f'{kind}s' for kind in kinds)}",
                name_span(left),
                _instead(entry, kinds),
            )
            return None
        return entry

    def member_scope(self, left: st.Left, entry: Entry | None, scope: Scope) -> Scope | None:
        """Returns the scope of the value in a statement such as `force q[i = 1..N] = …`. Reports
        members that are not declared or are boundary ends; returns None after an error."""
        index = left.index
        if left.range is not None:
            scope = self.indices.enter((left.range,), scope)
            index = Name(left.range.variable, None, left.range.span)
        if entry is None or scope is None:
            return scope
        named = Name(left.name, index, left.span)
        if entry.members is not None and entry.kind in MOVING:
            entry = replace(entry, members=Members(self.range_of(left.name)), kind="member")
        before = self.report.count
        self.indices.member(named, entry, replace(scope, name="="))
        return scope if self.report.count == before else None

    def range_of(self, name: str) -> tuple[int, int]:
        parts = (self.parts[f"{kind}s"] for kind in MOVING)
        family = next(c.range for declared in parts for c in declared if c.name == name)
        return integer(family.lo, self.sizes), integer(family.hi, self.sizes)

    def no_vector(self, left: st.Left, kind: str) -> None:
        message = f"the {kind} '{left.name}' is a vector; it must be a number"
        help = "'let' defines vectors; otherwise take a component (.x, .y, .z)"
        self.error(message, left, help)

    def shown_unit(self, of: Expr, facts: Facts) -> str:
        """Returns the unit for display: as written if the value has its dimension, else in SI."""
        dimension = facts.dimension or NONE
        if isinstance(of, Quantity):
            unit = units.parsed(of.unit)
            if unit is not None and unit.dimension == dimension:
                return unit.shown
        return si_text(dimension)

    def poison(self, left: st.Left) -> None:
        self.names.declare(Entry(left.name, "poisoned", UNKNOWN, name_span(left)))


def name_span(left: st.Left) -> Span:
    return Span(left.span.start, min(left.span.start + len(left.name), left.span.end))


def infinite(value: Expr) -> int:
    """Returns 1 if the end of a range is inf, -1 if it is -inf, 0 if it is a number."""
    value = value.of if isinstance(value, Quantity) else value
    of = value.of if isinstance(value, Negate) else value
    return (isinstance(of, Name) and of.id == "inf") * (-1 if of is not value else 1)


def _instead(entry: Entry, kinds: tuple[str, ...]) -> str:
    """Returns a hint about the right statement, for a name of the wrong kind."""
    if entry.kind == "state":
        return f"what changes a state is its rate: rate {entry.name} = …"
    if entry.kind == "coordinate" and kinds == ("state",):
        return "Lagrange's equations give its rate; add to them by 'force'"
    return "--set gives a parameter another value" if entry.kind == "parameter" else ""


def _nearest(name: str, known: list[str], noun: str) -> str:
    if near := meant(name, known):
        return near
    nouns = noun.replace(" or ", "s and ")
    return f"the {nouns}s are: {', '.join(known[:12])}" if known else ""


def as_is(name: str, dimension: Dimension | None) -> Target:
    """Returns the Target of a value given to a name; a number without a unit is in SI."""
    is_ = "" if dimension is None else units.described(dimension)
    return Target(dimension, f"{name} is {is_}", bare=True)
