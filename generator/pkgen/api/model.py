"""The class Model: the parameters, runs and kernels of a model."""

from __future__ import annotations

import argparse
import os
import warnings
from collections.abc import Mapping, Sequence
from copy import copy
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy

from ..compiler import Compilation, compile_model
from ..defaults import ITERATIONS, MAX_STEPS
from ..front.check.values import NoValue
from ..front.read import allowing, read
from ..indices import indexed, parted, unrolled
from ..middle.refused import refuse_statements
from ..model import Scene
from ..own.given import given as own_methods
from ..run import named
from ..run.ensemble import Ensemble, Settable
from ..run.library import load as load_library
from ..run.simulate import followed
from ..scenes import lengths
from ..scenes.scene import chosen
from ..scenes.scene import values as scene_values
from ..scenes.swarm import Arrays
from ..system.exits import INTERRUPTED, USAGE
from ..system.near import near
from . import arguments
from .analyses import Analyses, of_result
from .arguments import Files, Names, Value, Weights, in_words
from .controllers import Controller, Controllers
from .errors import RunError, UsageError
from .inputs import Computed, Function, Table
from .integrator import Integrator
from .kernels import Kernels
from .page import Page, shown
from .parameters import Parameters, Tables
from .prepare import prepare
from .result import Result

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .symbols import Symbolic, Typeset


def load(
    path: str | os.PathLike[str],
    scene: str | None = None,
    sizes: Mapping[str, int] | None = None,
    allow_path: Sequence[str | os.PathLike[str]] = (),
) -> Model:
    """Loads a model from its file, with one of its scenes or none. `sizes` are lengths of families
    that replace those in the file. `allow_path` are folders, besides the model's own, whose files
    the model may read. Raises ModelError with the positions of errors."""
    return Model(path, scene, {} if sizes is None else sizes, allow_path)


class Model(Kernels, Analyses):
    """A model, with one of its scenes or none. `params` has the values of its parameters.

    Kernels (`M`, `f`, `acceleration`, ...) are those of the whole model, without the scene's
    reductions, at the values of `params`. q and v have the model's coordinates and rates along
    their last axis, in the order of `coordinates` and `rates`, in SI. u has the inputs in the order
    of `inputs`, or is a dictionary of them; inputs that are not given are 0. All other axes, and
    those of t, are broadcast as by NumPy.
    """

    @in_words()
    def __init__(
        self,
        path: str | os.PathLike[str],
        scene: str | None,
        sizes: Mapping[str, int],
        allow_path: Sequence[str | os.PathLike[str]] = (),
    ) -> None:
        arguments.checked(path=path, scene=scene, sizes=sizes, allow_path=allow_path)
        self._allowed = arguments.several(allow_path)
        self.path, self.scene = os.fspath(path), scene
        self._sizes = lengths.given([f"{name}={length}" for name, length in sizes.items()])
        self._made: dict[object, Compilation] = {}
        self._more = ""  # lines behind those of the file
        self._warned: set[str] = set()
        self.params = Parameters(self, self._forget)
        self.tables = Tables(self, self._compile_anew)
        if scene is not None:  # raises errors of the scene here, not in run()
            chosen(self.compilation.declared, scene)
        self.compilation  # noqa: B018

    @cached_property
    def compilation(self) -> Compilation:
        """The compiled model, without reductions by a scene."""
        return self._compiled(argparse.Namespace(scene=None), unroll=lengths.UNROLL)

    def _compiled(self, options: argparse.Namespace, **how: Any) -> Compilation:
        source = read(self.path)
        source = source.with_lines(self._more) if self._more else source
        own = own_methods(options)
        key = (source, repr(sorted(vars(options).items())), how.get("kernels"), own)
        if key not in self._made:
            with allowing(*self._allowed), self.tables.brought():
                made = self._made[key] = compile_model(source, sizes=self._sizes, own=own, **how)
            for text in [warning.text(source) for warning in made.warnings]:
                if text not in self._warned:
                    self._warned.add(text)
                    warnings.warn(arguments.worded(text), stacklevel=4)
        return self._made[key]

    def _compile_anew(self) -> None:
        self._made.clear()
        self.__dict__.pop("compilation", None)
        self._forget()

    def _forget(self) -> None:
        self.__dict__.pop("_handle", None)

    def extended(self, lines: str, tables: Mapping[str, Any]) -> Model:
        """Returns a copy with lines behind those of the file, and with the arrays of tables."""
        other = copy(self)
        other._made, other._more = {}, f"{self._more}{lines}"
        other.__dict__.pop("compilation", None)
        other._forget()
        other.params, other.tables = Parameters(other, other._forget), Tables(other, other._forget)
        other.params._set.update(self.params._set)
        other.tables._set.update({**self.tables._set, **tables})
        return other

    @property
    def name(self) -> str:
        return self.compilation.model.name

    @property
    def coordinates(self) -> tuple[str, ...]:
        return tuple(named.coordinates(self.compilation).names())

    @property
    def rates(self) -> tuple[str, ...]:
        """The names of the rates, then the names of the first-order variables."""
        return tuple(named.coordinates(self.compilation, rates=True).names())

    @property
    def scenes(self) -> tuple[str, ...]:
        return tuple(s.name for s in self.compilation.declared.scenes if s.listed)

    def __getattr__(self, name: str) -> Any:
        """Returns a method that an add-on brings."""
        from functools import partial

        from ..system import addons

        if name.startswith("_") or name not in addons.points("methods"):
            raise AttributeError(f"a model has no attribute {name!r}")
        return partial(addons.load("methods", name), self)

    # -- runs ---------------------------------------------------------------------------------

    def run(
        self,
        until: Value | None = None,
        *,
        method: str | None = None,
        every: Value | None = None,
        step: Value | None = None,
        max_step: Value | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        start: Mapping[str, Value] | None = None,
        inputs: Mapping[str, Value | Function | Table] | None = None,
        hold: float | None = None,
        linear: float | None = None,
        controllers: Mapping[str, Controller] | None = None,
        record: Names | None = None,
        at: str | None = None,
        diagnose: Names = (),
        iteration: str = ITERATIONS[0],
        max_steps: int = MAX_STEPS,
        seed: int | None = None,
        tableau: Files = (),
        composition: Weights = (),
        sensitivity: Names = (),
    ) -> Result:
        """Integrates the model. Arguments are the options of `pkgen run` of the same names; by
        default, the scene's settings apply. Numbers are in SI units, or texts with a unit:
        `until="2 [min]"`. `tableau` (one file or several) and `composition` (weights) define
        methods; the first of them is the default of `method`.

        An input is a value, a table (t, values) with linear interpolation, a table (t, values,
        "hold") that is piecewise constant, or a function f(t, q, v). Explicit methods (default
        dop853) call f at each evaluation. With `hold`, f is called at multiples of `hold`, and the
        input is constant in between. With `linear`, f(t, None, None) is called at multiples of
        `linear`, and the input is interpolated linearly.

        `controllers` has a function f(t, q, v, u) for each sample block that it replaces. At the
        samples of the block it is called with the inputs and memory cells by name, and returns the
        new values of those that the block sets.

        `sensitivity` names parameters, inputs, and coordinates or rates for their starts: then
        `result.sensitivity["theta1", "m1"]` is the derivative of a column by one of them.

        Raises UsageError for invalid arguments, RunError if the numerics fail (its `result` has the
        rows up to the last valid time), and KeyboardInterrupt.
        """
        given = {k: x for k, x in locals().items() if k not in ("self", "hold", "linear")}
        del given["controllers"], given["sensitivity"]
        known = {"hold": hold, "linear": linear, "sensitivity": sensitivity}
        arguments.checked(inputs=inputs, controllers=controllers, **known)
        functions = {k: x for k, x in (inputs or {}).items() if arguments.is_computed(x)}
        given["inputs"] = {k: x for k, x in (inputs or {}).items() if k not in functions}
        computed: Computed | Controllers | None = Controllers(controllers) if controllers else None
        if functions or hold or linear:
            computed = laws = Computed(functions, hold, linear)
            refuse_statements(self.compilation.declared, "inputs")
            if laws.needs_explicit and method is None:
                given["method"] = "dop853"
        by = arguments.several(sensitivity)
        if by and computed:
            raise UsageError("sensitivity: inputs and controllers in Python have no derivatives")
        result = self._run(arguments.options(self, given), computed=computed, by=by)
        if by:
            with in_words(), of_result(result):
                result.sensitivity.moved  # noqa: B018
        return result

    def ensemble(
        self, table: Any, until: Value | None = None, *, threads: int | None = None, **more: Any
    ) -> Result:
        """Integrates many trajectories. `table` has a column for each parameter, input, coordinate
        or rate that differs between members: a dictionary of arrays, a data frame, a structured
        array, or the name of a CSV file. `more` are arguments of `run`."""
        options = arguments.options(self, {"until": until, "threads": threads, **more})
        if arguments.is_path(table):
            options.ensemble = os.fspath(table)
            return self._run(options)
        options.ensemble = "table"
        return self._run(options, lambda made: _members(made, table))

    @in_words()
    def _run(
        self,
        options: argparse.Namespace,
        table: Any = None,
        computed: Computed | Controllers | None = None,
        by: Sequence[str] = (),
    ) -> Result:
        if computed is not None:
            options.no_reduce = "all"  # input functions get q and v of the whole model
        errors: list[BaseException] = []
        if by:
            prepared, more = self.taped(options), {"tape": 1}
        else:
            prepared = prepare(options, self._compiled, table).built()
            more = computed.settings(prepared, errors) if computed else {}
        done, told = followed(prepared, **more)
        for error in errors:
            raise error
        expects = [verdict.record() for verdict in prepared.verdicts(told.report)]
        shown = prepared.columns()
        messages = arguments.worded("".join(f"{note}\n" for note in prepared.notes) + told.messages)
        result = Result(self.name, shown, done.rows(), told.report, messages, expects)
        if told.code == INTERRUPTED:
            raise KeyboardInterrupt
        said = told.messages.strip().replace("run: ", "") or "the run failed"
        if told.code == USAGE or told.report.get("status") == "PK_REFUSED":
            raise UsageError(said)
        if told.code:
            report = told.report
            first: Any = report.get("first_failed") or report
            valid = first.get("last_valid", first.get("t", 0.0))
            raise RunError(said, first.get("status", ""), valid, result)
        if by:
            from ..analysis.sensitivity.forward import Sensitivities
            from ..analysis.sensitivity.tape import Tape

            with of_result(result):
                result.sensitivity = Sensitivities(Tape(prepared, done), by, result.t)
        return result

    @in_words()
    def exact(self, t: ArrayLike) -> dict[str, NDArray[Any]]:
        """The closed forms of the motion (`exact x = …`) at the times t: by name, of t's shape."""
        declared = self.compilation.declared
        scene = Scene(name="", span=declared.span, exacts=declared.exacts)
        scene = chosen(declared, self.scene) if self.scene else scene
        given = {parted(name): value for name, value in self.params._set.items()}
        known = scene_values(declared, scene, given)
        (times,) = arguments.arrays(t=t)
        arrays, found = Arrays(known.values, "t", times), {}
        for form in scene.exacts:
            for index, loop in unrolled(form, known.sizes):
                name = indexed(form.name, index)
                try:
                    with numpy.errstate(all="ignore"):
                        found[name] = numpy.full(times.shape, arrays.value(form.value, loop))
                except (NoValue, KeyError) as error:
                    raise UsageError(f"the closed form of {name}: {error}") from None
        return found

    def show(self, path: str | os.PathLike[str] | None = None) -> Page:
        """Writes an interactive HTML page, NAME.html or `path`: an animation with controls of its
        parameters (`pkgen show`). A notebook shows the page. Raises UsageError."""
        return shown(self, Path(path or f"{self.name}.html"))

    def integrator(
        self,
        method: str | None = None,
        *,
        step: Value | None = None,
        max_step: Value | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        start: Mapping[str, Value] | None = None,
        inputs: Mapping[str, Value] | None = None,
        seed: int | None = None,
    ) -> Integrator:
        """Returns an Integrator at the initial state; arguments as in `run`. Raises UsageError."""
        given = {k: x for k, x in locals().items() if k != "self"}
        with in_words():
            options = arguments.options(self, {**given, "until": 1.0})
            options.no_reduce = "all"
            prepared = prepare(options, self._compiled, None).built()
            assert prepared.library is not None
            library = load_library(prepared.library)
            return Integrator(prepared, library.run(prepared.settings, idle=True, watch=-1))

    @property
    def start(self) -> NDArray[Any]:
        found = super().start
        if self.compilation.model.consistent:
            it = self.integrator()
            found = numpy.array([*it.q, *it.v])
        return found

    # -- equations ----------------------------------------------------------------------------

    def sympy(self) -> Symbolic:
        """L, M and f of M a = f, and the symbols q and v, as SymPy objects."""
        from .symbols import symbolic

        return symbolic(self._compiled(argparse.Namespace(scene=None), unroll=None))

    def equations(self) -> Typeset:
        """The equations of motion M a = f in LaTeX, which a notebook renders."""
        from .symbols import typeset

        return typeset(self.sympy())

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles path, scene, sizes, parameters and arrays of tables. Unpickling reads the model's
        file again."""
        given = self.path, self.scene, self._sizes, self._allowed
        return Model, given, (dict(self.params._set), dict(self.tables._set))

    def __setstate__(self, values: tuple[Mapping[str, float], Mapping[str, Any]]) -> None:
        parameters, tables = values
        self.tables.update(tables)
        self.params.update(parameters)

    def __repr__(self) -> str:
        scene = f", scene {self.scene}" if self.scene else ""
        return f"<pkgen model {self.name}: {', '.join(self.coordinates)}{scene}>"


def _members(compilation: Compilation, table: Any) -> Ensemble:
    """Returns an ensemble from a table in memory with named columns. Raises UsageError."""
    from ..run import members_file

    structured = isinstance(table, numpy.ndarray)
    names = table.dtype.names if structured else list(table) if hasattr(table, "keys") else None
    if names is None:
        allowed = "a dictionary of arrays, a data frame, a structured array, or a CSV file's name"
        raise UsageError(f"table={arguments.brief(table)}: give {allowed}")
    known = Settable(compilation)
    for name in names:
        if not isinstance(name, str) or name not in known:
            raise UsageError(f"column {name}: {near(str(name), list(known), 'parameter or start')}")
    columns = [known[name] for name in names]
    values = [arguments.arrays(**{f"column {name}": table[name]})[0] for name in names]
    return members_file.of_columns("table", columns, values)
