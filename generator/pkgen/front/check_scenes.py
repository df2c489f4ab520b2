"""Scenes, checked lightly: every name that a clause uses must be known.

Their units and what may stand where are checked when scenes are compiled.
"""

from __future__ import annotations

from ..source import Span
from ..tree import Expr, Name, Sum, children
from . import statements as st
from .check_names import BUILT_IN, Names, Report

_ALWAYS = frozenset(("t", "pi", "inf", *BUILT_IN))


class Scenes:
    def __init__(self, report: Report, names: Names) -> None:
        self.report, self.names = report, names

    def check(self, scene: st.Scene) -> None:
        swarms = [c.range.variable for c in scene.clauses if isinstance(c, st.Swarm)]
        for clause in scene.clauses:
            self._clause(clause, frozenset(swarms))

    def _clause(self, clause: st.Clause, variables: frozenset[str]) -> None:
        match clause:
            case st.StartAt(items=items):
                for item in items:
                    self._left(item.left, ("coordinate",), "'start' is for coordinates")
                    self._known(item.value, variables | _variable(item.left))
            case st.Assign(keyword=keyword, items=items):
                kinds, message = _ASSIGNED[keyword]
                for left, value in items:
                    self._left(left, kinds, message)
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

    def _left(self, left: st.Left, kinds: tuple[str, ...], message: str) -> None:
        span = Span(left.span.start, left.span.start + len(left.name))
        entry = self.names.table.get(left.name)
        if entry is None:
            self.names.unknown(left.name, span)
            return
        entry.used = True
        if entry.kind not in (*kinds, "poisoned"):
            self.report.error(f"{message}; '{left.name}' is another kind of name", span)

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
