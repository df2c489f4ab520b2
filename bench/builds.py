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
from dataclasses import dataclass
from pathlib import Path

from .contender import Unavailable
from .models import ROOT

OUTPUT = ROOT / "build" / "bench"
SOURCES = ROOT / "bench" / "c"
RUNTIME = ROOT / "runtime"
SAFE = ("-fno-math-errno", "-fno-trapping-math")
NATIVE = ("-march=native",)
WIDE = ("-O3", *NATIVE)


@dataclass(frozen=True)
class Build:
    cc: str
    flags: tuple[str, ...]

    def __str__(self) -> str:
        return " ".join((self.cc, *self.flags))


def _builds() -> tuple[Build, ...]:
    found = []
    for cc in ("gcc", "clang"):
        if not shutil.which(cc):
            continue
        for flags in (("-O2",), ("-O2", *NATIVE), WIDE):
            for contract in ("off", "fast") if "-march=native" in flags else ("off",):
                found.append(Build(cc, (*flags, f"-ffp-contract={contract}", *SAFE)))
    return tuple(found)


BUILDS = _builds()


def compile_program(
    build: Build, sources: list[Path], defines: dict[str, str], extra: tuple[str, ...] = (),
    libraries: tuple[str, ...] = (), compiler: str | None = None,
) -> Path:
    """The program, built unless its text, its headers' text and its flags are known already."""
    command = [compiler or build.cc, *build.flags, *extra]
    command += [f"-D{name}={value}" if value else f"-D{name}" for name, value in defines.items()]
    headers = sorted(RUNTIME.glob("include/**/*.h")) + sorted(RUNTIME.glob("src/*.h"))
    included = [Path(v.strip('"')) for v in defines.values() if v.startswith('"/')]
    digest = hashlib.sha256(repr((command, libraries)).encode())
    for path in [*sources, *included, *headers]:
        digest.update(path.read_bytes())
    program = OUTPUT / "programs" / f"{sources[0].stem}-{digest.hexdigest()[:16]}"
    if not program.exists():
        program.parent.mkdir(parents=True, exist_ok=True)
        made = program.with_suffix(f".{os.getpid()}")
        done = subprocess.run(
            [*command, *map(str, sources), "-o", str(made), *libraries, "-lm"],
            capture_output=True,
            text=True,
        )
        if done.returncode:
            raise Unavailable(f"{shlex.join(command)} failed: {done.stderr.strip()[:2000]}")
        made.rename(program)
    return program


def written(name: str, text: str) -> Path:
    """A generated file under build/bench/generated, rewritten only if it is another."""
    path = OUTPUT / "generated" / name
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text() != text:
        path.write_text(text)
    return path
