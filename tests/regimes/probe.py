"""A model of models/*.lag and a method of the runtime, step by step: probe.c through ctypes."""

import ctypes
import hashlib
import os
import subprocess
import tempfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np

from pkgen.compiler import compile_model
from pkgen.run import build, named
from pkgen.source import Source
from pkgen.system import toolchain

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
REAL, SIZE, TEXT = ctypes.c_double, ctypes.c_size_t, ctypes.c_char_p
ARRAY = np.ctypeslib.ndpointer(dtype=np.float64, flags="C_CONTIGUOUS")
SIGNATURES = {
    "probe_open": (ctypes.c_void_p, [TEXT]),
    "probe_close": (None, [ctypes.c_void_p]),
    "probe_known": (ctypes.c_int, [ctypes.c_void_p]),
    "probe_set": (ctypes.c_int, [ctypes.c_void_p, SIZE, ctypes.POINTER(TEXT), ARRAY]),
    "probe_start": (None, [ctypes.c_void_p, ARRAY, ARRAY]),
    "probe_begin": (
        ctypes.c_int,
        [ctypes.c_void_p, REAL, REAL, REAL, ctypes.c_int, ctypes.c_int, REAL, ARRAY, ARRAY],
    ),
    "probe_energy": (REAL, [ctypes.c_void_p, REAL, ARRAY, ARRAY]),
    "probe_steps": (SIZE, [ctypes.c_void_p, REAL, SIZE, SIZE, ARRAY]),
    "probe_rows": (SIZE, [ctypes.c_void_p, SIZE, ARRAY, ARRAY]),
    "probe_status": (ctypes.c_int, [ctypes.c_void_p, TEXT, SIZE]),
    "probe_state": (None, [ctypes.c_void_p, ARRAY]),
    "probe_counts": (None, [ctypes.c_void_p, ctypes.POINTER(ctypes.c_ulong * 2)]),
    "probe_acceleration": (ctypes.c_int, [ctypes.c_void_p, REAL, ARRAY, ARRAY, ARRAY]),
    "misused_verlet": (REAL, [ctypes.c_void_p, REAL, SIZE, ARRAY, ARRAY]),
    "misused_variable": (REAL, [ctypes.c_void_p, REAL, REAL, ARRAY, ARRAY]),
    "plain_verlet": (None, [ctypes.c_void_p, REAL, SIZE, ARRAY, ARRAY]),
}
FOREVER = 1e15


class Failed(Exception):
    """What the runtime refused, or a step that failed: its status and its reason."""

    def __init__(self, reason: str, status: int = 0):
        super().__init__(reason)
        self.status = status


def model_path(name: str) -> Path:
    own = HERE / "models" / f"{name}.lag"
    return own if own.exists() else ROOT / "models" / f"{name}.lag"


@cache
def library(name: str, sizes: tuple[tuple[str, int], ...] = ()) -> tuple[ctypes.CDLL, list[str]]:
    """The model's C, the core and the probe in one shared object; and names of q, then of v."""
    path = model_path(name)
    made = compile_model(Source(str(path), path.read_text()), sizes=dict(sizes), unroll=16)
    tools = toolchain.find_toolchain()
    core = build.runtime_library(tools)
    sources = [HERE / "probe.c", HERE / "misused.c"]
    texts = [repr((core.name, sizes, sorted(made.files.items())))]
    texts += [(HERE / f).read_text() for f in ("probe.c", "misused.c", "probe.h")]
    digest = hashlib.sha256("".join(texts).encode()).hexdigest()[:16]
    target = ROOT / "build" / "regimes" / f"{name}-{digest}.so"
    if not target.exists():
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=target.parent, prefix=".new-") as folder:
            for file, text in made.files.items():
                (Path(folder) / file).write_text(text)
            # -Bsymbolic: the library's objects, made for programs, then link into a shared object.
            command = [*tools.cc, toolchain.STANDARD, *tools.flags, "-O1", "-shared", "-fPIC"]
            command += ["-Wl,-Bsymbolic", "-DPK_RUNTIME", f"-DMODEL={made.model.name}"]
            command += [f"-I{toolchain.RUNTIME / 'include'}", f"-I{HERE}", f"{made.model.name}.c"]
            command += [*map(str, sources), str(core / "libpk.a"), *tools.gsl_libs, "-lm"]
            subprocess.run([*command, "-o", "probe.so"], cwd=folder, check=True)
            os.replace(Path(folder) / "probe.so", target)
    found = ctypes.CDLL(str(target))
    for function, (result, arguments) in SIGNATURES.items():
        getattr(found, function).restype = result
        getattr(found, function).argtypes = arguments
    names, rates = (
        [c.name for c in named.coordinates(made, rates=rates).columns(10_000)]
        for rates in (False, True)
    )
    integrals = [f"integral of {name}" for name in rates[len(names) :]]  # of states, of no use
    return found, [*names, *integrals, *rates]


class Probe:
    """One motion: rows are t, q, v, energy."""

    def __init__(
        self,
        model: str,
        method: str,
        h: float = 0.0,
        *,
        start: Mapping[str, float] | None = None,
        set: Mapping[str, float] | None = None,
        size: Mapping[str, int] | None = None,
        tolerance: float = 1e-13,
        fixed: bool = False,  # an adaptive method too keeps its step
        fixed_point: bool = False,
        max_iterations: int = 0,
    ):
        self.lib, self.names = library(model, tuple(sorted((size or {}).items())))
        self.n = len(self.names) // 2
        self.p = self.lib.probe_open(method.encode())
        if not self.lib.probe_known(self.p):
            raise Failed(f"no method {method}")
        given = dict(set or {})
        texts = (TEXT * len(given))(*(k.encode() for k in given))
        values = np.array([*given.values(), 0.0])
        if self.lib.probe_set(self.p, len(given), texts, values):
            raise Failed(f"cannot set {given}")
        self.q, self.v = np.zeros(self.n), np.zeros(self.n)
        self.lib.probe_start(self.p, self.q, self.v)
        for name, value in (start or {}).items():
            where = self.names.index(name)
            (self.q if where < self.n else self.v)[where % self.n] = value
        self._options = (
            1e100 if fixed else tolerance,
            h if fixed else 0.0,
            int(fixed_point),
            max_iterations,
        )
        self._done(self.lib.probe_begin(self.p, h, *self._options, 0.0, self.q, self.v))

    def __del__(self):
        if getattr(self, "p", None):
            self.lib.probe_close(self.p)

    def _done(self, status: int) -> None:
        if status < 0:
            text = ctypes.create_string_buffer(300)
            self.lib.probe_status(self.p, text, 300)
            raise Failed(text.value.decode(), status)

    @property
    def status(self) -> int:
        return self.lib.probe_status(self.p, ctypes.create_string_buffer(300), 300)

    @property
    def now(self) -> np.ndarray:
        out = np.zeros(2 + 2 * self.n)
        self.lib.probe_state(self.p, out)
        return out

    def steps(self, count: int, every: int = 1, strict: bool = True) -> np.ndarray:
        """Rows after each `every` of `count` steps, forward without end."""
        rows = np.empty((count // every, 2 + 2 * self.n))
        written = self.lib.probe_steps(self.p, FOREVER, count, every, rows)
        if strict:
            self._done(self.status)
        return rows[:written]

    def at(self, times) -> np.ndarray:
        """Rows at these times, each landed on."""
        times = np.ascontiguousarray(times, dtype=np.float64)
        rows = np.empty((len(times), 2 + 2 * self.n))
        self.lib.probe_rows(self.p, len(times), times, rows)
        self._done(self.status)
        return rows

    def acceleration(self, q, v) -> np.ndarray:
        a = np.zeros(self.n)
        self.lib.probe_acceleration(
            self.p, 0.0, np.ascontiguousarray(q, float), np.ascontiguousarray(v, float), a
        )
        return a

    def energy(self, q, v) -> float:
        q, v = np.ascontiguousarray(q, float), np.ascontiguousarray(v, float)
        return self.lib.probe_energy(self.p, 0.0, q, v)
