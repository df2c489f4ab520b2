"""Which nodes of a graph are entries of turned frames; what is done with them: frames.py."""

from __future__ import annotations

from collections.abc import Mapping

from ..record import record
from .nodes import CONSTANT, Node

Vector3 = tuple[Node, Node, Node]
Turn = tuple[Vector3, Node]  # a unit vector fixed in the frame before, and an angle
ROOT = -1  # what does not turn


@record
class Frame:
    """`axis` is that of the last turn, as seen from outside all; `first` the least of the entries
    that are its own, not those of a frame before."""

    parent: int
    axis: Vector3
    angle: Node
    first: Node


class Frames:
    """Those of a graph; `entries` has by node its frame, a vector fixed in that, and which of its
    components the node is."""

    def __init__(self) -> None:
        self.all: list[Frame] = []
        self.entries: dict[Node, tuple[int, Vector3, int]] = {}
        self.own: set[Node] = set()
        self.known: dict[tuple[Turn, ...], tuple[int | None, tuple[Vector3, ...]]] = {}

    def turning(self, mask: int) -> Mapping[Node, tuple[int, Vector3, int]]:
        """The entries, where these kinds of symbol vary: none where parameters do, which may be in
        axes and in fixed angles."""
        return {} if mask & CONSTANT else self.entries

    def copy(self) -> Frames:
        result = Frames()
        for name, value in vars(self).items():
            setattr(result, name, value.copy())
        return result
