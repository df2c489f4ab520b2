"""The nonlinear programme: IPOPT (cyipopt) where it is installed, else SciPy's SLSQP."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy

from pkgen.system.exits import NumericsFailed, UsageError

from .shooting import Shooting

if TYPE_CHECKING:
    from numpy.typing import NDArray

SOLVERS = ("ipopt", "slsqp")
CLOSE = 1e-7  # largest violation of a constraint at an optimum, relative to its scale
Found = tuple["NDArray[Any]", str, bool]  # unknowns, the solver's message, whether it converged


class Programme:
    """The programme in the free unknowns x = z/scale, from z with some values fixed."""

    def __init__(
        self, shooting: Shooting, z: NDArray[Any], lower: NDArray[Any], upper: NDArray[Any]
    ):
        self.shooting, self.z = shooting, z.copy()
        self.free = numpy.flatnonzero(lower < upper)
        fixed = lower == upper
        self.z[fixed] = lower[fixed]
        self.scale = self._scale(lower, upper)[self.free]
        self.bounds = [numpy.clip(x[self.free] / self.scale, -1e20, 1e20) for x in (lower, upper)]
        self.start = numpy.clip(self.z[self.free] / self.scale, *self.bounds)
        self.sizes = dict.fromkeys(("equalities", "inequalities"), numpy.ones(1))
        first = self.at(self.start)
        if first is None:
            raise NumericsFailed(f"a motion from the first guess fails: {shooting.failed}")
        near = self.at(self.start + 0.1) or first  # the slope at the guess itself may be 0
        self.objective_scale = (
            max(float(abs(x["gradient"]).max(initial=0)) for x in (first, near)) or 1.0
        )
        for k in self.sizes:  # a violation is a part of the scale of the unknowns
            slopes = [abs(x[f"{k}_by"]).max(axis=1, initial=0) for x in (first, near)]
            size = numpy.maximum(*slopes)
            self.sizes[k] = numpy.where(size > 0, size, 1.0)
        self.counts = len(first["equalities"]), len(first["inequalities"])

    def _scale(self, lower: NDArray[Any], upper: NDArray[Any]) -> NDArray[Any]:
        """Returns sizes of the unknowns: the largest of a column, or a quarter of its range."""
        ends = numpy.where(numpy.isfinite(lower) & numpy.isfinite(upper), upper - lower, 0.0)
        size = numpy.maximum(abs(self.z), ends / 4)
        for columns in (self.shooting.states, self.shooting.u):
            for column in columns.T:
                size[column] = size[column].max()
        return numpy.where(size > 0, size, 1.0)

    def whole(self, x: NDArray[Any]) -> NDArray[Any]:
        z = self.z.copy()
        z[self.free] = x * self.scale
        return z

    def at(self, x: NDArray[Any]) -> dict[str, Any] | None:
        """Returns values and derivatives by x."""
        found = self.shooting.evaluated(self.whole(x))
        if found is None:
            return None
        by = {
            k: found[k][..., self.free] * self.scale
            for k in ("gradient", "equalities_by", "inequalities_by")
        }
        for k, size in self.sizes.items():
            by |= {k: found[k] / size, f"{k}_by": by[f"{k}_by"] / size[:, None]}
        return found | by

    def violation(self, x: NDArray[Any]) -> float:
        found = self.at(x)
        if found is None:
            return numpy.inf
        off = [abs(found["equalities"]).max(initial=0), (-found["inequalities"]).max(initial=0)]
        return float(max(off))


def solved(programme: Programme, solver: str, iterations: int) -> tuple[NDArray[Any], str, str]:
    """Returns the unknowns z, the solver, and its message. Raises NumericsFailed, UsageError."""
    found = None
    if solver in ("", "ipopt"):
        found = _ipopt(programme, iterations)
        if found is None and solver:
            raise UsageError("--solver ipopt needs cyipopt: pip install cyipopt")
    name = "slsqp" if found is None else "ipopt"
    x, said, good = found or _slsqp(programme, iterations)
    off = programme.violation(x)
    if not off <= CLOSE:
        raise NumericsFailed(
            "no motion was found that satisfies the constraints: the largest violation is "
            f"{off:.2g} ({said}): relax them, give more --intervals or --iterations, or begin "
            "nearer by --guess"
        )
    if not good:
        raise NumericsFailed(
            f"the search ended before an optimum ({said}): give more --iterations, --input a "
            "range, or begin nearer by --guess"
        )
    return programme.whole(x), name, said


def _slsqp(programme: Programme, iterations: int) -> Found:
    try:
        from scipy.optimize import minimize
    except ImportError:
        raise UsageError("pkgen optimise needs SciPy: pip install 'pkgen-lag[analysis]'") from None
    equalities, inequalities = programme.counts
    scale = programme.objective_scale
    last: dict[str, Any] = programme.at(programme.start)

    def at(x: NDArray[Any]) -> dict[str, Any]:
        nonlocal last
        found = programme.at(x)
        if found is not None:
            last = found
            return found
        far = {
            "objective": abs(last["objective"]) + 1e6 * scale,
            "equalities": last["equalities"] + 1e3,
        }
        return last | far  # a step that is too long: the line search shortens it

    constraints = [
        {
            "type": "eq",
            "fun": lambda x: at(x)["equalities"],
            "jac": lambda x: at(x)["equalities_by"],
        }
    ]
    if inequalities:
        constraints.append(
            {
                "type": "ineq",
                "fun": lambda x: at(x)["inequalities"],
                "jac": lambda x: at(x)["inequalities_by"],
            }
        )
    found = minimize(
        lambda x: at(x)["objective"] / scale,
        programme.start,
        jac=lambda x: at(x)["gradient"] / scale,
        bounds=list(zip(*programme.bounds, strict=True)),
        constraints=constraints if equalities else constraints[1:],
        method="SLSQP",
        options={"maxiter": iterations, "ftol": 1e-11},
    )
    return found.x, str(found.message), found.success


def _ipopt(programme: Programme, iterations: int) -> Found | None:
    try:
        import cyipopt
    except ImportError:
        return None
    equalities, inequalities = programme.counts

    class Callbacks:
        def _at(self, x: NDArray[Any]) -> dict[str, Any]:
            found = programme.at(x)
            if found is None:
                raise cyipopt.CyIpoptEvaluationError
            return found

        def objective(self, x: NDArray[Any]) -> float:
            return self._at(x)["objective"] / programme.objective_scale

        def gradient(self, x: NDArray[Any]) -> NDArray[Any]:
            return self._at(x)["gradient"] / programme.objective_scale

        def constraints(self, x: NDArray[Any]) -> NDArray[Any]:
            found = self._at(x)
            return numpy.concatenate([found["equalities"], found["inequalities"]])

        def jacobian(self, x: NDArray[Any]) -> NDArray[Any]:
            found = self._at(x)
            return numpy.concatenate([found["equalities_by"], found["inequalities_by"]]).ravel()

    problem = cyipopt.Problem(
        n=len(programme.free),
        m=equalities + inequalities,
        problem_obj=Callbacks(),
        lb=programme.bounds[0],
        ub=programme.bounds[1],
        cl=numpy.zeros(equalities + inequalities),
        cu=numpy.concatenate([numpy.zeros(equalities), numpy.full(inequalities, 1e20)]),
    )
    options = {
        "print_level": 0,
        "sb": "yes",
        "max_iter": iterations,
        "tol": 1e-9,
        "bound_relax_factor": 0.0,
    }
    for name, value in (options | {"hessian_approximation": "limited-memory"}).items():
        problem.add_option(name, value)
    x, info = problem.solve(programme.start)
    said = info["status_msg"].decode().partition(" (")[0].rstrip(".")
    return x, said, info["status"] in (0, 1)  # within the tolerance, or an acceptable one
