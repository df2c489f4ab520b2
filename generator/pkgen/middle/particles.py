"""The particles of a model: masses and places whose sum of m/2 |r'|^2 is its kinetic energy.

They are read from the text of `kinetic`, where sums are taken apart, factors multiplied out,
families unrolled and names of definitions opened, down to squares of rates:

    m/2*(x'^2 + y'^2 + z'^2)    m/2*dot(r', r')    m/2*norm(r')^2    m/2*(r'^2 + r^2*phi'^2)

Squares of one mass whose names differ in x, y and z alone are of one particle, and so are two or
three in one bracket that have no names, or are of polar coordinates. That their sum is the kinetic
energy is then proved on the graph.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..equations import Matrix, Particles, Row
from ..indices import assignments, integer
from ..source import Span
from ..tree import Add, Call, Component, Expr, Multiply, Name, Negate, Power, Prime, Sum
from .differentiate import Forward
from .exact import Exact
from .expand import Expander
from .graph import BIT, VARIABLE, ZERO, Kind, Node, Symbol
from .terms import Loop

STATE = BIT[Kind.COORDINATE] | BIT[Kind.RATE] | BIT[Kind.TIME] | BIT[Kind.INPUT]
RATES = BIT[Kind.RATE]
AXES = "xyz"
HELP = (
    "write kinetic as a sum of m/2*(x'^2 + y'^2) or m/2*dot(r', r'), with x, y and z coordinates "
    "or definitions (let x = r*cos(phi))"
)


class NoParticles(Exception):
    def __init__(self, why: str, span: Span):
        super().__init__(why)
        self.why, self.span = why, span


@dataclass(frozen=True)
class _Square:
    """factor * (place')^2. `name` is what squares of one particle share, `axis` what they do not;
    `bracket` counts the sums that it may be together with others in."""

    factor: Node
    place: Node
    name: tuple[object, ...]
    axis: int  # -1: its name has none
    bracket: int
    span: Span


@dataclass(frozen=True)
class _Body:
    half_mass: Node
    place: Row  # of three


def particles_of(x: Expander, kinetic: Node | None) -> Particles:
    """Of a model whose kinetic energy is `kinetic`; without any, and why, where it has none."""
    try:
        if kinetic is None or not x.model.kinetic:
            raise NoParticles("the model states its L, not a kinetic energy", x.model.span)
        squares, bodies = _Reader(x).read()
        bodies = [*bodies, *_together(x, squares)]
        return _proved(x, kinetic, bodies)
    except NoParticles as found:
        return Particles((), (), (), (), why=found.why, span=found.span)


class _Reader:
    """Takes the text of the kinetic energy apart."""

    def __init__(self, x: Expander):
        self.x = x
        self.brackets = 0
        self.bodies: list[_Body] = []
        self.definitions = {}
        for item in x.model.definitions:
            for index, loop in x.unrolled(item.index, item.range):
                self.definitions[item.name, index] = item.value, loop

    def read(self) -> tuple[list[_Square], list[_Body]]:
        squares = []
        for expr in self.x.model.kinetic:
            squares += self.terms(expr, self.x.sizes, self.x.graph.number(1), self.next())
        return squares, self.bodies

    def next(self) -> int:
        self.brackets += 1
        return self.brackets

    def moves(self, expr: Expr, loop: Loop) -> bool:
        value = self.x.value(expr, loop)
        nodes = value if isinstance(value, tuple) else (value,)
        return any(self.x.graph.depends[node] & RATES for node in nodes)

    def terms(self, expr: Expr, loop: Loop, factor: Node, bracket: int) -> Iterator[_Square]:
        g = self.x.graph
        match expr:
            case Add(terms=terms, signs=signs):
                for term, sign in zip(terms, signs, strict=True):
                    signed = factor if sign > 0 else g.negate(factor)
                    yield from self.terms(term, loop, signed, bracket)
            case Negate(of=of):
                yield from self.terms(of, loop, g.negate(factor), bracket)
            case Sum(body=body, ranges=ranges):
                for inner in assignments(ranges, loop):
                    yield from self.terms(body, inner, factor, self.next())
            case Multiply():
                yield from self.product(expr, loop, factor, bracket)
            case Name(id=name, index=index) if found := self.opened(name, index, loop):
                yield from self.terms(*found, factor, self.next())
            case Call(function="dot", arguments=(Prime(of=a), Prime(of=b))):
                if self.x.value(a, loop) != self.x.value(b, loop):
                    raise NoParticles("a product of different rates is of no particle", expr.span)
                self.vector(a, loop, factor)
            case Power(base=base, exponent=exponent) if self.x.scalar(exponent, loop) == g.number(
                2
            ):
                yield from self.square(base, loop, factor, bracket)
            case _:
                raise NoParticles("this is no square of a rate", expr.span)

    def opened(self, name: str, index: Expr | None, loop: Loop) -> tuple[Expr, Loop] | None:
        return self.definitions.get((name, None if index is None else integer(index, loop)))

    def product(self, expr: Multiply, loop: Loop, factor: Node, bracket: int) -> Iterator[_Square]:
        x, g = self.x, self.x.graph
        moving = []
        for part, exponent in zip(expr.factors, expr.exponents, strict=True):
            if not self.moves(part, loop):
                factor = g.multiply(factor, g.power(x.scalar(part, loop), exponent))
            elif exponent < 0:
                raise NoParticles("a rate under a division is of no particle", part.span)
            else:
                moving.append(part)
        if len(moving) == 2 and x.value(moving[0], loop) == x.value(moving[1], loop):
            yield from self.square(moving[0], loop, factor, bracket)
        elif len(moving) == 1:
            inner = self.next() if isinstance(moving[0], Add) else bracket
            yield from self.terms(moving[0], loop, factor, inner)
        else:
            raise NoParticles("a product of different rates is of no particle", expr.span)

    def square(self, base: Expr, loop: Loop, factor: Node, bracket: int) -> Iterator[_Square]:
        """factor * base^2."""
        x, g = self.x, self.x.graph
        match base:
            case Prime(of=of):
                name, axis = _named(x, of, loop)
                place = x.scalar(of, loop)
                yield _Square(factor, place, name, axis, bracket, base.span)
                return
            case Call(function="norm", arguments=(Prime(of=of),)):
                self.vector(of, loop, factor)
                return
            case Multiply(factors=factors, exponents=exponents):
                moving = [f for f in factors if self.moves(f, loop)]
                if len(moving) == 1 and exponents[factors.index(moving[0])] > 0:
                    for part, exponent in zip(factors, exponents, strict=True):
                        if part is not moving[0]:
                            raised = g.power(x.scalar(part, loop), 2 * exponent)
                            factor = g.multiply(factor, raised)
                    yield from self.square(moving[0], loop, factor, bracket)
                    return
        raise NoParticles("this is no square of a rate", base.span)

    def vector(self, of: Expr, loop: Loop, factor: Node) -> None:
        self.bodies.append(_Body(factor, self.x.value(of, loop)))


def _named(x: Expander, of: Expr, loop: Loop) -> tuple[tuple[object, ...], int]:
    """What of a name the components of a particle share; and which of them it is."""
    match of:
        case Component(of=whole, axis=axis):
            return ("component", x.value(whole, loop)), axis
        case Name(id=name, index=index):
            at = None if index is None else integer(index, loop)
            if name[0] in AXES:
                return ("first", name[1:], at), AXES.index(name[0])
            if name[-2:-1] == "_" and name[-1] in AXES:
                return ("last", name[:-2], at), AXES.index(name[-1])
            return ("name", name, at), -1
    return ("none",), -1


def _together(x: Expander, squares: list[_Square]) -> list[_Body]:
    by_name: dict[tuple[object, ...], list[_Square]] = {}
    by_bracket: dict[int, list[_Square]] = {}
    for square in squares:
        if square.axis >= 0:
            by_name.setdefault((square.factor, *square.name), []).append(square)
        else:
            by_bracket.setdefault(square.bracket, []).append(square)
    found = []
    for group in by_name.values():
        axes = {square.axis: square.place for square in group}
        if len(axes) != len(group) or not {0, 1} <= axes.keys():
            said = "it has no x and y of one mass beside it: a motion on a line turns about nothing"
            raise NoParticles(said, group[0].span)
        found.append(_Body(group[0].factor, tuple(axes.get(axis, ZERO) for axis in range(3))))
    for group in by_bracket.values():
        body = _polar(x, group) or _unnamed(group)
        if body is None:
            said = "which components are those of one particle, names do not say"
            raise NoParticles(said, group[0].span)
        found.append(body)
    return found


def _unnamed(group: list[_Square]) -> _Body | None:
    same = {square.factor for square in group}
    places = tuple(square.place for square in group)
    if len(same) > 1 or not 2 <= len(group) <= 3 or any(s.name != ("none",) for s in group):
        return None
    return _Body(group[0].factor, (*places, ZERO)[:3])


def _polar(x: Expander, group: list[_Square]) -> _Body | None:
    """m/2*(r'^2 + r^2*phi'^2), also + r^2*sin(theta)^2*phi'^2 on a sphere, in that order."""
    g = x.graph
    if not 2 <= len(group) <= 3:
        return None
    radius, angle = group[0].place, group[1].place
    half_mass = group[0].factor
    if group[1].factor != g.multiply(half_mass, g.power(radius, 2)):
        return None
    sin, cos = g.call("sin", angle), g.call("cos", angle)
    if len(group) == 2:
        return _Body(half_mass, (g.multiply(radius, cos), g.multiply(radius, sin), ZERO))
    across, turn = g.multiply(radius, sin), group[2].place
    if group[2].factor != g.multiply(group[1].factor, g.power(sin, 2)):
        return None
    flat = (g.multiply(across, g.call(f, turn)) for f in ("cos", "sin"))
    return _Body(half_mass, (*flat, g.multiply(radius, cos)))


def _proved(x: Expander, kinetic: Node, bodies: list[_Body]) -> Particles:
    g = x.graph
    if not bodies:
        raise NoParticles("the kinetic energy has no term", x.model.span)
    for body in bodies:
        if g.depends[body.half_mass] & STATE:
            raise NoParticles("a mass that varies is of no particle", x.model.kinetic[0].span)
    again = Forward(g, VARIABLE, lambda node: _rate_of(x, node))
    places: Matrix = tuple(body.place for body in bodies)
    rates: Matrix = tuple(tuple(map(x.derivative, place)) for place in places)
    accelerations: Matrix = tuple(tuple(map(again, rate)) for rate in rates)
    total = g.sum(
        g.multiply(body.half_mass, g.power(component, 2))
        for body, rate in zip(bodies, rates, strict=True)
        for component in rate
    )
    rest = g.subtract(total, kinetic)
    if rest != ZERO and not Exact(g.copy()).is_zero(rest):
        said = "that these are the particles' kinetic energy is not proved"
        raise NoParticles(said, x.model.kinetic[0].span)
    masses = tuple(g.multiply(g.number(2), body.half_mass) for body in bodies)
    return Particles(masses, places, rates, accelerations)


def _rate_of(x: Expander, node: Node) -> Node:
    symbol = x.graph.data[node]
    if symbol.kind is Kind.RATE:
        return x.graph.symbol(Symbol(Kind.ACCELERATION, symbol.index))
    return x.derivative(node)
