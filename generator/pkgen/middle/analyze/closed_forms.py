"""Tries closed forms of the motion (`exact x = EXPR`) in numbers.

At t = 0 they must agree with the start, in value and in rate. Put into the equations of motion, at
some times, they must satisfy those rows of M a = f, and rates of states, that contain nothing else.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

from ...equations import Equations
from ...graph.evaluate import evaluate
from ...graph.graph import BIT, ZERO, Kind, Node, Symbol
from ...graph.rounding import sizes as errors_of
from ...graph.substitute import substituted
from ...indices import assignments, indexed, integer, parted
from ...model import Definition, Exact, Model
from ...record import record
from ...source import Diagnostic, ModelError, Span
from ...tree import Name, Number, Prime, of_member
from ..derive import derive
from ..points.singularities import defaults
from ..quantities import families, sizes

MOST = 200  # coordinates and states; of more, closed forms are not tried
TIMES = (1e-6, 1e-3, 0.03, 0.13, 0.29, 0.57, 0.83)  # as parts of the run
WRITTEN = 1e-8  # relative error of numbers in models, which have few digits
ROUND = 64 * sys.float_info.epsilon
_OPEN = BIT[Kind.COORDINATE] | BIT[Kind.RATE] | BIT[Kind.STATE] | BIT[Kind.INPUT]


def check_exact(
    model: Model,
    exacts: Sequence[Exact],
    given: Mapping[object, object] = {},
    until: float | None = None,
) -> None:
    """Raises ModelError if a closed form is not what it says. `given` has values of parameters by
    name or (name, index), where these are not the defaults."""
    declared = (*model.coordinates, *model.states)
    if not exacts or sum(f.count for f in families(model, declared).values()) > MOST:
        return
    written = [*_written(model, exacts)]
    outputs = tuple(x for _, *of in written for x in of)
    observed = (*model.observed, *outputs)
    e = derive.derive(replace(model, observed=observed, conserved=(), events=()), frozenset())
    nodes = e.observed[len(e.observed) - len(outputs) :]
    forms = [
        _Form(name, x.span, *nodes[5 * k : 5 * k + 5]) for k, (name, x, *_) in enumerate(written)
    ]

    def changed(k: int, default: float) -> float:
        name, index = parted(e.parameters[k].quantity.name)
        return float(given.get(name if index is None else (name, index), default))

    values = {Symbol(Kind.TIME): 0.0, **defaults(e.graph, e.parameters, changed)}
    if wrong := next(_Trial(e, forms, values, until or 1.0).wrong(), None):
        raise ModelError(model.source, [wrong])


def _written(model: Model, exacts: Sequence[Exact]) -> Iterator[tuple]:
    """Yields the name of each quantity with a closed form, and five outputs: the quantity, its
    closed form, the first and second derivative of this, and how far it may be off."""
    known = sizes(model)
    for item in exacts:
        for loop in assignments((item.range,) if item.range else (), known):
            at, value, off = None, item.value, item.within or Number(Fraction(-1), item.span)
            if item.range is not None:
                at = Number(Fraction(loop[item.range.variable]), item.span)
                value = of_member(value, item.range.variable, at)
            elif item.index is not None:
                at = Number(Fraction(integer(item.index, known)), item.span)
            rate = Prime(value, item.span)
            outputs = Name(item.name, at, item.span), value, rate, Prime(rate, item.span), off
            name = indexed(item.name, None if at is None else int(at.value))
            made = (Definition("0_exact", None, None, x, "", "", item.span) for x in outputs)
            yield name, *made


@record
class _Form:
    """A closed form, as nodes; `within` is negative if the model does not give it."""

    name: str
    span: Span
    quantity: Node
    form: Node
    rate: Node
    acceleration: Node
    within: Node


class _Trial:
    """Evaluates closed forms at the start (t = 0) and at times in the run."""

    def __init__(
        self, e: Equations, forms: list[_Form], values: dict[Symbol, float], until: float
    ) -> None:
        self.e, self.g, self.forms = e, e.graph, forms
        self.times = [{**values, Symbol(Kind.TIME): until * part} for part in TIMES]
        kinds = (Kind.COORDINATE, Kind.RATE, Kind.STATE)
        start = dict(values)
        for kind, row in zip(kinds, (e.start_q, e.start_v, e.state_start), strict=True):
            found = enumerate(evaluate(self.g, row, values))
            start |= {Symbol(kind, i): x for i, x in found}
        self.start = [start]
        places = {q.name: Symbol(Kind.COORDINATE, i) for i, q in enumerate(e.seen)}
        places |= {s.name: Symbol(Kind.STATE, i) for i, s in enumerate(e.states)}
        # The coordinates and states with closed forms.
        self.moving = {places[x.name]: x for x in forms if x.name in places}

    def wrong(self) -> Iterator[Diagnostic]:
        for x in self.forms:
            within = evaluate(self.g, [x.within], self.start[0])[0]
            yield from self._at_the_start(x, x.name, x.quantity, x.form, within)
        for symbol, x in self.moving.items():
            if symbol.kind is Kind.COORDINATE and not self._about(x):
                rate = self.g.symbol(Symbol(Kind.RATE, symbol.index))
                yield from self._at_the_start(x, f"{x.name}'", rate, x.rate)
        exact = {s: x for s, x in self.moving.items() if not self._about(x)}
        swap = {self.g.symbol(s): x.form for s, x in exact.items()}
        rates = (s for s in exact if s.kind is Kind.COORDINATE)
        swap |= {self.g.symbol(Symbol(Kind.RATE, s.index)): exact[s].rate for s in rates}
        for x in self.forms:
            if not self._about(x):
                terms = [x.quantity, self.g.negate(x.form)]
                yield from self._later(x, terms, swap, "is not what the motion gives")
        for symbol, x in exact.items():
            if (terms := self._equation(symbol, exact)) is not None:
                yield from self._later(x, terms, swap, "does not solve its equation of motion")

    def _about(self, x: _Form) -> bool:
        """Whether the model says how good a closed form is. Then its start alone is tried."""
        return self.g.value(x.within) != -1

    def _equation(self, symbol: Symbol, exact: Mapping[Symbol, _Form]) -> list[Node] | None:
        """Returns the terms of a row of M a - f, or of the rate of a state; None if the row
        contains accelerations without closed form."""
        e, g, i = self.e, self.g, symbol.index
        if symbol.kind is Kind.STATE:
            return [exact[symbol].rate, g.negate(e.state_rates[i])]
        row = [(m, exact.get(Symbol(Kind.COORDINATE, j))) for j, m in enumerate(e.mass[i])]
        row = [(m, x) for m, x in row if m != ZERO]
        if any(x is None for _, x in row):
            return None
        return [*(g.multiply(m, x.acceleration) for m, x in row), g.negate(e.force[i])]

    def _at_the_start(
        self, x: _Form, name: str, quantity: Node, form: Node, within: float = -1.0
    ) -> Iterator[Diagnostic]:
        found = self._off([quantity, self.g.negate(form)], self.start, within)
        if found is not None and not self.e.model.consistent:
            starts, minus = found[1:]
            message = f"{name} starts at {starts:.10g}, and its closed form at {-minus:.10g}"
            yield Diagnostic(message, x.span, "correct it, or start where it does")

    def _later(
        self, x: _Form, terms: list[Node], swap: Mapping[Node, Node], says: str
    ) -> Iterator[Diagnostic]:
        terms = substituted(self.g, terms, swap)
        if any(self.g.depends[node] & _OPEN for node in terms):
            return
        found = self._off(terms, self.times)
        if found is not None:
            t, *parts = found
            off, size = abs(sum(parts)), sum(map(abs, parts))
            message = f"the closed form of {x.name} {says}: at t = {t:.4g} it is off by {off:.4g},"
            help = f"correct it; an approximation says how good it is: exact {x.name} = … within …"
            yield Diagnostic(f"{message} where its terms are {size:.4g} in size", x.span, help)

    def _off(
        self, terms: list[Node], points: list[dict[Symbol, float]], within: float = -1.0
    ) -> list[float] | None:
        """Returns the time and the terms at the first of the points where their sum is not 0 up to
        rounding; None if there is none."""
        nodes = [*terms, *errors_of(self.g, terms)]
        for values in points:
            found = evaluate(self.g, nodes, values)
            parts, errors = found[: len(terms)], found[len(terms) :]
            allowed = WRITTEN * sum(map(abs, parts)) + ROUND * sum(errors) + sys.float_info.min
            total = abs(sum(parts))
            if math.isfinite(total) and total <= max(within, allowed):
                continue
            if math.isfinite(total) or points is self.start:  # later it may have no value
                return [values[Symbol(Kind.TIME)], *parts]
        return None
