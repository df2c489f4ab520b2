"""Derivatives of rotation matrices R = R_1 R_2 ... R_k, a chain of rotations about fixed axes, by
means of the angular velocity.

The entries of R are ordinary nodes of the graph. The table of frames records which nodes form a
matrix. In a forward sweep, a column c of R has the tangent w x c, where w, the angular velocity, is
the sum over rotations of the axis times the tangent of the angle. In a reverse sweep, the adjoints
of the columns add up to a torque, whose component along an axis is the derivative by the angle. The
cost of each rotation is independent of the length of the chain.
Reference: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, chapter 2.
"""

from __future__ import annotations

from collections.abc import Callable

from .frame_table import ROOT, Frame, Turn, Vector3
from .graph import ONE, ZERO, Graph, Node

# The table contains the entries of frames after at least this number of rotations. Entries for
# fewer rotations are short expressions, which are differentiated term by term.
DEEP = 3
UNITS: tuple[Vector3, ...] = ((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE))


def cross(g: Graph, a: Vector3, b: Vector3) -> Vector3:
    return tuple(
        g.subtract(g.multiply(a[i], b[j]), g.multiply(a[j], b[i]))
        for i, j in ((1, 2), (2, 0), (0, 1))
    )


def added(g: Graph, a: Vector3, b: Vector3) -> Vector3:
    return tuple(map(g.add, a, b))


def combined(g: Graph, columns: tuple[Vector3, ...], a: Vector3) -> Vector3:
    """Returns the product of a matrix, given by its columns, and the vector a."""
    return tuple(g.dot(row, a) for row in zip(*columns, strict=True))


def columns(
    g: Graph, turns: tuple[Turn, ...], turned: Callable[..., Vector3]
) -> tuple[Vector3, ...]:
    """Returns the columns of the rotation matrix of a chain of rotations. The function `turned`
    rotates a vector about an axis by an angle."""
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
    """Adds a frame to the table: that after the first `before` rotations of a chain and one more.
    Returns the index of the frame, or that of the parent frame if the angle of the last rotation is
    constant. Returns None if one of the nodes is older than the angle or the parent frame, since a
    reverse sweep then cannot visit the frames one after the other."""
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
    """Tangents of the entries of rotation matrices; `change` returns the tangent of an angle."""

    def __init__(self, g: Graph, change: Callable[[Node], Node]):
        self.graph = g
        self.change = change
        self.known: dict[int, Vector3] = {ROOT: (ZERO, ZERO, ZERO)}

    def __call__(self, entry: Node) -> Node:
        """Returns the tangent of an entry of a rotation matrix."""
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
    """Collects the adjoints of the entries of rotation matrices in a reverse sweep as torques."""

    def __init__(self, g: Graph):
        self.graph = g
        self.pulls: dict[int, dict[Vector3, list[Node]]] = {}
        self.torque: dict[int, Vector3] = {}

    def pull(self, entry: Node, bar: Node) -> None:
        frame, vector, i = self.graph.frames.entries[entry]
        self.pulls.setdefault(frame, {}).setdefault(vector, [ZERO] * 3)[i] = bar

    def angles(self, above: Node) -> list[tuple[Node, Node]]:
        """Returns pairs (angle, derivative by the angle) for all frames whose entries have higher
        node numbers than `above`, and adds the torque of each frame to that of its parent."""
        g, frames, found = self.graph, self.graph.frames.all, []
        while waiting := self.pulls.keys() | self.torque.keys():
            k = max(waiting, key=lambda x: frames[x].first)
            frame = frames[k]
            if frame.first <= above:
                break
            torque = self.torque.pop(k, (ZERO, ZERO, ZERO))
            for vector, bar in sorted(self.pulls.pop(k, {}).items()):
                torque = added(g, torque, cross(g, vector, tuple(bar)))
            found.append((frame.angle, g.dot(frame.axis, torque)))
            if frame.parent != ROOT:
                before = self.torque.get(frame.parent, (ZERO, ZERO, ZERO))
                self.torque[frame.parent] = added(g, before, torque)
        return found
