"""From generated C to a library that integrates it: the C compiler, the runtime, the cache.

The runtime is compiled once for each compiler, flags and processor, a model once
for each text and family of methods; both are kept in `PKGEN_CACHE`, else `$XDG_CACHE_HOME/pkgen`,
else `~/.cache/pkgen`. A cache that comes to another processor is not used there, since libraries
are made for the one at hand.
"""

from __future__ import annotations

import hashlib
import json
import os
import shlex
import shutil
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

from ..back.c.render import is_portable
from ..methods import Own, inline_flags
from ..own import in_c
from ..system.cache import cached
from ..system.files import scratch
from ..system.progress import say
from ..system.toolchain import (
    NATIVE,
    RUNTIME,
    STANDARD,
    BuildError,
    Toolchain,
    compile_c,
    find_toolchain,
    run,
)
from .library import load

SHARED = ("-fPIC", "-fno-semantic-interposition")
HIDDEN = "-fvisibility=hidden"  # what no header declares
GSL = "libpk_gsl.a"
ARCHIVES = {"librun.a": ("run", "omp"), GSL: ("gsl",), "libpk.a": ("src",)}  # of folders
LINK_WITH = "link"  # the file beside the libraries with what their users link with


def runtime_library(tools: Toolchain) -> Path:
    """The directory with librun.a, libpk_gsl.a where there is GSL, and libpk.a for this compiler,
    made if missing."""
    return cached("runtime", _runtime_name(tools), lambda new: _build_runtime(tools, new))


def _runtime_name(tools: Toolchain) -> str:
    digest = hashlib.sha256(repr((tools, STANDARD)).encode())
    for path in (Path(__file__), *sorted(RUNTIME.rglob("*.[ch]"))):  # what is linked, and how
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:24]


def _build_runtime(tools: Toolchain, directory: Path) -> None:
    ar = shutil.which("ar")
    if ar is None:
        raise BuildError("'ar' is missing; install binutils")
    say("compiling the runtime (once, 10 s)")
    threads = _threads(tools, directory)
    (directory / LINK_WITH).write_text(shlex.join(threads), encoding="utf-8")
    for library, parts in ARCHIVES.items():
        if library == GSL and not tools.has_gsl:
            continue
        sources = [path for part in parts for path in sorted((RUNTIME / part).rglob("*.c"))]
        objects = {f"{path.parent.name}_{path.stem}.o": path for path in sources}

        def one(name: str, path: Path) -> None:
            more = [*_gsl(tools), *(threads if path.parent.name == "omp" else [])]
            compile_c(tools, ["-c", *SHARED, HIDDEN, *more, str(path), "-o", name], directory)

        with ThreadPoolExecutor(os.cpu_count()) as pool:
            list(pool.map(one, objects, objects.values()))
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


def runtime_links(tools: Toolchain, library: Path) -> list[str]:
    """What librun.a is linked with: GSL's methods beside the core, which is without them."""
    gsl = [str(library / GSL)] if tools.has_gsl else []
    threads = shlex.split((library / LINK_WITH).read_text(encoding="utf-8"))
    return [*gsl, str(library / "libpk.a"), *tools.gsl_libs, "-lm", *threads]


def _gsl(tools: Toolchain) -> list[str]:
    return ["-DPK_WITH_GSL", *(tools.gsl_cflags or ())] if tools.has_gsl else []


# What says which model is run, and in which parts; no model can be called that.
CHOICE_FILE = "which-model.c"
CHOICE = """#include <pk/run.h>
{own}extern const struct pk_system {name}_system;
{parts}extern const struct pk_run_model {of};
const struct pk_run_model {of} = {{&{name}_system, {blocks}, {count}, {methods}}};
"""
# What a library of a model shows: the documented functions and the model's own.
EXPORTS_FILE = "exports"
EXPORTS = "{{ global: pk_model; pk_run_*; pk_stability_*; {name}_*; local: *; }};\n"

Parts = Sequence[tuple[str, Sequence[int]]]  # of a model: the name of each, its coordinates


def _choice(of: str, name: str, parts: Parts, own: Sequence[Own] = ()) -> str:
    text = ""
    for k, (part, coordinates) in enumerate(parts):
        text += f"extern const struct pk_system {part}_system;\n"
        text += f"static const size_t part{k}[] = {{{', '.join(map(str, coordinates))}}};\n"
    if parts:
        rows = ", ".join(f"{{&{part}_system, part{k}}}" for k, (part, _) in enumerate(parts))
        text += f"static const struct pk_part parts[] = {{{rows}}};\n"
    blocks = "parts" if parts else "NULL"
    methods = f"own_methods, {len(own)}" if own else "NULL, 0"
    made = {"parts": text, "blocks": blocks, "count": len(parts), "methods": methods}
    return CHOICE.format(of=of, name=name, own=in_c.rows(own), **made)


def _portable(tools: Toolchain, files: dict[str, str]) -> Toolchain:
    """The runtime is to be so where the model is."""
    return replace(tools, flags=(*tools.flags, "-DPK_PORTABLE")) if is_portable(files) else tools


def _linked(
    tools: Toolchain,
    files: dict[str, str],
    name: str,
    parts: Parts,
    arguments: list[str],
    folder: Path,
    form: Sequence[str] = (),
    own: Sequence[Own] = (),
) -> None:
    """Compiles the files of a model and links it by these arguments. Of a model in parts the steps
    are theirs: it has no more than outputs, and is compiled without."""
    form = [*form, *in_c.flags(own)]
    files = {**files, in_c.FILE: in_c.tables(own)} if own else files
    for file_name, text in files.items():
        (folder / file_name).write_text(text, encoding="utf-8")
    sources = [CHOICE_FILE, *([f"{part}.c" for part, _ in parts] or [f"{name}.c"])]
    if parts:
        compile_c(tools, [*form, "-DPK_RUNTIME", "-c", f"{name}.c"], folder)
        sources.append(f"{name}.o")
    compile_c(tools, [*form, "-DPK_RUNTIME", *sources, *arguments], folder)


def build_library(
    files: dict[str, str],
    name: str,
    *methods: str | None,
    ensemble: bool = False,
    tools: Toolchain | None = None,
    parts: Parts = (),
    own: Sequence[Own] = (),
) -> Path:
    """A shared library that integrates the model NAME, from its generated files, by any method and
    those of its `own`; by `methods` fastest, and by blocks of an ensemble's members. With `parts`,
    NAME has no more than outputs, and these are integrated.

    Raises BuildError with what the compiler said.
    """
    tools = _portable(tools or find_toolchain(), files)
    inlined = _inlined(tools, methods, own, ensemble)
    choice = _choice("pk_model", name, parts, own)
    made_of = (_runtime_name(tools), inlined, choice, in_c.tables(own), sorted(files.items()))
    digest = hashlib.sha256(repr(made_of).encode()).hexdigest()[:24]

    def make(new: Path) -> None:
        library = runtime_library(tools)
        every = {**files, CHOICE_FILE: choice, EXPORTS_FILE: EXPORTS.format(name=name)}
        linked = [*inlined, "-shared", f"-Wl,--version-script={EXPORTS_FILE}", "-o", "model.so"]
        linked += ["-Wl,--whole-archive", str(library / "librun.a"), "-Wl,--no-whole-archive"]
        linked += runtime_links(tools, library)
        _linked(tools, every, name, parts, linked, new, SHARED, own)

    return cached("models", f"{name[:40]}-{digest}", make) / "model.so"


def _inlined(
    tools: Toolchain, methods: Sequence[str | None], own: Sequence[Own], ensemble: bool
) -> list[str]:
    """Steps that are compiled with a model save time only where the compiler optimises."""
    flags = [] if {"-O0", "-O1"} & set(tools.flags) else inline_flags(methods, own)
    return [*flags, "-DPK_INLINE_ENSEMBLE"] if flags and ensemble else flags


def build_program(
    files: dict[str, str],
    name: str,
    settings: str,
    output: Path,
    *methods: str | None,
    parts: Parts = (),
    static: bool = False,
    native: bool = False,
    gsl: bool = False,
    own: Sequence[Own] = (),
    ensemble: bool = False,
) -> None:
    """A program of its own, with `settings` in C; by `ensemble` for blocks of members. Without GSL,
    which is under the GPL, unless asked for; for any processor of this kind unless `native`. Raises
    BuildError."""
    tools = find_toolchain()
    if not gsl:
        tools = replace(tools, gsl_cflags=None, gsl_libs=())
    if not native:
        tools = replace(tools, flags=tuple(f for f in tools.flags if (f,) not in NATIVE))
    tools = _portable(tools, files)
    library = runtime_library(tools)
    declared = "extern const struct pk_run_settings program_settings;\n"
    choice = _choice("program_model", name, parts, own) + declared + settings
    inlined = _inlined(tools, methods, own, ensemble)
    linked = [*inlined, *map(str, sorted((RUNTIME / "program").glob("*.c")))]
    linked += ["-o", "program", str(library / "librun.a"), *(["-static"] if static else [])]
    linked += runtime_links(tools, library)
    with scratch() as folder:
        _linked(tools, {**files, CHOICE_FILE: choice}, name, parts, linked, folder, own=own)
        output.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(folder / "program", output)


# The runtime lists its methods without a model; it links with this one.
NO_MODEL = """#include <pk/system.h>
extern const struct pk_system no_model_system;
const struct pk_system no_model_system = {.abi = PK_ABI, .name = "no_model"};
"""


def own_methods(own: Sequence[Own]) -> list[dict[str, object]]:
    """Those of a model, as the runtime describes them."""
    if not own:
        return []
    return load(build_library({"no_model.c": NO_MODEL}, "no_model", own=own)).own_methods()


def runtime_methods() -> list[dict[str, object]]:
    """The methods of the runtime, GSL's included where GSL is installed, as it describes them."""
    path = build_library({"no_model.c": NO_MODEL}, "no_model")

    def make(new: Path) -> None:  # to find their limits takes seconds
        (new / "methods").write_text(json.dumps(load(path).methods()), encoding="utf-8")

    return json.loads((cached("methods", path.parent.name, make) / "methods").read_text("utf-8"))
