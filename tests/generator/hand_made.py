"""Small Equations built without the front end, for the tests of lower and render."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from pkgen.equations import Equations, ParameterSlot, Quantity, Structure
from pkgen.graph.differentiate import Columns, Forward, gradient
from pkgen.graph.graph import BIT, ZERO, Graph, Kind, Node, Symbol
from pkgen.graph.solve import solve
from pkgen.model import Model
from pkgen.source import Source, Span

STATE = BIT[Kind.COORDINATE] | BIT[Kind.RATE]


@dataclass
class World:
    """The graph with the symbols of a model to be."""

    graph: Graph
    p: list[Node]
    q: list[Node]
    v: list[Node]
    u: list[Node]
    t: Node


def structure(n: int, **facts: bool) -> Structure:
    every = dict.fromkeys(
        [
            "mass_constant",
            "mass_diagonal",
            "quadratic",
            "separable",
            "autonomous",
            "conservative",
            "variational",
            "smooth",
        ],
        False,
    )
    return Structure(**(every | facts), cyclic=(False,) * n)


def make(
    name: str,
    parameters: Sequence[str],
    coordinates: Sequence[str],
    energies: Callable[[World], tuple[Node, Node]],
    *,
    inputs: Sequence[str] = (),
    observed: Callable[[World], dict[str, Node]] = lambda _: {},
    bounds: Callable[[World], dict[int, tuple[Node | None, Node | None]]] = lambda _: {},
    defaults: Callable[[World], dict[int, Node]] = lambda _: {},
    description: str = "a model made by hand",
    descriptions: str = "",
    unroll: bool = True,
) -> Equations:
    """Equations of L = T - V, (T, V) = energies(world); every default is 1.5 + its index."""
    g = Graph()

    def symbols(kind: str, count: int) -> list[Node]:
        return [g.symbol(Symbol(kind, i)) for i in range(count)]

    n = len(coordinates)
    world = World(
        g,
        symbols(Kind.PARAMETER, len(parameters)),
        symbols(Kind.COORDINATE, n),
        symbols(Kind.RATE, n),
        symbols(Kind.INPUT, len(inputs)),
        g.symbol(Symbol(Kind.TIME)),
    )
    kinetic, potential = energies(world)
    lagrangian = g.subtract(kinetic, potential)
    by = gradient(g, lagrangian, STATE)
    momenta = tuple(by.get(x, ZERO) for x in world.v)
    slope = tuple(by.get(x, ZERO) for x in world.q)

    def jacobian(rows: Sequence[Node], columns: list[Node], kind: str):
        found = Columns(g, rows, BIT[kind])
        table = [found.column(x) for x in columns]
        return tuple(tuple(column.get(row, ZERO) for column in table) for row in rows)

    mass = jacobian(momenta, world.v, Kind.RATE)
    mass = tuple(tuple(mass[min(i, j)][max(i, j)] for j in range(n)) for i in range(n))

    def coast(node: Node) -> Node:
        symbol = g.data[node]
        return world.v[symbol.index] if symbol.kind is Kind.COORDINATE else ZERO

    coasting = Forward(g, BIT[Kind.COORDINATE], coast)
    force = tuple(g.subtract(s, coasting(m)) for s, m in zip(slope, momenta, strict=True))
    solution = solve(g, mass, force) if unroll else None
    outputs = observed(world)
    limits, default = bounds(world), defaults(world)
    span = Span(0, 0)
    model = Model(
        source=Source(f"somewhere/{name}.lag", f"model {name}\n"),
        name=name,
        description=description,
        dimensionless=True,
        span=span,
        **dict.fromkeys(
            [
                "sizes",
                "parameters",
                "coordinates",
                "ends",
                "inputs",
                "definitions",
                "kinetic",
                "potential",
                "lagrangian",
                "dissipation",
                "forces",
                "observed",
                "conserved",
                "starts",
                "events",
                "scenes",
            ],
            (),
        ),
    )

    def quantities(names: Sequence[str], pattern: str) -> tuple[Quantity, ...]:
        return tuple(Quantity(pattern.format(x), "", descriptions) for x in names)

    return Equations(
        model=model,
        graph=g,
        parameters=tuple(
            ParameterSlot(
                quantity=Quantity(x, "", descriptions),
                family=x,
                position=0,
                length=0,
                default=default.get(i, _default(g, i)),
                follows=i in default,
                lo=limits.get(i, (None, None))[0],
                hi=limits.get(i, (None, None))[1],
                lo_open=False,
                hi_open=False,
            )
            for i, x in enumerate(parameters)
        ),
        coordinates=quantities(coordinates, "{}"),
        rates=quantities(coordinates, "{}'"),
        momenta_names=quantities(coordinates, "p_{}"),
        inputs=quantities(inputs, "{}"),
        observed_names=quantities(list(outputs), "{}"),
        conserved_names=(),
        lagrangian=lagrangian,
        written=lagrangian,
        kinetic=kinetic,
        potential=potential,
        energy=g.subtract(g.sum(map(g.multiply, world.v, momenta)), lagrangian),
        momenta=momenta,
        gradient=slope,
        applied=(ZERO,) * n,
        pdot=slope,
        mass=mass,
        force=force,
        acceleration=solution and solution.accelerations,
        pivots=solution and solution.pivots,
        p_q=jacobian(momenta, world.q, Kind.COORDINATE),
        pdot_q=jacobian(slope, world.q, Kind.COORDINATE),
        pdot_v=jacobian(slope, world.v, Kind.RATE),
        linear=None,
        singularities=(),
        observed=tuple(outputs.values()),
        conserved=(),
        events=(),
        event_names=(),
        start_q=tuple(g.number(0) for _ in range(n)),
        start_v=tuple(g.number(0) for _ in range(n)),
    )


def _default(g: Graph, index: int) -> Node:
    return g.divide(g.number(3 + 2 * index), g.number(2))


def pendulum_chain(name: str, links: int, *, unroll: bool = True) -> Equations:
    """`links` point masses on massless rods, end to end; parameters m1.., l1.., g."""

    def energies(w: World) -> tuple[Node, Node]:
        g = w.graph
        kinetic, potential = ZERO, ZERO
        x, y, height = ZERO, ZERO, ZERO
        for i in range(links):
            sine, cosine = g.call("sin", w.q[i]), g.call("cos", w.q[i])
            swing = g.multiply(w.p[links + i], w.v[i])
            x = g.add(x, g.multiply(swing, cosine))
            y = g.add(y, g.multiply(swing, sine))
            height = g.subtract(height, g.multiply(w.p[links + i], cosine))
            square = g.add(g.power(x, 2), g.power(y, 2))
            half = g.divide(w.p[i], g.number(2))
            kinetic = g.add(kinetic, g.multiply(half, square))
            potential = g.add(potential, g.multiply(g.multiply(w.p[i], w.p[2 * links]), height))
        return kinetic, potential

    numbers = range(1, links + 1)
    return make(
        name,
        [f"m{i}" for i in numbers] + [f"l{i}" for i in numbers] + ["g"],
        [f"theta{i}" for i in numbers],
        energies,
        unroll=unroll,
    )
