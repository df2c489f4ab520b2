"""The functions of a model's tables, and the data behind them: piecewise polynomials.

A table `road` adds rows to FUNCTIONS: a rising function of each argument whose floor is the number
of the piece (`road@0`), and the table itself with its derivatives (`road:0`, `road:1`, ...), which
take the arguments and the numbers of the pieces. So the floor is the only switch, and each step of
an integrator keeps it on one piece. runtime/include/pk/lookup.h does the same in C.
"""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Any

from ..record import record
from .row import Function

if TYPE_CHECKING:
    import numpy

ORDERS = 4  # Derivatives of order 4 vanish.
# The order of the highest continuous derivative at the knots, by the kind of the table, and at the
# ends, by what is outside.
SMOOTH = {"hold": -1, "linear": 0, "pchip": 1, "spline": 2}
AT_ENDS = {"error": 3, "hold": 0, "linear": 1, "periodic": 3}


@record(eq=False)
class Axis:
    """The knots of an axis. `smooth` is the order of the highest continuous derivative."""

    knots: numpy.ndarray
    period: float
    strict: bool
    smooth: int

    def place(self, x: Any) -> Any:
        """Returns pk_axis_place() of numbers or arrays."""
        import numpy

        k, last = self.knots, len(self.knots) - 1
        turns = numpy.floor((x - k[0]) / self.period) if self.period else 0 * numpy.asarray(x)
        x = x - turns * self.period
        n = numpy.clip(numpy.searchsorted(k, x, "right") - 1, 0, last - 1)
        with numpy.errstate(divide="ignore", invalid="ignore"):
            inside = n + (x - k[n]) / (k[n + 1] - k[n])
            below = -(k[0] - x) / (k[0] - x + (k[1] - k[0])) / 2
            above = last + (x - k[-1]) / (x - k[-1] + (k[-1] - k[-2])) / 2
        return turns * last + numpy.where(x >= k[-1], above, numpy.where(x >= k[0], inside, below))

    def piece(self, x: Any, n: Any) -> tuple[Any, Any]:
        """Returns pk_axis_piece() of numbers or arrays."""
        import numpy

        k, last = self.knots, len(self.knots) - 1
        turns = numpy.floor(n / last) if self.period else 0
        n, x = n - turns * last, x - turns * self.period
        known = (n >= -1) & (n <= last)
        if self.strict:
            known &= ((n >= 0) & (n < last)) | ((x >= k[0]) & (x <= k[-1]))
        n = numpy.where(known, n, -1).astype(int)
        return n + 1, numpy.where(known, x - k[numpy.maximum(n, 0)], numpy.nan)


@record(eq=False)
class Data:
    """A table's axes and its coefficients, of shape (pieces, 4) or (pieces, pieces, 4, 4)."""

    axes: tuple[Axis, ...]
    coefficients: numpy.ndarray
    degree: int

    def knot_values(self) -> numpy.ndarray:
        """Returns the values at the knots."""
        inside = (slice(1, None),) * len(self.axes) + (0,) * len(self.axes)
        return self.coefficients[inside]

    def value(self, orders: tuple[int, ...], *given: Any) -> Any:
        """Returns a derivative at the arguments. The numbers of their pieces may follow."""
        import numpy

        count = len(self.axes)
        if len(given) == count:
            places = (a.place(x) for a, x in zip(self.axes, given, strict=True))
            given = (*given, *map(numpy.floor, places))
        found = [a.piece(x, n) for a, x, n in zip(self.axes, given, given[count:], strict=False)]
        c = self.coefficients[tuple(row for row, _ in found)]
        for order, (_, s) in reversed([*zip(orders, found, strict=True)]):
            c = _cubic(c, order, s[..., None] if c.ndim > s.ndim + 1 else s)
        return c


def _cubic(c: Any, order: int, s: Any) -> Any:
    value = 0 * s
    for power in range(3, order - 1, -1):
        factor = 1
        for k in range(order):
            factor *= power - k
        value = value * s + factor * c[..., power]
    return value


def rows(table: str, key: str, data: Data) -> dict[str, Function]:
    """Returns the rows of a table, named `table` in the model. `key` tells tables of other models
    with the same name apart."""
    count = len(data.axes)
    letters = ("x", "y")[:count]
    found = {
        f"{key}@{i}": Function(
            internal=True,
            real=lambda x, i=i: float(data.axes[i].place(x)),
            array=lambda np, x, i=i: data.axes[i].place(x),
            derivative=lambda g, n, a: (g.number(0),),
            table=table,
            axis=i,
        )
        for i in range(count)
    }
    for orders in product(range(ORDERS), repeat=count):
        name = f"{key}:{''.join(map(str, orders))}"
        found[name] = Function(
            arguments=(*letters, *(f"n_{x}" for x in letters)),
            internal=True,
            real=lambda *x, o=orders: float(data.value(o, *x)),
            array=lambda np, *x, o=orders: data.value(o, *x),
            derivative=lambda g, n, *x, o=orders: _derivatives(g, key, data, o, x),
            branched=True,
            table=table,
            orders=orders,
            sympy=lambda sp, *x, o=orders: _of_sympy(sp, table, o, x[:count]),
        )
    return found


def _of_sympy(sp: Any, table: str, orders: tuple[int, ...], arguments: Any) -> Any:
    return sp.Function(table + "".join(f"_{k}" for k in orders if any(orders)))(*arguments)


def called(g: Any, key: str, data: Data, arguments: Any) -> Any:
    """Returns the node of a table at the arguments."""
    count = len(arguments)
    places = (g.call(f"{key}@{i}", x) for i, x in enumerate(arguments))
    pieces = [g.call(_piece(a, 0), u) for a, u in zip(data.axes, places, strict=True)]
    return g.call(f"{key}:{'0' * count}", *arguments, *pieces)


def _piece(axis: Axis, order: int) -> str:
    """Returns the function that numbers the pieces. `piece` counts as continuous, since the
    derivative of this order does not jump at the knots."""
    return "floor" if order > axis.smooth else "piece"


def _derivatives(
    g: Any, key: str, data: Data, orders: tuple[int, ...], given: tuple[Any, ...]
) -> tuple[Any, ...]:
    found, count = [], len(orders)
    for i, axis in enumerate(data.axes):
        order = orders[i] + 1
        if order > data.degree:
            found.append(g.number(0))
            continue
        new, arguments = (*orders[:i], order, *orders[i + 1 :]), list(given)
        piece = given[count + i]
        if g.data[piece] == "piece":
            arguments[count + i] = g.call(_piece(axis, order), *g.args[piece])
        found.append(g.call(f"{key}:{''.join(map(str, new))}", *arguments))
    return (*found, *(g.number(0) for _ in range(count)))
