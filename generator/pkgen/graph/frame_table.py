"""The table of nodes that are entries of turned frames; frames.py makes and uses it."""

from __future__ import annotations

from collections.abc import Mapping

from ..record import record
from .nodes import CONSTANT, Node

Vector3 = tuple[Node, Node, Node]
Turn = tuple[Vector3, Node]  # an axis (unit vector) fixed in the previous frame, and an angle
ROOT = -1  # the frame that does not turn


@record
class Frame:
    """`axis` is the axis of the last turn, in coordinates of the root frame. `first` is the least
    of the frame's entries that no earlier frame has."""

    parent: int
    axis: Vector3
    angle: Node
    first: Node


class Frames:
    """The frames of a graph. `entries` maps a node to its frame, a vector fixed in that frame, and
    the index of the vector's component that is the node."""

    def __init__(self) -> None:
        self.all: list[Frame] = []
        self.entries: dict[Node, tuple[int, Vector3, int]] = {}
        self.own: set[Node] = set()
        self.known: dict[tuple[Turn, ...], tuple[int | None, tuple[Vector3, ...]]] = {}

    def turning(self, mask: int) -> Mapping[Node, tuple[int, Vector3, int]]:
        """Returns the entries for derivatives by symbols in the mask. Returns none where the mask
        has parameters: these may be in axes and in fixed angles."""
        return {} if mask & CONSTANT else self.entries

    def copy(self) -> Frames:
        result = Frames()
        for name, value in vars(self).items():
            setattr(result, name, value.copy())
        return result
