"""Checks `sample` blocks: controllers that run at given times and set inputs and memory cells."""

from __future__ import annotations

from ... import model as m
from ...tree import Expr
from .. import statements as st
from ..units import NONE
from .names import UNKNOWN, Entry, Facts, Report
from .scene_numbers import Values, WrongValue
from .scope import PLACES, Scope
from .settings import Settings
from .shared import as_is, name_span

MOST = 64  # largest delay, in samples
_KINDS = ("input", "memory cell")


class Samples(Settings):
    def sample(self, block: st.Sample) -> None:
        times = [self.time(n, getattr(block, n)) for n in ("every", "offset")]
        entry = Entry(block.name, "sample", UNKNOWN, block.name_span, used=True)
        self.names.declare(entry)
        delay, count = 0, self.report.count
        if block.delay is not None:
            delay = self.indices.value(block.delay, Scope(PLACES["size"]))
            if delay is not None and not 0 <= delay <= MOST:
                help = "it counts samples: the motion has a value so many samples later"
                self.error(f"a delay is a whole number from 0 to {MOST}", block.delay, help)
                delay = 0
        self.own: set[str] = set()  # memory cells of this block
        self.set_here: dict[str, Entry] = {}
        steps, before = [], {*self.names.table}
        for clause in block.clauses:
            if clause.keyword == "memory":
                self._memory(block, clause)
            elif clause.keyword == "let":
                steps += self._let(clause)
            else:
                steps += [s for left, value in clause.items for s in self._set(block, left, value)]
        for name in {*self.names.table} - before - self.own:
            del self.names.table[name]  # a `let` of the block
        if not self.set_here and self.report.count == count:
            message = f"the sample block '{block.name}' sets nothing"
            self.error(message, block.name_span, "say what it sets, e.g. set u = -k*x")
        inputs = [n for n, e in self.set_here.items() if e.kind == "input"]
        self.queues += [(name, f"{name}.{k + 1}") for name in inputs for k in range(delay or 0)]
        given = block.name, *times, delay or 0, tuple(steps), block.description, block.head
        self.parts["samples"].append(m.Sample(*given))

    def _memory(self, block: st.Sample, clause: st.Define) -> None:
        left, scope = clause.left, Scope(PLACES["start"])
        if left.index or left.range:
            self.error("a memory cell has no index", left, "declare them one by one")
        value, facts = self.checked(clause.value, scope)
        if facts.vector:
            self.no_vector(left, "memory cell")
        shown = self.shown_unit(clause.value, facts)
        own = Facts(facts.dimension or NONE, False, united=facts.united, inputs={left.name: 0})
        self.names.declare(Entry(left.name, "memory cell", own, name_span(left)))
        self.own.add(left.name)
        self.sampled[left.name] = block.name
        cell = left.name, 0, (shown,), clause.description, clause.span, block.name, value
        self.parts["inputs"].append(m.Input(*cell))

    def _let(self, clause: st.Define) -> list[m.Given]:
        left = clause.left
        if left.index or left.range:
            self.error("a 'let' of a sample block has no index", left, "define the family above it")
        value, facts = self.factor(clause.value, Scope(PLACES["sample"], name=left.name))
        self.names.declare(Entry(left.name, "definition", facts, name_span(left), used=True))
        return [] if facts.turns else [m.Given(left.name, None, None, value, clause.span)]

    def _set(self, block: st.Sample, left: st.Left, value: Expr | None) -> list[m.Given]:
        entry = self.named(left, "'set' of a sample block", _KINDS)
        dimension = entry.facts.dimension if entry else None
        target = as_is(left.name, dimension)
        new, _ = self.wanted(value, Scope(PLACES["sample"]), target)
        if entry is None:
            return []
        if left.index is not None or left.range is not None:
            self.error(f"'{left.name}' is no family: it takes no index", left)
        entry.used = True
        by = self.sampled.setdefault(left.name, block.name)
        if by != block.name:
            message = f"'{left.name}' is set by the sample block '{by}' already"
            help = "an input has one block that sets it, a memory cell the block that declares it"
            self.error(message, left, help)
        self.set_here[left.name] = entry
        return [m.Given(left.name, None, None, new, left.span)]


def check_times(model: m.Model, report: Report) -> None:
    """Reports a period that is not positive, and an offset that is negative, at the parameters'
    default values."""
    values = Values(model, {})
    for block in model.samples:
        for name, expr in (("every", block.every), ("offset", block.offset)):
            try:
                (values.positive if name == "every" else values.not_negative)(name, expr)
            except WrongValue as wrong:
                help = "a period is a time above 0, e.g. every 0.01 [s]"
                report.error(str(wrong), wrong, wrong.help or help * (name == "every"))
