"""Makes one step of Lohner's method, which encloses a motion by a moving set.

The set is u + A r: u is a point, A a nearly orthogonal matrix, r a box around 0. A step moves u
along its Taylor series, with a bound of the remainder, and moves A r by J, the derivative of the
flow over the whole set (mean value theorem). The next A is the Q factor of the product J A, with
columns ordered by length, which reduces the wrapping effect. References: R. Lohner, Enclosing the
solutions of ordinary initial and boundary value problems, in Computerarithmetic, Teubner 1987; N.
Nedialkov, K. Jackson, G. Corliss, Validated solutions of initial value problems for ordinary
differential equations, Appl. Math. Comput. 105 (1999) 21-68.
"""

from __future__ import annotations

from typing import Any

from pkgen.record import record

from .apriori import Neighbourhood, neighbourhood
from .domains import flint
from .flow import Flow


@record
class Set:
    """The set u + A r at time t."""

    t: Any
    middle: list[Any]
    frame: Any
    box: list[Any]

    def hull(self) -> list[Any]:
        return _plus(self.middle, _times(self.frame, self.box))


@record
class Step:
    """Bounds of the motion from time `first.t` to `first.t + length`."""

    first: Set
    length: Any
    series: list[Any]  # Power series in time of the midpoint of the set, for each variable.
    # Taylor coefficients of the derivative of the flow with respect to the start.
    matrices: list[Any]
    around: Neighbourhood

    def parts(self, after: Any) -> tuple[list[Any], Any]:
        """Returns the midpoint at time `after` since the start of the step, and the derivative of
        the flow up to that time."""
        part = after / self.around.radius
        rest = _tail(part, self.series[0].prec)
        middle = [
            _at(c.coeffs(), after) + _radius(m * rest)
            for c, m in zip(self.series, self.around.moved, strict=True)
        ]
        rest = _tail(part, len(self.matrices))
        flow = self.matrices[-1]
        for matrix in reversed(self.matrices[:-1]):
            flow = flow * after + matrix
        rows = [[_radius(x * rest) for x in row] for row in self.around.turned.tolist()]
        return middle, flow + flint().arb_mat(rows)

    def hull(self, after: Any) -> list[Any]:
        middle, flow = self.parts(after)
        return _plus(middle, _times(flow * self.first.frame, self.first.box))

    def last(self) -> Set:
        """Returns the set at the step's end. Raises ZeroDivisionError if the set's matrix A has no
        inverse."""
        library = flint()
        middle, flow = self.parts(self.length)
        points = [x.mid() for x in middle]
        moved = flow * self.first.frame
        frame = _orthogonal(moved, self.first.box)
        inverse = frame.inv()
        left = [x - p for x, p in zip(middle, points, strict=True)]
        box = _plus(_times(inverse * moved, self.first.box), _times(inverse, left))
        box = [library.arb(0, x.abs_upper()) for x in box]
        return Set(self.first.t + self.length, points, frame, box)


def begun(t: Any, y: list[Any]) -> Set:
    library = flint()
    m = range(len(y))
    box = [library.arb(0, x.rad()) for x in y]
    unit = library.arb_mat([[int(i == j) for j in m] for i in m])
    return Set(t, [x.mid() for x in y], unit, box)


def step(flow: Flow, now: Set, order: int, ratio: Any, tried: Any) -> Step | None:
    """Makes a step whose length is `ratio` times the largest time radius of a neighbourhood that no
    motion leaves. Returns None if no such neighbourhood is found."""
    hull = now.hull()
    around = neighbourhood(flow, now.t, hull, tried)
    if around is None:
        return None
    length = (around.radius * ratio).mid()
    try:
        series = flow.series(now.t, now.middle, order)
        matrices = flow.variations(now.t, hull, max(order // 3, 4))
    except ValueError:  # a divisor may be 0
        return None
    return Step(now, length, series, matrices, around)


def _tail(part: Any, first: int) -> Any:
    """Returns the sum of part^k over all k >= first: the tail of a geometric series."""
    return part**first / (1 - part)


def _at(coefficients: list[Any], x: Any) -> Any:
    total = flint().arb(0)
    for c in reversed(coefficients):
        total = total * x + c
    return total


def _radius(x: Any) -> Any:
    return flint().arb(0, x.abs_upper())


def _plus(a: list[Any], b: list[Any]) -> list[Any]:
    return [x + y for x, y in zip(a, b, strict=True)]


def _times(matrix: Any, vector: list[Any]) -> list[Any]:
    return (matrix * flint().arb_mat([[x] for x in vector])).entries()


def _orthogonal(matrix: Any, box: list[Any]) -> Any:
    """Returns the Q factor of the matrix's midpoints by Gram-Schmidt, as exact numbers; columns are
    ordered by length. Unit vectors replace columns that depend linearly on others."""
    library = flint()
    m = len(box)
    columns = [[matrix[i, j].mid() for i in range(m)] for j in range(m)]

    def length(j: int) -> Any:
        return _dot(columns[j], columns[j]) * (box[j].abs_upper() ** 2)

    order = sorted(range(m), key=lambda j: float(length(j).log().mid() if length(j) > 0 else -1e9))
    found: list[list[Any]] = []
    units = [[library.arb(int(i == j)) for i in range(m)] for j in range(m)]
    for column in [*(columns[j] for j in reversed(order)), *units]:
        first = _dot(column, column)
        for _ in range(2):
            for q in found:
                part = _dot(q, column)
                column = [(x - part * y).mid() for x, y in zip(column, q, strict=True)]
        left = _dot(column, column)
        if len(found) < m and left > first * 2 ** -(library.ctx.prec // 2):
            size = left.sqrt()
            found.append([(x / size).mid() for x in column])
    return library.arb_mat([[found[j][i] for j in range(m)] for i in range(m)])


def _dot(a: list[Any], b: list[Any]) -> Any:
    return sum((x * y for x, y in zip(a, b, strict=True)), flint().arb(0))
