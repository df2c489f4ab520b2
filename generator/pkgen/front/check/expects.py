"""Checks `expect A = B within TOL at T`, an assertion about a scene's run."""

from __future__ import annotations

from dataclasses import replace

from ... import model as m
from ...tree import AXES, Call, Expr, Name, within
from .. import statements as st
from ..units import NONE, Dimension
from .names import EVENTS, Facts
from .scope import PLACES, Scope
from .settings import Settings
from .vectors import component

OF_RUN = frozenset(("drift", "time"))  # Functions that have one value for a whole run.


class Expects(Settings):
    def check(self, clause: st.Expect) -> tuple[m.Expect, ...]:
        """Returns one Expect, for vectors one for each component; () after an error."""
        before = self.report.count
        scope = Scope(PLACES["expect"])
        (a, of_a), (b, of_b) = (self.checked(e, scope) for e in (clause.a, clause.b))
        known = of_a.known and of_b.known
        if known and not self._comparable(clause, bool(of_a.vector), bool(of_b.vector)):
            return ()
        dimension = self._dimension(clause, of_a, of_b) if known else None
        tolerance = self._within(clause, dimension)
        at, event = self._when(clause.at)
        if known and self.report.count == before:
            self._meaning(clause, of_a.moves or of_b.moves, (a, b))
        if self.report.count > before or not known:
            return ()
        found = m.Expect(a, clause.relation, b, tolerance, at, event, clause.span)
        if not of_a.vector:
            return (found,)
        return tuple(
            replace(found, a=component(a, k), b=component(b, k), component=f".{axis}")
            for k, axis in enumerate(AXES)
        )

    def _comparable(self, clause: st.Expect, a: bool, b: bool) -> bool:
        expr = clause.a if a else clause.b
        why = "" if clause.relation == "=" or not a else ": none is above another"
        why = why if a == b else "; the other side is a number"
        if why:
            help = "take a component (.x, .y, .z) or norm(v)"
            self.error(f"{self.text(expr)} is a vector{why}", expr, help)
        return not why

    def _dimension(self, clause: st.Expect, a: Facts, b: Facts) -> Dimension:
        """Returns the dimension of both sides; a number without a unit takes the other side's."""
        for bare, other in ((a, b), (b, a)):
            if bare.bare and bare.dimension in (None, NONE) and other.dimension is not None:
                return other.dimension
        sides = (clause.a, clause.b)
        shared = self.common(sides, [a, b], "'expect'", numbers=True)
        return NONE if shared is None else shared

    def _within(self, clause: st.Expect, dimension: Dimension | None) -> Expr | None:
        if clause.within is None:
            if clause.relation == "=":
                message = "'=' without 'within': numbers of a run are never exactly equal"
                self.error(message, clause, "say how far it may be off: expect A = B within 1e-6")
            return None
        if clause.relation != "=":
            message = f"'within' goes with '=': '{clause.relation}' is met or not"
            self.error(message, clause.within)
            return None
        if dimension is None:
            return None
        return self.tolerance(clause.within, dimension)

    def _when(self, at: Expr | None) -> tuple[Expr | None, str]:
        """Returns (time, "") if `at` is a time, (None, event) if it is an event."""
        if at is None:
            return None, ""
        table = self.names.table
        named = isinstance(at, Name) and at.index is None
        if named and (at.id not in table or table[at.id].kind in EVENTS) and at.id != "pi":
            return None, self.event(at, "expect")
        return self.time("at", at), ""

    def _meaning(self, clause: st.Expect, moves: bool, sides: tuple[Expr, Expr]) -> None:
        called = (x for side in sides for x in within(side) if isinstance(x, Call))
        of_run = [x for x in called if x.function in OF_RUN]
        if not of_run and not moves:
            message = "nothing in it moves: it holds or fails without a run"
            self.error(message, clause, "e.g. expect x = 1 within 1e-6 at 2")
        elif of_run and moves:
            message = (
                f"{of_run[0].function}(…) is of the whole run: it is not compared with what moves"
            )
            self.error(message, of_run[0], "beside it stand numbers and parameters")
        elif of_run and clause.at is not None:
            self.error(f"{of_run[0].function}(…) is of the whole run: it has no 'at'", clause.at)


def calls(item: m.Expect, function: str) -> list[Call]:
    return [
        part
        for side in (item.a, item.b)
        for part in within(side)
        if isinstance(part, Call) and part.function == function
    ]
