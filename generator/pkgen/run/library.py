"""A compiled model in process: the runtime's layer of runs (pk/run.h, pk/stability.h) by ctypes.

The structures below are those of the headers, member by member; `pk_run_size` tells their sizes,
and a library of others is refused. A run holds no lock of the interpreter. What is to end it is
seen in `poll`, some ten times a second.
"""

from __future__ import annotations

import ctypes
import json
import threading
from collections.abc import Callable, Sequence
from ctypes import (
    CFUNCTYPE,
    POINTER,
    Structure,
    c_char,
    c_char_p,
    c_double,
    c_int,
    c_long,
    c_size_t,
    c_uint,
    c_ulong,
    c_void_p,
)
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from ..system import children
from ..system.exits import BuildError, NumericsFailed, UsageError
from .settings import Settings, Shown

if TYPE_CHECKING:
    import numpy

    from .ensemble import Ensemble

DONE, USAGE, FAILED, INTERRUPTED = 0, 2, 4, 130  # enum pk_run_code
DERIVED = 4  # PK_FAILURE_DERIVED
POLL = CFUNCTYPE(c_int, c_void_p, c_double)
Poll = Callable[[float], bool]  # of the part that is done; True: stop


class _Value(Structure):
    _fields_ = (("index", c_size_t), ("member", c_size_t), ("value", c_double))


class _Column(Structure):
    _fields_ = (("kind", c_char), ("index", c_size_t))


class _Expected(Structure):
    _fields_ = (
        ("relation", c_char),
        ("when", c_char),
        ("a", _Column),
        ("b", _Column),
        ("within", _Column),
        ("at", c_double),
        ("event", c_size_t),
    )


class _Part(Structure):
    _fields_ = (("method", c_char_p), ("step", c_double), ("rtol", c_double), ("h_max", c_double))


class _Settings(Structure):
    _fields_ = (
        ("method", c_char_p),
        *(
            (name, c_double)
            for name in ("until", "every", "step", "rtol", "atol", "h_min", "h_max")
        ),
        ("fixed_point", c_int),
        ("max_steps", c_ulong),
        ("land", c_int),
        *((f"n_{name}", c_size_t) for name in ("sizes", "parameters", "inputs", "q", "v", "z")),
        *((name, POINTER(_Value)) for name in ("sizes", "parameters", "inputs", "q", "v", "z")),
        ("n_columns", c_size_t),
        ("columns", POINTER(_Column)),
        ("n_hidden", c_size_t),
        ("hidden", POINTER(c_size_t)),
        ("at", c_size_t),
        ("n_expected", c_size_t),
        ("n_drifts", c_size_t),
        ("expected", POINTER(_Expected)),
        ("drifts", POINTER(_Column)),
        ("diagnose", c_uint),
        ("n_parts", c_size_t),
        ("parts", POINTER(_Part)),
        ("bare", c_int),
        ("compared", c_int),
        ("cap", c_double),
        ("members", c_size_t),
        ("n_member_columns", c_size_t),
        ("member_columns", POINTER(_Column)),
        ("member_values", POINTER(c_double)),
        ("member_name", c_char_p),
        ("first_member", c_long),
        ("threads", c_size_t),
        ("watch", c_int),
        ("csv", c_int),
        ("header", c_int),
        ("poll", POLL),
        ("context", c_void_p),
    )


class _Question(Structure):
    _fields_ = (
        ("method", c_char_p),
        *((name, c_double) for name in ("h", "amplitude", "seed", "stiffness", "damping")),
        ("mode", c_long),
        ("other", c_long),
        ("count", c_size_t),
    )


# Results and arguments of each function.
_FUNCTIONS = {
    "pk_run_size": (c_size_t, c_int),
    "pk_run_defaults": (_Settings,),
    "pk_run_new": (c_void_p, c_void_p, POINTER(_Settings)),
    "pk_run_go": (c_int, c_void_p),
    "pk_run_rows": (
        c_size_t,
        c_void_p,
        POINTER(POINTER(c_double)),
        POINTER(POINTER(c_double)),
        POINTER(c_size_t),
    ),
    "pk_run_report": (c_char_p, c_void_p),
    "pk_run_messages": (c_char_p, c_void_p),
    "pk_run_refused": (c_int, c_void_p),
    "pk_run_laps": (c_double, c_void_p, c_double),
    "pk_run_given": (c_char_p, c_void_p),
    "pk_run_evaluate": (c_size_t, c_void_p, c_char_p, c_size_t, *[POINTER(c_double)] * 4),
    "pk_run_width": (c_size_t, c_void_p, c_char_p),
    "pk_run_free": (None, c_void_p),
    "pk_run_stop": (None, c_int),
    "pk_run_diagnostic": (c_uint, c_char_p),
    "pk_run_methods": (c_char_p,),
    "pk_stability_new": (c_void_p, c_void_p, POINTER(_Settings)),
    "pk_stability_ask": (c_char_p, c_void_p, c_char_p, POINTER(_Question)),
    "pk_stability_wrong": (c_char_p, c_void_p),
    "pk_stability_free": (None, c_void_p),
}


@cache
def load(path: Path) -> Library:
    """The library of a model, which stays as long as the process does."""
    return Library(path)


class Library:
    def __init__(self, path: Path):
        try:
            self.c = ctypes.CDLL(str(path))
        except OSError as error:
            raise BuildError(f"cannot load the compiled model: {error}") from None
        for name, (result, *arguments) in _FUNCTIONS.items():
            function = getattr(self.c, name)
            function.restype, function.argtypes = result, arguments
        sizes = [_Settings, _Expected, _Part, _Question]
        if [self.c.pk_run_size(k) for k in range(len(sizes))] != [*map(ctypes.sizeof, sizes)]:
            raise BuildError("the compiled model is of another version of pkgen")
        children.on_end(self.c.pk_run_stop)
        self.model = ctypes.addressof(ctypes.c_char.in_dll(self.c, "pk_model"))

    def methods(self) -> list[dict[str, object]]:
        """What the runtime says of its methods."""
        return json.loads(self.c.pk_run_methods())

    def settings(self, given: Settings, **more: object) -> _Settings:
        """As C has them; `more` are members that are set as they stand."""
        s = self.c.pk_run_defaults()
        s.method = given.method.encode()
        s.until, s.rtol = given.until, given.rtol
        s.every = -1.0 if given.every is None else given.every
        s.step, s.h_max = given.step or 0.0, given.max_step or 0.0
        s.atol = s.atol if given.atol is None else given.atol
        s.fixed_point = given.iteration == "fixed"
        s.max_steps = given.max_steps
        s.land = {"": -1, "land": 1, "dense": 0}[given.rows]
        single = [_Value(i, 0, x) for i, x in given.parameters]
        _fill(s, "parameters", [*single, *(_Value(i, k, x) for i, k, x in given.members)], _Value)
        _fill(s, "inputs", [_Value(i, 0, x) for i, x in given.inputs], _Value)
        _fill(s, "q", [_Value(i, 0, x) for i, x in given.start_q], _Value)
        _fill(s, "v", [_Value(i, 0, x) for i, x in given.start_v], _Value)
        _fill(s, "z", [_Value(i, 0, x) for i, x in given.start_z], _Value)
        _fill(s, "columns", [_column(c) for c in given.show], _Column)
        _fill(s, "hidden", given.watched.hidden, c_size_t)
        s.at = 0 if given.at is None else given.at + 1
        _fill(s, "expected", [_expected(c) for c in given.watched.compared], _Expected)
        drifts = [_Column(b"e", 0) if d is None else _Column(b"o", d) for d in given.watched.drifts]
        _fill(s, "drifts", drifts, _Column)
        for name in given.diagnose:
            s.diagnose |= self.c.pk_run_diagnostic(name.encode())
        _fill(s, "parts", [_part(p) for p in given.parts], _Part)
        s.watch = {"": 0, "events": 1, "times": 2}[given.watch]
        for name, value in more.items():
            setattr(s, name, value)
        return s

    def run(
        self,
        settings: Settings,
        poll: Poll | None = None,
        ensemble: Ensemble | None = None,
        idle: bool = False,
        **more: object,
    ) -> Run:
        """A run that is over; or an `idle` one, whose kernels are called."""
        s = self.settings(settings, **more)
        if ensemble is not None:
            count = len(ensemble.lines) * len(ensemble.columns)
            values = (c_double * count).from_buffer(ensemble.values) if count else None
            s.members = len(ensemble.lines)
            columns = [_Column(c.kind[0].encode(), c.index) for c in ensemble.columns]
            s.n_member_columns = len(columns)
            s.member_columns = (_Column * len(columns))(*columns)
            s.member_values = ctypes.cast(values, POINTER(c_double))
            if ensemble.counted:
                s.member_name = ensemble.counted.encode()
                s.first_member = ensemble.lines[0]
        return Run(self, s, poll, idle)


class Run:
    """A run that is over: `code`, `report`, `messages`; `not_finite` if a constant is not."""

    def __init__(self, library: Library, settings: _Settings, poll: Poll | None, idle: bool):
        self._c = library.c
        self._run = None
        ended: list[BaseException | bool] = []

        def ask(_context: object, part: float) -> int:
            try:
                if poll and poll(part):
                    ended.append(True)
            except BaseException as error:  # nothing may go through C
                ended.append(error)
            return int(bool(ended))

        settings.poll = POLL(ask)
        self._run = c_void_p(self._c.pk_run_new(library.model, settings))
        if not self._run:
            raise NumericsFailed("out of memory")
        self.code = DONE if idle else self._go(ended)
        for error in ended:
            if isinstance(error, BaseException):
                raise error
        self.messages = self._c.pk_run_messages(self._run).decode()
        self.not_finite = self._c.pk_run_refused(self._run) % 8 == DERIVED
        self.report = json.loads(self._c.pk_run_report(self._run))

    def _go(self, ended: list[BaseException | bool]) -> int:
        """To the end; the code. Python's handlers of signals run between Python's statements in the
        main thread alone: that one waits, so that Ctrl-C is noted in the midst of a long step."""
        codes: list[int] = []
        if threading.current_thread() is not threading.main_thread():
            return self._c.pk_run_go(self._run)
        worker = threading.Thread(target=lambda: codes.append(self._c.pk_run_go(self._run)))
        worker.start()
        while worker.is_alive():
            try:
                worker.join()
            except BaseException as error:  # the memory of the run is in use until it has ended
                ended.append(error)
        return codes[0]

    def rows(self, low: bool = False) -> numpy.ndarray:
        """Kept rows, t first (the member before it): a row each. `low`: what they lack of more
        digits, to be added."""
        import numpy

        high, rest, columns = POINTER(c_double)(), POINTER(c_double)(), c_size_t()
        count = self._c.pk_run_rows(self._run, high, rest, columns)
        of = rest if low else high
        if not count or not of:
            return numpy.zeros((count, columns.value))
        return numpy.ctypeslib.as_array(of, (count, columns.value)).copy()

    def laps(self, seconds: float) -> float:
        """Seconds of the processor for one such run without rows; infinite if it fails."""
        return self._c.pk_run_laps(self._run, seconds) or float("inf")

    def evaluate(
        self, what: str, t: numpy.ndarray, q: numpy.ndarray, v: numpy.ndarray
    ) -> numpy.ndarray:
        """A kernel at many states: q and v of shape (count, n), t (count,); the result (count,
        width), not a number where M is singular."""
        import numpy

        count, n = v.shape
        t = numpy.ascontiguousarray(numpy.broadcast_to(t, (count,)), dtype=float)
        # Of first-order variables there are rates alone: their places among q are nobody's.
        whole = numpy.zeros((count, n))
        whole[:, : q.shape[1]] = q
        v = numpy.ascontiguousarray(v, dtype=float)
        out = numpy.empty((count, self._c.pk_run_width(self._run, what.encode())))
        pointers = [x.ctypes.data_as(POINTER(c_double)) for x in (t, whole, v, out)]
        self._c.pk_run_evaluate(self._run, what.encode(), count, *pointers)
        return out

    def given(self) -> dict[str, list[float]]:
        """Parameters and start as they are in memory."""
        return json.loads(self._c.pk_run_given(self._run))

    def close(self) -> None:
        run, self._run = self._run, None
        if run:
            self._c.pk_run_free(run)

    __del__ = close


class Stability:
    """Answers about one model with settings that stay."""

    def __init__(self, library: Library, settings: Settings):
        self._c = library.c
        self._of = c_void_p(self._c.pk_stability_new(library.model, library.settings(settings)))
        self._one = threading.Lock()
        if not self._of:
            raise NumericsFailed("out of memory")

    def ask(self, what: str, **question: object) -> dict:
        """Raises UsageError."""
        q = _Question(mode=-1, other=-1)
        for name, value in question.items():
            setattr(q, name, value.encode() if isinstance(value, str) else value)
        with self._one:  # an answer stands until the next question
            found = self._c.pk_stability_ask(self._of, what.encode(), q)
            said = self._c.pk_stability_wrong(self._of).decode() if found is None else ""
        if found is None:
            raise UsageError(said.strip().splitlines()[-1])
        return json.loads(found)

    def __del__(self) -> None:
        of, self._of = self._of, None
        if of:
            self._c.pk_stability_free(of)


def _fill(s: _Settings, name: str, values: Sequence[object], kind: type) -> None:
    setattr(s, f"n_{name}", len(values))
    setattr(s, name, (kind * len(values))(*values))


def _column(shown: Shown) -> _Column:
    return _Column(shown.kind[0].encode(), shown.index)


def _expected(c) -> _Expected:
    when = b"t" if c.at is not None else b"r" if c.event is None else b"e"
    within = _Column() if c.within is None else _column(c.within)
    relation = c.relation.encode()
    return _Expected(relation, when, _column(c.a), _column(c.b), within, c.at or 0, c.event or 0)


def _part(part) -> _Part:
    return _Part(part.method.encode(), part.step or 0, part.rtol, part.max_step or 0)


def initializer(s: _Settings) -> str:
    """The C that has these settings, as `program_settings`."""
    lists, members = [], []
    for name, kind in _Settings._fields_:
        value = getattr(s, name)
        if name in ("poll", "context", "member_values"):
            continue
        if isinstance(kind, type) and issubclass(kind, ctypes._Pointer):
            count = getattr(s, f"n_{name}")
            of = kind._type_
            what = _C_NAMES.get(of, "size_t")
            items = ", ".join(_literal(value[k]) for k in range(count))
            if count:
                lists.append(f"static const {what} {name}[] = {{{items}}};")
                members.append(f".{name} = {name}")
        else:
            members.append(f".{name} = {_literal(value)}")
    text = "\n".join(lists)
    return f"{text}\nconst struct pk_run_settings program_settings = {{{', '.join(members)}}};\n"


_C_NAMES = {
    _Value: "struct pk_run_value",
    _Column: "struct pk_run_column",
    _Expected: "struct pk_run_expected",
    _Part: "struct pk_run_part",
}


def _literal(value: object) -> str:
    if isinstance(value, Structure):
        return "{" + ", ".join(_literal(getattr(value, n)) for n, _ in value._fields_) + "}"
    if isinstance(value, bytes):
        return f'"{value.decode()}"' if len(value) != 1 else str(value[0])
    return "NULL" if value is None else repr(value)
