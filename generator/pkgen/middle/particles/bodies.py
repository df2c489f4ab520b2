"""A particle with its mass and position (in the code: place), and the grouping of scalar quantities
to positions by their names.

The names of the components of a position differ only in the letter x, y or z: x and y; x1[2] and
y1[2]; rx, ry and rz; a_x and a_y; X and Y. Two components make a position in a plane.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from typing import TypeVar

from ...equations import Row
from ...graph.graph import Node
from ...model import Model
from ...record import record

AXES = "xyz"
# The key of a component of a position: the part of the name that all components of the position
# share, and the axis 0, 1 or 2.
Key = tuple[Hashable, int]
Item = TypeVar("Item")


class NoParticles(Exception):
    """No particles were found. The text is the reason."""


@record
class Body:
    mass: Node
    place: Row  # The components x, y and z of the position; z is 0 in a plane.
    name: str  # The name of the position, such as "(x, y)".


def lengths(model: Model) -> frozenset[str]:
    """Returns the names of coordinates, definitions and outputs with the unit m. If the model is
    dimensionless, returns all names."""
    items = (*model.coordinates, *model.definitions, *model.observed)
    return frozenset(item.name for item in items if model.dimensionless or item.unit == "m")


def keys(name: str, index: int | None = None) -> Iterator[Key]:
    for k, letter in enumerate(name):
        if letter.lower() in AXES:
            shared = name[:k], name[k + 1 :], letter.islower(), index
            yield shared, AXES.index(letter.lower())


def places(items: Iterable[tuple[Item, Iterable[Key]]]) -> list[dict[int, Item]]:
    """Groups items with the same key to positions of two or three components. Each group maps axes
    to items. Larger groups come first."""
    by_key: dict[Hashable, list[tuple[int, Item]]] = {}
    for item, known in items:
        for shared, axis in known:
            by_key.setdefault(shared, []).append((axis, item))
    found = [dict(sorted(group)) for group in by_key.values()]
    return sorted((group for group in found if len(group) > 1), key=len, reverse=True)


def listed(names: tuple[str, ...]) -> str:
    """Returns the names as text; after four names the text ends with "..."."""
    return ", ".join(names[:4]) + (", ..." if names[4:] else "")
