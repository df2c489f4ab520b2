"""Periodic orbits by orthogonal collocation: on each interval of the grid a polynomial of degree 4,
which obeys the equations at the 4 Gauss points. It is of order 8 at the points of the grid.

collocation.py reduces the unknowns to the states at the beginnings of segments, the period and the
parameter. Corrections of these have the least norm. So families with conserved quantities, for
which the equations depend on each other, need no unfolding parameter.

Reference: E. Doedel, H. B. Keller, J. P. Kernevez, Int. J. Bifurcation and Chaos 1 (1991) 745.
"""

from __future__ import annotations

import copy
import math

import numpy

from pkgen.system.exits import UsageError

from .collocation import SEGMENTS, condensed, multipliers
from .flow import Flow
from .polynomials import DEGREE, POINTS, D, W, adapted, interpolated, points
from .problem import Linear, Node, Problem

STEPS_A_GRID = 5  # steps between adaptions of the grid
TRIVIAL = 1e-4  # a multiplier nearer to 1 is one of a conserved quantity, at the first orbit
TURN = 2 * math.pi


class Orbits(Problem):
    """x has the states at all points of all intervals, then in units of their first values the
    period, unless the forcing has one, and the parameter, unless the energy is free. The grid is
    the times at which intervals begin and end, from 0 to 1."""

    is_map = True
    flat = 1e-8
    unit = SEGMENTS**0.5

    def __init__(self, flow: Flow, grid: numpy.ndarray, z: numpy.ndarray, period, value, width=()):
        """`z` are the states of a guess at all points; `period` is a number, or a function of the
        parameter; `width` has the units of the states."""
        self.flow, self.family, self.grid = flow, flow.family, grid
        self.period_of = period if callable(period) else None
        self.periods = 1
        self.period0 = period(value) if callable(period) else float(period)
        self.value0 = value
        self.width = width if len(width) else _width(flow, z)
        places = (flow.among < self.family.first.m) & (abs(z[-1] - z[0]) > 0.9 * TURN)
        self.winding = places * TURN * numpy.round((z[-1] - z[0]) / TURN)
        system, t = self.family.system(value), numpy.zeros(len(z))
        a, b = (flow.rates(system, t, z + by) for by in (0, self.winding))
        if not (abs(a - b) <= 1e-9 * abs(a).max(0)).all():  # they are no angles
            self.winding = 0 * self.winding
        self.trivial: int | None = None
        self.steps = 0
        self.energy0: float | None = None
        self.begun = self._packed(z[:-1], self.period0, value)
        self.ref = self.begun
        self._chosen()

    # -- x ------------------------------------------------------------------------------------

    @property
    def extra(self) -> int:
        return (self.period_of is None) + (self.family.name is not None)

    def _chosen(self) -> None:
        count = len(self.grid) - 1
        self.segments = numpy.linspace(0, count, SEGMENTS + 1).astype(int)
        starts = (self.segments[:-1, None] * DEGREE * self.flow.count) + numpy.arange(
            self.flow.count
        )
        length = count * DEGREE * self.flow.count + self.extra
        self.of = numpy.array([*starts.ravel(), *range(length - self.extra, length)])

    def _packed(self, z: numpy.ndarray, period: float, value: float) -> numpy.ndarray:
        low, _ = self.family.range
        more = [period / self.period0] if self.period_of is None else []
        more += [(value - low) / self.family.width] if self.family.name is not None else []
        return numpy.append((z / self.width).ravel(), more)

    def parts(self, x: numpy.ndarray) -> tuple[numpy.ndarray, float, float]:
        """Returns the states at all points, the last one too, the period and the parameter."""
        z = x[: len(x) - self.extra].reshape(-1, self.flow.count) * self.width
        value = self.value0
        if self.family.name is not None:
            value = self.family.range[0] + float(x[-1]) * self.family.width
        period = self.period_of(value) * self.periods if self.period_of else 0.0
        if self.period_of is None:
            period = float(x[len(x) - self.extra]) * self.period0
        return numpy.concatenate([z, z[:1] + self.winding]), period, value

    def value(self, x: numpy.ndarray) -> float:
        z, _, value = self.parts(x)
        if self.family.name is None:
            return float(self.flow.energies(self.family.first, z[:1])[0])
        return value

    def energy_row(self, x: numpy.ndarray) -> numpy.ndarray:
        """Returns the derivatives of the energy at the beginnings of segments, their mean, by the
        unknowns x[of]."""
        z, _, value = self.parts(x)
        system = self.family.system(value)
        at = z[:-1:DEGREE][self.segments[:-1]]
        by = 1e-6 * numpy.diag(self.width)
        beside = numpy.concatenate([at[:, None] + by, at[:, None] - by], 1)
        h = self.flow.energies(system, beside.reshape(-1, self.flow.count))
        h = h.reshape(len(at), 2, self.flow.count)
        return numpy.append((h[:, 0] - h[:, 1]).ravel() / 2e-6 / len(at), numpy.zeros(self.extra))

    # -- the equations ------------------------------------------------------------------------

    def _forces(self, x: numpy.ndarray) -> tuple[numpy.ndarray, ...]:
        """Returns at all Gauss points z' - T f, the derivatives of T f by z, and by the unknowns
        that are no states."""
        z, period, value = self.parts(x)
        d, flow, system = self.flow.count, self.flow, self.family.system(value)
        index = numpy.arange(len(self.grid) - 1)[:, None] * DEGREE + numpy.arange(DEGREE + 1)
        Y = z[index]
        at = numpy.einsum("jk,ikd->ijd", W, Y).reshape(-1, d)
        h = numpy.diff(self.grid)
        times = (self.grid[:-1, None] + h[:, None] * POINTS).ravel()
        t = times * period if flow.forced else numpy.zeros(len(times))
        F = flow.rates(system, t, at)
        residual = numpy.einsum("jk,ikd->ijd", D, Y) / h[:, None, None]
        residual -= period * F.reshape(residual.shape)
        columns = [F * self.period0] if self.period_of is None else []
        if self.family.name is not None:
            low, high = self.family.beside(value)
            ends = []
            for p in (low, high):
                T = self.period_of(p) * self.periods if self.period_of else period
                by = times * T if flow.forced else t
                ends.append(T * flow.rates(self.family.system(p), by, at))
            columns.append((ends[1] - ends[0]) / (high - low) * self.family.width)
        A = period * flow.jacobian(system, t, at)
        return residual, A, numpy.stack(columns, -1)

    def _linear(self, x: numpy.ndarray) -> Linear | None:
        d, count, scale, h = self.flow.count, len(self.grid) - 1, self.width, numpy.diff(self.grid)
        try:
            residual, A, columns = self._forces(x)
        except UsageError:  # the parameter is out of its bounds
            return None
        A = (A * scale / scale[:, None]).reshape(count, DEGREE, d, d)
        columns = (columns / scale[:, None]).reshape(count, DEGREE, d, -1)
        residual = residual / scale
        made = condensed(h, self.segments, A, columns, residual)
        if made is None:
            return None
        self.maps = made.maps
        rows, off = self._more(x)
        size = float((abs(residual).max((1, 2)) * h).max())
        jacobian = numpy.concatenate([made.jacobian, rows])
        return Linear(numpy.append(made.residual, off), jacobian, made.expand, size)

    def _more(self, x: numpy.ndarray) -> tuple[numpy.ndarray, list[float]]:
        """Returns the rows of the phase, which is the nearest to that of the orbit `ref`, and of
        the energy where it is kept."""
        rows, residuals = [], []
        if not self.flow.forced:
            z, _, value = self.parts(self.ref)
            at = z[:-1:DEGREE][self.segments[:-1]]
            F = self.flow.rates(self.family.system(value), numpy.zeros(len(at)), at) / self.width
            F = F.ravel() / numpy.linalg.norm(F)
            rows.append(numpy.append(F, numpy.zeros(self.extra)))
            residuals.append(float(rows[-1] @ (x - self.ref)[self.of]))
        if self.energy0 is not None:
            z, _, value = self.parts(x)
            row = self.energy_row(x)
            size = numpy.linalg.norm(row) or 1.0
            low, high = self.family.beside(value)
            at = z[:-1:DEGREE][self.segments[:-1]]
            a, b, h = (
                self.flow.energies(self.family.system(p), at).mean() for p in (low, high, value)
            )
            row[-1] = (b - a) / (high - low) * self.family.width
            rows.append(row / size)
            residuals.append(float(h - self.energy0) / size)
        return numpy.array(rows).reshape(len(rows), len(self.of)), residuals

    # -- nodes --------------------------------------------------------------------------------

    def node(self, x: numpy.ndarray, t: numpy.ndarray) -> Node | None:
        if self.linear(x) is None:
            return None
        values = multipliers(self.maps)
        values = values[numpy.argsort(abs(values - 1))]
        if self.trivial is None:
            near = int((abs(values - 1) < TRIVIAL).sum())
            self.trivial = 0 if self.flow.forced else max(2, near) if self.flow.conservative else 1
        z, period, value = self.parts(x)
        system = self.family.system(value)
        whole = self.flow.states(system, z)
        names = self.family.names()
        low, high = whole.min(0)[system.used], whole.max(0)[system.used]
        about = {
            "state": self.family.state(system, whole[0]),
            "period": period,
            "energy": self.family.energy(system, whole[0]) if not self.flow.forced else None,
            "extents": {k: (float(a), float(b)) for k, a, b in zip(names, low, high, strict=True)},
        }
        rate = float(t[-1]) * self.family.width
        if self.family.name is None:
            rate = float(self.energy_row(x) @ t[self.of])
        return Node(x, t, self.value(x), rate, values[self.trivial :], about, self.grid)

    def at(self, node: Node) -> Node:
        self.grid = node.grid
        self._chosen()
        self.ref = node.x
        return node

    def apart(self, a: Node, b: Node) -> numpy.ndarray:
        def mark(n: Node) -> numpy.ndarray:
            ends = numpy.array([*n.about["extents"].values()])[:, 0] * 1.0
            more = [n.value / self.family.width, math.log(n.about["period"])]
            wide = numpy.ptp([*n.about["extents"].values()], axis=1)
            return numpy.array([*more, *wide, *ends])

        scale = numpy.array([*numpy.ptp([*a.about["extents"].values()], axis=1)])
        scale = numpy.where(scale > 0, scale, 1.0)
        return (mark(b) - mark(a)) / numpy.array([1, 1, *scale, *scale])

    def ends(self, a: Node, b: Node) -> str:
        ways = [n.x[self.of[: -self.extra or None]].reshape(SEGMENTS, -1) for n in (a, b)]
        one, other = (way - way.mean(0) for way in ways)
        return "the orbit has shrunk to an equilibrium" if (one * other).sum() < 0 else ""

    # -- the grid -----------------------------------------------------------------------------

    def settle(self, x: numpy.ndarray, t: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
        self.ref = x
        self.steps += 1
        if self.steps % STEPS_A_GRID:
            return x, t
        return self.adapted(x, t)

    def adapted(self, x: numpy.ndarray, t: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
        """Returns the orbit and its tangent on an adapted grid."""
        old = copy.copy(self)
        self.grid = adapted(self.grid, self.parts(x)[0] / self.width)
        self._chosen()
        self.ref = self._carried(old, x, self.winding / self.width)
        to = self._carried(old, t, 0 * self.winding)
        row = to[self.of] / numpy.linalg.norm(to[self.of])
        found = self.correct(self.ref, row, float(row @ self.ref[self.of]))
        if found is None:
            self.grid, self.ref = old.grid, x
            self._chosen()
            return x, t
        self.ref = found[0]
        return found[0], self.tangent(found[0], to)

    def doubled(self, node: Node) -> tuple[Problem, Node] | None:
        twice = copy.copy(self)
        twice.doublings += 1
        twice.periods, twice.period0 = 2 * self.periods, 2 * self.period0
        twice.winding = 2 * self.winding
        twice.grid = numpy.append(self.grid / 2, 0.5 + self.grid[1:] / 2)
        twice._chosen()

        def both(x: numpy.ndarray, winding: numpy.ndarray) -> numpy.ndarray:
            count = len(x) - self.extra
            z = x[:count].reshape(-1, self.flow.count)
            return numpy.concatenate([z.ravel(), (z + winding).ravel(), x[count:]])

        x, t = both(node.x, self.winding / self.width), both(node.t, 0 * self.winding)
        twice.ref = x
        other = twice.aside(Node(x, t, node.value, node.rate, node.values, {}))
        made = None if other is None else twice.beside(x, other)
        return None if made is None else (twice, made)

    def _carried(self, old: Orbits, x: numpy.ndarray, winding: numpy.ndarray) -> numpy.ndarray:
        z = x[: len(x) - self.extra].reshape(-1, self.flow.count)
        z = numpy.concatenate([z, z[:1] + winding])
        times = points(self.grid)[:-1]
        return numpy.append(interpolated(old.grid, z, times).ravel(), x[len(x) - self.extra :])


def _width(flow: Flow, z: numpy.ndarray) -> numpy.ndarray:
    """Returns the widths of an orbit, or a tenth of the largest one of coordinates, or of rates."""
    width, rates = numpy.ptp(z, axis=0), flow.among >= flow.family.first.n
    for kind in (rates, ~rates):
        width[kind] = numpy.fmax(width[kind], 0.1 * width[kind].max(initial=0.0))
    return numpy.where(width > 0, width, 1.0)
