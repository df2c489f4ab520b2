"""Compiles the C runtime in parts, each when a model first needs it, and caches them
(system/cache.py). The cache key includes the compiler, its flags and the processor, so that objects
for another processor are not used."""

from __future__ import annotations

import hashlib
import os
import shlex
import shutil
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache
from pathlib import Path

from ..methods import Method
from ..system.cache import cached
from ..system.progress import say
from ..system.toolchain import NATIVE, RUNTIME, STANDARD, BuildError, Toolchain, compile_c, run

SHARED = ("-fPIC", "-fno-semantic-interposition")
HIDDEN = "-fvisibility=hidden"  # exports only symbols that a header declares
GSL = "libpk_gsl.a"
LINK_WITH = "link"  # name of the file with the linker flags, in the folder of the libraries
# For each part of the runtime, which is compiled on its own: its source folders.
CORE = ("core", "constraints", "explicit", "integrate", "events", "watch")
PARTS = {
    "core": (
        *("run", "run/base", "run/settings", "run/observers", "run/steps", "src"),
        *(f"src/{name}" for name in CORE),
    ),
    "implicit": ("src/implicit",),
    "variational": ("src/variational",),
    "ensemble": ("run/ensemble", "omp", "src/ensemble"),
    "diagnose": ("run/diagnose", "run/stability", "src/diagnose", "gsl"),
}
WHOLE = tuple(PARTS)
ARCHIVES = {"run": "librun.a", "omp": "librun.a", "gsl": GSL, "src": "libpk.a"}  # by top folder
# HOT files have loops over SIMD lanes, and steps that are not inlined in a model; they are compiled
# with all flags. Other files compile in half the time at -O1 (QUICK) or -Og: runs take 0 to 5 %
# longer, with many rows or events 10 %.
QUICK = ("src/core", "src/explicit", "src/implicit", "src/integrate", "src/variational")
HOT = (
    *("src/ensemble/*.c", "src/variational/*.c"),
    *("src/explicit/embedded.c", "src/explicit/erk.c", "src/explicit/splitting.c"),
    *("src/core/band.c", "src/core/scale.c"),
    *("src/implicit/gauss_dense.c", "src/implicit/gauss_matrix.c", "src/implicit/gauss_places.c"),
    *("src/constraints/project.c", "src/watch/diagnostics.c"),
    *("src/events/events_look.c", "src/events/crossings.c", "run/diagnose/adjoint*.c"),
)
FAMILIES = {  # parts of the method families that are not in the core
    **dict.fromkeys(("COLLOCATION", "GAUSS", "RADAU", "EXPONENTIAL"), "implicit"),
    **dict.fromkeys(("LIE_MIDPOINT", "RATTLE"), "variational"),
    "GSL": "diagnose",
}


def runtime_library(tools: Toolchain, parts: Sequence[str] = WHOLE) -> Path:
    """Returns the folder with librun.a, libpk.a and, if GSL is installed, libpk_gsl.a, built from
    `parts`; compiles missing parts."""
    names = [part for part in PARTS if part in parts]

    def make(new: Path) -> None:
        archives: dict[str, list[str]] = {}
        with ThreadPoolExecutor(len(names)) as pool:
            folders = list(pool.map(lambda part: _compiled(tools, part), names))
        for folder in folders:
            for path in sorted(folder.glob("*.o")):
                archives.setdefault(path.name.partition("-")[0], []).append(str(path))
            if (folder / LINK_WITH).exists():
                shutil.copy(folder / LINK_WITH, new)
        ar = shutil.which("ar")
        if ar is None:
            raise BuildError("'ar' is missing; install binutils")
        for archive, objects in archives.items():
            run([ar, "rcs", archive, *objects], new)

    return cached("runtime", f"{runtime_name(tools)}-{'-'.join(names)}", make)


@cache  # reading the sources takes 6 ms
def runtime_name(tools: Toolchain) -> str:
    """Returns a digest of the sources, the compiler and its flags."""
    digest = hashlib.sha256(repr((tools, STANDARD)).encode())
    for path in (Path(__file__), *sorted(RUNTIME.rglob("*.[ch]"))):  # flags in this file count too
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:24]


def _compiled(tools: Toolchain, part: str) -> Path:
    """Returns the folder with the object files of a part of the runtime. The name of an object file
    is ARCHIVE-FOLDER_FILE.o, after its library and its source."""

    def make(new: Path) -> None:
        say(f"compiling the runtime: {part} (once)")
        if part == "ensemble":
            (new / LINK_WITH).write_text(shlex.join(_threads(tools, new)), encoding="utf-8")

        def one(folder: str) -> None:
            within = new / f"of_{folder.replace('/', '_')}"
            within.mkdir()
            gsl = ["-DPK_WITH_GSL", *(tools.gsl_cflags or ())] if tools.has_gsl else []
            more = [*gsl, *(_link_with(new) if folder == "omp" else [])]
            hot = {path for pattern in HOT for path in RUNTIME.glob(pattern)}
            every = {*(RUNTIME / folder).glob("*.c")}
            level, native = "-O1" if folder in QUICK else "-Og", {x for f in NATIVE for x in f}
            flags = (level if f == "-O3" else f for f in tools.flags if f not in native)
            light = replace(tools, flags=tuple(flags))
            for kind, sources in ((tools, every & hot), (light, every - hot)):
                if sources:  # one call of the compiler for all `sources`
                    names = map(str, sorted(sources))
                    compile_c(kind, ["-c", *SHARED, HIDDEN, *more, *names], within)
            for path in within.glob("*.o"):
                archive = ARCHIVES[folder.partition("/")[0]]
                path.rename(new / f"{archive}-{Path(folder).name}_{path.name}")
            within.rmdir()

        list(_pool().map(one, (f for f in PARTS[part] if f != "gsl" or tools.has_gsl)))

    return cached("objects", f"{part}-{runtime_name(tools)}", make)


@cache
def _pool() -> ThreadPoolExecutor:
    """Returns a thread pool, in which the parts of the runtime are compiled. It runs as many
    compilers at once as there are processors."""
    return ThreadPoolExecutor(os.cpu_count())


def _link_with(library: Path) -> list[str]:
    path = library / LINK_WITH
    return shlex.split(path.read_text(encoding="utf-8")) if path.exists() else []


def _threads(tools: Toolchain, directory: Path) -> list[str]:
    """Returns flags for OpenMP if the compiler can link with it, else []."""
    (directory / "omp.c").write_text(
        "#include <omp.h>\nint main(void) { return omp_get_max_threads() < 1; }\n", encoding="utf-8"
    )
    try:
        compile_c(tools, ["-fopenmp", "omp.c", "-o", "omp"], directory)
    except BuildError:
        return []
    return ["-fopenmp"]


def runtime_links(tools: Toolchain, library: Path) -> list[str]:
    """Returns the libraries to link after librun.a; GSL only if a part uses it."""
    gsl = [str(library / GSL)] if (library / GSL).exists() else []
    libraries = tools.gsl_libs if gsl or not tools.has_gsl else ()
    return [*gsl, str(library / "libpk.a"), *libraries, "-lm", *_link_with(library)]


def needed(methods: Iterable[Method], more: Iterable[str] = ()) -> tuple[str, ...]:
    """Returns the names of the runtime's parts that runs by these methods need, and `more`."""
    found = {"core", *more, *(part_of(method.family) for method in methods)}
    return tuple(part for part in PARTS if part in found)


def part_of(family: str) -> str:
    """Returns the part that contains the methods of a family."""
    return FAMILIES.get(family, "core")
