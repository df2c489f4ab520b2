"""Checks `model`, `size`, `param`, `const`, `let`, `observe` and `conserve`."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from ... import model as m
from ...tree import Expr, Name, Quantity, names
from .. import statements as st
from .. import units
from ..table import STATEMENTS
from ..units import NONE
from ..words import C_HEADERS, reserved, symbols_of
from .names import UNKNOWN, Entry, Facts, Members, joined
from .scope import PLACES, Scope
from .shared import Checks, as_is, infinite, name_span
from .vectors import by_component

_UNKNOWN = "?"  # Replaces a bound that has an error. No model can declare this name.


class Definitions(Checks):
    def model(self, statement: st.Head) -> None:
        if self.parts["name"]:
            self.error("a file holds one model; this is the second 'model'", statement)
            return
        self.parts["name"].append(statement)
        why = reserved(statement.name)
        if why:
            self.error(f"'{statement.name}' {why} and cannot name a model", statement.name_span)
        elif whose := symbols_of(statement.name):
            message = f"'{statement.name}' cannot name a model: symbols of {whose} begin so"
            help = f"choose another name, e.g. my_{statement.name}"
            self.error(message, statement.name_span, help)
        elif statement.name in C_HEADERS:
            message = f"'{statement.name}.h' is a header of C; a model's would hide it"
            help = f"choose another name, e.g. {statement.name}_model"
            self.error(message, statement.name_span, help)

    def size(self, statement: st.Define) -> None:
        left = statement.left
        if left.index is not None or left.range is not None:
            self.error("'size' takes a plain name", left)
        value = self.indices.value(statement.value, Scope(PLACES["size"]))
        value = self.given_sizes.get(left.name, value)
        if value is not None and value < 1:
            self.error(f"the size {left.name} is {value}; it must be at least 1", statement.value)
            value = None
        if value is None:
            self.poison(left)
            return
        # Expressions may use a size as a number.
        facts = Facts(NONE, False, Fraction(value), bare=True)
        if self.names.declare(Entry(left.name, "size", facts, left.span)):
            self.sizes[left.name] = value
        self.parts["sizes"].append(m.Size(left.name, value, statement.description, statement.span))

    def param(self, statement: st.Param) -> None:
        left = statement.left
        before = self.report.count
        scope, members = self.left_scope(left, "param")
        value, facts = self.checked(statement.value, scope)
        if statement.given is not None and facts.known:
            target = as_is(left.name, facts.dimension)
            value, given = self.wanted(statement.given, scope, target)
            facts = replace(facts, value=given.value, known=given.known)
        if facts.vector:
            self.no_vector(left, "parameter")
        bounds = self._bounds(statement.interval, left.name, facts)
        own = replace(_declared(facts, statement.value), value=None)
        own = own if facts.known or facts.dimension is not None else UNKNOWN
        entry = Entry(left.name, "parameter", own, name_span(left), members)
        entry.periodic = left.range is not None and not scope.loops
        new = self.names.declare(entry) and facts.known and not entry.periodic
        if new and self.report.count == before:
            self.sound.add(statement.span)
        used = (self.names.table.get(name) for name in names(value))
        follows = facts.value is None and any(e and e.kind == "parameter" for e in used)
        unit = self.shown_unit(statement.value, facts)
        shown = unit, statement.description, statement.span
        self.parts["parameters"].append(
            m.Parameter(left.name, left.range, value, follows, bounds, *shown)
        )

    def _bounds(self, interval: st.Interval | None, name: str, of: Facts) -> m.Bounds:
        if interval is None:
            return m.Bounds(None, None, True, True)
        lo, hi = (
            self._bound(end, sign, name, of) for end, sign in ((interval.lo, -1), (interval.hi, 1))
        )
        return m.Bounds(lo, hi, interval.lo_open, interval.hi_open)

    def _bound(self, end: Expr, sign: int, name: str, of: Facts) -> Expr | None:
        found = infinite(end)
        if found and found != sign:
            end_name = "lower" if sign < 0 else "upper"
            message = f"no value is left: the {end_name} bound is {'' if found > 0 else '-'}inf"
            self.error(message, end.of if found < 0 else end)
        if found:
            return None
        target = as_is(name, of.dimension)
        value, facts = self.wanted(end, Scope(PLACES["bound"]), target)
        return value if facts.known else Name(_UNKNOWN, None, end.span)

    def use(self, statement: st.Use) -> None:
        new = Entry(statement.name, "part", UNKNOWN, statement.name_span, used=True)
        self.names.declare(new)

    def set(self, statement: st.Drive) -> None:
        """Checks an input of a part that its user gives: it is a definition."""
        item, unit = statement.input, units.ONE
        if item.unit is not None:
            unit = self.expressions.unit(item.unit.text, item.unit.span) or unit
        target = as_is(item.name, unit.dimension)
        value, facts = self.wanted(statement.value, Scope(PLACES["let"]), target)
        own = {"dimension": unit.dimension, "bare": False, "united": unit is not units.ONE}
        facts = UNKNOWN if facts.vector else replace(facts, **own)
        self.names.declare(Entry(item.name, "definition", facts, item.name_span))
        self.shared.driven[item.name] = statement.span
        self.use_inputs(facts)
        shown = unit.shown, statement.description, statement.span
        self.parts["definitions"].append(m.Definition(item.name, None, None, value, *shown))

    def define(self, statement: st.Define) -> None:
        keyword, left = statement.keyword, statement.left
        row = STATEMENTS[keyword]
        scope, members = self.left_scope(left, keyword)
        if keyword in ("const", "conserve") and (left.range or left.index):
            help = "use 'let' for a family" if keyword == "const" else ""
            self.error(f"'{keyword}' defines one name, not a family", left, help)
        if keyword == "observe" and left.index is not None:
            self.error(
                "'observe' takes NAME or NAME[i = lo..hi]", left, "give it a name of its own"
            )
        before = self.report.count
        if keyword == "let":
            value, facts = self._let(statement, scope, members)
        else:
            value, facts = self.checked(statement.value, scope)
            kind = "constant" if keyword == "const" else "output"
            if facts.vector and kind == "constant":
                self.no_vector(left, kind)
            if keyword == "conserve" and facts.bare:
                self.warn("a number is always conserved", statement.value)
            shown = _declared(facts, statement.value) if kind == "constant" else facts
            entry = Entry(left.name, kind, shown, name_span(left), members)
            entry.used = kind == "output"
            self.names.declare(entry)
        if keyword == "const" and facts.known and self.report.count == before:
            self.sound.add(statement.span)
        self.use_inputs(facts)
        if facts.turns:
            return
        unit = self.shown_unit(statement.value, facts)
        shown = unit, statement.description, statement.span
        definition = m.Definition(left.name, left.index, left.range, value, *shown)
        vector = facts.vector and row.fills in ("observed", "conserved")
        self.parts[row.fills] += by_component(definition) if vector else (definition,)

    def _let(self, statement: st.Define, scope: Scope, members: Members | None):
        left = statement.left
        if members is None:
            value, facts = self.factor(statement.value, scope)
            shown = replace(facts, bare=False)
            self.names.declare(Entry(left.name, "definition", shown, name_span(left)))
            return value, facts
        entry = self.names.table.get(left.name)
        new = entry is None or entry.kind != "definition" or entry.members is None
        if new:
            # The family is declared before its value is checked, since the value may use lower
            # members. The facts of the family are UNKNOWN until the first member sets them.
            entry = Entry(left.name, "definition", UNKNOWN, name_span(left), Members())
            self.names.declare(entry)
        if not members.intervals:  # The range or index has an error.
            entry.periodic = True
        self.indices.defining = (left.name, left.range) if scope.loops else None
        value, facts = self.checked(statement.value, scope)
        self.indices.defining = None
        for lo, hi in members.intervals:
            if entry.members.touch(lo, hi):
                some = f"{left.name}[{lo}] is"
                some = some if lo == hi else f"some of {left.name}[{lo}..{hi}] are"
                self.error(f"{some} defined already", left)
            entry.members.add(lo, hi)
        self._merge(entry, facts, statement)
        return value, facts

    def _merge(self, entry: Entry, facts: Facts, statement: st.Define) -> None:
        """Merges the facts of a new member into those of its family."""
        before = entry.facts
        facts = replace(facts, bare=False, value=None)
        if before is UNKNOWN:
            entry.facts = facts
            return
        if None not in (before.dimension, facts.dimension) and before.dimension != facts.dimension:
            was, new = (units.described(x.dimension) for x in (before, facts))
            message = f"unit mismatch: {entry.name} is {was}, this member is {new}"
            self.error(message, statement.value)
        dimension = facts.dimension if before.dimension is None else before.dimension
        entry.facts = joined(dimension, facts.vector, [before, facts])


def _declared(facts: Facts, written: Expr) -> Facts:
    """Returns the facts of a defined name: those of its value `written`, except that a name never
    counts as a bare number, which could still take a unit."""
    dimension = NONE if facts.dimension is None and facts.known else facts.dimension
    united = isinstance(written, Quantity) or facts.united or dimension != NONE
    return replace(facts, dimension=dimension, bare=False, united=united)
