"""Checks settings of a scene: times, tolerances, accuracy, method, and names of events."""

from __future__ import annotations

from ...indices import hidden
from ...methods import known
from ...system.near import meant
from ...tree import Expr, Name
from .. import statements as st
from .. import units
from ..units import NONE
from .expr import Checked
from .names import KIND_TEXT
from .scope import PLACES, Scope
from .shared import Checks, as_is

# The smallest `accuracy` that a scene may demand. Double precision allows no better one, since
# the result and the formula for the result are both rounded.
FINEST = 2.0**-51


class Settings(Checks):
    def setting(
        self, name: str, value: Expr, dimension: units.Dimension, place: str = "setting"
    ) -> Checked:
        target = as_is(f"'{name}'", dimension)
        return self.wanted(value, Scope(PLACES[place]), target)

    def tolerance(self, within: Expr, dimension: units.Dimension) -> Expr:
        value, facts = self.setting("within", within, dimension)
        if facts.value is not None and facts.value < 0:
            self.error("'within' is how far off it may be: it cannot be negative", within)
        return value

    def time(self, name: str, value: Expr | None) -> Expr | None:
        """Checks a time; it may have a unit of time even in a model without units."""
        if value is None:
            return None
        if self.time_dimension == NONE:
            new, facts = self.checked(value, Scope(PLACES["setting"]))
            if facts.dimension == units.TIME:
                return new
        return self.setting(name, value, self.time_dimension)[0]

    def accuracy(self, value: Expr) -> Expr:
        new, facts = self.setting("accuracy", value, NONE, "accuracy")
        if facts.value is None:
            return new
        if not facts.value > 0:
            self.error("'accuracy' must be positive", value, "e.g. accuracy 1e-9")
        elif facts.value < FINEST:
            message = f"an accuracy of {float(facts.value):.3g} is below round-off"
            help = f"doubles allow {FINEST:.1e} at best; 1e-12 is much already"
            self.error(message, value, help)
        elif facts.value > 1:
            message = "an accuracy above 1 promises nothing: it is relative to the quantity's size"
            self.error(message, value, "e.g. accuracy 1e-6")
        return new

    def method(self, clause: st.Method) -> None:
        """Reports an unknown method, missing settings of a method, and settings that do not
        apply to the method."""
        methods = known(self.parts["methods"])
        name, method = clause.name, methods.get(clause.name)
        if method is None:
            help = meant(name, methods) or "'pkgen methods' lists them"
            self.error(f"there is no method '{name}'", clause.name_span, help)
            return
        if method.fixed and clause.step is None:
            message = f"{name} has a fixed step: say how long it is"
            self.error(message, clause, f"e.g. method {name} step 0.01")
        if clause.rtol is not None and "adaptive" not in method.traits:
            why = "has a fixed step" if method.fixed else "is exact"
            self.error(f"{name} {why}: 'rtol' is for adaptive methods", clause.rtol, "leave it out")

    def event(self, at: Expr, clause: str) -> str:
        """Returns the name of an event; "" after an error."""
        whole = [x for x in self.parts["contacts"] if x.range is None]
        events = {e.name for e in (*self.parts["events"], *whole) if not hidden(e.name)}
        if isinstance(at, Name) and at.index is None and at.id in events:
            return at.id
        if isinstance(at, Name) and self.names.table.get(at.id) is None:
            help = f"the events are: {', '.join(sorted(events))}" if events else ""
            help = help or f"declare it: event {at.id}: EXPRESSION rising"
            self.error(f"unknown event '{at.id}'", at, meant(at.id, events) or help)
            return ""
        kind = ""
        if isinstance(at, Name):
            kind = f"; '{at.id}' is {KIND_TEXT[self.names.table[at.id].kind]}"
        help = "'until' gives a duration, 'every' an interval" if "record" in clause else ""
        self.error(f"'{clause}' takes an event{kind}", at, help)
        return ""
