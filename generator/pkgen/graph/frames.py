"""Turned frames: chains of rotations about fixed axes, and derivatives by their angular velocity.

The columns of R = R_1 R_2 ... R_k are nodes of the graph as any other. That they turn as one is
known besides: along any direction a column c changes by w x c, where w is the sum of the axes times
the changes of their angles; and a gradient by the columns is a torque, whose part along its axis is
the slope by an angle. So derivatives cost as much a link as its own turn, however deep it stands.
Reference: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, chapter 2.
"""

from __future__ import annotations

from collections.abc import Callable

from .frame_table import ROOT, Frame, Turn, Vector3
from .graph import ONE, ZERO, Graph, Node

DEEP = 3  # turns; of fewer the entries are short themselves
UNITS: tuple[Vector3, ...] = ((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE))


def cross(g: Graph, a: Vector3, b: Vector3) -> Vector3:
    return tuple(
        g.subtract(g.multiply(a[i], b[j]), g.multiply(a[j], b[i]))
        for i, j in ((1, 2), (2, 0), (0, 1))
    )


def dot(g: Graph, a: Vector3, b: Vector3) -> Node:
    return g.sum(g.multiply(i, j) for i, j in zip(a, b, strict=True))


def added(g: Graph, a: Vector3, b: Vector3) -> Vector3:
    return tuple(g.add(i, j) for i, j in zip(a, b, strict=True))


def combined(g: Graph, columns: tuple[Vector3, ...], a: Vector3) -> Vector3:
    """The vector whose components along the columns are those of a."""
    rows = zip(*columns, strict=True)
    return tuple(g.sum(g.multiply(c, i) for c, i in zip(row, a, strict=True)) for row in rows)


def columns(
    g: Graph, turns: tuple[Turn, ...], turned: Callable[..., Vector3]
) -> tuple[Vector3, ...]:
    """Those of the product of the turns; `turned` is that of a vector by one of them."""
    frame: int | None = ROOT
    found, known = UNITS, g.frames.known
    for k, (axis, angle) in enumerate(turns):
        key = turns[: k + 1]
        if key not in known:
            local = tuple(turned(g, axis, angle, unit) for unit in UNITS)
            made = tuple(combined(g, found, a) for a in local)
            if frame is not None:
                frame = _frame(g, frame, combined(g, found, axis), angle, made, k)
            known[key] = frame, made
        frame, found = known[key]
    return found


def _frame(
    g: Graph,
    parent: int,
    axis: Vector3,
    angle: Node,
    columns: tuple[Vector3, ...],
    before: int,
) -> int | None:
    """That of the last turn, the parent's where its angle is constant; None where a gradient
    could not be swept frame by frame, since an entry stood there before."""
    frames, fixed = g.frames, g.is_constant(angle)
    places = {
        node: (parent if fixed else len(frames.all), column, i)
        for column in columns
        for i, node in enumerate(column)
        if not g.is_constant(node) and node not in frames.own
    }
    lowest = max(angle, ZERO if parent == ROOT else frames.all[parent].first)
    if not fixed and (not places or min(places) <= lowest):
        return None
    frames.own.update(places)
    if before + 1 >= DEEP:
        frames.entries.update(places)
    if fixed:
        return parent
    frames.all.append(Frame(parent, axis, angle, min(places)))
    return len(frames.all) - 1


class Turning:
    """How frames turn along one direction, given the changes of their angles."""

    def __init__(self, g: Graph, change: Callable[[Node], Node]):
        self.graph = g
        self.change = change
        self.known: dict[int, Vector3] = {ROOT: (ZERO, ZERO, ZERO)}

    def __call__(self, entry: Node) -> Node:
        """The change of an entry."""
        g = self.graph
        frame, vector, i = g.frames.entries[entry]
        return cross(g, self._rate(frame), vector)[i]

    def _rate(self, index: int) -> Vector3:
        g, frames = self.graph, self.graph.frames.all
        chain: list[int] = []
        at = index
        while at not in self.known:
            chain.append(at)
            at = frames[at].parent
        for k in reversed(chain):
            change = self.change(frames[k].angle)
            turn = tuple(g.multiply(change, i) for i in frames[k].axis)
            self.known[k] = added(g, self.known[frames[k].parent], turn)
        return self.known[index]


class Torques:
    """A gradient's parts by the entries of frames, which are swept from the deepest."""

    def __init__(self, g: Graph):
        self.graph = g
        self.pulls: dict[int, dict[Vector3, list[Node]]] = {}
        self.torque: dict[int, Vector3] = {}

    def pull(self, entry: Node, bar: Node) -> None:
        frame, vector, i = self.graph.frames.entries[entry]
        self.pulls.setdefault(frame, {}).setdefault(vector, [ZERO] * 3)[i] = bar

    def angles(self, above: Node) -> list[tuple[Node, Node]]:
        """The slopes by the angles of all frames whose entries are above a node."""
        g, frames, found = self.graph, self.graph.frames.all, []
        while waiting := self.pulls.keys() | self.torque.keys():
            k = max(waiting, key=lambda x: frames[x].first)
            frame = frames[k]
            if frame.first <= above:
                break
            torque = self.torque.pop(k, (ZERO, ZERO, ZERO))
            for vector, bar in sorted(self.pulls.pop(k, {}).items()):
                torque = added(g, torque, cross(g, vector, tuple(bar)))
            found.append((frame.angle, dot(g, frame.axis, torque)))
            if frame.parent != ROOT:
                before = self.torque.get(frame.parent, (ZERO, ZERO, ZERO))
                self.torque[frame.parent] = added(g, before, torque)
        return found
