"""The starts of members. Each start is a function of the plan and the member's number only.

Random numbers are from the generator Philox. Each member has its own range of the generator's
counter, so that its numbers do not depend on the division into shards. Sobol' points are from
SciPy. The strata of a Latin hypercube are permuted by a Feistel network, which computes the image
of a number without those of other numbers.
"""

from __future__ import annotations

import math
import warnings

import numpy as np

from pkgen.record import record
from pkgen.run.ensemble import Column

WORDS = 4  # 64-bit words in a block of Philox
SOBOL_BITS = 32
_ROUNDS = 6


@record
class Axis:
    """A sampled quantity, in SI: a range (on a grid, with a number of points), or a list."""

    column: Column
    lo: float = 0.0
    hi: float = 0.0
    points: int = 0
    values: tuple[float, ...] = ()

    def spread(self, u: np.ndarray) -> np.ndarray:
        """Maps numbers in [0, 1) to the range of the axis."""
        return np.minimum(self.lo + (self.hi - self.lo) * u, self.hi)

    def on_grid(self) -> np.ndarray:
        return np.array(self.values) if self.values else np.linspace(self.lo, self.hi, self.points)


@record
class Starts:
    """The starts of all members, by one kind of sampling."""

    kind: str
    axes: tuple[Axis, ...]
    members: int
    seed: int
    numbers: np.ndarray | None = None  # flat indices in the grid, for kind "points"

    @property
    def columns(self) -> tuple[Column, ...]:
        return tuple(axis.column for axis in self.axes)

    def values(self, first: int, count: int) -> np.ndarray:
        """Returns the starts of `count` members from `first` (from 0), of shape (count, axes)."""
        found = np.empty((count, len(self.axes)))
        for k, x in enumerate(_KINDS[self.kind](self, first, count)):
            found[:, k] = x
        return found


def _uniform(starts: Starts, first: int, count: int) -> np.ndarray:
    """Returns random numbers in [0, 1), of shape (axes, count)."""
    blocks = -(-len(starts.axes) // WORDS)
    made = np.random.Philox(key=starts.seed, counter=first * blocks)
    raw = made.random_raw(count * blocks * WORDS).reshape(count, blocks * WORDS)
    return (raw[:, : len(starts.axes)].T >> np.uint64(11)) * 2.0**-53


def _random(starts: Starts, first: int, count: int) -> list[np.ndarray]:
    u = _uniform(starts, first, count)
    return [axis.spread(u[k]) for k, axis in enumerate(starts.axes)]


def _latin(starts: Starts, first: int, count: int) -> list[np.ndarray]:
    u, n = _uniform(starts, first, count), starts.members
    numbers = np.arange(first, first + count, dtype=np.uint64)
    strata = [permuted(numbers, n, starts.seed, k) for k in range(len(starts.axes))]
    return [axis.spread((strata[k] + u[k]) / n) for k, axis in enumerate(starts.axes)]


def permuted(numbers: np.ndarray, n: int, seed: int, axis: int) -> np.ndarray:
    """Returns the images of numbers in a random permutation of 0, ..., n - 1. An image >= n is
    permuted again until it is smaller (cycle walking)."""
    half = max(1, (max(1, n - 1).bit_length() + 1) // 2)
    keys = np.random.Philox(key=seed, counter=(1 << 128) + axis * _ROUNDS).random_raw(_ROUNDS)
    found = _feistel(numbers, half, keys)
    while len(beyond := np.flatnonzero(found >= n)):
        found[beyond] = _feistel(found[beyond], half, keys)
    return found


def _feistel(x: np.ndarray, half: int, keys: np.ndarray) -> np.ndarray:
    """Applies a Feistel network: a permutation of the integers that have 2 * `half` bits."""
    mask, bits = np.uint64((1 << half) - 1), np.uint64(half)
    left, right = x >> bits, x & mask
    for key in keys:
        z = (right + key) * np.uint64(0x9E3779B97F4A7C15)  # the mixing function of SplitMix64
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        left, right = right, left ^ ((z ^ (z >> np.uint64(31))) & mask)
    return (left << bits) | right


def _sobol(starts: Starts, first: int, count: int) -> list[np.ndarray]:
    from scipy.stats import qmc

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # SciPy warns if `count` is not a power of 2.
        made = qmc.Sobol(len(starts.axes), scramble=True, bits=SOBOL_BITS, seed=starts.seed)
        if first:
            made.fast_forward(first)
        u = made.random(count).T
    return [axis.spread(u[k]) for k, axis in enumerate(starts.axes)]


def _grid(starts: Starts, first: int, count: int) -> list[np.ndarray]:
    """Returns points of the grid; the last axis varies fastest."""
    number = np.arange(first, first + count)
    found = []
    for axis in reversed(starts.axes):
        points = axis.on_grid()
        number, digit = np.divmod(number, len(points))
        found.append(points[digit])
    return found[::-1]


def _points(starts: Starts, first: int, count: int) -> list[np.ndarray]:
    axes = [axis.on_grid() for axis in starts.axes]
    shape = tuple(map(len, axes))
    digits = np.unravel_index(starts.numbers[first : first + count], shape)
    return [points[digit] for points, digit in zip(axes, digits, strict=True)]


def _list(starts: Starts, first: int, count: int) -> list[np.ndarray]:
    return [np.array(axis.values[first : first + count]) for axis in starts.axes]


_KINDS = {
    **{"random": _random, "latin": _latin, "sobol": _sobol},
    **{"grid": _grid, "list": _list, "points": _points},
}


def on_grid(axes: tuple[Axis, ...]) -> int:
    return math.prod(len(axis.values) or axis.points for axis in axes)
