"""Compiles the runtime's core and one model to WebAssembly, by Debian's clang, lld and wasi-libc;
without GSL, which is under the GPL, and without emscripten."""

from __future__ import annotations

import gzip
import hashlib
import os
import shutil
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from ...methods import Own
from ...own import in_c
from ...system.cache import cached
from ...system.exits import BuildError
from ...system.progress import say
from ...system.toolchain import DECLARED, RUNTIME, STANDARD, run
from ..host.data import DATA, HERE, data

VERSIONS = ("", *(f"-{k}" for k in range(19, 13, -1)))  # suffixes of the names of clang and lld
LIBC = (Path("/usr/lib/wasm32-wasi/libc.a"), Path("/opt/wasi-sysroot/lib/wasm32-wasi/libc.a"))
TARGET = "--target=wasm32-wasi"
# With -msimd128 the method gauss is a third faster and a swarm a tenth. The page needs
# DecompressionStream, and every browser that has it has SIMD. With -fno-unroll-loops the code is as
# fast and a tenth smaller.
FLAGS = (
    TARGET,
    STANDARD,
    DECLARED,
    "-O2",
    "-msimd128",
    "-fno-slp-vectorize",
    "-fno-unroll-loops",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-DPK_RUNTIME",
)
# Linking has no -O: with -O clang runs the program wasm-opt if it is installed, and version 108 of
# wasm-opt breaks code compiled with -msimd128. The stack, which holds the arrays of large models,
# is first in memory, so that an overflow traps instead of overwriting data.
LINK = (
    TARGET,
    "-mexec-model=reactor",
    "-Wl,--gc-sections",
    "-Wl,--strip-all",
    "-Wl,--stack-first",
    "-Wl,-z,stack-size=1048576",
    "-Wl,--export=malloc",
    "-Wl,--export=free",
    "-lm",
)
CORE = "core.o"


def missing() -> list[str]:
    """Returns the Debian packages that a build of a page needs and that are not installed."""
    clang, linker, libc = _found()
    wanted = (("clang", clang), ("lld", linker), ("wasi-libc", libc))
    names = [package for package, there in wanted if not there]
    return names + ([] if not clang or _has_builtins(clang) else ["libclang-rt-dev-wasm32"])


def _found() -> tuple[str | None, str | None, Path | None]:
    clang, linker = (
        next((found for end in VERSIONS if (found := shutil.which(name + end))), None)
        for name in ("clang", "wasm-ld")
    )
    return clang, linker, next((path for path in LIBC if path.exists()), None)


def _tools() -> tuple[list[str], list[str]]:
    """Returns the commands that compile and link. Raises BuildError with all missing packages."""
    if names := missing():
        wanted = " ".join(names)
        raise BuildError(f"a live page needs a compiler to WebAssembly: apt-get install {wanted}")
    clang, linker, libc = _found()
    assert clang and libc and linker
    root = f"--sysroot={libc.parents[2]}"
    return [clang, *FLAGS, root, f"-I{RUNTIME / 'include'}"], [clang, root, f"-fuse-ld={linker}"]


def _has_builtins(clang: str) -> bool:
    """Returns whether clang's library of functions for operations that WebAssembly lacks exists."""
    folder = Path(os.path.realpath(clang)).parents[1] / "lib"
    return any(folder.glob("clang/*/lib/**/libclang_rt.builtins*wasm32*"))


def _runtime(compiles: list[str], linker: str, more: Sequence[Path]) -> Path:
    """Returns the cached object file of the code that all models share; compiles it if missing."""
    folders = (RUNTIME / "src", HERE)
    sources = [*sorted(path for folder in folders for path in folder.rglob("*.c")), *more]
    digest = hashlib.sha256(repr((compiles, CORE)).encode())
    for path in [*sorted([*RUNTIME.rglob("*.[ch]"), *HERE.glob("*.[ch]")]), *more]:
        digest.update(path.name.encode() + b"\0" + path.read_bytes())

    def make(new: Path) -> None:
        say("compiling the runtime to WebAssembly (once, 10 s)")

        def one(source: Path) -> str:
            name = f"{source.parent.name}_{source.stem}.o"
            run([*compiles, f"-I{HERE}", "-c", str(source), "-o", name], new)
            return name

        with ThreadPoolExecutor(os.cpu_count()) as pool:
            objects = list(pool.map(one, sources))
        run([linker, "-r", *objects, "-o", CORE], new)
        for name in objects:
            (new / name).unlink()

    return cached("runtime-wasm", digest.hexdigest()[:24], make) / CORE


def wasm(
    files: Mapping[str, str], name: str, own: Sequence[Own] = (), more: Sequence[Path] = ()
) -> bytes:
    """Returns the gzipped WebAssembly module of the model `name`. It contains the generated
    `files`, the integration methods `own` and the C files `more`, but no default values, which
    JavaScript takes from the description. Equal files give equal bytes. Raises BuildError with the
    missing packages or the compiler's output."""
    compiles, links = _tools()
    core = _runtime(compiles, links[-1].partition("=")[2], more)
    every = {**files, DATA: data(name, own), in_c.FILE: in_c.tables(own)}
    digest = hashlib.sha256(repr((core.parent.name, LINK, sorted(every.items()))).encode())

    def make(new: Path) -> None:
        for file_name, text in every.items():
            (new / file_name).write_text(text, encoding="utf-8")
        run([*compiles, f"-I{HERE}", *in_c.flags(own), "-c", f"{name}.c", DATA], new)
        objects = [f"{name}.o", DATA.replace(".c", ".o"), str(core)]
        run([*links, *LINK, *objects, "-o", "model.wasm"], new)
        packed = gzip.compress((new / "model.wasm").read_bytes(), 9, mtime=0)
        (new / "model.wasm.gz").write_bytes(packed)

    folder = cached("wasm", f"{name[:40]}-{digest.hexdigest()[:24]}", make)
    return (folder / "model.wasm.gz").read_bytes()
