"""Tries closed forms of the motion (`exact x = EXPR`) in numbers.

At t = 0 they must agree with the start, in value and in rate. Put into the equations of motion, at
some times, they must satisfy those rows of M a = f, and rates of states, that contain nothing else.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

from ...graph.evaluate import evaluate
from ...graph.graph import BIT, Graph, Kind, Node, Symbol
from ...graph.rounding import sizes as errors_of
from ...graph.substitute import substituted
from ...indices import assignments, indexed, parted
from ...model import Definition, Exact, Model
from ...tree import Name, Number, Prime, of_member
from ..points.samples import started
from ..points.singularities import defaults
from ..quantities import error, families, sizes
from .derive import derive

MOST = 200  # coordinates and states; of more, closed forms are not tried
TIMES = (1e-6, 1e-3, 0.03, 0.13, 0.29, 0.57, 0.83)  # as parts of the run
WRITTEN = 1e-8  # relative error of numbers in models, which have few digits
ROUND = 64 * sys.float_info.epsilon
_STATE = (Kind.COORDINATE, Kind.RATE, Kind.STATE)
_OPEN = sum(BIT[kind] for kind in (*_STATE, Kind.ACCELERATION, Kind.INPUT))
Values = dict[Symbol, float]


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
    forms, outputs = [], []
    for item in exacts:
        for loop in assignments((item.range,) if item.range else (), sizes(model)):
            at, value = None, item.value
            if item.range is not None:
                at = Number(Fraction(loop[item.range.variable]), item.span)
                value = of_member(value, item.range.variable, at)
            forms.append((item, indexed(item.name, at and int(at.value))))
            rate = Prime(value, item.span)
            outputs += Name(item.name, at, item.span), value, rate, Prime(rate, item.span)
            outputs.append(item.within or Number(Fraction(0), item.span))
    more = (Definition("0_exact", None, None, x, "", "", x.span) for x in outputs)
    observed = (*model.observed, *model.conserved, *more)
    e = derive(replace(model, observed=observed, conserved=(), events=()), frozenset())
    g, nodes = e.graph, e.observed[-len(outputs) :]

    def changed(k: int, default: float) -> float:
        name, index = parted(e.parameters[k].quantity.name)
        return float(given.get(name if index is None else (name, index), default))

    def symbol(kind: Kind, i: int) -> Node:
        return g.symbol(Symbol(kind, i))

    known: Values = {Symbol(Kind.TIME): 0.0, **defaults(g, e.parameters, changed)}
    start = started(g, e.parameters, (e.start_q, e.start_v, e.state_start), changed)
    times = [{**known, Symbol(Kind.TIME): (until or 1.0) * part} for part in TIMES]
    places = {q.name: (Kind.COORDINATE, i) for i, q in enumerate(e.seen)}
    places |= {s.name: (Kind.STATE, i) for i, s in enumerate(e.states)}
    at_start, later, swap = [], [], {}
    for k, (item, name) in enumerate(forms):
        quantity, form, rate, acceleration, within = nodes[5 * k : 5 * k + 5]
        kind, i = places.get(name, (None, 0))
        off = [quantity, g.negate(form)]
        at_start.append((item, name, off, evaluate(g, [within], known)[0]))
        if item.within is not None:
            continue
        later.append((item, name, off))
        if kind is not None:
            swap[symbol(kind, i)] = form
        if kind is Kind.STATE:
            later.append((item, name, [rate, g.negate(e.state_rates[i])]))
        elif kind is Kind.COORDINATE:
            swap |= {symbol(Kind.RATE, i): rate, symbol(Kind.ACCELERATION, i): acceleration}
            at_start.append((item, f"{name}'", [symbol(Kind.RATE, i), g.negate(rate)], 0.0))
            terms = [g.multiply(m, symbol(Kind.ACCELERATION, j)) for j, m in enumerate(e.mass[i])]
            later.append((item, name, [*terms, g.negate(e.force[i])]))
    for item, name, terms, within in () if model.consistent else at_start:
        if found := _off(g, terms, [start], within):
            message = f"{name} starts at {found[1]:.10g}, and its closed form at {-found[2]:.10g}"
            raise error(model, message, item.span, "correct it, or start where it does")
    for item, name, terms in later:
        terms = substituted(g, terms, swap)
        if not any(g.depends[x] & _OPEN for x in terms) and (found := _off(g, terms, times)):
            t, *parts = found
            message = (
                f"the closed form of {name} does not follow from the motion: at t = {t:.4g} it"
            )
            message += f" is off by {abs(sum(parts)):.4g}, where its terms are"
            message += f" {sum(map(abs, parts)):.4g} in size"
            help = f"correct it; an approximation says how good it is: exact {name} = … within …"
            raise error(model, message, item.span, help)


def _off(
    g: Graph, terms: list[Node], points: list[Values], within: float = 0.0
) -> list[float] | None:
    """Returns the time and the terms at the first of the points where their sum is not 0, up to
    rounding and `within`. At one of several points it need not have a value."""
    nodes = [*terms, *errors_of(g, terms)]
    for values in points:
        found = evaluate(g, nodes, values)
        parts, errors = found[: len(terms)], found[len(terms) :]
        allowed = WRITTEN * sum(map(abs, parts)) + ROUND * sum(errors) + sys.float_info.min
        total = abs(sum(parts))
        known = math.isfinite(total)
        if not (known and total <= max(within, allowed)) and (known or len(points) == 1):
            return [values[Symbol(Kind.TIME)], *parts]
    return None
