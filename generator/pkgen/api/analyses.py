"""Derivatives of runs, equilibria and linear models of a model."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..compiler import Compilation
from ..scenes.compile_plan import whole
from ..system.exits import NumericsFailed
from . import arguments
from .arguments import Names, Value, in_words
from .errors import RunError
from .prepare import Prepared, prepare
from .result import Result

if TYPE_CHECKING:
    from .effective import EffectivePotential


@contextmanager
def of_result(result: Result) -> Iterator[None]:
    """Raises failures of derivatives as RunError with the result of the run."""
    try:
        yield
    except NumericsFailed as error:
        raise RunError(str(error), "", result.t[-1] if len(result) else 0.0, result) from None


class Analyses:
    """The base class of Model that has its analyses. Model has the functions that these call."""

    _compiled: Callable[..., Compilation]
    _run: Callable[..., Result]

    def gradient(self, of: str, by: Names, **more: Any) -> dict[str, float]:
        """Returns the derivative of the last value of a column by parameters, inputs, and starts of
        coordinates and rates, by name; "t" is a column too, for an event that ends the run. `more`
        are arguments of `run`, without inputs and controllers in Python. The derivative is that of
        the numerical solution. Raises as `run`."""
        from ..analysis.sensitivity.gradient import gradient

        arguments.checked(of=of, by=by)
        names = arguments.several(by)
        result = self._run(arguments.options(self, more), by=names)
        with in_words(), of_result(result):
            return gradient(result.sensitivity.tape, of, names, result.t[-1]) if names else {}

    def taped(self, options: argparse.Namespace) -> Prepared:
        """Prepares a run whose steps are kept, for its derivatives."""
        from ..analysis.sensitivity import tape
        from ..back.kernels import all_but

        options.no_reduce = "all"
        how = {"unroll": None, "kernels": all_but("out_x", "out_u", "out_p") | {"lanes"}}
        prepared = prepare(options, lambda of, **more: self._compiled(of, **{**more, **how}))
        tape.refuse(prepared)
        return replace(prepared, library=tape.library(prepared))

    def equilibria(
        self,
        *,
        start: Mapping[str, Value] | None = None,
        inputs: Mapping[str, Value] | None = None,
        tries: int = 100,
    ) -> list[dict[str, Any]]:
        """Returns the equilibria and the steady motions, as `pkgen equilibria --json` lists them:
        `state`, `stable`, `frequencies`, `modes`, and by name what is steady or small. The search
        has `tries` starts besides that of the motion; momenta of cyclic coordinates are those of
        the start. Raises UsageError, ModelError."""
        from ..analysis.linear import equilibria, report

        with in_words():
            options = arguments.options(self, {"start": start, "inputs": inputs})
            options.tries = tries
            made = self._compiled(options, unroll=None, use=whole(options))
            found = report.record(made, equilibria.of_model(options, made))
        return found["equilibria"]  # type: ignore[return-value]

    def effective_potential(
        self,
        *,
        start: Mapping[str, Value] | None = None,
        inputs: Mapping[str, Value] | None = None,
    ) -> EffectivePotential:
        """Returns V_eff of the coordinates that are not cyclic: its `str` is the expression, it is
        a function of the coordinates, and `plot(name, lo, hi)` draws it. The momenta are those of
        the start. Without cyclic coordinates it is the energy at rest. Raises UsageError,
        ModelError."""
        from ..analysis.linear.system import opened
        from .effective import EffectivePotential

        with in_words():
            options = arguments.options(self, {"start": start, "inputs": inputs})
            made = self._compiled(options, unroll=None, use=whole(options))
            return EffectivePotential(made, opened(options, made, "effective_potential"))
