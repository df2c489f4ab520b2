"""The equations y' = F(t, y) in ball arithmetic; y has coordinates, rates and first-order
variables."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from pkgen.equations import Equations
from pkgen.graph.differentiate import Forward
from pkgen.graph.graph import BIT, ONE, ZERO, Graph, Kind, Node, Symbol
from pkgen.graph.substitute import substituted
from pkgen.middle.jacobians import slopes, variables
from pkgen.record import record

from .domains import Complexes, Reals, Series, ball, flint, written

TIME = Symbol(Kind.TIME)


Ends = tuple[Fraction, Fraction]  # The ends of an interval, which are equal for a number.


@record
class Given:
    """The requested motion, in exact numbers in SI. Parameters, coordinates and rates are given by
    index (first-order variables follow the rates); `columns` are the graph nodes of the columns of
    the rows."""

    equations: Equations
    parameters: Mapping[int, Ends]
    coordinates: Mapping[int, Ends]
    rates: Mapping[int, Ends]
    names: tuple[str, ...]
    columns: tuple[Node, ...]
    until: Fraction
    every: Fraction

    @property
    def wide(self) -> list[int]:
        """The indices of the parameters that are intervals."""
        return [k for k, (low, high) in self.parameters.items() if low != high]

    @property
    def several(self) -> bool:
        """Whether an interval is given, so that there are many motions."""
        ends = (*self.coordinates.values(), *self.rates.values())
        return bool(self.wide) or any(low != high for low, high in ends)


class Flow:
    """The function F of y' = F(t, y), its Jacobian, and the columns of the rows, in the current
    precision. An interval parameter becomes a variable whose rate is 0, so that its value is the
    same wherever it occurs."""

    def __init__(self, given: Given):
        e = given.equations
        g = e.graph.copy()
        self.parameters = _parameters(e, given)
        wide = given.wide
        resting = [Symbol(Kind.STATE, len(e.states) + i) for i in range(len(wide))]
        self.variables = [*variables(e), *resting]
        self.size = len(self.variables)
        swap = _swapped(g, e, dict(zip(wide, resting, strict=True)), given)
        columns = substituted(g, given.columns, swap)
        rates = [*substituted(g, slopes(g, e), swap), *(ZERO for _ in wide)]
        self.slopes = written(g, rates, self.parameters)
        jacobian = [[_partial(g, row, s) for s in self.variables] for row in rates]
        self.entries = [
            (i, j) for i, row in enumerate(jacobian) for j, x in enumerate(row) if x != ZERO
        ]
        nodes = [jacobian[i][j] for i, j in self.entries]
        self.jacobian = written(g, nodes, self.parameters)
        self.columns = written(g, columns, self.parameters)
        self.start = _start(e, given, self.parameters)
        self.start += [self.parameters[Symbol(Kind.PARAMETER, k)] for k in wide]
        rows = (*e.constraints.positions, *e.constraints.residual) if e.constraints else ()
        self.residuals = written(g, substituted(g, rows, swap), self.parameters)

    def values(self, t: Any, y: list[Any]) -> dict[Symbol, Any]:
        return {TIME: t, **dict(zip(self.variables, y, strict=True))}

    def series(self, t: Any, y: list[Any], order: int) -> list[Any]:
        """Returns the solution that starts at y at time t: a power series in time, up to `order`,
        for each variable."""
        library = flint()
        found = [[x] for x in y]
        for k in range(order):
            terms = [library.arb_series(c, k + 1) for c in found]
            now = library.arb_series([t, 1][: k + 1], k + 1)
            for c, slope in zip(found, self.slopes(SERIES, self.values(now, terms)), strict=True):
                c.append(_coefficient(slope, k) / (k + 1))
        return [library.arb_series(c, order + 1) for c in found]

    def variations(self, t: Any, y: list[Any], order: int) -> list[Any]:
        """Returns the Taylor coefficients in time of the Jacobian of the flow with respect to its
        start (matrices)."""
        library = flint()
        terms = self.series(t, y, order)
        now = library.arb_series([t, 1], order + 1)
        entries = self.jacobian(SERIES, self.values(now, terms))
        by_power = [self._matrix([_coefficient(x, k) for x in entries]) for k in range(order)]
        m = range(self.size)
        found = [library.arb_mat([[int(i == j) for j in m] for i in m])]
        for k in range(order):
            total = by_power[0] * found[k]
            for i in range(1, k + 1):
                total += by_power[i] * found[k - i]
            found.append(total * (library.arb(1) / (k + 1)))
        return found

    def jacobian_bound(self, t: Any, y: list[Any]) -> Any:
        """Returns bounds of the absolute values of the Jacobian's entries over complex balls."""
        found = self.jacobian(COMPLEX, self.values(t, y))
        return self._matrix([flint().acb(x).abs_upper() for x in found])

    def _matrix(self, entries: list[Any]) -> Any:
        library = flint()
        rows = [[library.arb(0)] * self.size for _ in range(self.size)]
        for (i, j), x in zip(self.entries, entries, strict=True):
            rows[i][j] = x
        return library.arb_mat(rows)

    def shown(self, t: Any, y: list[Any]) -> list[Any]:
        return self.columns(REAL, self.values(t, y))


REAL, SERIES, COMPLEX = Reals(), Series(), Complexes()


def _coefficient(value: Any, k: int) -> Any:
    """Returns coefficient k of a series, or of a constant ball."""
    library = flint()
    if isinstance(value, library.arb_series):
        return value[k]
    return library.arb(value) if k == 0 else library.arb(0)


def _partial(g: Graph, node: Node, symbol: Symbol) -> Node:
    return Forward(g, BIT[symbol.kind], lambda leaf: ONE if g.data[leaf] == symbol else ZERO)(node)


def _swapped(
    g: Graph, e: Equations, resting: Mapping[int, Symbol], given: Given
) -> dict[Node, Node]:
    """Returns replacements of parameter nodes: of interval parameters by variables, and of
    parameters by their defaults if these depend on interval parameters."""
    swap: dict[Node, Node] = {}
    for k, slot in enumerate(e.parameters if resting else ()):
        symbol = g.symbol(Symbol(Kind.PARAMETER, k))
        if k in resting:
            swap[symbol] = g.symbol(resting[k])
        elif k not in given.parameters:
            (swap[symbol],) = substituted(g, [slot.default], swap)
    return swap


def _parameters(e: Equations, given: Given) -> dict[Symbol, Any]:
    """Returns all parameters as balls; a default may depend on earlier parameters."""
    found: dict[Symbol, Any] = {}
    for k, slot in enumerate(e.parameters):
        if k in given.parameters:
            value = ball(*given.parameters[k])
        else:
            (value,) = written(e.graph, [slot.default], found)(REAL, {})
        found[Symbol(Kind.PARAMETER, k)] = value
    return found


def _start(e: Equations, given: Given, parameters: Mapping[Symbol, Any]) -> list[Any]:
    n = len(e.coordinates)
    nodes = [*e.start_q, *e.start_v, *e.state_start]
    values = written(e.graph, nodes, parameters)(REAL, {})
    known = dict(zip(_all(e), values, strict=True))
    known |= {Symbol(Kind.COORDINATE, i): ball(*x) for i, x in given.coordinates.items()}
    for i, x in given.rates.items():
        symbol = Symbol(Kind.RATE, i) if i < n else Symbol(Kind.STATE, i - n)
        known[symbol] = ball(*x)
    return [known[s] for s in variables(e)]


def _all(e: Equations) -> list[Symbol]:
    n = range(len(e.coordinates))
    kinds = ((Kind.COORDINATE, n), (Kind.RATE, n), (Kind.STATE, range(len(e.states))))
    return [Symbol(kind, i) for kind, indices in kinds for i in indices]
