"""One particle: its mass and place; and which components are of one place, by their names.

The names of x, y and z differ in that letter alone, wherever it stands: x and y; x1[2] and y1[2];
rx, ry and rz; a_x and a_y; X and Y. Two of them are a plane.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from typing import TypeVar

from ...equations import Row
from ...graph.graph import Node
from ...model import Model
from ...record import record

AXES = "xyz"
Key = tuple[Hashable, int]  # what the components of one place share, and which of them it is
Item = TypeVar("Item")


class NoParticles(Exception):
    """And why."""

    def __init__(self, why: str):
        super().__init__(why)
        self.why = why


@record
class Body:
    mass: Node
    place: Row  # of three, 0 beside a plane
    name: str  # "(x, y)"


def lengths(model: Model) -> frozenset[str]:
    """The names of coordinates, definitions and outputs that are lengths; all, without units."""
    items = (*model.coordinates, *model.definitions, *model.observed)
    return frozenset(item.name for item in items if model.dimensionless or item.unit == "m")


def keys(name: str, index: int | None = None) -> Iterator[Key]:
    for k, letter in enumerate(name):
        if letter.lower() in AXES:
            shared = name[:k], name[k + 1 :], letter.islower(), index
            yield shared, AXES.index(letter.lower())


def places(items: Iterable[tuple[Item, Iterable[Key]]]) -> list[dict[int, Item]]:
    """Of things with keys those that share one, by axis: two or three; the largest first."""
    by_key: dict[Hashable, list[tuple[int, Item]]] = {}
    for item, known in items:
        for shared, axis in known:
            by_key.setdefault(shared, []).append((axis, item))
    found = [dict(sorted(group)) for group in by_key.values()]
    return sorted((group for group in found if len(group) > 1), key=len, reverse=True)


def listed(names: tuple[str, ...]) -> str:
    """Up to four of them."""
    return ", ".join(names[:4]) + (", ..." if names[4:] else "")
