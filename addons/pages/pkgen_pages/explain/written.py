"""Typesets statements of a model as their author wrote them: energies, forces, constraints, `let`
definitions.

In these formulas, vectors and rotations are single symbols. The checker replaces them by their
components, so other modules show components.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction

from pkgen.front import parse
from pkgen.front import statements as st
from pkgen.front.table import STATEMENTS
from pkgen.indices import made_of, multipliers
from pkgen.middle.quantities import single_rotations
from pkgen.model import Model
from pkgen.source import Span
from pkgen.tree import (
    COMPONENTS,
    Add,
    Call,
    Component,
    Condition,
    Expr,
    Multiply,
    Name,
    Negate,
    Number,
    Power,
    Prime,
    Quantity,
    Sum,
    Vector,
    names,
)

from . import mathml
from .mathml import fraction, operator, row
from .typeset import function

# The letters of energies, by the field of the model that a statement fills.
_ENERGIES = {
    "kinetic": "T",
    "potential": "V",
    "lagrangian": "L",
    "hamiltonian": "H",
    "dissipation": "D",
    "fast": "V_fast",
}
_NAMING = ("let", "const", "observe", "conserve")
_COMPARED = ("<", "<=", ">", ">=", "==")
_TURNS = frozenset(("rot", "inverse", "euler", "tait_bryan"))
_VECTORS = frozenset(("omega", "cross"))
NUMBER, VECTOR, TURN = "number", "vector", "turn"

# A formula as chunks, between which a line may break; and a description of the formula.
Line = tuple[list[str], str]


class Written:
    """The statements of a model, and the kind of each name: number, vector or rotation."""

    def __init__(self, model: Model):
        self.statements = parse.parse_all(model.source).statements
        self.text = model.source.text
        rotations = [r.name for r in model.rotations]
        self.lone = rotations[0] if rotations and len(single_rotations(model)) == 1 else ""
        self.kinds = dict.fromkeys(rotations, TURN)
        self.kinds |= {made_of("p_{}", r): VECTOR for r in rotations}
        self.lets: dict[str, st.Define] = {}
        for s in self.statements:
            if isinstance(s, st.Define) and s.keyword in _NAMING:
                self.kinds[s.left.name] = self.kind(s.value)
                self.lets.setdefault(s.left.name, s)
        self.kinds |= {
            name: self.kind(s.a)
            for s in self.statements
            if isinstance(s, st.Equation)
            for name in multipliers(s.left.name)
        }

    # -- statements ---------------------------------------------------------------------------

    def energies(self) -> list[Line]:
        """Returns lines for T, V, L and D, each the sum of its statements. Body statements are
        quoted; T_bodies and V_bodies denote their contributions to T and V."""
        found: dict[str, list[str]] = {}
        bodies = [s for s in self.statements if s.keyword in ("body", "joint", "gravity")]
        said: list[Line] = []
        if bodies:
            said = [([mathml.words(self._as_written(s.span))], "") for s in bodies]
            found = {letter: [mathml.name(f"{letter}_bodies")] for letter in "TV"}
        for s in self.statements:
            if isinstance(s, st.Single) and s not in bodies:
                terms = found.setdefault(_ENERGIES[STATEMENTS[s.keyword].fills], [])
                terms += self._terms(s.value, first=not terms)
        sums = [(_equation(mathml.name(name), terms), "") for name, terms in found.items()]
        return said + (
            sums if any(len(terms) > 1 for terms in found.values()) or not bodies else []
        )

    def _as_written(self, span: Span) -> str:
        return " ".join(self.text[span.start : span.end].split())

    def parameters(self) -> list[st.Param]:
        return [s for s in self.statements if isinstance(s, st.Param)]

    def forces(self) -> list[Line]:
        made = [s for s in self.statements if isinstance(s, st.Force)]
        return [(self._force(s), "") for s in made]

    def _force(self, s: st.Force) -> list[str]:
        """Returns a force along a coordinate as an equation, any other as it is written."""
        if s.keyword == "torque" or s.place is not None or s.left.name in self.lets:
            return [mathml.words(self._as_written(s.span))]
        return _equation(mathml.sub(mathml.name("Q"), self.left(s.left)), self._terms(s.value))

    def constraints(self) -> list[Line]:
        found = []
        for s in self.statements:
            if isinstance(s, st.Equation):
                right = self._terms(s.b)
                chunks = self._terms(s.a)
                found.append(([*chunks, mathml.binary("=") + right[0], *right[1:]], s.left.name))
        return found

    def lets_of(self, keywords: Iterable[str]) -> list[Line]:
        """Returns the `let` definitions that statements with these keywords use, even
        indirectly."""
        waiting = [n for s in self.statements for n in _used(s) if s.keyword in keywords]
        used: set[str] = set()
        while waiting:
            name = waiting.pop()
            if name in self.lets and name not in used:
                used.add(name)
                waiting += names(self.lets[name].value)
        return [self._let(s) for name, s in self.lets.items() if name in used]

    def _let(self, s: st.Define) -> Line:
        return _equation(self.left(s.left), self._terms(s.value)), s.description

    def left(self, left: st.Left) -> str:
        letter = self.name(left.name)
        index = left.index if left.range is None else Name(left.range.variable, None, left.span)
        return letter if index is None else _indexed(letter, self(index))

    # -- expressions --------------------------------------------------------------------------

    def kind(self, expr: Expr) -> str:
        match expr:
            case Vector():
                return VECTOR
            case Name(id=name):
                return self.kinds.get(name, NUMBER)
            case Call(function=name, arguments=_):
                return TURN if name in _TURNS else VECTOR if name in _VECTORS else NUMBER
            case Add(terms=(first, *_)):
                return self.kind(first)
            case Multiply(factors=factors):
                kinds = [self.kind(f) for f in factors]
                last = VECTOR if VECTOR in kinds else NUMBER
                return TURN if kinds[-1] == TURN else last
            case Negate(of=of) | Prime(of=of) | Quantity(of=of):
                return self.kind(of)
            case Sum(body=body):
                return self.kind(body)
        return NUMBER

    def __call__(self, expr: Expr) -> str:
        return row(*self._terms(expr))

    def name(self, name: str) -> str:
        return mathml.name(name, self.lone, bold=self.kinds.get(name) == VECTOR)

    def _terms(self, expr: Expr, first: bool = True) -> list[str]:
        """Returns the terms of a sum with signs; if `first`, the first term has no plus sign."""
        terms, signs = (expr.terms, expr.signs) if isinstance(expr, Add) else ((expr,), (1,))
        found = []
        for term, sign in zip(terms, signs, strict=True):
            if isinstance(term, Negate):
                term, sign = term.of, -sign
            if isinstance(term, Multiply) and isinstance(term.factors[0], Negate):
                factors = (term.factors[0].of, *term.factors[1:])
                term, sign = Multiply(factors, term.exponents, term.span), -sign
            between = found or not first
            shown = "-" if sign < 0 else "+"
            before = mathml.binary(shown) if between else mathml.leading("-") if sign < 0 else ""
            found.append(before + self._term(term))
        return found

    def _term(self, expr: Expr) -> str:
        if isinstance(expr, Multiply):
            return self._product(expr)
        return self._factor(expr)

    def _product(self, expr: Multiply) -> str:
        """Returns a product in the order of the source: m/2*v^2 is the fraction m/2, then v²."""
        done: list[str] = []
        above: list[Expr] = []
        below: list[Expr] = []

        def close() -> None:
            if below:
                over = self._side_by_side(above)
                small = all(isinstance(x, Number) for x in (*above, *below))
                done.append(fraction(over, self._side_by_side(below), small))
            elif above:
                done.append(self._beside(above))
            above.clear()
            below.clear()

        for factor, exponent in zip(expr.factors, expr.exponents, strict=True):
            if exponent > 0 and below:
                close()
            (above if exponent > 0 else below).append(factor)
        close()
        return mathml.product(done)

    def _side_by_side(self, factors: list[Expr]) -> str:
        """Returns a numerator or denominator, in which a single sum needs no brackets."""
        return self(factors[0]) if len(factors) == 1 else self._beside(factors)

    def _beside(self, factors: list[Expr]) -> str:
        """Returns the product of the factors, with a dot before numbers."""
        found = ""
        for k, factor in enumerate(factors):
            shown = self._factor(factor)
            digits = isinstance(factor, Number | Quantity) and k > 0
            found = (
                f"{found}{operator('⋅')}{shown}"
                if digits
                else mathml.product([x for x in (found, shown) if x])
            )
        return found

    def _factor(self, expr: Expr) -> str:
        match expr:
            case Number(value=value):
                return mathml.number(_decimal(value))
            case Name(id=name, index=None):
                return self.name(name)
            case Name(id=name, index=index):
                return _indexed(self.name(name), self(index))
            case Prime():
                return self._prime(expr)
            case Component(of=of, axis=axis):
                return self._component(of, COMPONENTS[axis])
            case Power(base=base, exponent=exponent):
                return self._power(base, exponent)
            case Call(function=name, arguments=arguments):
                return self._call(name, arguments)
            case Sum(body=body, ranges=ranges):
                signs = [
                    mathml.sums(mathml.name(r.variable), self(r.lo), self(r.hi)) for r in ranges
                ]
                inner = self(body)
                return row(*signs, mathml.fenced(inner) if isinstance(body, Add) else inner)
            case Condition(operator="not", parts=(part,)):
                return row(mathml.words("not "), self._factor(part))
            case Condition(operator=sign, parts=parts):
                between = operator(sign) if sign in _COMPARED else mathml.words(f" {sign} ")
                return between.join(map(self._factor, parts))
            case Vector(items=items):
                return mathml.fenced(operator(",").join(self(item) for item in items))
            case Quantity(of=of, unit=unit):
                return row(self._factor(of), mathml.unit(unit))
        return mathml.fenced(self(expr))  # Add, Multiply, Negate

    def _prime(self, expr: Prime) -> str:
        of, primes = expr.of, 1
        while isinstance(of, Prime):
            of, primes = of.of, primes + 1
        match of:
            case Name(id=name, index=None):
                bold = self.kinds.get(name) == VECTOR
                return mathml.name(name + "'" * primes, self.lone, bold)
            case Name(id=name, index=index):
                return _indexed(self.name(name + "'" * primes), self(index))
        order = mathml.number(str(primes)) if primes > 1 else ""
        d, t = mathml.name("d"), mathml.name("t")
        above, below = (mathml.sup(d, order), mathml.sup(t, order)) if order else (d, t)
        return row(fraction(above, row(d, below)), mathml.fenced(self(of)))

    def _component(self, of: Expr, axis: str) -> str:
        if isinstance(of, Name) and of.index is None:
            return mathml.name(f"{of.id}.{axis}", self.lone)
        if isinstance(of, Call) and of.function == "omega" and isinstance(of.arguments[0], Name):
            return self._body_rate(of.arguments[0], f".{axis}")
        return mathml.sub(mathml.fenced(self(of)), mathml.name(axis))

    def _body_rate(self, rotation: Name, axis: str = "") -> str:
        found = mathml.name(f"omega({rotation.id}){axis}", self.lone, bold=not axis)
        return _indexed(found, self(rotation.index)) if rotation.index else found

    def _power(self, base: Expr, exponent: Expr) -> str:
        above = self._exponent(exponent)
        match base:
            case Name() | Prime(of=Name()) | Component() | Number():
                return mathml.sup(self._factor(base), above)
            case Call(function=name, arguments=arguments) if name not in ("dot", "cross"):
                return function(name, [self(a) for a in arguments], _bare(arguments), above)
        return mathml.sup(mathml.fenced(self(base)), above)

    def _exponent(self, expr: Expr) -> str:
        """Returns an exponent; a fraction of two numbers is written on one line, like 1/2."""
        match expr:
            case Multiply(factors=(Number(value=a), Number(value=b)), exponents=(1, -1)):
                return f"<mn>{_decimal(a)}/{_decimal(b)}</mn>"
        return self(expr)

    def _call(self, name: str, arguments: tuple[Expr, ...]) -> str:
        shown = [self(a) for a in arguments]
        match name, shown:
            case "dot", [_, _]:
                return row(self._factor(arguments[0]), operator("·"), self._factor(arguments[1]))
            case "cross", [_, _]:
                made = row(self._factor(arguments[0]), operator("×"), self._factor(arguments[1]))
                return mathml.fenced(made)
            case "norm", [a]:
                return mathml.bars(a)
            case "inverse", [a]:
                return mathml.sup(self._factor(arguments[0]), mathml.number("-1"))
            case "omega", [a] if isinstance(arguments[0], Name):
                return self._body_rate(arguments[0])
        return function(name, shown, _bare(arguments))


def _used(s: st.Statement) -> Iterator[str]:
    """Yields the names in a statement's expressions."""
    for part in ("value", "a", "b"):
        expr = getattr(s, part, None)
        if expr is not None:
            yield from names(expr)


def _bare(arguments: tuple[Expr, ...]) -> bool:
    """Whether the argument of a function needs no brackets."""
    return len(arguments) == 1 and isinstance(arguments[0], Name | Number | Component)


def _equation(left: str, terms: list[str]) -> list[str]:
    return [row(left, operator("="), terms[0]), *terms[1:]]


def _indexed(letter: str, index: str) -> str:
    return mathml.sub(letter, index)


def _decimal(value: Fraction) -> str:
    return f"{float(value):.15g}"
