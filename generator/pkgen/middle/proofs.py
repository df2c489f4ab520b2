"""`conserve`: each claim is proved, refuted, or neither, and these are never confused.

Proved: its time derivative along the equations of motion is zero by exact arithmetic alone.
Refuted: at a state that is shown it is not zero, by more than any rounding can explain.
Not proved: neither; then how far it holds at the states that were tried.
"""

from __future__ import annotations

from collections.abc import Iterable

from ..equations import Claim, Equations, Indices
from ..model import Model
from ..source import Diagnostic, ModelError
from .along import Along
from .balls import Balls
from .differentiate import reachable
from .exact import Exact
from .graph import VARIABLE, ZERO, Graph, Kind, Node, Op, Symbol
from .normal import Normal
from .samples import Sample, samples

PROVED, REFUTED, OPEN = "proved", "refuted", "not proved"
SHOWN = 12  # values of a counterexample
# Whose derivative does not say where they jump.
_JUMPING = {"step": "step jumps", "sign": "sign jumps", "atan2": "atan2 jumps by 2 pi"}


def claims_of(equations: Equations, blocks: Indices, jumping: bool) -> tuple[Claim, ...]:
    """The outcome of each `conserve`; `blocks` are those of M, and L is `jumping` at a step."""
    if not equations.conserved:
        return ()
    along = Along(equations, blocks)
    exact = Exact(along.graph)
    return tuple(
        _claim(along, exact, quantity.name, node, jumping)
        for quantity, node in zip(equations.conserved_names, equations.conserved, strict=True)
    )


def _claim(along: Along, exact: Exact, name: str, node: Node, jumping: bool) -> Claim:
    g = along.graph
    terms = along.terms(node)
    obstacle = "L jumps at a step" if jumping else _jumps(g, node)
    proof = "" if obstacle else vanishes(g, exact, terms)
    if proof:
        return Claim(name, PROVED, proof)
    tried = _Tried(along, name, terms)
    if tried.against is not None:
        return Claim(name, REFUTED, tried.counterexample())
    return Claim(name, OPEN, "; ".join(x for x in (obstacle, tried.how_far()) if x))


def vanishes(g: Graph, exact: Exact, terms: list[Node]) -> str:
    """Why the sum is zero, or "" where that is not seen."""
    total = g.sum(terms)
    if total == ZERO:
        return "term by term"
    if Normal(g)(total) == {}:
        return "by its normal form"
    if exact.is_zero(total):
        return "by its numerator, angles and roots taken apart"
    return ""


def _jumps(g: Graph, node: Node) -> str:
    calls = (g.data[n] for n in reachable(g, [node], VARIABLE) if g.op[n] is Op.CALL)
    return next((_JUMPING[function] for function in calls if function in _JUMPING), "")


class _Tried:
    """A derivative's terms at some states, and the one that speaks most against it."""

    def __init__(self, along: Along, name: str, terms: list[Node]):
        self.along, self.name = along, name
        self.against: Sample | None = None
        self.count, self.relative, self.held = 0, 0.0, False
        balls = Balls()
        total = along.graph.sum(terms)
        worst = 0.0
        for sample in samples(along.equations, balls, along.graph, terms):
            rate, *parts = balls.values(along.graph, [total, *terms], sample.values)
            if rate is None or None in parts:
                continue
            size = max(sum(part.most for part in parts), balls.tiny)
            self.count += 1
            self.relative = max(self.relative, float(rate.most / size))
            self.held |= not sample.varied and not rate.least > 0
            # With parameters at their defaults it is easier to check.
            if rate.least / size > worst and not (
                self.against and sample.varied and not self.against.varied
            ):
                worst = rate.least / size
                self.against, self.rate, self.size = sample, float(rate.mid), float(size)

    def counterexample(self) -> str:
        values = list(self._named(self.against))
        if len(values) > SHOWN:
            values[SHOWN:] = [f"and {len(values) - SHOWN} more"]
        at = ", ".join(values)
        text = f"d{self.name}/dt = {self.rate:.4g}, where its terms are {self.size:.4g} in size"
        text += f", at {at}" if at else ""
        if self.held and self.against.varied:
            text += " (it does hold with the parameters' defaults: should they be const?)"
        return text

    def how_far(self) -> str:
        if not self.count:
            return "and it could be evaluated at no state tried"
        return (
            f"at {self.count} states tried |d{self.name}/dt| is below "
            f"{self.relative:.1e} of the size of its terms"
        )

    def _named(self, sample: Sample) -> Iterable[str]:
        e = self.along.equations
        names = {
            Kind.COORDINATE: e.coordinates,
            Kind.RATE: e.rates,
            Kind.INPUT: e.inputs,
            Kind.PARAMETER: [slot.quantity for slot in e.parameters],
        }
        for symbol, value in sample.chosen.items():
            yield f"{_name(names, symbol)} = {float(value):.10g}"


def _name(names: dict, symbol: Symbol) -> str:
    if symbol.kind is Kind.TIME:
        return "t"
    row = names[symbol.kind]
    if symbol.index >= len(row):  # the derivative of an input's last one
        return _name(names, Symbol(symbol.kind, symbol.index - len(row))) + "'"
    return row[symbol.index].name


def check_claims(model: Model, claims: tuple[Claim, ...]) -> None:
    """Raises ModelError with those that are not proved."""
    findings = []
    for item, claim in zip(model.conserved, claims, strict=True):
        if claim.outcome == REFUTED:
            message = f"'{claim.name}' is not constant: {claim.says}"
        elif claim.outcome == OPEN:
            message = f"that '{claim.name}' is constant is not proved: {claim.says}"
        else:
            continue
        help = f"to watch it, say 'observe {claim.name}'; only what is proved can be conserved"
        findings.append(Diagnostic(message, item.span, help))
    if findings:
        raise ModelError(model.source, findings)
