"""The optimum: the objective, the inputs over time, the motion and the parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy

from .shooting import Shooting

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from pkgen.api.model import Model
    from pkgen.api.result import Result


class Optimum:
    """`objective` is the least (or largest) value; `t` has the times of the ends of intervals,
    `states` and `inputs` columns there by name (a constant input has one value less), `parameters`
    and `start` values by name."""

    def __init__(self, model: Model, shooting: Shooting, z: NDArray[Any], solver: str, said: str):
        self._model, self._shooting = model, shooting
        found = shooting.evaluated(z)
        assert found
        self.objective = shooting.problem.sign * float(found["objective"])
        self.duration = float(z[shooting.T])
        self.t = numpy.linspace(0, self.duration, shooting.problem.intervals + 1)
        states = numpy.vstack([found["start"], z[shooting.states[1:]]]).T
        self.states = dict(zip(shooting.moving, states, strict=True))
        self.inputs = {name: z[shooting.u[:, j]] for j, name in enumerate(shooting.inputs)}
        values = zip(shooting.parameters, z[shooting.p], strict=True)
        self.parameters = {name: float(x) for name, x in values}
        self.start = {name: float(x[0]) for name, x in self.states.items()}
        self.solver, self.said, self.runs = solver, said, shooting.runs

    def tables(self) -> dict[str, tuple[Any, ...]]:
        """Returns the inputs as Model.run() takes them."""
        if self._shooting.problem.linear:
            return {name: (self.t, u) for name, u in self.inputs.items()}
        return {name: (self.t, numpy.append(u, u[-1]), "hold") for name, u in self.inputs.items()}

    def run(self, **more: Any) -> Result:
        """Makes the whole motion in one run, with the inputs as tables."""
        model = self._model.extended("", {}) if self.parameters else self._model
        model.params.update(self.parameters)
        given = {"start": self.start, "inputs": self.tables(), "until": self.duration}
        return model.run(**(given | more))

    def record(self) -> dict[str, Any]:
        """Returns what `--json` prints."""
        return {
            "objective": self.objective,
            "duration": self.duration,
            "parameters": self.parameters,
            "start": self.start,
            "t": self.t.tolist(),
            "inputs": {name: u.tolist() for name, u in self.inputs.items()},
            "states": {name: x.tolist() for name, x in self.states.items()},
            "solver": self.solver,
            "said": self.said,
            "runs": self.runs,
        }

    def text(self) -> str:
        lines = [f"objective = {self.objective:.9g}", f"duration = {self.duration:.9g}"]
        lines += [f"{name} = {x:.9g}" for name, x in self.parameters.items()]
        names = [*self.inputs, *self.states]
        columns = [*self.inputs.values(), *self.states.values()]
        rows = [["t", *names]]
        for k, t in enumerate(self.t):
            rows.append([f"{t:.6g}", *(f"{x[min(k, len(x) - 1)]:.6g}" for x in columns)])
        lines += ["  ".join(f"{cell:>12}" for cell in row) for row in rows]
        return "\n".join([*lines, f"by {self.solver}, {self.runs} runs of an interval"])

    def plot(self) -> Figure:
        """Draws inputs and states over time."""
        import matplotlib
        from matplotlib.figure import Figure

        from pkgen.plot import style

        columns = {**self.inputs, **self.states}
        with matplotlib.rc_context(style.LOOK):
            size = (style.PAGE, 1.3 * len(columns) + 0.6)
            figure = Figure(figsize=size, layout="constrained")
            axes = figure.subplots(len(columns), 1, sharex=True, squeeze=False)
            for k, (axis, (name, x)) in enumerate(zip(axes[:, 0], columns.items(), strict=True)):
                if len(x) < len(self.t):
                    axis.stairs(x, self.t, baseline=None, color=style.colour(k))
                else:
                    axis.plot(self.t, x, color=style.colour(k))
                axis.set_ylabel(name)
            axes[-1, 0].set_xlabel("t")
        return figure
