"""Checks `exact x = EXPR within TOL`, closed forms of the motion as functions of t."""

from __future__ import annotations

from ... import model as m
from ...source import Span
from .. import statements as st
from .scope import PLACES, Scope
from .settings import Settings
from .shared import as_is

_KINDS = ("coordinate", "state", "output", "definition")


class Exacts(Settings):
    def exact(self, statement: st.Pairs) -> None:
        self._add(statement)
        self.parts["exacts"] = list(self.exacts)

    def of_scene(self, scene: st.Scene) -> tuple[m.Exact, ...]:
        """Returns the closed forms that are valid in a scene: its own or, without any, the model's.
        These are of the model's start: a scene that starts or holds anything does not have them."""
        words = {clause.keyword for clause in scene.clauses}
        self.exacts.clear()
        for clause in scene.clauses:
            if clause.keyword == "exact":
                self._add(clause)
        if self.exacts and "swarm" in words:
            message = "the members of a swarm start differently: they have no closed form in common"
            self.error(message, self.exacts[0])
        if not self.exacts and not words & {"start", "hold", "swarm"}:
            self.exacts += self.parts["exacts"]
        return tuple(self.exacts)

    def _add(self, statement: st.Pairs) -> None:
        """Adds the closed forms to those which error(x) finds."""
        for left, value in statement.items:
            entry = self.named(left, "a closed form", _KINDS)
            scope = self.member_scope(left, entry, Scope(PLACES["exact"]))
            if entry is None or scope is None:
                continue
            facts, within = entry.facts, statement.within
            new, _ = self.wanted(value, scope, as_is(left.name, facts.dimension))
            if within is not None:
                within = self.tolerance(within, facts.dimension)
            if facts.vector or facts.turns or (facts.known and not facts.moves):
                help = "it is of a number that moves, as a component: observe a = r.x"
                self.error(f"'{left.name}' has no closed form", left, help)
            if left.index is not None:
                help = f"say it as a range: {left.name}[i = 3..3]"
                self.error("a closed form is of a name or of a range", left, help)
            if any(left.name == form.name for form in self.exacts):
                self.error(f"'{left.name}' has its closed form already", left)
            span = Span(left.span.start, value.span.end)
            self.exacts.append(m.Exact(left.name, None, left.range, new, span, within))
