"""Loads a compiled model and calls its runtime (pk/run.h, pk/stability.h) by ctypes.

A library whose structure sizes (`pk_run_size`) differ is refused. A run does not hold the
interpreter lock. The runtime calls `poll` about ten times a second; its result may end the run.
"""

from __future__ import annotations

import ctypes
import json
import threading
from collections.abc import Callable, Sequence
from ctypes import POINTER, Structure, c_double, c_size_t, c_void_p
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from ..system import children
from ..system.exits import DONE, BuildError, NumericsFailed, UsageError
from .header import FUNCTIONS, STRUCTURES
from .settings import Compared, Settings, Shown

if TYPE_CHECKING:
    import numpy

    from ..functions.tables import Data
    from .ensemble import Column, Ensemble

DERIVED = 4  # PK_FAILURE_DERIVED
_SIZED = [
    STRUCTURES[f"struct pk_{name}"]
    for name in ("run_settings", "run_expected", "run_part", "run_reduced")
]
_Settings = _SIZED[0]
_FIELDS = dict(_Settings._fields_)
COMPUTE, SAMPLE = _FIELDS["compute"], _FIELDS["sample"]
# Fields of pk_run_settings that have no meaning in a standalone program.
OF_A_CALL = ("poll", "context", "member_values", "compute", "stops", "seen", "computed", "sample")
Poll = Callable[[float], bool]  # gets the completed fraction of the run; returns True to stop


@cache
def load(path: Path) -> Library:
    """Returns the library of a model; it stays loaded until the process ends."""
    return Library(path)


class Library:
    def __init__(self, path: Path):
        try:
            self.c = ctypes.CDLL(str(path))
        except OSError as error:
            raise BuildError(f"cannot load the compiled model: {error}") from None
        for name, (result, arguments) in FUNCTIONS.items():
            if function := getattr(self.c, name, None):  # some libraries lack pk_stability_*
                function.restype, function.argtypes = result, arguments
        if [self.c.pk_run_size(k) for k in range(len(_SIZED))] != [*map(ctypes.sizeof, _SIZED)]:
            raise BuildError("the compiled model is of another version of pkgen")
        children.on_end(self.c.pk_run_stop)
        self.model = STRUCTURES["struct pk_run_model"].in_dll(self.c, "pk_model")

    def methods(self, own: bool = False) -> list[dict[str, object]]:
        """Returns descriptions, made by the runtime, of its methods or, with `own`, of the methods
        that the user defines for the model."""
        return json.loads(self.c.pk_stability_methods(self.model, own))

    def settings(self, given: Settings, **more: object) -> Structure:
        """Returns the settings as a C structure; `more` sets further fields by name."""
        s = self.c.pk_run_defaults()
        s.method = given.method.encode()
        s.until, s.rtol = given.until, given.rtol
        s.every = -1.0 if given.every is None else given.every
        s.step, s.h_max = given.step or 0.0, given.max_step or 0.0
        s.atol = s.atol if given.atol is None else given.atol
        s.fixed_point = given.iteration == "fixed"
        s.max_steps, s.seed = given.max_steps, given.seed
        s.land = {"": -1, "land": 1, "dense": 0}[given.rows]
        given_of = [*((i, 0, x) for i, x in given.parameters), *given.members]
        _fill(s, "parameters", given_of)
        for name in ("inputs", "q", "v"):
            pairs = given.inputs if name == "inputs" else getattr(given, f"start_{name}")
            _fill(s, name, [(i, 0, x) for i, x in pairs])
        _fill(s, "tables", [_table(k, data) for k, data in given.tables])
        _fill(s, "columns", [column(c) for c in given.show])
        _fill(s, "hidden", given.watched.hidden)
        s.at = 0 if given.at is None else given.at + 1
        _fill(s, "expected", [_expected(c) for c in given.watched.compared])
        drifts = [(b"e", 0, 0) if d is None else (b"o", d, 0) for d in given.watched.drifts]
        _fill(s, "drifts", drifts)
        for name in given.diagnose:
            s.diagnose |= self.c.pk_run_diagnostic(name.encode())
        parts = [(p.method.encode(), p.step or 0, p.rtol, p.max_step or 0) for p in given.parts]
        _fill(s, "parts", parts)
        s.watch = {"": 0, "events": 1, "times": 2, "none": -1}[given.watch]
        for name, value in more.items():
            (_fill if isinstance(value, tuple) else setattr)(s, name, value)
        return s

    def run(
        self,
        settings: Settings,
        poll: Poll | None = None,
        ensemble: Ensemble | None = None,
        idle: bool = False,
        **more: object,
    ) -> Run:
        """Runs to the end and returns the run; an `idle` run is not started, but can evaluate
        kernels."""
        s = self.settings(settings, **more)
        if ensemble is not None:
            count = len(ensemble.lines) * len(ensemble.columns)
            values = (c_double * count).from_buffer(ensemble.values) if count else None
            s.members = len(ensemble.lines)
            _fill(s, "member_columns", [column(c) for c in ensemble.columns])
            s.member_values = ctypes.cast(values, POINTER(c_double))
            if ensemble.counted:
                s.member_name = ensemble.counted.encode()
                s.first_member = ensemble.lines[0]
        return Run(self, s, poll, idle)


class Run:
    """A run that has ended. It has an exit code `code`, `report` and `messages`; `not_finite` tells
    whether a constant of the model, computed from parameters, is not finite."""

    def __init__(self, library: Library, settings: Structure, poll: Poll | None, idle: bool):
        self._c, self._model = library.c, library.model
        self._run = None
        ended: list[BaseException | bool] = []

        def ask(_context: object, part: float) -> int:
            try:
                if poll and poll(part):
                    ended.append(True)
            except BaseException as error:  # no exception may pass through C
                ended.append(error)
            return int(bool(ended))

        settings.poll = _FIELDS["poll"](ask)
        self._run = c_void_p(self._c.pk_run_new(library.model, settings))
        if not self._run:
            raise NumericsFailed("out of memory")
        self.code = DONE if idle else self._go(ended)
        for error in ended:
            if isinstance(error, BaseException):
                raise error
        self.messages = self.said()
        self.not_finite = self._c.pk_run_refused(self._run) % 8 == DERIVED
        self.report = json.loads(self._c.pk_run_report(self._run))

    def _go(self, ended: list[BaseException | bool]) -> int:
        """Runs to the end and returns the exit code. The run has its own thread so that Ctrl-C
        works during a long step: Python runs signal handlers only between statements of the main
        thread."""
        codes: list[int] = []
        if threading.current_thread() is not threading.main_thread():
            return self._c.pk_run_go(self._run)
        worker = threading.Thread(target=lambda: codes.append(self._c.pk_run_go(self._run)))
        with children.postponed(ended):  # the thread uses the memory of the run until it has ended
            worker.start()
            worker.join()
        return codes[0]

    def rows(self, low: bool = False) -> numpy.ndarray:
        """Returns the rows that the run has in memory, of shape (rows, columns). The first column
        is t; in an ensemble, the first column is the member and the second is t. With `low`,
        returns corrections, which added to the rows give more digits than a double has."""
        high, rest, columns = POINTER(c_double)(), POINTER(c_double)(), c_size_t()
        count = self._c.pk_run_rows(self._run, high, rest, columns)
        return _array(rest if low else high, count, columns.value)

    def members(self) -> numpy.ndarray:
        """Returns a row for each member of the ensemble: its status, its last valid time, and the
        numbers that the setting `reduced` requests."""
        numbers, columns = POINTER(c_double)(), c_size_t()
        count = self._c.pk_run_members(self._run, numbers, columns)
        return _array(numbers, count, columns.value)

    def laps(self, seconds: float) -> float:
        """Repeats the run without rows, for up to `seconds`. Returns the CPU seconds of one run, or
        infinity if the run fails."""
        return self._c.pk_run_laps(self._run, seconds) or float("inf")

    def evaluate(
        self,
        what: str,
        t: numpy.ndarray,
        q: numpy.ndarray,
        v: numpy.ndarray,
        u: numpy.ndarray | None = None,
    ) -> numpy.ndarray:
        """Evaluates the kernel `what` at many states. The shapes are (count, n) for v, (count, at
        most n) for q, (count,) for t, (count, inputs) for u. If u is None, the inputs are those of
        the run. Returns an array of shape (count, width), with NaN where the mass matrix is
        singular."""
        import numpy

        count, n = v.shape
        t = numpy.ascontiguousarray(numpy.broadcast_to(t, (count,)), dtype=float)
        # First-order variables are in v only: the runtime ignores q at their indices.
        whole = numpy.zeros((count, n))
        whole[:, : q.shape[1]] = q
        v = numpy.ascontiguousarray(v, dtype=float)
        out = numpy.empty((count, self._c.pk_run_width(self._run, what.encode())))
        given = None if u is None else numpy.ascontiguousarray(u, dtype=float)
        arrays = (t, whole, v, given, out)
        pointers = [None if x is None else x.ctypes.data_as(POINTER(c_double)) for x in arrays]
        self._c.pk_run_evaluate(self._run, what.encode(), count, *pointers)
        return out

    def begin(self, state: numpy.ndarray, u: numpy.ndarray) -> Callable[[float, int], int]:
        """Begins an integration step by step, with the inputs `u`. The returned function takes a
        time and whether to make only one step; it writes t, q and v to `state` and returns the
        status (enum pk_status). Raises UsageError."""
        if self._c.pk_run_begin(self._run):
            raise UsageError(self.said().strip())
        inputs, at = (x.ctypes.data_as(POINTER(c_double)) for x in (u, state))
        run, advance = self._run, self._c.pk_run_advance
        return lambda t, one: advance(run, t, one, inputs, at)

    def said(self) -> str:
        return str(self._c.pk_run_messages(self._run).decode())

    def rates(self) -> Callable[[float, numpy.ndarray], numpy.ndarray]:
        """Returns y' as a function of t and y = (coordinates, rates and first-order variables); the
        function is not reentrant. Raises UsageError if the model has no accelerations."""
        import numpy

        n, what = self._c.pk_run_width(self._run, b"acceleration"), b"acceleration"
        seen = len(self.given()["q"])
        if not n:
            raise UsageError("the model has no accelerations")
        t, q, y, out = (numpy.zeros(k) for k in (1, n, seen + n, seen + n))
        address = [x.ctypes.data for x in (t, q, y[seen:], out[seen:])]
        pointers = [ctypes.cast(a, POINTER(c_double)) for a in address]
        evaluate = self._c.pk_run_evaluate

        def rates(time: float, state: numpy.ndarray) -> numpy.ndarray:
            t[0], y[:] = time, state
            q[:seen] = y[:seen]
            evaluate(self._run, what, 1, *pointers[:-1], None, pointers[-1])
            out[:seen] = y[seen : 2 * seen]
            return out.copy()

        return rates

    def given(self) -> dict[str, list[float]]:
        """Returns the values of the parameters and the initial state that the run uses."""
        return json.loads(self._c.pk_run_given(self._run))

    def close(self) -> None:
        run, self._run = self._run, None
        if run:
            self._c.pk_run_free(run)

    __del__ = close


def _array(numbers: ctypes._Pointer, rows: int, columns: int) -> numpy.ndarray:
    """Returns a copy of an array in C; zeros if the pointer is NULL."""
    import numpy

    if not rows or not numbers:
        return numpy.zeros((rows, columns))
    return numpy.ctypeslib.as_array(numbers, (rows, columns)).copy()


def _fill(s: Structure, name: str, values: Sequence[object]) -> None:
    setattr(s, f"n_{name}", len(values))
    setattr(s, name, (_FIELDS[name]._type_ * len(values))(*values))


def _table(index: int, data: Data) -> tuple[object, ...]:
    """Returns a struct pk_run_table, which points to the memory of `data`."""
    axes = [(a.knots, a.period) for a in data.axes]
    (x, period_x), (y, period_y) = axes if len(axes) == 2 else (*axes, (axes[0][0][:0], 0.0))
    arrays = x, y, data.coefficients
    pointers = [v.ctypes.data_as(POINTER(c_double)) for v in arrays]
    counts = index, len(x), len(y), data.coefficients.size
    return *counts, *pointers, period_x, period_y, data.axes[0].strict


def column(shown: Shown | Column) -> tuple[bytes, int, int]:
    return shown.kind[0].encode(), shown.index, getattr(shown, "member", 0)


def _expected(c: Compared) -> tuple[object, ...]:
    when = b"t" if c.at is not None else b"r" if c.event is None else b"e"
    within = (b"\0", 0, 0) if c.within is None else column(c.within)
    sides = column(c.a), column(c.b), within
    return c.relation.encode(), when, *sides, c.at or 0, c.event or 0


def initializer(s: Structure) -> str:
    """Returns C code that defines a struct `program_settings` with these settings."""
    lists, members = [], []
    for name, kind in _FIELDS.items():
        value = getattr(s, name)
        if name in OF_A_CALL:
            continue
        if not issubclass(kind, ctypes._Pointer):
            members.append(f".{name} = {_literal(value)}")
        elif count := getattr(s, f"n_{name}"):
            of = kind._type_
            what = f"struct {of.__name__}" if issubclass(of, Structure) else "size_t"
            items = ", ".join(_literal(value[k]) for k in range(count))
            lists.append(f"static const {what} {name}[] = {{{items}}};")
            members.append(f".{name} = {name}")
    text = "\n".join(lists)
    return f"{text}\nconst struct pk_run_settings program_settings = {{{', '.join(members)}}};\n"


def _literal(value: object) -> str:
    if isinstance(value, Structure):
        return "{" + ", ".join(_literal(getattr(value, n)) for n, _ in value._fields_) + "}"
    if isinstance(value, bytes):
        return f'"{value.decode()}"' if len(value) != 1 else str(value[0])
    return "NULL" if value is None else repr(value)
