"""pkgen's methods, compiled with the runtime and the model as `pkgen run` does it."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from functools import cache, partial
from pathlib import Path

from ..builds import (
    AS_RUN,
    OUTPUT,
    ROOT,
    RUNTIME,
    SOURCES,
    Broken,
    Build,
    Unavailable,
    compile_program,
    runtime_library,
    written,
)
from ..contender import HALVINGS, Contender, Program, programs
from ..models import REFERENCES, Model

# What compiles a family's stepper into the model's own file (pk/inlined.h).
FAMILIES = {
    "gauss": "GAUSS",
    "dop853": "EMBEDDED",
    "rk4": "ERK",
    "verlet": "SPLITTING",
    "gauss4": "GAUSS",
    "gauss8": "GAUSS",
    "taylor": "TAYLOR",
}
FIXED_STEP = frozenset({"rk4", "verlet", "gauss4", "gauss8"})


def pkgen_python() -> str:
    """The interpreter that has pkgen: the tree's own, which is not that of the peers."""
    own = ROOT / ".venv" / "bin" / "python"
    return os.environ.get("PKGEN_PYTHON") or (str(own) if own.exists() else sys.executable)


@cache
def generated(name: str, *options: str) -> Path:
    """The folder with NAME.c and NAME.h."""
    folder = OUTPUT / "generated" / "-".join(("pkgen", *(o.strip("-") for o in options)))
    emit(ROOT / "models" / f"{name}.lag", folder, *options)
    return folder


def emit(model: Path, folder: Path, *options: str) -> None:
    """What pkgen makes of a model, into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    command = [pkgen_python(), ROOT / "bench" / "emit.py", model, folder, *options]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    if done.returncode:
        said = done.stderr.strip().splitlines() or ["?"]
        raise Broken(f"pkgen refused {model.name}: {said[-1][:200]}")


def kernel_header(model: Model, *options: str, lanes: bool = False, scalar: str = "double") -> str:
    """The path, quoted for -D, of a header that includes the generated file whole and wraps its
    kernels as `acceleration()` or `lanes()`, so that the compiler sees through them."""
    folder, name = generated(model.name, *options), model.name
    text = (folder / f"{name}.c").read_text() + (folder / f"{name}.h").read_text()
    if lanes and f"{name}_lanes(" not in text:
        raise Unavailable("this pkgen has no lane kernels")
    given = ", ".join(x.hex() for x in model.values)
    named = REFERENCES[name]["params"]
    assigned = "\n".join(f"    params.{n} = (pk_real)given[{i}];" for i, n in enumerate(named))
    wrapped = _LANES if lanes else _ACCELERATION.replace("double", scalar)
    return _quoted(
        f"{folder.name}/{name}_{'lanes' if lanes else scalar}.h",
        f"""/* {hashlib.sha256(text.encode()).hexdigest()}: of what is included */
#include "{folder}/{name}.c"
enum {{ N = {model.n} }};
static struct {name}_params params;
__attribute__((constructor)) static void set_parameters(void)
{{
    static const double given[] = {{{given}}};
    {name}_defaults(&params);
{assigned}
    {name}_prepare(&params);
}}
{wrapped.replace("NAME", name)}""",
    )


_ACCELERATION = """static int acceleration(double t, const double *q, const double *v, double *a)
{
    return NAME_acceleration(&params, t, q, v, NULL, a);
}
"""
_LANES = """static int lanes(const double *t, const double *q, const double *v, double *a)
{
    return NAME_lanes(&params, t, q, v, NULL, a) != 0;
}
"""


def _quoted(name: str, text: str) -> str:
    return f'"{written(name, text)}"'


def parameters(model: Model) -> list[str]:
    given = REFERENCES[model.name]["params"]
    return [f"{name}={value}" for name, value in given.items()]


def _open(method: str, inlined: bool, model: Model, builds: tuple[Build, ...]) -> list[Program]:
    folder = generated(model.name)
    defines = {
        "PK_RUNTIME": "",
        "BENCH_SYSTEM": f"{model.name}_system",
        "BENCH_N": str(model.n),
    }
    if inlined:
        defines[f"PK_INLINE_{FAMILIES[method]}"] = ""
    sources = [SOURCES / "pkgen_methods.c", SOURCES / "harness.c", folder / f"{model.name}.c"]
    flags = ("-std=c11", f"-I{RUNTIME / 'include'}", f"-I{folder}")

    def make(build: Build) -> Path:
        return compile_program(build, sources, defines, flags, (str(runtime_library(build)),))

    return programs(builds, make, [method, *parameters(model)])


def _open_as_run(method: str, model: Model, _: tuple[Build, ...]) -> list[Program]:
    return _open(method, True, model, AS_RUN)


def contenders() -> list[Contender]:
    found = []
    run = Contender("pkgen gauss (as pkgen run)", "pkgen", False, partial(_open_as_run, "gauss"))
    for method in FAMILIES:
        for inlined in (True, False) if method in ("gauss", "dop853") else (True,):
            fixed = method in FIXED_STEP
            name = f"pkgen {method}" + ("" if inlined else " (function pointer)")
            ladder = {"ladder": HALVINGS} if fixed else {}
            opened = partial(_open, method, inlined)
            found.append(Contender(name, "pkgen", fixed, opened, **ladder))
    return [run, *found]
