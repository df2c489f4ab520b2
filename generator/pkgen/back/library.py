"""Builds a shared library of a model, the runtime's files for it and a host's C code, for this
machine or for others.

The library has no GSL and runs on every processor of its architecture. zig compiles libraries for
other machines (pip install ziglang).
"""

from __future__ import annotations

import hashlib
import os
import platform
import shutil
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec

from ..record import record
from ..system.cache import cached
from ..system.exits import BuildError
from ..system.near import near
from ..system.toolchain import DECLARED, FLAGS, STANDARD, find_toolchain, run

OLD_GLIBC = "2.17"
# By default zig cc adds checks that stop the program at undefined behaviour.
ZIG = ("-fno-sanitize=undefined",)


@record
class Target:
    """A kind of machine for which libraries are built: its name, its name in zig, the suffix of its
    libraries, and the folder for it in an FMU of version 3 or 2."""

    name: str
    zig: str
    suffix: str
    fmi3: str
    fmi2: str


TARGETS = {
    t.name: t
    for t in (
        Target("linux-x86_64", f"x86_64-linux-gnu.{OLD_GLIBC}", ".so", "x86_64-linux", "linux64"),
        Target(
            "linux-aarch64",
            f"aarch64-linux-gnu.{OLD_GLIBC}",
            ".so",
            "aarch64-linux",
            "aarch64-linux",
        ),
        Target("windows-x86_64", "x86_64-windows-gnu", ".dll", "x86_64-windows", "win64"),
        Target("macos-x86_64", "x86_64-macos", ".dylib", "x86_64-darwin", "darwin64"),
        Target("macos-aarch64", "aarch64-macos", ".dylib", "aarch64-darwin", "aarch64-darwin"),
    )
}


def this_machine() -> str:
    """Returns this machine's name in TARGETS. Raises BuildError if TARGETS does not have it."""
    system = {"darwin": "macos", "win32": "windows"}.get(sys.platform, sys.platform)
    machine = {"AMD64": "x86_64", "arm64": "aarch64"}.get(platform.machine(), platform.machine())
    name = f"{system}-{machine}"
    if name not in TARGETS:
        raise BuildError(f"no library can be made for {name}; there are: {', '.join(TARGETS)}")
    return name


def named(text: str) -> list[Target]:
    """Returns the targets in a list such as `linux-x86_64,windows-x86_64`. Raises BuildError."""
    found = []
    for name in dict.fromkeys(word.strip() for word in text.split(",")):
        if name not in TARGETS:
            raise BuildError(f"--target {name}: {near(name, list(TARGETS), 'option')}")
        found.append(TARGETS[name])
    return found


def library(files: Mapping[str, str], shown: str, target: Target | None = None) -> bytes:
    """Returns a shared library of C files and headers, given by their paths. It exports the names
    that begin with a word of `shown`. Without a target, this machine's own compiler is used. Raises
    BuildError."""
    there = target or TARGETS[this_machine()]
    compiler = list(find_toolchain().cc) if target is None else _zig(target)
    options = ["-fPIC"] if there.suffix != ".dll" else []
    compiles = [*compiler, STANDARD, DECLARED, *FLAGS, "-fvisibility=hidden", *options]
    link = [*compiler, "-shared", "-s"]
    if there.suffix == ".so":  # each library in a process uses its own runtime, which is hidden
        link += ["-Wl,--version-script=exports", "-Wl,-z,defs"]
    libraries = [] if there.suffix == ".dll" else ["-lm"]
    core = {path: text for path, text in files.items() if path.startswith(("src/", "include/"))}
    name = f"library{there.suffix}"
    digest = _digest(compiles, link, sorted(files.items()))

    def make(new) -> None:
        objects = _core(core, compiles)
        own = {path: text for path, text in files.items() if path not in core}
        headers = {path: text for path, text in core.items() if path.endswith(".h")}
        names = " ".join(f"{word}*;" for word in shown.split())
        exports = {"exports": f"{{ global: {names} local: *; }};\n"}
        made = [f"{source}.o" for source in _compiled({**headers, **own, **exports}, compiles, new)]
        run([*link, *made, *map(str, sorted(objects.glob("*.o"))), *libraries, "-o", name], new)
        for path in list(new.iterdir()):
            if path.name != name:
                shutil.rmtree(path) if path.is_dir() else path.unlink()

    return (cached("libraries", digest, make) / name).read_bytes()


def _digest(*what: object) -> str:
    return hashlib.sha256(repr(what).encode()).hexdigest()[:24]


def _core(files: Mapping[str, str], compiles: Sequence[str]):
    """Returns the cache folder with the object files of the runtime's C files."""

    def make(new) -> None:
        for path in _compiled(files, compiles, new):
            os.replace(new / f"{path}.o", new / f"{path.replace('/', '_')}.o")
        for folder in ("src", "include"):
            shutil.rmtree(new / folder, ignore_errors=True)

    return cached("cores", _digest(compiles, sorted(files.items())), make)


def _compiled(files: Mapping[str, str], compiles: Sequence[str], folder) -> list[str]:
    """Writes the files and compiles the C files among them, whose paths it returns."""
    for path, text in files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text, encoding="utf-8")
    sources = [path for path in files if path.endswith(".c")]

    def one(source: str) -> None:
        run([*compiles, "-c", source, "-o", f"{source}.o"], folder)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(one, sources))
    return sources


def _zig(target: Target) -> list[str]:
    if find_spec("ziglang") is None:
        raise BuildError(
            f"--target {target.name}: zig compiles for other machines: pip install ziglang"
        )
    return [sys.executable, "-m", "ziglang", "cc", "-target", target.zig, *ZIG]
