"""CVODE from the wheel scikit-sundae, called from C with a compiled right-hand side.

Debian's libsundials is an unoptimised build and is never used. That the wheel's is optimised is
read off its machine code: without optimisation every local variable lives in memory, relative to
the frame pointer, in some third of all instructions.
"""

from __future__ import annotations

import importlib.util
import re
import shutil
import subprocess
from functools import cache, partial
from pathlib import Path

from ..builds import RUNTIME, SOURCES, Build, Unavailable, compile_program
from ..contender import Contender, Program, programs
from ..models import Model
from .gsl import equations_header

MOST_FRAME_ACCESSES = 0.15


@cache
def library() -> tuple[Path, str]:
    """libsundials_cvode of the wheel, and what is known of its build."""
    found = importlib.util.find_spec("sksundae")
    if not found:
        raise Unavailable("scikit-sundae is not installed")
    folder = Path(found.origin).parent.parent / "scikit_sundae.libs"
    libraries = sorted(folder.glob("libsundials_cvode-*"))
    if not libraries:
        raise Unavailable("the wheel of scikit-sundae has no libsundials_cvode")
    share = frame_accesses(libraries[0])
    if share > MOST_FRAME_ACCESSES:
        raise Unavailable(f"the wheel's CVODE is not optimised ({share:.0%} frame accesses)")
    version = re.search(r"\.so\.(.*)", libraries[0].name)
    return libraries[0], f"SUNDIALS {version[1]}, {share:.1%} frame accesses: optimised"


def frame_accesses(path: Path) -> float:
    """The share of instructions that reach memory relative to the frame pointer."""
    if not shutil.which("objdump"):
        raise Unavailable("objdump is missing: the build of CVODE cannot be checked")
    said = subprocess.run(["objdump", "-d", path], capture_output=True, text=True, check=True)
    lines = [line for line in said.stdout.splitlines() if line.count("\t") >= 2]
    return sum("(%rbp)" in line for line in lines) / max(1, len(lines))


def _open(method: str, model: Model, builds: tuple[Build, ...]) -> list[Program]:
    path, known = library()
    defines = {"BENCH_EQUATIONS": equations_header(model, "pkgen")}
    include = ("-std=gnu11", f"-I{RUNTIME / 'include'}")
    sources = [SOURCES / "cvode_methods.c", SOURCES / "harness.c"]
    beside = [str(path)]
    beside += [str(p) for p in path.parent.glob("libsundials_core-*")]
    libraries = (*beside, f"-Wl,-rpath,{path.parent}", f"-Wl,-rpath-link,{path.parent}")
    return programs(
        builds,
        lambda b: compile_program(b, sources, defines, include, libraries),
        [method],
        f"; {known}",
    )


def contenders() -> list[Contender]:
    return [
        Contender("CVODE Adams", "C", False, partial(_open, "adams")),
        Contender("CVODE BDF", "C", False, partial(_open, "bdf")),
    ]
