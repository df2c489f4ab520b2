"""Compiles emitted C and calls its kernels through ctypes; the models that its tests share."""

import ctypes
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from conftest import STRICT
from pkgen.back.c import lower, render
from pkgen.back.c.program import Program
from pkgen.back.kernels import kernel as spec_of
from pkgen.equations import Equations
from pkgen.front.check import check
from pkgen.middle.analyze import analyze
from pkgen.middle.derive import derive
from pkgen.middle.structure import Structure
from pkgen.model import Model
from pkgen.source import Source

ROOT = Path(__file__).parents[2]
MODELS = sorted((ROOT / "models").glob("*.lag"))
COMPILERS = ("gcc", "clang")
TYPES = {"float": ["-DPK_FLOAT"], "double": [], "long double": ["-DPK_LONG_DOUBLE"]}


# What a kernel returns that fails: enum pk_failure.
MASS, CONSTRAINT, PARAMETER, DERIVED, SIZE = range(1, 6)


def failed(failure: int, number: int = 0) -> int:
    """PK_FAILED(failure, number)."""
    return failure + 8 * number


# Quick ones have each compiler and each type at least once.
BUILDS = [
    pytest.param(c, t, marks=[] if quick else pytest.mark.long, id=f"{c}-{t}")
    for c, t, quick in [
        ("gcc", "double", True),
        ("gcc", "float", True),
        ("gcc", "long double", False),
        ("clang", "float", False),
        ("clang", "double", False),
        ("clang", "long double", True),
    ]
]
# A model's code alone, with what the runtime calls, and with steps too: each has all of the last.
RUNTIME = ["-DPK_RUNTIME", f"-I{ROOT / 'runtime' / 'include'}"]
FAMILIES = ("ERK", "EMBEDDED", "SPLITTING", "ENSEMBLE")
INLINED = [*RUNTIME, *(f"-DPK_INLINE_{family}" for family in FAMILIES)]


def no_warnings(compiler: str, scalar: str, name: str, folder: Path) -> None:
    """Of a model's code in its three forms. Warnings that need optimisation are gcc's, the same in
    every type, and the last form has the code of all: all else is only read."""
    for more in ([], RUNTIME, INLINED):
        optimised = (compiler, scalar, more) == ("gcc", "double", INLINED)
        how = ["-O1", "-c", "-o", "x.o"] if optimised else ["-fsyntax-only"]
        run(compiler, *STRICT, *TYPES[scalar], *how, *more, f"{name}.c", cwd=folder)


# Every helper, every kind of power, an input, dissipation, families, names that are macros.
ODD = """\
model odd    # ends with */ and ??/
size N = 3
param I = 2 in (0, inf)
param M_PI = 0.3
param k[i = 1..N] = 2 + i in [0, inf)
param linux = 1/3
param c = 2*I*M_PI in (0.1, 100]
param y1 = -0.7
coord q[1..N]
coord p, gamma
input push
fixed q[0] = 0.1*sin(linux*t), q[N+1] = 0
kinetic I/2*p'^2 + I/2*gamma'^2*(2 + sin(p))^(3/2) + I*p'*gamma'/5 + sum(I/2*q[i]'^2, i = 1..N)
potential sum(k[1]/2*(q[i+1] - q[i])^2, i = 0..N) + k[2]*abs(p) + k[3]*max(gamma, y1)*pi^(1/3)
potential sqrt(1 + p^2 + gamma^4) + (2 + cos(p))^(-5/3) + exp(-q[1]^2)/(1 + q[2]^2)^3
dissipation c/2*p'^2 + c*min(gamma', 0.5)^2*step(p)
force gamma = push*cos(p)
observe far = q[2] + p
observe near = atan2(p, 2 + gamma)
conserve nothing = I*p'
event meet: q[2] + p - 0.1*t rising stop  # where ??/ they meet
event work: energy - push*gamma' + far falling
event turn: p_gamma
start q[1] = 0.2, p = 0.3, gamma' = pi/2
"""


def texts():
    return [*((path.stem, path.read_text(encoding="utf-8")) for path in MODELS), ("odd", ODD)]


def read_model(path: Path) -> tuple[Equations, Program]:
    return read_text(path.read_text(encoding="utf-8"), path.name)


def read_text(text: str, name: str = "model.lag") -> tuple[Equations, Program]:
    model, _ = check.check_text(Source(name, text))
    equations = derive.derive(model)
    return equations, lower.lower(equations, analyze.analyze(equations, with_claims=True))


def without_facts(n: int, **known: bool) -> Structure:
    """Of n coordinates: nothing is proved but what is said."""
    names = "mass_constant mass_diagonal quadratic separable autonomous conservative variational"
    return Structure(
        **(dict.fromkeys([*names.split(), "smooth"], False) | known), cyclic=(False,) * n
    )


def lowered(model: Model | str, *kernels: str, unroll: bool = True, **known: bool) -> Program:
    """The program of a model, or of its text, without its facts; M a = f is left to a loop where
    it is not to be unrolled."""
    if isinstance(model, str):
        model, _ = check.check_text(Source("model.lag", model))
    e = derive.derive(model)
    e = e if unroll else replace(e, acceleration=None, pivots=None)
    return lower.lower(e, without_facts(len(e.coordinates), **known), frozenset(kernels) or None)


def write(program: Program, directory: Path, *, self_test: bool = False) -> list[str]:
    """The files of a program in a directory; their names."""
    files = render.render(program, self_test=self_test)
    for name, text in files.items():
        (directory / name).write_text(text, encoding="utf-8")
    return sorted(files)


def run(*command: str | Path, cwd: Path) -> str:
    """Its output; a failure shows everything it said."""
    assert shutil.which(str(command[0])) or Path(command[0]).exists(), f"{command[0]} is missing"
    done = subprocess.run(
        [str(x) for x in command], cwd=cwd, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}"
    return done.stdout


class Loaded:
    """A model compiled to a shared object, in double; kernels take and give lists of floats."""

    def __init__(
        self, program: Program, directory: Path, compiler: str = "gcc", optimise: str = "-O1"
    ) -> None:
        self.program = program
        self.name = program.equations.model.name
        write(program, directory)
        library = directory / f"{self.name}.so"
        flags = [optimise, "-ffp-contract=off", "-shared", "-fPIC"]
        run(compiler, *STRICT, *flags, f"{self.name}.c", "-o", library, "-lm", cwd=directory)
        self.library = ctypes.CDLL(str(library))
        count = len(program.parameter_names) + len(program.constants)
        if program.factored:
            n = len(program.equations.coordinates)
            count += n * n + n
        count += len(program.equations.switches)
        count += len(program.tables)  # pointers, as long as a double
        self.params = (ctypes.c_double * max(1, count))()
        self.function("defaults", None)(self.params)

    def function(self, name: str, result: object):
        function = getattr(self.library, f"{self.name}_{name}")
        function.restype = result
        return function

    def prepare(self) -> int:
        return self.function("prepare", ctypes.c_int)(self.params)

    def derive(self, given: list[int] | None = None) -> None:
        flags = None if given is None else (ctypes.c_ubyte * len(given))(*given)
        self.function("derive", None)(self.params, flags)

    def call(self, kernel: str, t=0.0, q=(), v=(), u=(), a=()) -> tuple[object, list[list[float]]]:
        """What a kernel returns and the arrays that it writes."""
        spec = self.program.kernel(kernel)
        assert spec is not None, kernel
        function = self.function(
            kernel, {"int": ctypes.c_int, "void": None, "pk_real": ctypes.c_double}[spec.result]
        )
        outputs = [(ctypes.c_double * o.length)(*[9.875] * o.length) for o in spec.outputs]
        arrays = [
            (ctypes.c_double * max(1, len(x)))(*x)
            for x in (q, v, u, *([a] * len(spec_of(kernel).given)))
        ]
        result = function(self.params, ctypes.c_double(t), *arrays, *outputs)
        return result, [list(o) for o in outputs]
