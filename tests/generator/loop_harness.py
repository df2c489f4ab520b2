"""Looped C loaded beside the unrolled C of the same model, at any size, through ctypes."""

import ctypes
from pathlib import Path

from c_harness import STRICT, Loaded, run

from pkgen.back.c import lower
from pkgen.back.c.families.lower import lower_families
from pkgen.back.c.render import render_families
from pkgen.front.check import check
from pkgen.middle.analyze import analyze
from pkgen.middle.derive import derive
from pkgen.middle.derive.states import as_rates
from pkgen.middle.families.derive import derive_families
from pkgen.middle.families.equations import FamilyEquations
from pkgen.source import Source


def looped(text: str) -> FamilyEquations:
    model, _ = check.check_text(Source("model.lag", text))
    return derive_families(model)


class Written(Loaded):
    """The model at one size, unrolled."""

    def __init__(self, text: str, size: int, directory: Path) -> None:
        model, _ = check.check_text(Source("model.lag", text), {"N": size})
        equations = derive.derive(model)
        directory.mkdir(exist_ok=True)
        in_c = as_rates(equations, analyze.analyze(equations), None)
        super().__init__(lower.lower(*in_c), directory, optimise="-O0")


class Looped:
    """The model with families as loops, in double; one library for all sizes."""

    def __init__(self, text: str, directory: Path, flags: tuple[str, ...] = ()) -> None:
        self.equations = looped(text)
        self.name = self.equations.model.name
        directory.mkdir(exist_ok=True)
        files = render_families(lower_families(self.equations))
        for name, content in files.items():
            (directory / name).write_text(content, encoding="utf-8")
        library = directory / f"{self.name}-loops.so"
        flags = ("-Wshadow", "-O2", "-ffp-contract=off", "-shared", "-fPIC", *flags)
        run("gcc", *STRICT, *flags, f"{self.name}.c", "-o", library, "-lm", cwd=directory)
        self.library = ctypes.CDLL(str(library))
        self.types = {}
        fields = [(s.name, ctypes.c_ssize_t) for s in self.equations.model.sizes]
        for group in self.equations.parameters:
            kind = ctypes.POINTER(ctypes.c_double) if group.is_family else ctypes.c_double
            fields.append((group.name, kind))
        fields += [(table.name, ctypes.c_void_p) for table in self.equations.model.tables]
        header = files[f"{self.name}.h"]
        hoisted, places = (
            int(header.split(field)[1].split("]")[0]) if field in header else 0
            for field in ("pk_real c_[", "ptrdiff_t at_[")
        )
        fields += [
            ("c_", ctypes.c_double * hoisted),
            ("work_", ctypes.c_void_p),
            *([("failed_", ctypes.c_int)] if "int failed_" in header else []),
            ("at_", ctypes.c_ssize_t * places),
        ]
        switches = len(self.equations.switches)
        if switches:
            fields.append(("side_", ctypes.POINTER(ctypes.c_double)))
            places = ctypes.c_ssize_t * switches
            fields += [(name, places) for name in ("side_lo_", "side_hi_", "side_at_")]
        self.struct = type("Params", (ctypes.Structure,), {"_fields_": fields})

    def function(self, name: str, result: object = None):
        function = getattr(self.library, f"{self.name}_{name}")
        function.restype = result
        return function

    def at(self, size: int) -> "LoopedAt":
        return LoopedAt(self, size)


class LoopedAt:
    """The library at one size, its parameters at their defaults."""

    def __init__(self, of: Looped, size: int) -> None:
        self.of = of
        self.params = of.struct()
        of.function("sizes")(ctypes.byref(self.params))
        self.params.N = size
        bytes_ = of.function("block_size", ctypes.c_size_t)(ctypes.byref(self.params))
        self.block = (ctypes.c_char * max(8, bytes_))()
        of.function("attach")(ctypes.byref(self.params), self.block)
        of.function("defaults")(ctypes.byref(self.params))
        assert self.prepare() == 0
        self.restless = False  # whether kernels find what they need as of another state
        self.n = of.function("count", ctypes.c_size_t)(ctypes.byref(self.params))

    def prepare(self) -> int:
        return self.of.function("prepare", ctypes.c_int)(ctypes.byref(self.params))

    def mass_size(self) -> int:
        return self.of.function("mass_size", ctypes.c_size_t)(ctypes.byref(self.params))

    def start(self) -> tuple[list[float], list[float]]:
        q, v = (ctypes.c_double * self.n)(), (ctypes.c_double * self.n)()
        self.of.function("start")(ctypes.byref(self.params), q, v)
        return list(q), list(v)

    def call(self, kernel: str, t, q, v, u, lengths: tuple[int, ...], result=None):
        """What a kernel returns, and the arrays of the lengths given that it writes."""
        if self.restless and q is not None:
            self.restless = False
            elsewhere = t + 1, [0.3 - x for x in q], [0.2 - x for x in v], u
            self.call("acceleration", *elsewhere, (self.n,), ctypes.c_int)
            self.restless = True
        arrays = [None if x is None else (ctypes.c_double * max(1, len(x)))(*x) for x in (q, v, u)]
        outputs = [(ctypes.c_double * n)(*[9.875] * n) for n in lengths]
        function = self.of.function(kernel, result)
        value = function(ctypes.byref(self.params), ctypes.c_double(t), *arrays, *outputs)
        return value, [list(o) for o in outputs]
