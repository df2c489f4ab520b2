"""The plan of a compilation: the part of the model that a run needs, its kernels and its method.

It is made once, from a scene and options (`scenes/compile_plan.py`), and stored in the compiled
model, where all code that runs or describes the model reads it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

from .defaults import GAUSS_RTOL, RTOL, UNTIL
from .equations import AnyEquations
from .methods import provides
from .middle.reduce.reduction import Needs
from .middle.report import ReportLine
from .middle.structure import Structure
from .model import Model
from .record import record

EXPONENTIAL_MOST = 64  # most coordinates for `exponential`, whose step multiplies by a full matrix
Made = tuple[AnyEquations, Structure]
OPTION, SCENE, DEFAULT = "option", "scene", "default"  # origins of a method


@record
class RunNumbers:
    """Numbers of a run in SI units, from options or from a scene; None: not set there."""

    until: float | None = None
    every: float | None = None
    step: float | None = None
    max_step: float | None = None
    rtol: float | None = None
    atol: float | None = None

    def else_of(self, other: RunNumbers) -> RunNumbers:
        """Returns these numbers; a number that is not set is replaced by that of `other`."""
        pairs = ((f.name, getattr(self, f.name)) for f in fields(RunNumbers))
        return RunNumbers(**{k: getattr(other, k) if x is None else x for k, x in pairs})


DEFAULTS = RunNumbers(until=UNTIL, rtol=RTOL)


@record
class CompilePlan:
    """The kernels to compile (None: all), the method of the planned run ("": no run is planned),
    the origin of the method, the numbers from options, and whether `jet` is compiled beside the
    kernels of the method."""

    kernels: frozenset[str] | None = None
    method: str = ""
    source: str = DEFAULT
    numbers: RunNumbers = RunNumbers()
    jets: bool = False


@record
class Use:
    """The parts of a model that are used: here the whole model, in subclasses what a scene needs.
    `more_declared` adds declarations."""

    more_declared: Callable[[Model], Model] = lambda declared: declared

    def declared(self, declared: Model) -> Model:
        """Returns the model with the declarations that options add."""
        return self.more_declared(declared)

    def model(self, declared: Model) -> tuple[Model, tuple[ReportLine, ...]]:
        """Returns the model with parameters that are fixed and coordinates that are held."""
        return declared, ()

    def exact(self, declared: Model) -> tuple:
        """Returns the arguments of check_exact(), which tries closed forms."""
        return declared, declared.exacts

    def needs(self, used: Model) -> Needs | None:
        """Returns the needed outputs (None: all)."""
        return None

    def plan(self, used: Model, made: Made | None) -> CompilePlan:
        """Returns the plan; while (equations, structure) are unknown, with all kernels that may be
        needed."""
        return CompilePlan()

    def reads(self, used: Model) -> frozenset[str] | None:
        """Returns the parameters that a run reads (None: all)."""
        return None

    def of(self, declared: Model) -> tuple[Model, tuple[ReportLine, ...]]:
        return self.model(self.declared(declared))


def default_method(made: Made, rtol: float, exact: bool) -> str:
    """Returns the method for all coordinates or a block. With `exact`, a small linear system with
    constant coefficients gets its exact flow, in steps short enough to detect events.

    gauss is the fastest method for smooth equations and tight tolerances; its error estimate is
    invalid across a kink. A long chain has fast oscillations of small amplitude, for which the
    iteration of gauss would limit the step size, and its stages would not fit into the cache. This
    does not apply to sums over all pairs, for which gauss is faster."""
    equations, structure = made
    if equations.model.noises:
        return "baoab" if provides(structure, "linear_drag") else "heun"
    by_gauss = structure.smooth_in_pieces and rtol <= GAUSS_RTOL
    few = len(equations.coordinates) + len(equations.states) <= EXPONENTIAL_MOST
    if exact and structure.affine and few and equations.dense:
        return "exponential"
    return "gauss" if by_gauss and not equations.is_chain else "dop853"
