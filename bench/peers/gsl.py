"""GSL's steppers, on pkgen's kernel and on SymPy's C: rk8pd, rkf45, msadams."""

from __future__ import annotations

import shlex
import shutil
import subprocess
from functools import partial

from .. import codegen
from ..builds import RUNTIME, SOURCES, Build, Unavailable, compile_program, written
from ..contender import Contender, Program, programs
from ..models import Model
from .own import kernel_header

STEPPERS = ("rk8pd", "rkf45", "msadams")


def equations_header(model: Model, source: str) -> str:
    """The path, quoted for -D, of a header with `acceleration()` by pkgen or by SymPy."""
    if source == "pkgen":
        return kernel_header(model)
    text = "#include <math.h>\n" + codegen.acceleration(model)
    return f'"{written(f"{source}/{model.name}_equations.h", text)}"'


def _open(stepper: str, source: str, model: Model, builds: tuple[Build, ...]) -> list[Program]:
    config = shutil.which("gsl-config")
    if not config:
        raise Unavailable("GSL is not installed (no gsl-config)")
    said = subprocess.run([config, "--libs"], capture_output=True, text=True, check=True).stdout
    defines = {"BENCH_EQUATIONS": equations_header(model, source)}
    include = ("-std=gnu11", f"-I{RUNTIME / 'include'}")
    sources = [SOURCES / "gsl_methods.c", SOURCES / "harness.c"]
    libraries = tuple(shlex.split(said))
    return programs(
        builds, lambda b: compile_program(b, sources, defines, include, libraries), [stepper]
    )


def contenders() -> list[Contender]:
    found = [Contender(f"GSL {s}", "C", False, partial(_open, s, "pkgen")) for s in STEPPERS]
    found.append(Contender("SymPy cse + GSL rk8pd", "C", False, partial(_open, "rk8pd", "sympy")))
    return found
