"""Where a class changes: members of finer and finer grids about the boundary between classes.

A cell of a grid whose corners are of several classes is cut in two along each axis; the corners of
the pieces that are new are the members of the next level. So they follow from the classes of the
levels before, whoever ran these, and in which order.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from pkgen.record import record


@record(eq=False)
class Level:
    """Points of a grid of `shape`, by their flat numbers there, in order; and its cells by their
    lowest corners, which may be cut further. `classes` are those of the points."""

    shape: tuple[int, ...]
    points: np.ndarray
    classes: np.ndarray
    cells: np.ndarray

    def next(self) -> tuple[Level, np.ndarray]:
        """The finer grid, with all points whose classes will be known; which of them are new. Their
        classes are to be filled in."""
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
        """With the classes of new points."""
        filled = self.classes.copy()
        filled[np.searchsorted(self.points, new)] = classes
        return Level(self.shape, self.points, filled, self.cells)

    def _mixed(self) -> np.ndarray:
        """Cells whose corners are of several classes."""
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
    """The grid of a plan, all of it known, and all of its cells."""
    points = np.arange(len(classes), dtype=np.int64)
    places = np.stack(np.unravel_index(points, shape), axis=1)
    inside = (places < np.array(shape) - 1).all(axis=1)
    return Level(shape, points, classes.astype(np.int64), points[inside])
