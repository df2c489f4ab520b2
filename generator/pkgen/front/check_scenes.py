"""Scenes: what `pkgen run --scene` runs is checked in full, names, units and members.

Of the clauses that cannot be run yet only the names are checked, and the scene keeps why it is
refused. A scene with a `swarm` is one of these as a whole, for its starts use the swarm's variable.
"""

from __future__ import annotations

from dataclasses import replace
from difflib import get_close_matches

from .. import model as m
from ..indices import NotAnInteger, integer
from ..source import Span
from ..tree import Expr, Name, Prime, Sum, children
from . import statements as st
from . import units
from .check_dynamics import Dynamics
from .check_expr import Target
from .check_names import BUILT_IN, KIND_TEXT, Entry
from .check_scope import PLACES, Scope
from .check_shared import Shared, name_span
from .units import NONE

_ALWAYS = frozenset(("t", "pi", "inf", *BUILT_IN))
_REFUSED = {
    st.Swarm: "'swarm' cannot be run yet; --ensemble FILE.csv runs many starts",
    st.Expect: "'expect' cannot be checked yet; record the quantity and compare",
    "hold": "'hold' cannot be run yet",
    "accuracy": "'accuracy' cannot be promised yet; choose by 'method NAME step H' or 'rtol R'",
}


class Scenes:
    def __init__(self, shared: Shared, dynamics: Dynamics) -> None:
        self.shared, self.dynamics = shared, dynamics
        self.report, self.names = shared.report, shared.names
        self.expressions = shared.expressions

    def check(self, scene: st.Scene) -> None:
        if any(s.name == scene.name for s in self.shared.parts["scene"]):
            self.report.error(f"there is a scene '{scene.name}' already", scene.name_span)
        swarms = frozenset(c.range.variable for c in scene.clauses if isinstance(c, st.Swarm))
        found: dict[str, object] = {
            "assignments": (),
            "starts": (),
            "until": None,
            "method": "",
            "step": None,
            "rtol": None,
            "record": None,
        }
        refused: list[tuple[str, Span]] = []
        for clause in scene.clauses:
            why = _REFUSED.get(type(clause)) or _REFUSED.get(getattr(clause, "keyword", ""))
            if why:
                refused.append((why, clause.span))
            if why or swarms:
                self._names_of(clause, swarms)
            else:
                self._clause(clause, found)
        self.shared.parts["scene"].append(
            m.Scene(scene.name, scene.description, **found, refused=tuple(refused), span=scene.span)
        )

    # clauses that are run

    def _clause(self, clause: st.Clause, found: dict) -> None:
        match clause:
            case st.StartAt(items=items):
                checked = [self.dynamics.start_item(item) for item in items]
                found["starts"] += tuple(x for x in checked if x is not None)
            case st.Assign(items=items):
                checked = [self._assignment(left, value) for left, value in items]
                found["assignments"] += tuple(x for x in checked if x is not None)
            case st.Setting(value=value):  # until
                self._once(found["until"], "until", clause.span)
                found["until"] = self._time("until", value)
            case st.Method(name=name, step=step, rtol=rtol):
                self._once(found["method"], "method", clause.span)
                found["method"] = name
                found["step"] = self._time("step", step)
                found["rtol"] = None if rtol is None else self._setting("rtol", rtol, NONE)
            case st.Record():
                self._once(found["record"], "record", clause.span)
                found["record"] = self._record(clause)

    def _once(self, before: object, keyword: str, span: Span) -> None:
        if before:
            self.report.error(f"a scene has one '{keyword}'; this is the second", span)

    def _time(self, name: str, value: Expr | None) -> Expr | None:
        if value is None:
            return None
        return self._setting(name, value, self.expressions.time_dimension)

    def _setting(self, name: str, value: Expr, dimension: units.Dimension) -> Expr:
        """A number; in a model without units a time may have its unit all the same."""
        scope = Scope(PLACES["setting"])
        kind = units.described(dimension)
        target = Target(dimension, f"'{name}' is {kind}", bare=True)
        if dimension == NONE and name != "rtol":
            new, facts = self.expressions.check(value, scope)
            if facts.dimension == units.TIME:
                return new
        return self.expressions.wanted(value, scope, target)[0]

    def _assignment(self, left: st.Left, value: Expr) -> m.Assignment | None:
        entry = self._assigned(left, ("parameter", "input"), "'set' gives parameters and inputs")
        if entry is None or entry.kind == "poisoned":
            return None
        scope: Scope | None = Scope(PLACES["setting" if entry.kind == "parameter" else "driving"])
        index = left.index
        if left.range is not None:
            scope = self.expressions.indices.enter((left.range,), scope)
            if scope is None:
                return None
            index = Name(left.range.variable, None, left.range.span)
        named = Name(left.name, index, left.span)
        if not self.expressions.indices.member(named, entry, replace(scope, name="=")):
            return None
        dimension = entry.facts.dimension
        kind = "" if dimension is None else units.described(dimension)
        target = Target(dimension, f"{left.name} is {kind}", bare=True)
        new, facts = self.expressions.wanted(value, scope, target)
        return m.Assignment(left.name, left.index, left.range, new, facts.time, left.span)

    def _record(self, clause: st.Record) -> m.Record:
        columns = [self._column(item) for item in clause.items]
        return m.Record(
            columns=tuple(c for c in columns if c is not None),
            every=self._time("every", clause.every),
            at="" if clause.at is None else self._event(clause.at),
            span=clause.span,
        )

    def _column(self, item: Expr) -> m.Definition | None:
        value, facts = self.expressions.check(item, Scope(PLACES["record"]))
        inner, order = value, 0
        while isinstance(inner, Prime):
            inner, order = inner.of, order + 1
        if not isinstance(inner, Name):
            self.report.error(
                "a record takes names, not expressions",
                item.span,
                "give it a name: observe NAME = …",
            )
            return None
        if not facts.known:
            return None
        if inner.id == "t":
            self.report.error("'t' is the first column of every record", item.span)
            return None
        if facts.vector:
            self.report.error(
                f"'{inner.id}' is a vector; a column is a number",
                item.span,
                "observe NAME = … takes a component (.x, .y, .z)",
            )
            return None
        try:
            index = None if inner.index is None else integer(inner.index, self.shared.sizes)
        except NotAnInteger:  # reported
            return None
        name = inner.id + ("" if index is None else f"[{index}]") + "'" * order
        unit = self.shared.shown_unit(value, facts)
        return m.Definition(name, None, None, value, unit, "", item.span)

    def _event(self, at: Expr) -> str:
        events = {e.name for e in self.shared.parts["event"]}
        if isinstance(at, Name) and at.index is None and at.id in events:
            return at.id
        if isinstance(at, Name) and self.names.table.get(at.id) is None:
            near = get_close_matches(at.id, sorted(events), 1, 0.6)
            help = f"the events are: {', '.join(sorted(events))}" if events else ""
            help = help or f"declare it: event {at.id}: EXPRESSION rising"
            self.report.error(
                f"unknown event '{at.id}'", at.span, f"did you mean '{near[0]}'?" if near else help
            )
        else:
            kind = ""
            if isinstance(at, Name):
                kind = f"; '{at.id}' is {KIND_TEXT[self.names.table[at.id].kind]}"
            self.report.error(
                f"'record … at' takes an event{kind}",
                at.span,
                "'until' gives a duration, 'every' an interval",
            )
        return ""

    # clauses that are not run: names alone

    def _names_of(self, clause: st.Clause, variables: frozenset[str]) -> None:
        match clause:
            case st.StartAt(items=items):
                for item in items:
                    self._assigned(item.left, ("coordinate",), "'start' is for coordinates")
                    self._known(item.value, variables | _variable(item.left))
            case st.Assign(keyword=keyword, items=items):
                kinds, message = _ASSIGNED[keyword]
                for left, value in items:
                    self._assigned(left, kinds, message)
                    if value is not None:
                        self._known(value, variables | _variable(left))
            case st.Record(items=items, every=every, at=at):
                for expr in (*items, every, at):
                    self._known(expr, variables)
            case st.Expect(a=a, b=b, within=within, at=at):
                for expr in (a, b, within, at):
                    self._known(expr, variables)
            case st.Setting(value=value):
                self._known(value, variables)
            case st.Method(step=step, rtol=rtol):
                self._known(step, variables)
                self._known(rtol, variables)

    def _assigned(self, left: st.Left, kinds: tuple[str, ...], message: str) -> Entry | None:
        entry = self.names.table.get(left.name)
        if entry is None:
            self.names.unknown(left.name, name_span(left))
            return None
        entry.used = True
        if entry.kind not in (*kinds, "poisoned"):
            self.report.error(f"{message}; '{left.name}' is another kind of name", name_span(left))
            return None
        return entry

    def _known(self, expr: Expr | None, variables: frozenset[str]) -> None:
        waiting = [expr] if expr is not None else []
        while waiting:
            part = waiting.pop()
            waiting.extend(children(part))
            if isinstance(part, Name):
                self._name(part, variables)
            elif isinstance(part, Sum):
                variables = variables | {r.variable for r in part.ranges}

    def _name(self, name: Name, variables: frozenset[str]) -> None:
        if name.id in variables or name.id in _ALWAYS:
            return
        if name.id.startswith("p_") and name.id[2:] in self.names.coordinates:
            return
        entry = self.names.table.get(name.id)
        if entry is None:
            self.names.unknown(name.id, name.span)
        else:
            entry.used = True


_ASSIGNED = {
    "set": (("parameter", "input"), "'set' gives parameters and inputs"),
    "hold": (("coordinate",), "'hold' is for coordinates"),
}


def _variable(left: st.Left) -> frozenset[str]:
    return frozenset((left.range.variable,)) if left.range is not None else frozenset()
