"""Checks scenes, clause by clause: names, units, members, and combinations of clauses.

`check/given.py` checks the values that a scene sets, `check/settings.py` numbers and events,
`check/expects.py` expectations; `check/scene_values.py` checks values known at compile time.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from ... import model as m
from ...indices import NotAnInteger, indexed, integer
from ...source import Span
from ...tree import Call, Component, Expr, Name, Prime, Range
from .. import statements as st
from ..table import STATEMENTS
from ..units import NONE
from .dynamics import Dynamics
from .exacts import Exacts
from .expects import Expects
from .given import Given
from .methods import Methods
from .names import NAMED
from .rotations import quaternion_names
from .scope import PLACES, Scope
from .settings import Settings
from .shared import Checks, Shared
from .vectors import by_component, component_name


class Scenes(Checks):
    def __init__(self, shared: Shared, dynamics: Dynamics, methods: Methods) -> None:
        super().__init__(shared)
        self.methods, self.dynamics = methods, dynamics
        self.settings, self.expects = Settings(shared), Expects(shared)
        self.exacts_of = Exacts(shared)

    def check(self, scene: st.Scene) -> None:
        if any(s.name == scene.name for s in self.parts["scenes"]):
            self.error(f"there is a scene '{scene.name}' already", scene.name_span)
        if not scene.clauses:
            message = f"the scene '{scene.name}' is empty"
            self.error(message, scene.name_span, "say what it runs, e.g. until 10")
        swarms = [c for c in scene.clauses if isinstance(c, st.Swarm)]
        for clause in swarms[1:]:
            self.second("swarm", clause.span)
        one = _Scene(self, swarms[0].range if swarms else None)
        one.said["exacts"] = self.exacts_of.of_scene(scene)
        for clause in scene.clauses:
            one.clause(clause)
        self.parts["scenes"].append(one.made(scene))

    def second(self, keyword: str, span: Span) -> None:
        self.error(f"a scene has one '{keyword}'; this is the second", span)


class _Scene(Given):
    """Builds one scene from its clauses."""

    def __init__(self, scenes: Scenes, swarm: Range | None) -> None:
        super().__init__(scenes.shared, scenes.dynamics, swarm)
        self.scenes, self.settings = scenes, scenes.settings
        self.said: dict[str, object] = {}  # name of a field of m.Scene -> its value
        self.expects: list[m.Expect] = []
        self.seen: set[str] = set()

    def clause(self, clause: st.Statement) -> None:
        help = ""
        if isinstance(clause, st.Record):
            help = "the rows' column in front says which member it is, without being recorded"
        if not isinstance(clause, st.StartAt) and self.swarm_of(_expressions(clause), help):
            return
        row = STATEMENTS[clause.keyword]
        if row.once:
            if clause.keyword in self.seen:
                self.scenes.second(clause.keyword, clause.span)
            self.seen.add(clause.keyword)
        if clause.keyword not in ("swarm", "exact"):  # __init__ and of_scene() have checked them.
            getattr(self, row.clause.rpartition(".")[2])(clause)

    def until(self, clause: st.Single) -> None:
        self.said["until"] = self.settings.time("until", clause.value)

    def accuracy(self, clause: st.Single) -> None:
        self.said["accuracy"] = self.settings.accuracy(clause.value)
        self._one_of_both(clause.span)

    def method(self, clause: st.Method) -> None:
        self.said |= {"method": clause.name, "method_span": clause.name_span}
        if clause.file is not None:
            self.scenes.methods.bring(clause)
        self.settings.method(clause)
        self.said["step"] = self.settings.time("step", clause.step)
        if clause.rtol is not None:
            self.said["rtol"] = self.settings.setting("rtol", clause.rtol, NONE)[0]
        self._one_of_both(clause.span)

    def _one_of_both(self, span: Span) -> None:
        if {"accuracy", "method"} <= self.seen:
            self.error(
                "'accuracy' and 'method' in one scene: with an accuracy pkgen chooses the method",
                span,
                "leave one of them out",
            )

    def expect(self, clause: st.Expect) -> None:
        self.expects += self.scenes.expects.check(clause)

    # record

    def record(self, clause: st.Record) -> None:
        columns: dict[str, m.Definition] = {}
        for column in (column for item in clause.items for column in self._columns(item)):
            if column.name in columns:
                self.error(f"'{column.name}' is recorded already", column)
            columns[column.name] = column
        every = self.settings.time("every", clause.every)
        event = "" if clause.at is None else self.settings.event(clause.at, "record … at")
        self.said["record"] = m.Record(tuple(columns.values()), every, event, clause.span)

    def _columns(self, item: Expr) -> Iterable[m.Definition]:
        """Returns the columns of a recorded name: one for a number, three for a vector, four for a
        rotation."""
        before = self.report.count
        value, facts = self.factor(item, Scope(PLACES["record"]))
        if self.report.count > before:
            return ()
        if facts.turns and facts.turns[0].name and isinstance(item, Name):
            at = None if item.index is None else integer(item.index, self.sizes)
            own, rest = (
                (replace(item, id=x) for x in quaternion_names(item.id)),
                ("", "", item.span),
            )
            return (m.Definition(indexed(x.id, at), None, None, x, *rest) for x in own)
        value, facts = self.checked(item, Scope(PLACES["record"]))
        inner, order, axis = item, 0, None
        while isinstance(inner, Prime):
            inner, order = inner.of, order + 1
        if isinstance(inner, Component):
            inner, axis = inner.of, inner.axis
        if isinstance(inner, Call) and inner.function in NAMED and facts.known:
            (of,) = inner.arguments
            inner = replace(of, id=f"{inner.function}({of.id})")
        if not isinstance(inner, Name):
            message = "a record takes names, not expressions"
            self.error(message, item, "give it a name: observe NAME = …")
            return ()
        if not facts.known:
            return ()
        if inner.id == "t":
            self.error("'t' is the first column of every record", item)
            return ()
        try:
            index = None if inner.index is None else integer(inner.index, self.sizes)
        except NotAnInteger:  # The error is reported already.
            return ()
        name = inner.id if axis is None else component_name(inner.id, axis)
        name, unit = indexed(name, index), self.shown_unit(value, facts)
        column = m.Definition(name, None, None, value, unit, "", item.span)
        columns = by_component(column) if facts.vector else (column,)
        return (replace(c, name=c.name + "'" * order) for c in columns)

    # the whole scene

    def made(self, scene: st.Scene) -> m.Scene:
        self.finish()
        if self.expects and "until" not in self.seen:
            message = "an expectation needs to know how long the scene runs"
            self.error(message, self.expects[0], "add to the scene: until 10")
        return m.Scene(
            name=scene.name,
            description=scene.description,
            span=scene.span,
            assignments=tuple(self.assignments),
            starts=tuple(self.starts),
            holds=tuple(self.holds),
            swarm=self.members,
            expects=tuple(self.expects),
            consistent=self.consistent,
            **self.said,
        )


def _expressions(clause: st.Statement) -> tuple[Expr | None, ...]:
    match clause:
        case st.Pairs(items=items):
            return tuple(value for _, value in items)
        case st.Single(value=value):
            return (value,)
        case st.Method(step=step, rtol=rtol):
            return step, rtol
        case st.Record(items=items, every=every, at=at):
            return (*items, every, at)
        case st.Expect(a=a, b=b, within=within, at=at):
            return a, b, within, at
    return ()
