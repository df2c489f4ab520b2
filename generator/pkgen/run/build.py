"""From generated C to a program that integrates it: the C compiler, the runtime, the cache.

The runtime and the driver are compiled once for each compiler, flags and processor, a model once
for each text and family of methods; both are kept in `PKGEN_CACHE`, else `$XDG_CACHE_HOME/pkgen`,
else `~/.cache/pkgen`. A cache that comes to another processor is not used there, since programs
are made for the one at hand.
"""

from __future__ import annotations

import hashlib
import json
import shlex
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..back.c.render import is_portable
from ..methods import inline_flags
from ..system import children
from ..system.cache import cached
from ..system.progress import say
from ..system.toolchain import (
    RUNTIME,
    STANDARD,
    BuildError,
    Toolchain,
    compile_c,
    find_toolchain,
    run,
)

LINK_WITH = "link"  # the file beside the libraries with what their users link with


def runtime_library(tools: Toolchain) -> Path:
    """The directory with libpk.a and librun.a for this compiler, made if missing."""
    return cached("runtime", _runtime_name(tools), lambda new: _build_runtime(tools, new))


def _runtime_name(tools: Toolchain) -> str:
    digest = hashlib.sha256(repr((tools, STANDARD)).encode())
    for path in sorted(RUNTIME.rglob("*.[ch]")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:24]


def _build_runtime(tools: Toolchain, directory: Path) -> None:
    libraries = {
        "libpk.a": ["src"] + (["gsl"] if tools.has_gsl else []),
        "librun.a": ["run", "omp"],
    }
    ar = shutil.which("ar")
    if ar is None:
        raise BuildError("'ar' is missing; install binutils")
    say("compiling the runtime (once, 20 s)")
    threads = _threads(tools, directory)
    (directory / LINK_WITH).write_text(shlex.join(threads), encoding="utf-8")
    for library, parts in libraries.items():
        objects = []
        for path in (p for part in parts for p in sorted((RUNTIME / part).rglob("*.c"))):
            objects.append(f"{path.parent.name}_{path.stem}.o")
            more = [*_gsl(tools), *(threads if path.parent.name == "omp" else [])]
            compile_c(tools, ["-c", *more, str(path), "-o", objects[-1]], directory)
        run([ar, "rcs", library, *objects], directory)
        for name in objects:
            (directory / name).unlink()


def _threads(tools: Toolchain, directory: Path) -> list[str]:
    """Flags for OpenMP, where the compiler can link with it."""
    (directory / "omp.c").write_text(
        "#include <omp.h>\nint main(void) { return omp_get_max_threads() < 1; }\n",
        encoding="utf-8",
    )
    try:
        compile_c(tools, ["-fopenmp", "omp.c", "-o", "omp"], directory)
    except BuildError:
        return []
    return ["-fopenmp"]


def _gsl(tools: Toolchain) -> list[str]:
    return ["-DPK_WITH_GSL", *(tools.gsl_cflags or ())] if tools.has_gsl else []


# The driver is linked with whatever model this names.
CHOICE_FILE = "which-model.c"  # no model can be called that
CHOICE = """#include <pk/apart.h>
extern const struct pk_system {name}_system;
extern const struct pk_system *const run_model;
extern const struct pk_part *const run_parts;
extern const size_t run_n_parts;
const struct pk_system *const run_model = &{name}_system;
"""
WHOLE = """const struct pk_part *const run_parts = NULL;
const size_t run_n_parts = 0;
"""

Parts = Sequence[tuple[str, Sequence[int]]]  # of a model: the name of each, its coordinates


def _choice(name: str, parts: Parts) -> str:
    """The C that says which model is run, and in which parts."""
    text = CHOICE.format(name=name)
    if not parts:
        return text + WHOLE
    rows = []
    for k, (part, coordinates) in enumerate(parts):
        text += f"extern const struct pk_system {part}_system;\n"
        text += f"static const size_t part{k}[] = {{{', '.join(map(str, coordinates))}}};\n"
        rows.append(f"    {{&{part}_system, part{k}}},\n")
    text += "static const struct pk_part parts[] = {\n" + "".join(rows) + "};\n"
    text += "const struct pk_part *const run_parts = parts;\n"
    return text + f"const size_t run_n_parts = {len(parts)};\n"


def build_program(
    files: dict[str, str],
    name: str,
    *methods: str | None,
    ensemble: bool = False,
    tools: Toolchain | None = None,
    parts: Parts = (),
) -> Path:
    """A program that integrates the model NAME, from its generated files, by any method; by
    `methods` fastest, and by blocks of an ensemble's members. With `parts`, NAME has no more than
    outputs, and these are integrated.

    Raises BuildError with what the compiler said.
    """
    tools = tools or find_toolchain()
    if is_portable(files):  # the runtime is then to be so as well
        tools = replace(tools, flags=(*tools.flags, "-DPK_PORTABLE"))
    inlined = inline_flags(methods)
    inlined += ["-DPK_INLINE_ENSEMBLE"] if inlined and ensemble else []
    choice = _choice(name, parts)
    made_of = (_runtime_name(tools), inlined, choice, sorted(files.items()))
    digest = hashlib.sha256(repr(made_of).encode()).hexdigest()[:24]

    def make(new: Path) -> None:
        library = runtime_library(tools)
        for file_name, text in {**files, CHOICE_FILE: choice}.items():
            (new / file_name).write_text(text, encoding="utf-8")
        libraries = [str(library / archive) for archive in ("librun.a", "libpk.a")]
        libraries += [*tools.gsl_libs, "-lm"]
        libraries += shlex.split((library / LINK_WITH).read_text(encoding="utf-8"))
        sources = [CHOICE_FILE, *([f"{part}.c" for part, _ in parts] or [f"{name}.c"])]
        if parts:
            compile_c(tools, ["-DPK_RUNTIME", "-c", f"{name}.c"], new)
            sources.append(f"{name}.o")
        linked = [*sources, "-o", "program", *libraries]
        compile_c(tools, ["-DPK_RUNTIME", *inlined, *linked], new)

    return cached("programs", f"{name[:40]}-{digest}", make) / "program"


# The driver lists its methods without a model; it links with this one.
NO_MODEL = """#include <pk/system.h>
extern const struct pk_system no_model_system;
const struct pk_system no_model_system = {.abi = PK_ABI, .name = "no_model"};
"""


def driver_methods() -> list[dict[str, object]]:
    """The methods of the runtime, GSL's included where GSL is installed, as it describes them."""
    program = build_program({"no_model.c": NO_MODEL}, "no_model")

    def make(new: Path) -> None:  # to find their limits takes seconds
        done = subprocess.run(
            [program, "--methods"], capture_output=True, text=True, check=True, **children.group()
        )
        (new / "methods").write_text(done.stdout, encoding="utf-8")

    listed = cached("methods", program.parent.name, make) / "methods"
    return [json.loads(line) for line in listed.read_text(encoding="utf-8").splitlines()]
