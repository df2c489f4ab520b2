"""Proves or refutes the claims of `conserve` statements, that a quantity is constant.

The claim is proved if exact arithmetic shows that the time derivative of the quantity along the
equations of motion is zero. It is refuted if the derivative at a sample state differs from zero by
more than a bound of the rounding error. Otherwise it is "not proved", and the report has the
largest derivative found at the sample states.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ...equations import Equations
from ...functions import FUNCTIONS
from ...functions.row import DIVISOR
from ...graph.balls import Balls
from ...graph.differentiate import reachable
from ...graph.evaluate import evaluate
from ...graph.exact import Exact
from ...graph.graph import BIT, VARIABLE, ZERO, Graph, Kind, Node, Op, Symbol
from ...graph.normal import Normal
from ...graph.ranges import Ranges
from ...graph.substitute import substituted
from ...graph.wording import wording
from ...model import Model
from ...source import Diagnostic, ModelError
from ..attitudes import on_sphere
from ..naming import naming
from ..points.samples import Sample, samples, started
from ..points.singularities import about, dangerous, squared, zeros
from ..points.squares import bounds_of
from ..structure import Claim, Indices
from .along import Along

PROVED, REFUTED, OPEN = "proved", "refuted", "not proved"
# The largest number of values shown in a counterexample.
SHOWN = 12
VISIBLE = 1e-300
# A time derivative at the initial state refutes a claim if its ratio to the size of its terms is
# larger than this number. Rounding errors, and the allowed errors of an initial state that has to
# satisfy constraints, have smaller ratios.
OFF = 1e-6
NOWHERE = "states at which the constraints hold, other than the start, were not looked for"


def claims_of(equations: Equations, blocks: Indices, jumping: bool) -> tuple[Claim, ...]:
    """Returns the outcome for each `conserve` statement. `blocks` are the blocks of the mass
    matrix, `jumping` says whether L contains a step."""
    if not equations.conserved:
        return ()
    if equations.model.struck:
        why = "events, contacts, frictions or noise change the motion, which no proof looks at"
        return tuple(Claim(q.name, OPEN, why) for q in equations.conserved_names)
    along = Along(equations, blocks)
    ranges = Ranges(along.graph, [bounds_of(along.graph, x) for x in equations.parameters])
    exact = Exact(along.graph, ranges=ranges)
    return tuple(
        _claim(along, exact, quantity.name, node, jumping)
        for quantity, node in zip(equations.conserved_names, equations.conserved, strict=True)
    )


def _claim(along: Along, exact: Exact, name: str, node: Node, jumping: bool) -> Claim:
    g = along.graph
    anywhere = along.terms(node)
    terms = along.on_constraints(anywhere)
    obstacle = "L jumps at a step" if jumping else _jumps(along, exact.ranges, node)
    obstacle = obstacle or _jolted(along, node)
    proof = "" if obstacle else vanishes(g, exact, terms)
    attitudes = tuple(a for a in along.equations.attitudes if a.numbers)
    if not proof and attitudes:
        # The claim needs to hold only for quaternions of length 1.
        terms = substituted(g, terms, on_sphere(g, attitudes))
        proof = "" if obstacle else vanishes(g, exact, terms)
    if proof:
        return Claim(name, PROVED, proof)
    bound = along.equations.constraints
    if bound is not None and bound.holonomic:
        return _at_the_start(along, name, anywhere, obstacle)
    tried = _Tried(along, name, terms)
    if tried.against is not None:
        return Claim(name, REFUTED, tried.counterexample())
    return _open(name, obstacle, tried.how_far())


def _open(name: str, *says: str) -> Claim:
    return Claim(name, OPEN, "; ".join(filter(None, says)))


def vanishes(g: Graph, exact: Exact, terms: list[Node]) -> str:
    """Returns a text that names the method by which the sum of terms was proved zero; "" if it was
    not proved."""
    total = g.sum(terms)
    if total == ZERO:
        return "term by term"
    if Normal(g)(total) == {}:
        return "by its normal form"
    if exact.is_zero(total):
        return "by its numerator, angles, roots and signs taken apart"
    return ""


def _jumps(along: Along, ranges: Ranges, node: Node) -> str:
    """Returns the reason why a quantity may be discontinuous, or "". The derivatives of |x|/x and
    of atan(1/x) + atan(x) are zero too, but these functions jump at x = 0."""
    g = along.graph
    below = reachable(g, [node], VARIABLE)
    calls = [FUNCTIONS[g.data[n]] for n in below if g.op[n] is Op.CALL]
    jumps = sorted(row.jump for row in calls if row.jump)
    if jumps:
        return jumps[0]
    roots = any(g.op[n] is Op.POWER and g.data[n].denominator > 1 for n in below)
    if not roots and not any(row.branched for row in calls):
        return ""
    e = along.equations
    motion = _divisors(
        g, ranges, [*e.force, *sum(e.mass, ()), *(e.acceleration or ()), *e.state_rates]
    )
    for zero in _divisors(g, ranges, [node]) - motion:
        return f"it may jump where {wording(g, about(g, zero), naming(e))} vanishes"
    return ""


def _jolted(along: Along, node: Node) -> str:
    """Returns the reason why a quantity may jump at an impulse, or "". The momentum of a coordinate
    does not jump if no impulse has a component along this coordinate. The energy does not jump
    either if the surfaces of impulses and the constraints do not depend on t."""
    g, e = along.graph, along.equations
    if not e.impulsive:
        return ""
    rows = e.constraints.rows if e.constraints is not None else ()
    timeless = all(x.slope_t == ZERO and any(x.slope) for x in e.impulsive)
    held = e.constraints is None or e.constraints.workless
    kept = {
        rest
        for rest, (_, i) in along.leaves.items()
        if (i is None and timeless and held)
        or (
            i is not None
            and not any(x.slope[i] for x in e.impulsive)
            and not any(r[i] for r in rows)
        )
    }
    seen, stack = set(), [node]
    while stack:
        n = stack.pop()
        if n in kept or n in seen or not g.depends[n] & BIT[Kind.RATE]:
            continue
        seen.add(n)
        stack += g.args[n]
        if g.op[n] is Op.SYMBOL:
            at = ", ".join(x.quantity.name for x in e.impulsive)
            return f"{naming(e)(g.data[n])} jumps where {at} vanishes"
    return ""


def _divisors(g: Graph, ranges: Ranges, nodes: list[Node]) -> set[Node]:
    """Returns those divisors in the nodes that are not proved to be nonzero."""
    divisors = [base for base, use in dangerous(g, ranges, nodes) if use == DIVISOR]
    found = {zero for base in divisors for zero, _ in zeros(g, ranges, base)}
    return found | {square for zero in found for square in squared(g, zero)}


def _at_the_start(along: Along, name: str, terms: list[Node], obstacle: str) -> Claim:
    """Returns the outcome of the claim that the quantity `name` is constant. Evaluates its time
    derivative at the initial state only, because no other states that satisfy the constraints are
    known."""
    e = along.equations
    if e.model.consistent:
        return _open(name, obstacle, NOWHERE)
    try:
        start = started(e.graph, e.parameters, (e.start_q, e.start_v, e.state_start))
        rate, *parts = evaluate(along.graph, [along.graph.sum(terms), *terms], start)
    except KeyError:  # inputs and unsolved accelerations have no value
        return _open(name, obstacle, NOWHERE)
    size = sum(map(abs, parts))
    says = f"d{name}/dt = {rate:.4g}, where its terms are {size:.4g} in size, at the start"
    if abs(rate) > OFF * size:
        return Claim(name, REFUTED, says)
    return _open(name, obstacle, NOWHERE, says)


class _Tried:
    """Evaluates a time derivative, given as a list of terms, at sample states. Stores the state
    that shows best that the derivative is not zero."""

    def __init__(self, along: Along, name: str, terms: list[Node]):
        self.along, self.name = along, name
        self.against: Sample | None = None
        self.count, self.relative, self.held = 0, 0, False
        self.balls = balls = Balls()
        total = along.graph.sum(terms)
        best: tuple = ()
        for sample in samples(along.equations, balls, along.graph, terms):
            rate, *parts = balls.values(along.graph, [total, *terms], sample.values)
            if rate is None or None in parts:
                continue
            self.count += 1
            # A term may be 0 because its parts cancel; its error radius shows how large they are.
            size = sum(part.most for part in parts)
            most = max(size, rate.rad / balls.tiny)
            self.relative = max(self.relative, rate.most / most if most else 0)
            self.held |= not sample.varied and not rate.least > 0
            # Prefers counterexamples that are easy to check: parameters at their defaults, and a
            # derivative within the range of doubles.
            rank = (not sample.varied, rate.least > VISIBLE, rate.least / most if most else 0)
            if rate.least > 0 and rank > best:
                best, self.against, self.rate, self.size = rank, sample, rate.mid, size

    def counterexample(self) -> str:
        values = list(self._named(self.against))
        if len(values) > SHOWN:
            values[SHOWN:] = [f"and {len(values) - SHOWN} more"]
        at = ", ".join(values)
        rate, size = self._number(self.rate), self._number(self.size)
        text = f"d{self.name}/dt = {rate}, where its terms are {size} in size"
        text += f", at {at}" if at else ""
        if self.held and self.against.varied:
            text += " (it does hold with the parameters' defaults: should they be const?)"
        return text

    def how_far(self) -> str:
        if not self.count:
            return "it has a value at no state tried"
        if not self.relative:
            return f"d{self.name}/dt is 0 at {self.count} states tried"
        return (
            f"at {self.count} states tried |d{self.name}/dt| is below "
            f"{self._number(self.relative)} of the size of its terms"
        )

    def _number(self, x: Any) -> str:
        """Returns a number, which may exceed the range of doubles, as text with four digits."""
        return self.balls.mp.nstr(x, 4)

    def _named(self, sample: Sample) -> Iterable[str]:
        name = naming(self.along.equations)
        chosen = dict(sample.chosen)
        for at in (a for a in self.along.equations.attitudes if a.numbers):
            w, *vector = (Symbol(Kind.STATE, k) for k in at.numbers)
            if not chosen.keys() & set(vector):
                continue
            a = [chosen.get(symbol, 0) for symbol in vector]
            below = 1 + sum(x * x for x in a)
            chosen |= {s: 2 * x / below for s, x in zip(vector, a, strict=True)}
            chosen[w] = 2 / below - 1
        for symbol, value in chosen.items():
            yield f"{name(symbol)} = {float(value):.10g}"


def check_claims(model: Model, claims: tuple[Claim, ...]) -> None:
    """Raises ModelError if any claim is not proved."""
    findings = []
    failed = {REFUTED: "'{}' is not constant", OPEN: "that '{}' is constant is not proved"}
    for item, claim in zip(model.conserved, claims, strict=True):
        if claim.outcome not in failed:
            continue
        message = f"{failed[claim.outcome].format(claim.name)}: {claim.says}"
        help = f"to watch it, say 'observe {claim.name}'; only what is proved can be conserved"
        findings.append(Diagnostic(message, item.span, help))
    if findings:
        raise ModelError(model.source, findings)
