"""Integrators of other packages, called by their own Python API (`--against`).

A package that takes a function gets the model's compiled acceleration by ctypes; a package that
takes expressions gets them from the model's graph. Each gets a relative tolerance, and absolute
tolerances in proportion to the scale of each variable. Compilation by a package is not timed.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Any

from pkgen.analysis.chart.measure import Program
from pkgen.analysis.chart.points import GSL, ChartedMethod
from pkgen.compiler import Compilation
from pkgen.functions import FUNCTIONS
from pkgen.graph.differentiate import reachable
from pkgen.graph.graph import Kind, Op, Symbol
from pkgen.graph.written import Written
from pkgen.middle.jacobians import slopes, variables
from pkgen.record import record
from pkgen.run.build import runtime_methods

if TYPE_CHECKING:
    import numpy

SELDOM = 64  # evaluations between two checks of the CPU time
MOST_STEPS = 10**7
TIME = Symbol(Kind.TIME)


class Refused(Exception):
    """A package cannot take this model; the message says why."""


class Slow(Exception):
    """An integration has exceeded its time limit."""


class Motion:
    """The initial value problem y' = f(t, y), which begins at `start`; y has the coordinates, rates
    and first-order variables. `count` is the number of calls of f. f raises Slow if the CPU time
    exceeds `late`."""

    def __init__(self, compilation: Compilation, program: Program, scales: Sequence[float]):
        import numpy

        self.compilation, self.settings = compilation, program.given()
        self.until = program.settings.until
        given = program.start
        self.start = numpy.array([*given["q"], *given["v"]], dtype=float)
        self.scales = numpy.array(scales)
        self.count, self.late = 0, float("inf")
        self._idle = program.library.run(self.settings, idle=True)
        self._rates = self._idle.rates()

    def f(self, t: float, y: numpy.ndarray) -> numpy.ndarray:
        self.count += 1
        if self.count % SELDOM == 0 and time.process_time() > self.late:
            raise Slow
        return self._rates(t, y)

    def expressions(self, name: str, domain: Any, t: Any, y: Sequence[Any]) -> list[Any]:
        """Returns f as expressions of the package `name`, with numeric parameters. Raises
        Refused."""
        e = self.compilation.equations
        if e.acceleration is None:
            raise Refused(f"the accelerations are too large to be written out for {name}")
        g = e.graph.copy()
        nodes = slopes(g, e)
        called = {
            g.data[n] for n in reachable(g, nodes) if g.op[n] is Op.CALL and not g.is_constant(n)
        }
        for function in sorted(called):
            if FUNCTIONS[function].kinked and not hasattr(domain, function):
                raise Refused(f"{name} has no {function}(), which the equations have")
        constants = {Symbol(Kind.PARAMETER, i): x for i, x in self.settings.parameters}
        inputs = {Symbol(Kind.INPUT, i): 0.0 for i in range(len(e.inputs))}
        inputs |= {Symbol(Kind.INPUT, i): x for i, x in self.settings.inputs}
        values = {TIME: t, **inputs, **dict(zip(variables(e), y, strict=True))}
        return Written(g, nodes, constants)(domain, values)


# A function of a tolerance and a list of times. It returns the states at these times; if the list
# is empty, it returns the state at the end.
Integrate = Callable[[float, Sequence[float]], Any]


def gsl_methods() -> list[str]:
    """Returns the names of GSL's methods in the runtime; none if it was compiled without GSL."""
    return [name for m in runtime_methods() if (name := str(m["name"])).startswith(GSL)]


@record
class Peer:
    """A package. `open(motion, method)` makes an integrator; `takes` describes its input."""

    name: str  # The name in --against, with which the names of the package's methods begin.
    module: str = ""  # Module to import; "" if the runtime contains the methods.
    package: str = ""  # Name for pip.
    takes: str = ""
    methods: Mapping[str, int] = field(default_factory=dict)  # orders by method
    open: Callable[[Motion, str], Integrate] | None = None

    @property
    def missing(self) -> str:
        """Says why the package is not available and how to install it; "" if it is available."""
        if not self.module:
            return "" if gsl_methods() else "pkgen is built without gsl: install libgsl-dev"
        try:
            importlib.import_module(self.module)
        except ImportError as error:
            return f"{self.name} cannot be imported ({error}): pip install {self.package}"
        return ""

    @property
    def version(self) -> str:
        from importlib import metadata

        return f"{self.package} {metadata.version(self.package)}" if self.package else self.name

    def charted(self) -> list[ChartedMethod]:
        return [
            ChartedMethod(f"{self.name}_{name}", order, ("adaptive", "dense"), peer=self.version)
            for name, order in self.methods.items()
        ]


def _scipy(motion: Motion, method: str) -> Integrate:
    from scipy.integrate import solve_ivp

    def integrate(tolerance: float, times: Sequence[float]) -> Any:
        done = solve_ivp(
            motion.f,
            (0.0, motion.until),
            motion.start,
            method=method,
            rtol=tolerance,
            atol=tolerance * motion.scales,
            t_eval=times or None,
        )
        if not done.success:
            raise ArithmeticError(done.message)
        return done.y.T

    return integrate


def _heyoka(motion: Motion, method: str) -> Integrate:
    """Returns an integrator that heyoka compiles anew for each tolerance, since the tolerance
    determines the order of its Taylor method."""
    import heyoka

    names = [f"y{i}" for i in range(len(motion.start))]
    y = heyoka.make_vars(*names) if len(names) > 1 else [heyoka.make_vars(*names)]
    rates = motion.expressions("heyoka", heyoka, heyoka.time, y)
    system = [(a, heyoka.expression(b)) for a, b in zip(y, rates, strict=True)]
    compiled: dict[float, Any] = {}

    def integrate(tolerance: float, times: Sequence[float]) -> Any:
        if tolerance not in compiled:
            compiled[tolerance] = heyoka.taylor_adaptive(system, list(motion.start), tol=tolerance)
        it = compiled[tolerance]
        it.time = 0.0
        it.state[:] = motion.start
        if times:
            outcome, *_, states = it.propagate_grid(list(times), max_steps=MOST_STEPS)
        else:
            outcome, *_ = it.propagate_until(motion.until, max_steps=MOST_STEPS)
            states = [it.state]
        if outcome != heyoka.taylor_outcome.time_limit:
            raise ArithmeticError(f"{outcome} at t = {it.time:.3g}")
        return states

    return integrate


def _cvode(motion: Motion, method: str) -> Integrate:
    import numpy
    from sksundae.cvode import CVODE

    def rates(t: float, y: Any, out: Any) -> None:
        out[:] = motion.f(t, y)

    def integrate(tolerance: float, times: Sequence[float]) -> Any:
        solver = CVODE(
            rates,
            method=method,
            rtol=tolerance,
            atol=tolerance * motion.scales,
            max_num_steps=MOST_STEPS,
        )
        ends = numpy.array([*times] if times else [0.0, motion.until])
        done = solver.solve(ends, motion.start)
        if not done.success:
            raise ArithmeticError(str(done.message))
        return done.y

    return integrate


COMPILED = "the model's compiled acceleration, by ctypes"
PEERS = (
    Peer("scipy", "scipy", "scipy", COMPILED, {"DOP853": 8, "Radau": 5, "LSODA": 12}, _scipy),
    Peer(
        "heyoka",
        "heyoka",
        "heyoka",
        "the model's expressions, compiled by LLVM",
        {"taylor": 20},
        _heyoka,
    ),
    Peer("cvode", "sksundae", "scikit-sundae", COMPILED, {"Adams": 12, "BDF": 5}, _cvode),
    Peer("gsl"),
)
