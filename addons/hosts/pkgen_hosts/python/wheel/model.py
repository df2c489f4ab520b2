"""A mechanical model, made by pkgen. `Model()` integrates it, and evaluates it at arrays of states.

    m = Model(l2=0.5)
    rows = m.run(10, every=0.01)
    rows["theta1"], rows.t
    m.acceleration(q, v)                      # q, v of shape (..., n)
    scipy.integrate.solve_ivp(m.rhs, (0, 10), m.start)

Values are in SI. `description` lists parameters, units, methods, events.
"""

from __future__ import annotations

import ctypes
import difflib
import json
import math
from collections.abc import MutableMapping
from pathlib import Path

import numpy as np

_HERE = Path(__file__).parent
description = json.loads((_HERE / "model.json").read_text(encoding="utf-8"))
_C = ctypes.CDLL(str(next(p for p in _HERE.iterdir() if p.name.startswith("library."))))
_ANSWERS = {
    ctypes.c_void_p: "params motion_new y crossings",
    ctypes.c_size_t: "rows crossed values",
    ctypes.c_char_p: "why",
    ctypes.c_int: "set",
    ctypes.c_double: "t",
    None: "given start free params_free",
}
for _kind, _names in _ANSWERS.items():
    for _name in _names.split():
        getattr(_C, f"pk_host_{_name}").restype = _kind
_ACCELERATIONS, _ENERGY, _OUTPUTS = range(3)  # of enum pk_host_kind

_COORDINATES = tuple(c["name"] for c in description["coordinates"])
_BUDGET = 100_000.0  # steps between checks for Ctrl-C
_MOTION_ENDED, _MORE = 2, 1
_MOST_ROWS = 1e9


class RunError(Exception):
    """A step failed before the end of the run. `rows` are the rows before the failure."""

    def __init__(self, message, rows):
        super().__init__(message)
        self.rows = rows


def _rates():
    """Returns names and units of v: rates of coordinates, body rates, first-order variables."""
    found = {c["index"]: (c["rate"], c["rate_unit"]) for c in description["coordinates"]}
    for r in description["rotations"]:
        for k, name in enumerate(r["rates"]):
            found[r["rate_indices"][k]] = (name, r["rate_unit"])
    found.update({s["index"]: (s["name"], s["unit"]) for s in description["states"]})
    return [found[k] for k in sorted(found)]


_RATES = tuple(name for name, _ in _rates())
_N_Q, _N = len(_COORDINATES), len(_RATES)


def _known(name, names, kind):
    if name in names:
        return names[name]
    near = difflib.get_close_matches(name, list(names), n=3)
    more = f"; did you mean {' or '.join(map(repr, near))}?" if near else ""
    raise ValueError(f"{name}: the model has no such {kind}{more}")


def _pointer(array):
    return array.ctypes.data_as(ctypes.c_void_p)


def _array(place, shape):
    """Returns a copy of an array in C's memory."""
    if not math.prod(shape):
        return np.empty(shape)
    first = ctypes.cast(place, ctypes.POINTER(ctypes.c_double))
    return np.ctypeslib.as_array(first, shape).copy()


class Parameters(MutableMapping):
    """The model's parameters by name, in SI. The default of a parameter may depend on other
    parameters; until the parameter is set, its value follows theirs."""

    def __init__(self, model):
        self._model = model
        self._index = {p["name"]: k for k, p in enumerate(description["parameters"])}
        self._given = np.zeros(len(self._index))
        _C.pk_host_given(_pointer(self._given))
        self._default = self._given.copy()

    def __getitem__(self, name):
        return float(self._model._values[_known(name, self._index, "parameter")])

    def __setitem__(self, name, value):
        self._take(_known(name, self._index, "parameter"), float(value))

    def __delitem__(self, name):
        k = _known(name, self._index, "parameter")
        self._take(k, self._default[k])

    def _take(self, k, value):
        before = self._given[k]
        self._given[k] = value
        try:
            self._model._prepare()
        except ValueError:
            self._given[k] = before
            self._model._prepare()
            raise

    def __iter__(self):
        return iter(self._index)

    def __len__(self):
        return len(self._index)

    def __repr__(self):
        return f"{{{', '.join(f'{name}={self[name]:g}' for name in self)}}}"


class Rows:
    """The result of a run: `rows["theta1"]`, `rows.t`, `rows.events` as (name, t), `rows.units`."""

    def __init__(self, columns, units, events):
        self._columns, self.units, self.events = columns, units, events

    @property
    def columns(self):
        return tuple(self._columns)

    @property
    def t(self):
        return self._columns["t"]

    def __getitem__(self, name):
        return (
            self._columns[name] if name in self._columns else _known(name, self._columns, "column")
        )

    def __len__(self):
        return len(self.t)

    def __repr__(self):
        return f"<{len(self)} rows of {', '.join(self.columns)}>"


class Model:
    """The model with its own set of parameter values. `inputs` has the constant inputs by name."""

    coordinates, rates = _COORDINATES, _RATES
    outputs = tuple(o["name"] for o in description["outputs"])
    methods = tuple(m["name"] for m in description["methods"] if m["applies"] and not m["gsl"])

    def __init__(self, **parameters):
        self._params = _C.pk_host_params(ctypes.c_size_t(1), ctypes.c_int(1))
        if not self._params:
            raise MemoryError
        self._params = ctypes.c_void_p(self._params)
        self.params = Parameters(self)
        self.inputs = {u["name"]: u["value"] for u in description["inputs"]}
        self._prepare()
        for name, value in parameters.items():
            self.params[name] = value

    def __del__(self):
        params, self._params = getattr(self, "_params", None), None
        if params:
            _C.pk_host_params_free(params)

    def _prepare(self):
        values = np.append(self.params._given, 0.0)
        if not _C.pk_host_set(self._params, _pointer(values)):
            raise ValueError(_C.pk_host_why().decode())
        self._values = values

    @property
    def start(self):
        """Returns y at t = 0: coordinates, then rates and first-order variables."""
        y = np.zeros(2 * _N)
        _C.pk_host_start(self._params, _pointer(y))
        return y[: _N_Q + _N]

    def _u(self, count):
        for name in self.inputs:
            _known(name, {u["name"]: 0 for u in description["inputs"]}, "input")
        one = [float(self.inputs[u["name"]]) for u in description["inputs"]]
        return np.ascontiguousarray(np.broadcast_to(one or [0.0], (count, max(1, len(one)))))

    def _values_of(self, kind, width, q, v, t):
        q, v, t = np.asarray(q, float), np.asarray(v, float), np.asarray(t, float)
        if q.shape[-1:] != (_N_Q,) or v.shape[-1:] != (_N,):
            raise ValueError(f"q must be of shape (..., {_N_Q}), v of shape (..., {_N})")
        shape = np.broadcast_shapes(q.shape[:-1], v.shape[:-1], t.shape)
        count = math.prod(shape)
        y = np.empty((*shape, _N_Q + _N))
        y[..., :_N_Q], y[..., _N_Q:] = q, v
        times = np.ascontiguousarray(np.broadcast_to(t, shape))
        out = np.empty((*shape, width))
        arrays = map(_pointer, (times, y, self._u(count), out))
        _C.pk_host_values(self._params, ctypes.c_int(kind), ctypes.c_size_t(count), *arrays)
        return out

    def acceleration(self, q, v, t=0.0):
        """Returns the accelerations q'' (and the rates x' of first-order variables), of shape (...,
        n); NaN where the mass matrix is singular."""
        return self._values_of(_ACCELERATIONS, _N, q, v, t)

    def energy(self, q, v, t=0.0):
        """Returns the energy v.dL/dv - L, of shape (...)."""
        return self._values_of(_ENERGY, 1, q, v, t)[..., 0]

    def observe(self, q, v, t=0.0):
        """Returns the model's outputs, of shape (..., number of outputs)."""
        return self._values_of(_OUTPUTS, len(self.outputs), q, v, t)

    def rhs(self, t, y):
        """Returns y' of y = (q, v), of shape (n,) or (n, count), for SciPy's solve_ivp."""
        y = np.asarray(y, float)
        a = self.acceleration(y[:_N_Q].T, y[_N_Q:].T, t)
        return np.concatenate([y[_N_Q : 2 * _N_Q], a.T])

    def run(self, until, every=None, method=None, step=None, rtol=None, start=None):
        """Returns rows at t = 0 to `until`, `every` apart in s. `start` is y at t = 0, or values by
        name. An event may end the motion before `until`. Raises RunError if a step fails."""
        default = description["run"]
        method = _known(method or default["method"], {m: m for m in self.methods}, "method")
        until = float(until)
        every = until / 1000 if every is None else float(every)
        rtol = default["rtol"] if rtol is None else float(rtol)
        if not (0 < until < math.inf and 0 < every <= until):
            raise ValueError("until and every must be positive and finite, every at most until")
        if not until / every < _MOST_ROWS:
            raise ValueError(
                f"every: rows would be {until / every:.3g}, at most {_MOST_ROWS:g} can be"
            )
        if step is not None and not step > 0:
            raise ValueError("the step must be positive and finite")
        count = math.floor(until / every * (1 + 1e-12)) + 1
        times = np.minimum(np.arange(count) * every, until)
        if until - times[-1] > 1e-9 * until:
            times = np.append(times, until)
        about = next(m for m in description["methods"] if m["name"] == method)
        if step is None and method == default["method"]:
            step = default["step"]
        if step is None and about["exact"]:
            step = every  # An exact method has no error, however long the step.
        if step is None and not about["adaptive"]:
            raise ValueError(f"method {method} has fixed steps: give step")
        y, u = self._begin(start), self._u(1)
        sizes = [ctypes.c_double(x) for x in (step or 0.0, rtol, 0.0)]
        motion = _C.pk_host_motion_new(
            self._params, method.encode(), *sizes, _pointer(y), _pointer(u)
        )
        if not motion:
            raise ValueError(_C.pk_host_why().decode())
        motion = ctypes.c_void_p(motion)
        try:
            return self._rows(motion, times)
        finally:
            _C.pk_host_free(motion)

    def _begin(self, start):
        y = self.start
        if isinstance(start, dict):
            names = {name: k for k, name in enumerate((*_COORDINATES, *_RATES))}
            for name, value in start.items():
                y[_known(name, names, "coordinate or rate")] = value
        elif start is not None:
            y = np.array(start, float)
            if y.shape != (_N_Q + _N,):
                raise ValueError(f"start must be of shape ({_N_Q + _N},)")
        return y

    def _rows(self, motion, times):
        y = np.empty((len(times), _N_Q + _N))
        made, status = 0, ctypes.c_int(0)
        while made < len(times) and status.value in (0, _MORE):
            some = slice(made, min(made + 10_000, len(times)))
            made += _C.pk_host_rows(
                motion, ctypes.c_size_t(some.stop - made), _pointer(times[some]),
                ctypes.c_double(_BUDGET), _pointer(y[some]), ctypes.byref(status),
            )  # fmt: skip
        why = _C.pk_host_why().decode()
        times, y = times[:made], y[:made]
        if status.value == _MOTION_ENDED:  # the last row is the state at the event
            times = np.append(times, _C.pk_host_t(motion))
            y = np.vstack([y, _array(_C.pk_host_y(motion), (_N_Q + _N,))])
        rows = self._table(times, y[:, :_N_Q], y[:, _N_Q:], self._events(motion))
        if status.value not in (0, _MORE, _MOTION_ENDED):
            raise RunError(why, rows)
        return rows

    def _events(self, motion):
        count = _C.pk_host_crossed(motion)
        table = _array(_C.pk_host_crossings(motion), (count, 2 + _N_Q + _N))
        names = [e["name"] for e in description["events"]]
        return [(names[int(row[0])], float(row[1])) for row in table]

    def _table(self, times, q, v, events):
        time = "" if description["dimensionless"] else "s"
        columns, units = {"t": times}, {"t": time}
        for k, c in enumerate(description["coordinates"]):
            columns[c["name"]], units[c["name"]] = q[:, k], c["unit"]
        for k, (name, unit) in enumerate(_rates()):
            columns[name], units[name] = v[:, k], unit
        found = self.observe(q, v, times) if self.outputs else None
        for k, o in enumerate(description["outputs"]):
            columns[o["name"]], units[o["name"]] = found[:, k], o["unit"]
        for c in description["constants"]:
            if c["kind"] == "energy":
                columns["energy"], units["energy"] = self.energy(q, v, times), c["unit"]
        return Rows(columns, units, events)

    def __repr__(self):
        return f"<{description['model']}: {', '.join(_COORDINATES or _RATES)}>"
