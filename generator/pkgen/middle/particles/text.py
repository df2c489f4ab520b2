"""Finds particles in the text of the statements `kinetic` or `lagrangian`.

The expression is expanded, with families unrolled and definitions inserted, to a sum of squares of
rates with factors:

    m/2*(x'^2 + y'^2 + z'^2)    m/2*dot(r', r')    m/2*norm(r')^2    m/2*(r'^2 + r^2*phi'^2)

Squares with the same mass belong to one particle if their names match as components of a position
(bodies.py), such as x and y. Two or three squares in one bracket belong to one particle too if they
have no names, or have the form of polar coordinates. Terms of degree 0 or 1 in the rates are
ignored. particles.py proves the result.
"""

from __future__ import annotations

from collections.abc import Iterator

from ...graph.differentiate import gradient
from ...graph.graph import BIT, ZERO, Kind, Node
from ...indices import assignments, indexed, integer
from ...record import record
from ...tree import Add, Call, Component, Expr, Multiply, Name, Negate, Power, Prime, Sum, Vector
from ..expand.expand import Expander
from ..expand.names import Loop
from .bodies import Body, Key, keys, lengths, places

RATES = BIT[Kind.RATE]


class _Unread(Exception):
    """The energy is not a sum of squares of rates."""


@record
class _Square:
    """The term factor * (place')^2 of the energy, where `place` is an expression, such as a
    coordinate or a component of a position. Squares may belong to one particle if they have a key
    in common (see Key), or if they are in the same bracket of the text. `bracket` is the number of
    this bracket."""

    factor: Node
    place: Node
    name: str
    keys: tuple[Key, ...]
    named: bool  # whether `place` is a name in the model rather than an expression
    bracket: int


def read(x: Expander, polar: bool) -> list[Body]:
    """Returns the particles; [] if the energy is not a sum of squares of rates. With `polar`, polar
    coordinates are recognized."""
    reader = _Reader(x)
    squares = []
    try:
        for expr in (*x.model.kinetic, *x.model.lagrangian):
            squares += reader.terms(expr, x.sizes, x.graph.number(1), reader.next())
        return [*reader.bodies, *_together(x, squares, polar)]
    except _Unread:
        return []


class _Reader:
    """Splits the energy into squares of rates with factors."""

    def __init__(self, x: Expander):
        self.x = x
        self.lengths = lengths(x.model)
        self.brackets = 0
        self.bodies: list[Body] = []
        self.definitions = {}
        for item in x.model.definitions:
            for index, loop in x.unrolled(item.index, item.range):
                self.definitions[item.name, index] = item.value, loop

    def next(self) -> int:
        self.brackets += 1
        return self.brackets

    def moves(self, expr: Expr, loop: Loop) -> bool:
        value = self.x.value(expr, loop)
        nodes = value if isinstance(value, tuple) else (value,)
        return any(self.x.graph.depends[node] & RATES for node in nodes)

    def of_first_degree(self, expr: Expr, loop: Loop) -> bool:
        """Whether an expression has degree 0 or 1 in the rates."""
        g, node = self.x.graph, self.x.scalar(expr, loop)
        slopes = gradient(g, node, RATES).values() if g.depends[node] & RATES else ()
        return not any(g.depends[slope] & RATES for slope in slopes)

    def opened(self, expr: Expr, loop: Loop) -> tuple[Expr, Loop] | None:
        """If the expression is a name with a definition, returns the defining expression and the
        values of the loop variables in it. Returns None for other expressions."""
        if not isinstance(expr, Name):
            return None
        at = None if expr.index is None else integer(expr.index, loop)
        return self.definitions.get((expr.id, at))

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
            case _ if self.of_first_degree(expr, loop):
                return
            case Multiply():
                yield from self.product(expr, loop, factor, bracket)
            case Name() if found := self.opened(expr, loop):
                yield from self.terms(*found, factor, self.next())
            case Call(function="dot", arguments=(a, b)):
                if self.x.value(a, loop) != self.x.value(b, loop):
                    raise _Unread
                yield from self.vector(a, loop, factor)
            case Power(base=base, exponent=exponent) if self.x.scalar(exponent, loop) == g.number(
                2
            ):
                yield from self.square(base, loop, factor, bracket)
            case _:
                raise _Unread

    def product(self, expr: Multiply, loop: Loop, factor: Node, bracket: int) -> Iterator[_Square]:
        x = self.x
        factor, moving = self.split(expr, loop, factor)
        if len(moving) == 2 and x.value(moving[0], loop) == x.value(moving[1], loop):
            yield from self.square(moving[0], loop, factor, bracket)
        elif len(moving) == 1:
            inner = self.next() if isinstance(moving[0], Add) else bracket
            yield from self.terms(moving[0], loop, factor, inner)
        else:
            raise _Unread

    def split(
        self, expr: Multiply, loop: Loop, factor: Node, power: int = 1
    ) -> tuple[Node, list[Expr]]:
        """Returns `factor` times all factors of a product that contain no rates, each raised to
        `power`; and the list of the remaining factors."""
        x, g, moving = self.x, self.x.graph, []
        for part, exponent in zip(expr.factors, expr.exponents, strict=True):
            if not self.moves(part, loop):
                factor = g.multiply(factor, g.power(x.scalar(part, loop), power * exponent))
            elif exponent < 0:
                raise _Unread
            else:
                moving.append(part)
        return factor, moving

    def square(self, base: Expr, loop: Loop, factor: Node, bracket: int) -> Iterator[_Square]:
        """Writes factor * base^2 as a sum of squares of rates with factors, and yields these
        squares."""
        match base:
            case Prime(of=of):
                name, known = self.named(of, loop)
                named = isinstance(of, Name | Component)
                place = self.x.scalar(of, loop)
                yield _Square(factor, place, name, known, named, bracket)
            case Name() if found := self.opened(base, loop):
                yield from self.square(*found, factor, bracket)
            case Negate(of=of):
                yield from self.square(of, loop, factor, bracket)
            case Call(function="norm", arguments=(of,)):
                yield from self.vector(of, loop, factor)
            case Call(function="sqrt", arguments=(of,)):
                yield from self.terms(of, loop, factor, self.next())
            case Multiply():
                factor, moving = self.split(base, loop, factor, 2)
                if len(moving) != 1:
                    raise _Unread
                yield from self.square(moving[0], loop, factor, bracket)
            case _:
                raise _Unread

    def vector(self, expr: Expr, loop: Loop, factor: Node) -> Iterator[_Square]:
        """Writes factor * |expr|^2, for a vector `expr`, as a sum of squares of rates with factors,
        and yields these squares. If `expr` is the time derivative of a vector, nothing is yielded;
        a particle at this vector is added to `bodies`."""
        match expr:
            case Prime(of=of):
                name, _ = self.named(of, loop)
                self.bodies.append(_body(self.x, factor, self.x.value(of, loop), name))
            case Name() if found := self.opened(expr, loop):
                yield from self.vector(*found, factor)
            case Vector(items=items):
                bracket = self.next()
                for item in items:
                    if self.moves(item, loop):
                        yield from self.square(item, loop, factor, bracket)
            case _:
                raise _Unread

    def named(self, of: Expr, loop: Loop) -> tuple[str, tuple[Key, ...]]:
        """Returns the text of an expression that may be a component of a position, and its keys
        (see Key), which show to which position the component belongs."""
        text = self.x.model.source.text[of.span.start : of.span.end]
        match of:
            case Component(of=whole, axis=axis):
                return text, ((self.x.value(whole, loop), axis),)
            case Name(id=name, index=index):
                at = None if index is None else integer(index, loop)
                return indexed(name, at), tuple(keys(name, at)) if name in self.lengths else ()
        return text, ()


def _body(x: Expander, half_mass: Node, place: tuple[Node, ...], name: str) -> Body:
    return Body(x.graph.multiply(x.graph.number(2), half_mass), place, name)


def _together(x: Expander, squares: list[_Square], polar: bool) -> list[Body]:
    found, used = [], set()
    by_mass = [
        (k, [((s.factor, shared), axis) for shared, axis in s.keys]) for k, s in enumerate(squares)
    ]
    for group in places(by_mass):
        if used.isdisjoint(group.values()):
            used |= set(group.values())
            place = tuple(squares[group[a]].place if a in group else ZERO for a in range(3))
            names = ", ".join(squares[k].name for k in group.values())
            found.append(_body(x, squares[min(group.values())].factor, place, f"({names})"))
    by_bracket: dict[int, list[_Square]] = {}
    for k, square in enumerate(squares):
        if k not in used:
            by_bracket.setdefault(square.bracket, []).append(square)
    for group in by_bracket.values():
        unnamed = len({s.factor for s in group}) == 1 and not any(s.named for s in group)
        place = (*(square.place for square in group), ZERO)[:3] if unnamed else None
        place = place or (polar and _polar(x, group))
        if not place or not 2 <= len(group) <= 3:
            raise _Unread
        names = ", ".join(square.name for square in group)
        found.append(_body(x, group[0].factor, place, f"({names})"))
    return found


def _polar(x: Expander, group: list[_Square]) -> tuple[Node, ...] | None:
    """Returns the place of the particle of m/2*(r'^2 + r^2*phi'^2), or of m/2*(r'^2 + r^2*theta'^2
    + r^2*sin(theta)^2*phi'^2); None for other squares."""
    g = x.graph
    if not 2 <= len(group) <= 3:
        return None
    radius, angle = group[0].place, group[1].place
    if group[1].factor != g.multiply(group[0].factor, g.power(radius, 2)):
        return None
    sin, cos = g.call("sin", angle), g.call("cos", angle)
    if len(group) == 2:
        return g.multiply(radius, cos), g.multiply(radius, sin), ZERO
    across, turn = g.multiply(radius, sin), group[2].place
    if group[2].factor != g.multiply(group[1].factor, g.power(sin, 2)):
        return None
    flat = (g.multiply(across, g.call(f, turn)) for f in ("cos", "sin"))
    return (*flat, g.multiply(radius, cos))
