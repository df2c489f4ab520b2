"""Models built by hand, for tests of the stages after `check`.

Expressions are written in Python's syntax and read by its `ast`, with D(x) for x', q[i] for a
member, S("i", 1, 3, body) for a sum. Nothing is executed.
"""

from __future__ import annotations

import ast
from fractions import Fraction

from pkgen.middle.reduce.reduction import Needs
from pkgen.model import (
    Bounds,
    Coordinate,
    Definition,
    End,
    Force,
    Input,
    Model,
    Parameter,
    Size,
    Start,
)
from pkgen.plan import Use
from pkgen.record import record
from pkgen.source import Source, Span
from pkgen.tree import (
    Add,
    Call,
    Component,
    Expr,
    Multiply,
    Name,
    Negate,
    Number,
    Power,
    Prime,
    Range,
    Sum,
    Vector,
)

HERE = Span(0, 1)


def expression(text: str | int | float) -> Expr:
    return _tree(ast.parse(str(text), mode="eval").body)


def _tree(node: ast.expr) -> Expr:
    match node:
        case ast.Constant(value=value):
            return Number(Fraction(str(value)), HERE)
        case ast.Name(id=name):
            return Name(name, None, HERE)
        case ast.Subscript(value=ast.Name(id=name), slice=index):
            return Name(name, _tree(index), HERE)
        case ast.UnaryOp(op=ast.USub(), operand=of):
            return Negate(_tree(of), HERE)
        case ast.BinOp(left=a, op=ast.Add(), right=b):
            return Add((_tree(a), _tree(b)), (1, 1), HERE)
        case ast.BinOp(left=a, op=ast.Sub(), right=b):
            return Add((_tree(a), _tree(b)), (1, -1), HERE)
        case ast.BinOp(left=a, op=ast.Mult(), right=b):
            return Multiply((_tree(a), _tree(b)), (1, 1), HERE)
        case ast.BinOp(left=a, op=ast.Div(), right=b):
            return Multiply((_tree(a), _tree(b)), (1, -1), HERE)
        case ast.BinOp(left=a, op=ast.Pow(), right=b):
            return Power(_tree(a), _tree(b), HERE)
        case ast.Attribute(value=of, attr=axis):
            return Component(_tree(of), "xyz".index(axis), HERE)
        case ast.List(elts=items):
            return Vector(tuple(map(_tree, items)), HERE)
        case ast.Call(func=ast.Name(id="D"), args=[of]):
            return Prime(_tree(of), HERE)
        case ast.Call(func=ast.Name(id="S"), args=[ast.Constant(value=i), lo, hi, body]):
            return Sum(_tree(body), (Range(i, _tree(lo), _tree(hi), HERE),), HERE)
        case ast.Call(func=ast.Name(id=name), args=args):
            return Call(name, tuple(map(_tree, args)), HERE)
    raise ValueError(ast.dump(node))


def _split(name: str) -> tuple[str, Expr | None, Range | None]:
    """ "x", "x[3]" or "x[k=1..N]" as name, index and range."""
    if "[" not in name:
        return name, None, None
    name, inside = name.rstrip("]").split("[")
    if ".." not in inside:
        return name, expression(inside), None
    variable, _, ends = inside.rpartition("=")
    lo, hi = ends.split("..")
    return name, None, Range(variable or "i", expression(lo), expression(hi), HERE)


def model(
    params: dict[str, object] | None = None,
    coords: tuple[str, ...] = (),
    lets: dict[str, str] | None = None,
    kinetic: str | tuple[str, ...] = (),
    potential: str | tuple[str, ...] = (),
    lagrangian: str | tuple[str, ...] = (),
    dissipation: str | tuple[str, ...] = (),
    forces: dict[str, str] | None = None,
    inputs: dict[str, int] | None = None,
    sizes: dict[str, int] | None = None,
    ends: tuple[tuple[str, str, int | None, str | None], ...] = (),
    observed: dict[str, str] | None = None,
    conserved: dict[str, str] | None = None,
    starts: dict[str, str] | None = None,
    name: str = "test",
) -> Model:
    def expressions(given: str | tuple[str, ...]) -> tuple[Expr, ...]:
        return tuple(map(expression, (given,) if isinstance(given, str) else given))

    def definitions(given: dict[str, str] | None) -> tuple[Definition, ...]:
        return tuple(
            Definition(*_split(n), expression(value), "", "", HERE)
            for n, value in (given or {}).items()
        )

    def start(target: str, value: str) -> Start:
        n, index, over = _split(target.replace("'", ""))
        return Start(n, index, over, target.count("'"), expression(value), HERE)

    parameters = []
    for n, value in (params or {}).items():
        base, _, over = _split(n)
        bounds = Bounds(None, None, False, False)
        default = expression(value)
        follows = not isinstance(default, Number)
        parameters.append(Parameter(base, over, default, follows, bounds, "", "", HERE))
    coordinates = []
    for n in coords:
        base, _, over = _split(n)
        coordinates.append(Coordinate(base, over, "", "", "", "", HERE))
    return Model(
        source=Source("test.lag", "model test\n"),
        name=name,
        description="",
        dimensionless=True,
        sizes=tuple(Size(n, value, "", HERE) for n, value in (sizes or {}).items()),
        parameters=tuple(parameters),
        coordinates=tuple(coordinates),
        ends=tuple(
            End(kind, n, index, None if value is None else expression(value), HERE)
            for kind, n, index, value in ends
        ),
        inputs=tuple(
            Input(n, order, ("",) * (order + 1), "", HERE) for n, order in (inputs or {}).items()
        ),
        definitions=definitions(lets),
        kinetic=expressions(kinetic),
        potential=expressions(potential),
        lagrangian=expressions(lagrangian),
        dissipation=expressions(dissipation),
        forces=tuple(
            Force(*_split(n), expression(value), HERE) for n, value in (forces or {}).items()
        ),
        observed=definitions(observed),
        conserved=definitions(conserved),
        starts=tuple(start(n, value) for n, value in (starts or {}).items()),
        events=(),
        scenes=(),
        span=HERE,
    )


def links(count: int, own: bool = False) -> Model:
    """The N-link pendulum; with `own`, each link has a mass and a length of its own."""
    m, length = ("m[k]", "l[k]") if own else ("m", "l")
    return model(
        sizes={"N": count},
        params={"m[k=1..N]": 1.3, "l[k=1..N]": 0.7, "g": 9.81}
        if own
        else {"m": 1.3, "l": 0.7, "g": 9.81},
        coords=("theta[1..N]",),
        lets={
            "x[0]": "0",
            "y[0]": "0",
            "x[k=1..N]": f"x[k-1] + {length}*sin(theta[k])",
            "y[k=1..N]": f"y[k-1] - {length}*cos(theta[k])",
        },
        kinetic=f"S('k', 1, N, {m}/2*(D(x[k])**2 + D(y[k])**2))",
        potential=f"S('k', 1, N, {m}*g*y[k])",
        name="links",
    )


@record(kw_only=True)
class Needing(Use):
    """The whole model, of which these columns alone are needed."""

    columns: frozenset[str]

    def needs(self, used: Model) -> Needs:
        return Needs(self.columns)
