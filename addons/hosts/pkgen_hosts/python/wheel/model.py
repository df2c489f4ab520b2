"""A model of mechanics, made by pkgen: `Model()` runs it, and evaluates it at any number of states.

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
    ctypes.c_void_p: "params new t q v crossings",
    ctypes.c_size_t: "parameters rows accelerations_size take_crossings n",
    ctypes.c_char_p: "why reason",
    ctypes.c_int: "set values",
    None: "free params_free start accelerations",
}
for _kind, _names in _ANSWERS.items():
    for _name in _names.split():
        getattr(_C, f"live_{_name}").restype = _kind
_C.live_t.restype = ctypes.c_double

_COORDINATES = tuple(c["name"] for c in description["coordinates"])
_BUDGET = 100_000.0  # steps between checks for Ctrl-C
_MOTION_ENDED, _MORE = 2, 1
_MOST_ROWS = 1e9


class RunError(Exception):
    """The motion ends early; `rows` are its rows."""

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
    """Parameters by name, in SI. A default that depends on other parameters follows them until it
    is set."""

    def __init__(self, model):
        self._model = model
        self._index = {p["name"]: k for k, p in enumerate(description["parameters"])}
        self._given = np.array(
            [
                math.nan if p["follows"] or p["value"] is None else p["value"]
                for p in description["parameters"]
            ],
            float,  # even if all are integers
        )
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
    """The model, with its own parameter values. `inputs` has the constant values of inputs by name.
    """

    coordinates, rates = _COORDINATES, _RATES
    outputs = tuple(o["name"] for o in description["outputs"])
    methods = tuple(m["name"] for m in description["methods"] if m["applies"] and not m["gsl"])

    def __init__(self, **parameters):
        self._params = _C.live_params(ctypes.c_size_t(1), ctypes.c_int(1))
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
            _C.live_params_free(params)

    def _prepare(self):
        values = np.append(self.params._given, 0.0)
        if not _C.live_set(self._params, _pointer(values)):
            raise ValueError(_C.live_why().decode())
        self._values = values

    @property
    def start(self):
        """Returns y at t = 0: coordinates, then rates and first-order variables."""
        n, n_q = len(_RATES), len(_COORDINATES)
        q, v = np.zeros(n + 1), np.zeros(n + 1)
        _C.live_start(self._params, _pointer(q), _pointer(v))
        for c in description["coordinates"]:
            for array, key in ((q, "q"), (v, "v")):
                if not c[f"{key}_follows"]:
                    array[c["index"]] = c[key] or 0.0
        for r in description["rotations"]:
            for at, k in enumerate(r["rate_indices"]):
                v[k] = v[k] if r["rates_follow"][at] else r["rate_values"][at] or 0.0
        for s in description["states"]:
            v[s["index"]] = v[s["index"]] if s["follows"] else s["value"] or 0.0
        return np.concatenate([q[:n_q], v[:n]])

    def _u(self, count):
        for name in self.inputs:
            _known(name, {u["name"]: 0 for u in description["inputs"]}, "input")
        one = [float(self.inputs[u["name"]]) for u in description["inputs"]]
        return np.ascontiguousarray(np.broadcast_to(one or [0.0], (count, max(1, len(one)))))

    def _states(self, q, v, t):
        """Returns the shape, and flat arrays of all states. In C the integrals of first-order
        variables follow the coordinates; nothing depends on them."""
        n, n_q = len(_RATES), len(_COORDINATES)
        q, v, t = np.asarray(q, float), np.asarray(v, float), np.asarray(t, float)
        if q.shape[-1:] != (n_q,) or v.shape[-1:] != (n,):
            raise ValueError(f"q must be of shape (..., {n_q}), v of shape (..., {n})")
        shape = np.broadcast_shapes(q.shape[:-1], v.shape[:-1], t.shape)
        count = math.prod(shape)
        places = np.zeros((count, n))
        places[:, :n_q] = np.broadcast_to(q, (*shape, n_q)).reshape(count, n_q)
        rates = np.ascontiguousarray(np.broadcast_to(v, (*shape, n)).reshape(count, n))
        times = np.ascontiguousarray(np.broadcast_to(t, shape).reshape(count))
        return shape, count, times, places, rates, self._u(count)

    def acceleration(self, q, v, t=0.0):
        """Returns q'' (and x' of first-order variables), of shape (..., n); NaN where M is
        singular."""
        shape, count, times, places, rates, u = self._states(q, v, t)
        out, failed = np.empty_like(rates), np.zeros(count + 1, np.uint8)
        work = np.empty(_C.live_accelerations_size(self._params) + 1)
        arrays = map(_pointer, (times, places, rates, u, out, failed, work))
        _C.live_accelerations(self._params, ctypes.c_size_t(count), *arrays)
        out[failed[:count] != 0] = np.nan
        return out.reshape(*shape, len(_RATES))

    def _values_of(self, which, width, q, v, t):
        shape, count, times, places, rates, u = self._states(q, v, t)
        out = np.full((count, width), np.nan)
        sizes = (ctypes.c_int(which), ctypes.c_size_t(width), ctypes.c_size_t(count))
        arrays = map(_pointer, (times, places, rates, u, out))
        _C.live_values(self._params, *sizes, *arrays)
        return out.reshape(*shape, width)

    def energy(self, q, v, t=0.0):
        """Returns v.dL/dv - L, of shape (...)."""
        return self._values_of(2, 1, q, v, t)[..., 0]

    def observe(self, q, v, t=0.0):
        """Returns the model's outputs, of shape (..., number of outputs)."""
        return self._values_of(0, len(self.outputs), q, v, t)

    def rhs(self, t, y):
        """Returns y' of y = (q, v), of shape (n,) or (n, count), for SciPy's solve_ivp."""
        y = np.asarray(y, float)
        n = len(_COORDINATES)
        a = self.acceleration(y[:n].T, y[n:].T, t)
        return np.concatenate([y[n : 2 * n], a.T])

    def run(self, until, every=None, method=None, step=None, rtol=None, start=None):
        """Returns rows from t = 0 to `until`, `every` apart; `start` is y, or values by name.
        Raises RunError if the motion ends early."""
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
            step = every  # an exact method takes steps of any length
        if step is None and not about["adaptive"]:
            raise ValueError(f"method {method} has fixed steps: give step")
        q, v = self._begin(start)
        u = self._u(1)
        sizes = [ctypes.c_double(x) for x in (step or 0.0, rtol, 0.0)]
        motion = _C.live_new(self._params, method.encode(), *sizes, *map(_pointer, (q, v, u)))
        if not motion:
            raise ValueError(_C.live_why().decode())
        motion = ctypes.c_void_p(motion)
        try:
            return self._rows(motion, times, q, v)
        finally:
            _C.live_free(motion)

    def _begin(self, start):
        n, n_q = len(_RATES), len(_COORDINATES)
        y = self.start
        if isinstance(start, dict):
            names = {name: k for k, name in enumerate((*_COORDINATES, *_RATES))}
            for name, value in start.items():
                y[_known(name, names, "coordinate or rate")] = value
        elif start is not None:
            y = np.array(start, float)
            if y.shape != (n_q + n,):
                raise ValueError(f"start must be of shape ({n_q + n},)")
        q = np.zeros(n + 1)
        q[:n_q] = y[:n_q]
        return q, np.append(y[n_q:], 0.0)

    def _rows(self, motion, times, q, v):
        n, n_q = len(_RATES), len(_COORDINATES)
        places, rates = np.empty((len(times), n)), np.empty((len(times), n))
        made, status = 0, ctypes.c_int(0)
        while made < len(times) and status.value in (0, _MORE):
            some = slice(made, min(made + 10_000, len(times)))
            made += _C.live_rows(
                motion, ctypes.c_size_t(n), ctypes.c_size_t(some.stop - made),
                _pointer(times[some]), ctypes.c_double(_BUDGET), _pointer(places[some]),
                _pointer(rates[some]), ctypes.byref(status),
            )  # fmt: skip
        ended = status.value not in (0, _MORE)
        if ended and status.value == _MOTION_ENDED:  # adds a row at the event
            times = np.append(times[:made], _C.live_t(motion))
            last = [_array(state(motion), (n,)) for state in (_C.live_q, _C.live_v)]
            places = np.vstack([places[:made], last[0]])
            rates = np.vstack([rates[:made], last[1]])
        else:
            times, places, rates = times[:made], places[:made], rates[:made]
        rows = self._table(times, places[:, :n_q], rates, self._events(motion, n))
        if ended and status.value != _MOTION_ENDED:
            raise RunError(_C.live_reason(motion).decode(), rows)
        return rows

    def _events(self, motion, n):
        width = 2 + 2 * n
        count = _C.live_take_crossings(motion)
        if not count:
            return []
        table = _array(_C.live_crossings(motion), (count, width))
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
