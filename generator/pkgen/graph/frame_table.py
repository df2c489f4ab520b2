"""The table of nodes that are entries of rotation matrices; frames.py fills and uses it."""

from __future__ import annotations

from collections.abc import Mapping

from ..record import record
from .nodes import CONSTANT, Node

Vector3 = tuple[Node, Node, Node]
# A rotation, as (axis, angle). The axis is a unit vector in the parent frame.
Turn = tuple[Vector3, Node]
# This number, in place of an index, stands for the space-fixed frame.
ROOT = -1


@record
class Frame:
    """A frame of reference that is rotated by `angle` about `axis` relative to its parent frame.
    `axis` has space-fixed coordinates. The entries of the rotation matrix are nodes; `first` is the
    smallest node number among those that are not entries for an earlier frame."""

    parent: int
    axis: Vector3
    angle: Node
    first: Node


class Frames:
    """The frames of reference of a graph. `entries` maps each node that is a component of a vector
    fixed in a frame to a triple: the index of the frame, the vector, and the index of the
    component."""

    def __init__(self) -> None:
        self.all: list[Frame] = []
        self.entries: dict[Node, tuple[int, Vector3, int]] = {}
        self.own: set[Node] = set()
        self.known: dict[tuple[Turn, ...], tuple[int | None, tuple[Vector3, ...]]] = {}

    def turning(self, mask: int) -> Mapping[Node, tuple[int, Vector3, int]]:
        """Returns the map to use in derivatives by symbols of the kinds in `mask`: `entries`, or an
        empty map if the mask includes parameters. The rules for rotation matrices take axes as
        constant, but axes may contain parameters."""
        return {} if mask & CONSTANT else self.entries

    def copy(self) -> Frames:
        result = Frames()
        for name, value in vars(self).items():
            setattr(result, name, value.copy())
        return result
