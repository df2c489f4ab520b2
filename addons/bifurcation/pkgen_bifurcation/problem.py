"""A continuation problem: equations whose solutions form a curve."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy

ITERATIONS, LAST_CORRECTION = 12, 1e-9  # Newton's iterations; the last correction
ROUGHLY_FLAT = 1e-4  # as Problem.flat, at a branch point that is known roughly
STEP_ASIDE = 2e-2  # first step on a branch that begins at a branch point


@dataclass
class Linear:
    """The residual at x and its Jacobian by the reduced unknowns x[problem.of]. `expand` converts a
    correction of these to one of all of x; if `homogeneous`, as if the residual were 0."""

    residual: numpy.ndarray
    jacobian: numpy.ndarray
    expand: Callable[[numpy.ndarray, bool], numpy.ndarray]
    size: float  # how far x is from a solution


@dataclass
class Node:
    """A point of a branch: x and its tangent, with what the problem says of it."""

    x: numpy.ndarray
    t: numpy.ndarray
    value: float
    rate: float  # derivative of the value along the branch
    values: numpy.ndarray  # eigenvalues or multipliers
    about: dict[str, Any]  # state by name, period, energy
    grid: Any = None  # the grid that x belongs to
    kind: str = ""  # the kind of a special point, or ""


@dataclass
class Path:
    """A branch as it was followed."""

    nodes: list[Node]
    ended: list[str]  # at its two ends
    origin: Node | None = None  # the branch point that it passes through
    problem: Any = None
    specials: list[Node] = field(default_factory=list)


@dataclass
class Seed:
    """A point from which a branch is followed: in both directions, or along its tangent alone."""

    problem: Problem
    node: Node
    origin: Node | None = None
    outward: bool = False


class Problem:
    """Solves residual(x) = 0, with one more unknown than independent equations. Numbers of x are in
    units of their ranges. `of` are the indices of x by which lengths are measured."""

    of: numpy.ndarray | slice = slice(None)
    grid: Any = None
    ref: Any = None  # a point that the equations refer to
    is_map = False
    unit = 1.0  # the unit of step lengths
    doublings = 0
    slack = 0  # solutions go on in so many directions beside the tangent
    flat = 1e-7  # a singular value below this part of the largest counts as 0

    last: tuple = (None, None, None)

    def linear(self, x: numpy.ndarray) -> Linear | None:
        """Returns the equations at x; None where they are not finite."""
        if self.last[0] is not x or self.last[1] is not self.ref:
            self.last = x, self.ref, self._linear(x)
        return self.last[2]

    def _linear(self, x: numpy.ndarray) -> Linear | None:
        raise NotImplementedError

    def node(self, x: numpy.ndarray, t: numpy.ndarray) -> Node | None:
        raise NotImplementedError

    def settle(self, x: numpy.ndarray, t: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
        """Called after each step; may change the grid."""
        return x, t

    # -- the bordered equations ---------------------------------------------------------------

    def _solved(self, at: Linear, row: numpy.ndarray, right: numpy.ndarray, last: float):
        matrix = numpy.concatenate([at.jacobian, row[None]])
        return numpy.linalg.lstsq(matrix, numpy.append(right, last), rcond=self.flat)[0]

    def correct(self, x: numpy.ndarray, row: numpy.ndarray, last: float):
        """Returns the solution with row . x[of] = last near x, and the number of iterations; None
        if Newton's method does not find it."""
        for k in range(ITERATIONS):
            at = self.linear(x)
            if at is None:
                return None
            step = at.expand(self._solved(at, row, -at.residual, last - row @ x[self.of]), False)
            x = x + step
            size = abs(step).max()
            if not size < 1:
                return None
            if size < LAST_CORRECTION:
                at = self.linear(x)
                return (x, k) if at is not None and at.size < 1e-7 else None
        return None

    def tangent(self, x: numpy.ndarray, before: numpy.ndarray) -> numpy.ndarray:
        """Returns the direction of the branch at x, nearest to `before`, of length 1."""
        at = self.linear(x)
        row = before[self.of]
        t = at.expand(self._solved(at, row / numpy.linalg.norm(row), 0 * at.residual, 1.0), True)
        return t / numpy.linalg.norm(t[self.of])

    def aside(self, node: Node) -> numpy.ndarray | None:
        """Returns the other direction in which solutions go on from a branch point; None where they
        go on in more."""
        if self.slack:
            return None
        at, t = self.linear(node.x), node.t[self.of]
        _, _, v = numpy.linalg.svd(numpy.concatenate([at.jacobian, t[None]]))
        other = at.expand(v[-1], True)
        return other / numpy.linalg.norm(other[self.of])

    def apart(self, a: Node, b: Node) -> numpy.ndarray:
        """Returns the displacement from a to b, which may be of other grids."""
        raise NotImplementedError

    def ends(self, a: Node, b: Node) -> str:
        """Returns why a branch ends between two points within the range, or ""."""
        return ""

    def doubled(self, node: Node) -> tuple[Problem, Node] | None:
        """Returns the problem of twice the period, and its first point beside a doubling."""
        return None

    def beside(self, x: numpy.ndarray, way: numpy.ndarray) -> Node | None:
        """Returns a point of the branch that goes from x in a direction."""
        row = way[self.of]
        for length in (STEP_ASIDE, STEP_ASIDE / 4, STEP_ASIDE / 16):
            found = self.correct(x + length * way, row, float(row @ x[self.of]) + length)
            if found is not None:
                return self.node(found[0], self.tangent(found[0], way))
        return None

    def is_simple(self, node: Node) -> bool:
        """Returns whether one branch alone goes through a point. Another branch through a pitchfork
        turns there as at a fold."""
        return self.slack_at(node, ROUGHLY_FLAT) <= self.slack

    def slack_at(self, node: Node, small: float = 1e-6) -> int:
        """Returns in how many directions beside the tangent solutions go on."""
        at, t = self.linear(node.x), node.t[self.of]
        s = numpy.linalg.svd(numpy.concatenate([at.jacobian, t[None]]), compute_uv=False)
        return int((s[: len(t)] < small * s[0]).sum())

    def at(self, node: Node) -> Node:
        """Makes the grid that of the node."""
        self.grid = node.grid
        return node

    # -- test functions -----------------------------------------------------------------------

    def determinant(self, values: numpy.ndarray, plus: float) -> float:
        """Returns the product of (value - plus), each factor of at most 1 in size."""
        factors = values - plus
        return float(numpy.prod(factors / numpy.fmax(1, abs(factors))).real)

    def growth(self, values: numpy.ndarray) -> numpy.ndarray:
        return numpy.log(abs(values) + 1e-300) if self.is_map else values.real

    def count_unstable(self, values: numpy.ndarray) -> int:
        """Returns the number of eigenvalues or multipliers of motions that grow."""
        most = 1e-6 if self.is_map else 1e-7 * abs(values).max(initial=0.0)
        return int((self.growth(values) > most).sum())
