"""The residuals of a fit and their derivatives, exact for the numerical solution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy

from pkgen.analysis.sensitivity.forward import Sensitivities
from pkgen.analysis.sensitivity.tape import ran
from pkgen.api.prepare import Prepared
from pkgen.record import record
from pkgen.run import named
from pkgen.system.exits import NumericsFailed

from .data import Experiment

if TYPE_CHECKING:
    from numpy.typing import NDArray


MOST_STEPS = 20_000  # steps of a run; values tried on the way may make a motion very fast


@record
class Unknown:
    """A parameter, or the start of a coordinate, rate or state in one experiment (None: in all)."""

    name: str
    unit: str
    value: float
    lower: float = -numpy.inf
    upper: float = numpy.inf
    experiment: int | None = None
    prior: tuple[float, float] | None = None  # value and standard deviation
    of: str = ""  # its name in the run, "" the same

    @property
    def inner(self) -> str:
        return self.of or self.name

    def shown(self, experiments: int) -> str:
        several = self.experiment is not None and experiments > 1
        return f"{self.name}#{self.experiment + 1}" if several else self.name


class Problem:
    """Sums of squares over all experiments; `scale` has the standard deviation of each column."""

    def __init__(
        self,
        runs: Sequence[Prepared],
        experiments: Sequence[Experiment],
        unknowns: Sequence[Unknown],
        scale: Mapping[str, float],
    ):
        self.runs, self.experiments = runs, experiments
        self.unknowns, self.scale = unknowns, dict(scale)
        self.evaluations = 0
        self.failed = ""  # why the last run that failed did so

    @property
    def columns(self) -> list[str]:
        return [*dict.fromkeys(name for e in self.experiments for name in e.columns)]

    def changed(self, x: NDArray[Any], k: int, until: float) -> Prepared:
        """Returns the run of experiment k at the unknowns x."""
        prepared = self.runs[k]
        of, settings = prepared.compilation, prepared.settings
        q, v = (named.coordinates(of, rates=r) for r in (False, True))
        into = {"parameters": named.parameters(of), "inputs": named.inputs(of)}
        into |= {"start_q": q, "start_v": v}
        lists = {key: dict(getattr(settings, key)) for key in into}
        for unknown, value in zip(self.unknowns, x, strict=True):
            if unknown.experiment in (None, k):
                key = next(key for key, names in into.items() if unknown.inner in names)
                lists[key][into[key][unknown.inner][0]] = float(value)
        given = {key: tuple(values.items()) for key, values in lists.items()}
        given["max_steps"] = min(settings.max_steps or MOST_STEPS, MOST_STEPS)
        return replace(prepared, settings=replace(settings, until=until, every=until, **given))

    def one(self, x: NDArray[Any], k: int, horizon: float) -> dict[str, tuple[Any, Any]] | None:
        """Returns for each column of experiment k its values and derivatives, of shapes (samples,)
        and (samples, unknowns), up to a part of its time; None if the run fails."""
        e = self.experiments[k]
        within = e.t <= horizon * e.t[-1]
        until = float(e.t[within][-1])
        run = self.changed(x, k, until)
        self.evaluations += 1
        mine = [i for i, u in enumerate(self.unknowns) if u.experiment in (None, k)]
        try:
            tape = ran(run)
            found = Sensitivities(tape, [self.unknowns[i].inner for i in mine], e.t[within])
            values = {}
            for name in e.columns:
                slopes = numpy.zeros((within.sum(), len(x)))
                slopes[:, mine] = found.of(name)
                values[name] = found.values(name), slopes
        except NumericsFailed as error:
            self.failed = str(error)
            return None
        return values

    def __call__(
        self, x: NDArray[Any], horizon: float = 1.0
    ) -> tuple[NDArray[Any], NDArray[Any]] | None:
        """Returns the residuals in units of their standard deviations, and their derivatives; None
        if a run fails. Missing samples are left out; priors come last."""
        residuals, slopes = [], []
        for k, e in enumerate(self.experiments):
            found = self.one(x, k, horizon)
            if found is None:
                return None
            for name, (values, by) in found.items():
                data = e.columns[name][: len(values)]
                known = numpy.isfinite(data)
                residuals.append((values - data)[known] / self.scale[name])
                slopes.append(by[known] / self.scale[name])
        for i, unknown in enumerate(self.unknowns):
            if unknown.prior:
                residuals.append(numpy.array([(x[i] - unknown.prior[0]) / unknown.prior[1]]))
                slopes.append(numpy.eye(len(x))[i : i + 1] / unknown.prior[1])
        residual, slope = numpy.concatenate(residuals), numpy.concatenate(slopes)
        good = numpy.isfinite(residual).all() and numpy.isfinite(slope).all()
        return (residual, slope) if good else None

    def rms(self, x: NDArray[Any]) -> dict[str, float]:
        """Returns the root mean square of the residuals of each column, in SI."""
        sums = {name: [0.0, 0] for name in self.columns}
        for k, e in enumerate(self.experiments):
            for name, (values, _) in (self.one(x, k, 1.0) or {}).items():
                gap = (values - e.columns[name])[numpy.isfinite(e.columns[name])]
                sums[name][0] += float(gap @ gap)
                sums[name][1] += len(gap)
        return {name: (total / max(count, 1)) ** 0.5 for name, (total, count) in sums.items()}
