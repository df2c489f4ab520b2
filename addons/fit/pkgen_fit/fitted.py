"""The result of a fit: values, standard deviations, correlations, residuals and their picture."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy

from pkgen.record import record
from pkgen.system.exits import NumericsFailed

from .problem import Problem

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

UNSEEN = 1e-6  # relative singular value of a direction that the data do not determine
AT_BOUND = 1e-3  # distance from a bound, in standard deviations
# Smallest relative norm of a Jacobian column; below it the unknown has no influence.
WITHOUT = 1e-9


@record
class Estimate:
    value: float
    sigma: float
    unit: str


class Fitted:
    """`parameters` has an Estimate by name; `covariance` and `correlation` are in their order;
    `rms` has the root mean square of the residuals by column, in SI."""

    def __init__(self, problem: Problem, x: NDArray[Any], estimated: bool):
        """`estimated`: the standard deviations of the data are those of the residuals."""
        found = problem(x)
        if found is None:
            raise NumericsFailed(f"the run at the solution failed: {problem.failed}")
        residual, slope = found
        self._problem, self.x = problem, x
        names = [u.shown(len(problem.experiments)) for u in problem.unknowns]
        size = numpy.array([abs(v) if v else 1.0 for v in x])
        _identified(slope * size, names)
        self.covariance: NDArray[Any] = numpy.linalg.inv(slope.T @ slope)
        self.samples, free = len(residual), len(residual) - len(x)
        if estimated:
            self.covariance *= len(residual) / max(free, 1)
        sigma = numpy.sqrt(numpy.diag(self.covariance))
        self.correlation: NDArray[Any] = self.covariance / numpy.outer(sigma, sigma)
        self.parameters = {
            name: Estimate(float(v), float(s), u.unit)
            for name, v, s, u in zip(names, x, sigma, problem.unknowns, strict=True)
        }
        self.rms = problem.rms(x)
        self.chi2 = None if estimated else float(residual @ residual)
        self.at_bounds = [
            name
            for name, v, s, u in zip(names, x, sigma, problem.unknowns, strict=True)
            if min(abs(v - u.lower), abs(v - u.upper)) <= AT_BOUND * s
        ]

    @property
    def values(self) -> dict[str, float]:
        """The values by name: `m.params.update(found.values)` if only parameters are free."""
        return {name: one.value for name, one in self.parameters.items()}

    def residuals(self) -> dict[str, list[tuple[NDArray[Any], NDArray[Any]]]]:
        """Returns for each column, and each experiment, the times and model - data, in SI."""
        found: dict[str, list[tuple[NDArray[Any], NDArray[Any]]]] = {}
        for k, e in enumerate(self._problem.experiments):
            for name, (values, _) in (self._problem.one(self.x, k, 1.0) or {}).items():
                found.setdefault(name, []).append((e.t, values - e.columns[name]))
        return found

    def record(self) -> dict[str, Any]:
        """Returns what `--json` prints."""
        names = [*self.parameters]
        return {
            "parameters": {
                name: {"value": one.value, "sigma": one.sigma, "unit": one.unit}
                for name, one in self.parameters.items()
            },
            "correlation": {
                a: dict(zip(names, map(float, row), strict=True))
                for a, row in zip(names, self.correlation, strict=True)
            },
            "rms": self.rms,
            "samples": self.samples,
            "chi2": self.chi2,
            "at_bounds": self.at_bounds,
            "evaluations": self._problem.evaluations,
        }

    def text(self) -> str:
        lines = []
        for name, one in self.parameters.items():
            unit = f" {one.unit}" if one.unit else ""
            digits = _digits(one.value, one.sigma)
            lines.append(f"{name} = {one.value:.{digits}g} +- {one.sigma:.2g}{unit}")
        names = [*self.parameters]
        for i, a in enumerate(names):
            for j in range(i):
                if abs(self.correlation[i, j]) > 0.9:
                    lines.append(f"{names[j]} and {a} are correlated: {self.correlation[i, j]:.3f}")
        lines += [f"{name} is at its bound" for name in self.at_bounds]
        lines += [f"rms of {name}: {x:.4g}" for name, x in self.rms.items()]
        return "\n".join([*lines, f"{self.samples} samples"])

    def plot(self) -> Figure:
        """Draws over time, for each column, the data beside the motion, and model - data."""
        import matplotlib
        from matplotlib.figure import Figure

        from pkgen.plot import style

        with matplotlib.rc_context(style.LOOK):
            found = self.residuals()
            figure = Figure(figsize=(style.PAGE, 3.2 * len(found)), layout="constrained")
            axes = figure.subplots(2 * len(found), 1, sharex=True)
            for place, (name, each) in enumerate(found.items()):
                above, below = axes[2 * place : 2 * place + 2]
                having = [e for e in self._problem.experiments if name in e.columns]
                for k, (e, (t, gap)) in enumerate(zip(having, each, strict=True)):
                    data = e.columns[name]
                    known = numpy.isfinite(data)
                    above.plot(t[known], (gap + data)[known], color=style.colour(k))
                    above.plot(t, data, ".", ms=3, color=style.colour(k))
                    below.plot(t, gap, ".", ms=3, color=style.colour(k))
                below.axhline(0, color=style.GREY, lw=0.6)
                above.set_ylabel(name)
                below.set_ylabel("model - data")
            axes[-1].set_xlabel("t")
        return figure


def _digits(value: float, sigma: float) -> int:
    """Returns the digits of a value up to the second one of its standard deviation; 9 at most."""
    if not (value and 0 < sigma < math.inf):
        return 9
    return min(max(2 + math.floor(math.log10(abs(value))) - math.floor(math.log10(sigma)), 2), 9)


def _identified(slope: NDArray[Any], names: list[str]) -> None:
    """Raises NumericsFailed if the data do not determine the unknowns; `slope` is by relative
    changes."""
    sizes = numpy.linalg.norm(slope, axis=0)
    for name, size in zip(names, sizes, strict=True):
        if not size > WITHOUT * sizes.max():
            raise NumericsFailed(
                f"{name} has no influence on the data: remove it from --free / --free-start"
            )
    _, s, V = numpy.linalg.svd(slope / sizes)
    s = numpy.concatenate([s, numpy.zeros(len(names) - len(s))])
    unseen = V[s <= UNSEEN * s[0]] / sizes
    if not len(unseen):
        return
    ways = [
        {name: w for name, w in zip(names, 100 * way, strict=True) if abs(w) > 0.1}
        for way in _sparse(unseen)
    ]
    free = " and ".join(name for name in names if any(name in way for way in ways))
    said = [" and ".join(f"{name} by {w:+.3g} %" for name, w in way.items()) for way in ways]
    raise NumericsFailed(
        f"the data do not determine {free}: changing "
        f"{' together has no effect, nor has changing '.join(said)} together has no effect; fix "
        f"{'one' if len(ways) == 1 else len(ways)}, or give a prior"
    )


def _sparse(rows: NDArray[Any]) -> NDArray[Any]:
    """Returns a basis of the same space with many zeros, by elimination with complete pivoting."""
    rows = rows.copy()
    for k in range(len(rows)):
        i, j = numpy.unravel_index(abs(rows[k:]).argmax(), rows[k:].shape)
        rows[[k, k + i]] = rows[[k + i, k]]
        rows[k] /= rows[k, j]
        for other in range(len(rows)):
            if other != k:
                rows[other] -= rows[other, j] * rows[k]
    return rows / abs(rows).max(axis=1, keepdims=True)
