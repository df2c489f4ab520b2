"""The least-squares solution: Gauss-Newton in a trust region (SciPy), from several starts.

The error of a frequency has many local minima over a long record, but few over a short one: each
start is first improved on a sixteenth of the record, the best of them on longer parts, up to all.
Parts with too few samples are left out. With 24 starts this takes a fifth to a thirtieth of the
time that all starts on the whole record take.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy

from pkgen.system.exits import NumericsFailed, UsageError

from .problem import Problem, Unknown

if TYPE_CHECKING:
    from numpy.typing import NDArray

PARTS = (1 / 16, 1 / 4, 1.0)  # parts of the record
KEPT = (6, 3)  # solutions that go on to the next part
TRIES = 24
WIDE = 10.0  # an unbounded parameter starts between its value divided and multiplied by this
STEPS = (12, 25, 200)  # evaluations of a start on each part
# The loss is linear beyond so many standard deviations: 95 % efficient for normal errors;
# P. J. Huber, Robust Statistics (1981).
HUBER = 1.345


def starts(unknowns: list[Unknown], tries: int) -> Iterator[NDArray[Any]]:
    """Yields the given values, then points spread around them."""
    from scipy.stats import qmc

    x0 = numpy.array([u.value for u in unknowns])
    lower, upper = (numpy.array([getattr(u, end) for u in unknowns]) for end in ("lower", "upper"))
    yield numpy.clip(x0, lower, upper)
    for part in qmc.Halton(len(x0), seed=1).random(max(tries, 0)):
        x = x0 * WIDE ** (2 * part - 1)
        x = numpy.where(x0 == 0, 2 * part - 1, x)
        inside = numpy.isfinite(lower) & numpy.isfinite(upper)
        x[inside] = lower[inside] + part[inside] * (upper - lower)[inside]
        for i, unknown in enumerate(unknowns):
            if unknown.experiment is not None:  # a start estimated from the data
                x[i] = x0[i]
        yield numpy.clip(x, lower, upper)


def solve(problem: Problem, tries: int, huber: bool) -> NDArray[Any]:
    """Returns the unknowns of least squares. Raises UsageError, NumericsFailed."""
    try:
        import scipy.optimize  # noqa: F401
    except ImportError:
        raise UsageError("pkgen fit needs SciPy: pip install 'pkgen-lag[analysis]'") from None
    least = max(3 * len(problem.unknowns), 8)
    count = max(len(e.t) for e in problem.experiments)
    parts = [part for part in PARTS if part == 1 or part * count >= least]
    points = [*starts(list(problem.unknowns), tries)]
    for part, steps in zip(parts, STEPS[-len(parts) :], strict=True):
        found = [local(problem, x, part, steps, huber) for x in points]
        best = sorted((one for one in found if one is not None), key=lambda one: one[0])
        if not best:
            why = f": {problem.failed}" if problem.failed else ""
            raise NumericsFailed(f"no run from {len(points)} starts reaches the data{why}")
        kept = KEPT[0] if part < 0.1 else KEPT[1]
        points = _distinct([x for _, x in best])[:kept]
        if part < 1:  # the given values may be right where a short record shows nothing
            points.append(numpy.array([u.value for u in problem.unknowns]))
    return points[0]


def local(
    problem: Problem, x: NDArray[Any], part: float, steps: int, huber: bool
) -> tuple[float, NDArray[Any]] | None:
    """Returns the cost and the unknowns of the local minimum near x; None if no run succeeds."""
    from scipy.optimize import least_squares

    kept: dict[bytes, Any] = {}

    def at(x: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        key = x.tobytes()
        if key not in kept:
            kept.clear()
            found = problem(x, part)
            kept[key] = (numpy.full(size, numpy.nan), None) if found is None else found
        return kept[key]

    first = problem(x, part)
    if first is None:
        return None
    size = len(first[0])
    kept[x.tobytes()] = first
    bounds = [[getattr(u, end) for u in problem.unknowns] for end in ("lower", "upper")]
    how = {"loss": "huber", "f_scale": HUBER} if huber else {}
    found = least_squares(
        lambda x: at(x)[0],
        x,
        jac=lambda x: at(x)[1],
        bounds=bounds,
        x_scale="jac",
        max_nfev=steps,
        **dict.fromkeys(("ftol", "xtol", "gtol"), 1e-12 if part == 1 else 1e-6),
        **how,
    )
    return float(found.cost), found.x


def _distinct(points: list[NDArray[Any]]) -> list[NDArray[Any]]:
    found: list[NDArray[Any]] = []
    for x in points:
        if all(abs(x - y).max() > 1e-6 * abs(y).max() for y in found):
            found.append(x)
    return found
