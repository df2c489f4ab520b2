"""One particle, its mass and place; and grouping of the components of a place by their names.

Names of the components of a place differ only in the letter x, y or z, at any position: x and y;
x1[2] and y1[2]; rx, ry and rz; a_x and a_y; X and Y. Two components make a place in a plane.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from typing import TypeVar

from ...equations import Row
from ...graph.graph import Node
from ...model import Model
from ...record import record

AXES = "xyz"
Key = tuple[Hashable, int]  # the part of the name shared by a place, and the axis 0, 1, 2
Item = TypeVar("Item")


class NoParticles(Exception):
    """No particles were found; `why` is the reason."""

    def __init__(self, why: str):
        super().__init__(why)
        self.why = why


@record
class Body:
    mass: Node
    place: Row  # three components, z = 0 in a plane
    name: str  # "(x, y)"


def lengths(model: Model) -> frozenset[str]:
    """Returns names of coordinates, definitions and outputs with unit m; all, without units."""
    items = (*model.coordinates, *model.definitions, *model.observed)
    return frozenset(item.name for item in items if model.dimensionless or item.unit == "m")


def keys(name: str, index: int | None = None) -> Iterator[Key]:
    for k, letter in enumerate(name):
        if letter.lower() in AXES:
            shared = name[:k], name[k + 1 :], letter.islower(), index
            yield shared, AXES.index(letter.lower())


def places(items: Iterable[tuple[Item, Iterable[Key]]]) -> list[dict[int, Item]]:
    """Groups two or three items that share a key, as item by axis; the largest groups first."""
    by_key: dict[Hashable, list[tuple[int, Item]]] = {}
    for item, known in items:
        for shared, axis in known:
            by_key.setdefault(shared, []).append((axis, item))
    found = [dict(sorted(group)) for group in by_key.values()]
    return sorted((group for group in found if len(group) > 1), key=len, reverse=True)


def listed(names: tuple[str, ...]) -> str:
    """Returns up to four names as text."""
    return ", ".join(names[:4]) + (", ..." if names[4:] else "")
