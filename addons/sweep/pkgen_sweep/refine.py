"""Refines a grid where classes change: members of finer grids near the boundary between classes.

A cell whose corners are of several classes is halved along each axis; new corners of the pieces are
the members of the next level. So members depend only on the classes of the previous levels, not on
the engine or the order of work.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from pkgen.record import record


@record(eq=False)
class Level:
    """A level: sorted flat indices of its known points in a grid of `shape`, and their `classes`;
    and the cells that may be refined, by their lowest corners."""

    shape: tuple[int, ...]
    points: np.ndarray
    classes: np.ndarray
    cells: np.ndarray

    def next(self) -> tuple[Level, np.ndarray]:
        """Returns the level of the finer grid, and its new points, whose classes are UNKNOWN until
        known()."""
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
        """Returns the level with the classes of new points."""
        filled = self.classes.copy()
        filled[np.searchsorted(self.points, new)] = classes
        return Level(self.shape, self.points, filled, self.cells)

    def _mixed(self) -> np.ndarray:
        """Returns the cells whose corners are of several classes."""
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
    """Returns the level of a plan's grid, with all points and all cells."""
    points = np.arange(len(classes), dtype=np.int64)
    places = np.stack(np.unravel_index(points, shape), axis=1)
    inside = (places < np.array(shape) - 1).all(axis=1)
    return Level(shape, points, classes.astype(np.int64), points[inside])
