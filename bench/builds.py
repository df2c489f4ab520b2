"""Compilers and flags: each contender in C is built by several, and its fastest build takes part.

Contraction is always said, since gcc and clang differ in their defaults. Fast-math is used only
where a peer's own build file asks for it.
"""

from __future__ import annotations

import hashlib
import os
import shlex
import shutil
import subprocess
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from .models import ROOT

OUTPUT = Path(os.environ.get("BENCH_OUTPUT") or ROOT / "build" / "bench")
SOURCES = ROOT / "bench" / "c"
RUNTIME = ROOT / "runtime"
SAFE = ("-fno-math-errno", "-fno-trapping-math")
NATIVE = ("-march=native",)
WIDE = ("-O3", *NATIVE)


class Unavailable(Exception):
    """What cannot take part: it is not installed, or has no such model."""


class Broken(Unavailable):
    """What should take part, and fails: the bench goes on, says so and fails in the end."""


Refused = dict[str, Exception]  # who cannot take part, and why


@dataclass(frozen=True)
class Build:
    cc: str
    flags: tuple[str, ...]

    def __str__(self) -> str:
        return " ".join((self.cc, *self.flags))


# As `pkgen run` compiles (FLAGS in its toolchain.py): scalar statements not joined, no contraction.
RUN_FLAGS = (*WIDE, "-fno-tree-slp-vectorize", "-ffp-contract=off", *SAFE)
FUSED = (*WIDE, "-ffp-contract=fast", *SAFE)
COMPILERS = tuple(cc for cc in ("gcc", "clang") if shutil.which(cc))
AS_RUN = tuple(Build(cc, RUN_FLAGS) for cc in COMPILERS)[:1]
# `make bench QUICK=1`: the flags that win most often.
QUICK_BUILDS = (*(Build(cc, FUSED) for cc in COMPILERS), *AS_RUN)
BUILDS = tuple(
    Build(cc, flags)
    for cc in COMPILERS
    for flags in (("-O2", *NATIVE, "-ffp-contract=fast", *SAFE), FUSED, RUN_FLAGS)
)


def compile_program(
    build: Build,
    sources: list[Path],
    defines: dict[str, str],
    extra: tuple[str, ...] = (),
    libraries: tuple[str, ...] = (),
) -> Path:
    """The program, built unless its text, its headers' text and its flags are known already."""
    command = [build.cc, *build.flags, *extra]
    command += [f"-D{name}={value}" if value else f"-D{name}" for name, value in defines.items()]
    included = [Path(v.strip('"')) for v in defines.values() if v.startswith('"/')]
    digest = _digest([*sources, *included, *_headers()], repr((command, libraries)))
    program = OUTPUT / "programs" / f"{sources[0].stem}-{digest}"
    if not program.exists():
        program.parent.mkdir(parents=True, exist_ok=True)
        made = program.with_suffix(f".{os.getpid()}-{threading.get_ident()}")
        run([*command, *map(str, sources), "-o", str(made), *libraries, "-lm"])
        made.rename(program)
    return program


def runtime_library(build: Build) -> Path:
    """The runtime's core by the same compiler and flags."""
    sources = sorted((RUNTIME / "src").rglob("*.c"))
    digest = _digest([*sources, *_headers()], str(build))
    library = OUTPUT / "programs" / f"runtime-{digest}" / "libpk.a"
    if not library.exists():
        library.parent.mkdir(parents=True, exist_ok=True)
        command = [build.cc, *build.flags, "-std=c11", f"-I{RUNTIME / 'include'}"]
        names = (f"{s.parent.name}_{s.stem}.o" for s in sources)  # two folders have a keep.c
        objects = [str(library.parent / name) for name in names]
        for source, made in zip(sources, objects, strict=True):
            run([*command, "-c", str(source), "-o", made])
        run(["ar", "rcs", str(library), *objects])
    return library


def each_build(builds: tuple[Build, ...], make: Callable[[Build], Path]) -> list[Path]:
    """The programs of all builds, compiled as many at once as there are cores."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(make, builds))


def run(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        said = done.stderr.splitlines()
        first = next((line for line in said if "error" in line), "".join(said[:1]))
        with (OUTPUT / "failures.log").open("a") as log:
            log.write(f"{shlex.join(command)}\n{done.stderr}\n")
        raise Broken(f"{command[0]} failed (see failures.log): {first[:200]}")


def _headers() -> list[Path]:
    return sorted([*RUNTIME.glob("include/**/*.h"), *RUNTIME.glob("src/**/*.h")])


def _digest(files: list[Path], flags: str) -> str:
    digest = hashlib.sha256(flags.encode())
    for path in files:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def written(name: str, text: str) -> Path:
    """A generated file under build/bench/generated, rewritten only if it is another."""
    path = OUTPUT / "generated" / name
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text() != text:
        path.write_text(text)
    return path
