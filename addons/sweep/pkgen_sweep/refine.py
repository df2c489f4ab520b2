"""Refines a grid near the boundary between classes of members.

A cell whose corners have different classes is halved along each axis; the new corners are the
members of the next level. So members depend only on the classes of the previous levels, not on the
engine or the order of work.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from pkgen.record import record


@record(eq=False)
class Level:
    """A level of refinement: a grid with `shape` points along its axes. `points` has the sorted
    flat indices of the members, which are points of the grid; `classes` has their classes. `cells`
    has the grid cells that may be refined, as flat indices of their lowest corners."""

    shape: tuple[int, ...]
    points: np.ndarray
    classes: np.ndarray
    cells: np.ndarray

    def next(self) -> tuple[Level, np.ndarray]:
        """Returns the next level, whose grid is twice as fine, and the flat indices of its new
        points. Their classes are UNKNOWN until known() sets them."""
        mixed = self._mixed()
        fine = tuple(2 * n - 1 for n in self.shape)
        corners = np.array(list(product((0, 1), repeat=len(self.shape))))
        coarse = np.stack(np.unravel_index(mixed, self.shape), axis=1)
        cells = (2 * coarse[:, None, :] + corners[None]).reshape(-1, len(self.shape))
        wanted = (cells[:, None, :] + corners[None]).reshape(-1, len(self.shape))
        wanted = np.unique(_flat(wanted, fine))
        old = _flat(2 * np.stack(np.unravel_index(self.points, self.shape), axis=1), fine)
        there = np.isin(old, wanted, assume_unique=True)
        new = np.setdiff1d(wanted, old, assume_unique=True)
        classes = np.full(len(wanted), UNKNOWN)
        classes[np.searchsorted(wanted, old[there])] = self.classes[there]
        return Level(fine, wanted, classes, _flat(cells, fine)), new

    def known(self, new: np.ndarray, classes: np.ndarray) -> Level:
        """Sets the classes of the new points; returns the level."""
        filled = self.classes.copy()
        filled[np.searchsorted(self.points, new)] = classes
        return Level(self.shape, self.points, filled, self.cells)

    def _mixed(self) -> np.ndarray:
        """Returns the cells whose corners have different classes."""
        at = np.stack(np.unravel_index(self.cells, self.shape), axis=1)
        first, mixed = None, np.zeros(len(at), bool)
        for corner in product((0, 1), repeat=len(self.shape)):
            flat = _flat(at + np.array(corner), self.shape)
            found = self.classes[np.searchsorted(self.points, flat)]
            first = found if first is None else first
            mixed |= found != first
        return self.cells[mixed]


UNKNOWN = np.iinfo(np.int64).min


def _flat(places: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    return np.ravel_multi_index(tuple(places.T), shape).astype(np.int64)


def begun(shape: tuple[int, ...], classes: np.ndarray) -> Level:
    """Returns the first level: the plan's grid, with all points and cells."""
    points = np.arange(len(classes), dtype=np.int64)
    places = np.stack(np.unravel_index(points, shape), axis=1)
    inside = (places < np.array(shape) - 1).all(axis=1)
    return Level(shape, points, classes.astype(np.int64), points[inside])
