"""Equilibria and steady motions along a parameter. Their equations are those of the search in
analysis/linear/steady.py, at each value with the start, momenta and constraints of this value."""

from __future__ import annotations

import copy

import numpy

from pkgen.analysis.linear import modes
from pkgen.analysis.linear.equilibria import TRIES, Search
from pkgen.analysis.linear.symmetries import Fields, symmetries
from pkgen.system.exits import UsageError

from .family import Family
from .problem import Linear, Node, Problem, Seed


class Equilibria(Problem):
    """x has the unknowns of the search in units of its box, and the parameter in units of the
    range."""

    def __init__(self, family: Family):
        self.family, system = family, family.first
        if not system.is_steady():
            raise UsageError(
                "the equations depend on time, and nothing rests: --orbit is of periodic motions"
            )
        units = [x.unit for x in family.compilation.equations.coordinates[: system.m]]
        with numpy.errstate(all="ignore"):
            self.search = Search(system, symmetries(Fields(system), units))
        self.flat = 2e-10 if self.search.is_exact else 1e-7
        self.scale = self.search.box
        self.rows = numpy.ones(len(self.search.scale))  # sizes of the equations

    def steady(self, value: float) -> Search:
        """Returns the equations at a value of the parameter, in the units of the first ones."""
        one = copy.copy(self.search)
        one.system = self.family.system(value)
        one.fields = Fields(one.system)
        one.q0 = numpy.split(one.system.begun, 2)[0]
        one.momenta = one.system.kernel("free momenta", 0.0, one.system.begun)
        begun = one.fields.start[None]
        one.conserved = [(s, one.fields.momentum(s, begun)) for s, _ in one.conserved]
        one.known, one.errors, one.nullities = [], [], []
        return one

    def parts(self, x: numpy.ndarray) -> tuple[numpy.ndarray, float]:
        low, _ = self.family.range
        return x[:-1] * self.scale, low + float(x[-1]) * self.family.width

    def _linear(self, x: numpy.ndarray) -> Linear | None:
        z, value = self.parts(x)
        try:
            (residual,), (jacobian,), (good,) = self.steady(value).linear(z[None])
            low, high = self.family.beside(value)
            a, b = (self.steady(p).equations(z[None])[0] for p in (low, high))
        except UsageError:  # the parameter is out of its bounds
            return None
        by_value = (b - a) / (high - low) * self.family.width / self.rows
        units = self.search.scale / self.rows
        jacobian = jacobian * units[:, None] / self.search.reach(z) * self.scale
        jacobian, residual = numpy.concatenate([jacobian, by_value[:, None]], 1), residual * units
        if not good or not numpy.isfinite(jacobian).all():
            return None
        size = float(abs(residual).max(initial=0.0))
        return Linear(residual, jacobian, lambda step, _: step, size)

    def node(self, x: numpy.ndarray, t: numpy.ndarray) -> Node | None:
        z, value = self.parts(x)
        steady = self.steady(value)
        state = steady.states(z)
        moving = list(zip(z[steady.system.n :], steady.moving, strict=True))
        try:
            values = modes.eigenvalues(steady.system, state, moving)
        except numpy.linalg.LinAlgError:
            return None
        about = {"state": self.family.state(steady.system, state)}
        about["energy"] = self.family.energy(steady.system, state)
        return Node(x, t, value, float(t[-1]) * self.family.width, values, about)

    def apart(self, a: Node, b: Node) -> numpy.ndarray:
        at, to = (self.parts(n.x)[0] for n in (a, b))
        apart = self.search.apart(at, to) * self.search.box / self.scale
        return numpy.append(apart, b.x[-1] - a.x[-1])

    def seeds(self) -> list[Seed]:
        """Returns the equilibria that are found at both ends of the range and at the model's own
        value."""
        roots = []
        for value in dict.fromkeys([*self.family.range, self.family.own()]):
            search = self.steady(value)
            search.run(TRIES)
            roots += [(z, value) for z in search.known]
        if not roots:
            raise UsageError("no equilibrium was found: --start has where the search begins")
        # Units are the distances of what is found; the box is wide where motions run away.
        spread = numpy.ptp([z for z, _ in roots], axis=0)
        box = self.search.box
        self.scale = numpy.where(spread > 1e-6 * box.max(initial=0.0), spread, box)
        along = numpy.append(numpy.zeros(len(box)), 1.0)
        low, width = self.family.range[0], self.family.width
        starts = [numpy.append(z / self.scale, (value - low) / width) for z, value in roots]
        starts = [x for x in starts if self.linear(x) is not None]
        sizes = numpy.max([abs(self.linear(x).jacobian).max(1) for x in starts], axis=0)
        self.rows, self.last = numpy.where(sizes > 0, sizes, 1.0), (None,) * 3
        found = []
        for x in starts:
            at = self.correct(x, along, float(x[-1]))
            x = at[0] if at else x
            found.append(self.node(x, self.tangent(x, along)))
        return [Seed(self, node) for node in found if node is not None]
