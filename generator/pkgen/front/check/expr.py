"""Checks expressions, names and units, and replaces each `[unit]` by its factor.

`Expressions.check` returns the expression in SI and its Facts. After an error the facts are
UNKNOWN, which match anything, so that one mistake is reported once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from ...indices import NotAnInteger, integer, multipliers, of_made
from ...record import record
from ...source import Span
from ...tree import AXES, Add, Condition, Expr, Name, Negate, Number, Vector
from .. import units
from ..units import NONE, Dimension
from .calls import Calls
from .checking import Checked
from .conditions import positive
from .names import BUILT_IN, KIND_TEXT, UNKNOWN, Entry, Facts, Members, Turn, Wrong, joined
from .operators import Operators
from .quantities import Quantities
from .rotations import attitude
from .scope import Place, Scope
from .vectors import EXAMPLE, output_vector


@record
class Target:
    """The dimension that a value must have (None allows any). `needs` is the text of this demand in
    messages. `bare` means that a number without a unit is allowed, as a value in SI."""

    dimension: Dimension | None
    needs: str
    bare: bool = False


class Expressions(Operators, Calls, Quantities):
    """Checks expressions. The method for a class of `tree.Expr` has its name in lower case."""

    # entry points

    def check(self, expr: Expr, scope: Scope) -> Checked:
        new, facts = self.factor(expr, scope)
        if not facts.turns:
            return new, facts
        message = f"{self.text(expr)} is a rotation, which turns a vector"
        self.error(message, expr, f"e.g. {EXAMPLE}")
        return expr, UNKNOWN

    def factor(self, expr: Expr, scope: Scope) -> Checked:
        """Checks an expression that may be a rotation. The facts of a rotation are not valid,
        except for `turns`, the factors of the rotation."""
        try:
            return getattr(self, type(expr).__name__.lower())(expr, scope)
        except Wrong as wrong:
            if wrong.message:
                self.error(wrong.message, wrong.at or expr, wrong.help)
            return expr, UNKNOWN

    def positive(self, expr: Condition, scope: Scope) -> Checked:
        """Checks a condition; returns a function that is positive where it holds."""
        try:
            return positive(expr, lambda part: self.check(part, scope), self.cells)
        except Wrong as wrong:
            self.error(wrong.message, wrong.at or expr, wrong.help)
            return expr, UNKNOWN

    def wanted_vector(self, expr: Expr, scope: Scope, target: Target) -> Checked:
        """Checks a vector of a given dimension; in a literal [x, y, z] checks each item."""
        if isinstance(expr, Vector) and len(expr.items) == len(AXES):
            parts = [self.wanted(item, scope, target) for item in expr.items]
            facts = joined(target.dimension, True, [f for _, f in parts])
            return Vector(tuple(e for e, _ in parts), expr.span), facts
        new, facts = self.check(expr, scope)
        if facts.vector is False and facts.known:
            message = f"{self.text(expr)} is a number, {target.needs}"
            self.error(message, expr, "write the vector [x, y, z]")
        elif None not in (facts.dimension, target.dimension) and facts.dimension != (
            target.dimension
        ):
            self.against(expr, facts, target.dimension, target.needs, target.bare)
        return new, facts

    def wanted(self, expr: Expr, scope: Scope, target: Target) -> Checked:
        """Checks a number of a given dimension; in a sum checks each term."""
        if isinstance(expr, Add) and not target.bare:
            parts = [self.wanted(term, scope, target) for term in self.terms(expr)]
            return self.summed(expr, parts, target.dimension)
        if isinstance(expr, Negate):
            of, facts = self.wanted(expr.of, scope, target)
            return self.negated(expr, of, facts)
        if isinstance(expr, Add):
            parts = [self.check(term, scope) for term in self.terms(expr)]
            if not all(f.bare and f.dimension in (None, NONE) for _, f in parts):
                for part, (_, facts) in zip(expr.terms, parts, strict=True):
                    self._against(part, facts, replace(target, bare=False), numbers=True)
            return self.summed(expr, parts, target.dimension)
        new, facts = self.check(expr, scope)
        self._against(expr, facts, target, numbers=target.bare)
        return new, facts

    def _against(self, expr: Expr, facts: Facts, target: Target, numbers: bool) -> None:
        if facts.vector:
            message = f"{self.text(expr)} is a vector, {target.needs}"
            help = "take a component (.x, .y, .z), dot(a, b) or norm(a)"
            self.error(message, expr, help)
        elif target.dimension is None or facts.dimension in (None, target.dimension):
            return
        elif not (target.bare and facts.bare and facts.dimension == NONE):
            self.against(expr, facts, target.dimension, target.needs, numbers)

    # leaves

    def number(self, expr: Number, scope: Scope) -> Checked:
        return expr, Facts(None if expr.value == 0 else NONE, False, expr.value, bare=True)

    def name(self, expr: Name, scope: Scope) -> Checked:
        entry = self._entry(expr, scope)
        if entry is None:
            if expr.index is not None:
                self.indices.valid(expr.index, scope)
            raise Wrong
        entry.used = True
        if entry.kind == "poisoned":
            raise Wrong
        if entry.kind not in scope.place.kinds:
            raise self._forbidden(expr, entry, scope.place)
        if not self.indices.member(expr, entry, scope):
            raise Wrong
        if entry.kind in ("output", "built-in", "multiplier") and entry.facts.vector:
            return output_vector(expr), entry.facts
        if entry.kind == "rotation":
            turn = attitude(expr.id, expr.index, expr.span)
            return expr, replace(entry.facts, turns=(turn,))
        if entry.turning is not None:
            return expr, self._turning(expr, entry)
        return expr, entry.facts

    columns: Callable[[str], tuple[str, ...]]  # Set by check/bodies.py.

    def _turning(self, expr: Name, entry: Entry) -> Facts:
        """Returns the facts of a rotation that belongs to a family of bodies; `expr` has its
        index."""
        try:
            member = entry.turning.get(integer(expr.index, self.sizes))
            if member is None:
                raise Wrong
            return member
        except NotAnInteger:
            names = self.columns(expr.id)
            columns = tuple(Name(name, expr.index, expr.span) for name in names)
            return replace(entry.facts, turns=(Turn(columns=columns),))

    def _entry(self, expr: Name, scope: Scope) -> Entry | None:
        name = expr.id
        if name in scope.variables:
            return Entry(name, "loop variable", Facts(NONE, bare=True), expr.span)
        entry = self.names.table.get(name)
        if entry is not None:
            return entry
        if name == "pi":
            return Entry(name, "constant", Facts(NONE, False, math.pi, bare=True), expr.span)
        if name == "t":
            return Entry(name, "time", Facts(self.time_dimension, time=True), expr.span)
        if name == "inf":
            self._once(name, "'inf' stands only in bounds, e.g. in (0, inf)", expr.span)
            return None
        moving = of_made("p_", name)
        if name in BUILT_IN or moving in self.names.moving:
            return self._built_in(name, expr)
        if moving in self.names.states:
            message = f"'{name}': {moving} is a state, and only coordinates have momenta"
            self._once(name, message, expr.span, f"its rate is {moving}'")
            return None
        built_in = "built-in" in scope.place.kinds
        self.names.unknown(name, expr.span, missing=scope.place.missing, built_in=built_in)
        return None

    def _built_in(self, name: str, expr: Name) -> Entry | None:
        if not self.names.moving and self.names.states:
            self._once(
                name,
                f"'{name}' is not known here: a model of states alone has no energy",
                expr.span,
                f"define it: let {name} = …" if name != "energy" else "observe H = … names one",
            )
            return None
        everything = self.names.moving
        facts = Facts(self.energy_dimension, united=True, coordinates=everything, rates=everything)
        of = self.names.table.get(of_made("p_", name))
        if of is not None and of.facts.dimension is None:
            facts = replace(facts, dimension=None, known=False)
        elif of is not None:
            action = units.times(self.energy_dimension, self.time_dimension)
            facts = replace(facts, dimension=units.over(action, of.facts.dimension))
        if of is not None and of.kind == "rotation":
            facts = replace(facts, vector=True)
        # The ends of a family, such as q[0] of q[1..N], have no momentum.
        members = Members(of.own) if of is not None and of.own else None
        return Entry(name, "built-in", facts, expr.span, members)

    def _once(self, name: str, message: str, span: Span, help: str = "") -> None:
        if name not in self.names.reported:
            self.names.reported.add(name)
            self.error(message, span, help)

    def _forbidden(self, expr: Name, entry: Entry, place: Place) -> Wrong:
        if entry.kind == "output":
            help = f"define {expr.id} with 'let' to use it elsewhere"
        elif entry.kind == "built-in":
            where = ("event", "rate") if self.names.states else ("event",)
            words = [f"'{word}'" for word in ("observe", "conserve", *where)]
            help = f"it can be used in {', '.join(words[:-1])} and {words[-1]}"
        elif entry.kind == "multiplier":
            help = "it follows from the motion, and can be used in outputs and events"
        elif entry.kind == "body":
            name = self.text(expr)
            help = f"its places are {name}.com, {name}.origin, {name}.point([x, y, z])"
        elif entry.kind == "constraint":
            help = f"its multiplier is {multipliers(expr.id)[0]}, in outputs and events"
        else:
            help = f"{place.what} may use {place.may_use}"
        return Wrong(f"'{expr.id}' is {KIND_TEXT[entry.kind]}: {place.what} cannot use it", help)
