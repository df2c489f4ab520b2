"""Finds and runs the C compiler, and chooses its flags."""

from __future__ import annotations

import hashlib
import os
import shlex
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pkgen_runtime

from ..record import record
from . import children
from .exits import BuildError
from .progress import trace

RUNTIME = Path(pkgen_runtime.__file__).parent
# -ffast-math is not used: it deletes compensated sums and NaN tests. Contraction to fused
# multiply-add is off: the defaults of gcc and clang differ. Without contraction, vector lanes and
# scalar code agree to the last bit, and the results of gcc and clang nearly agree; with it, inlined
# rk4 and dop853 would be 2 to 6 % faster. -O3 is for the loops over vector lanes. SLP vectorization
# is off: it makes small steps 5 % slower, since they load numbers that were just stored.
FLAGS = (
    "-O3",
    "-fno-tree-slp-vectorize",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-trapping-math",
)
# Without this flag, C assumes that an undeclared function returns int.
DECLARED = "-Werror=implicit-function-declaration"
# Alternative flags for this computer's processor: the first that the compiler accepts is used.
NATIVE = (("-march=native",), ("-mcpu=native",), ())
STANDARD = "-std=c11"
TIMEOUT_SECONDS = 300


@record
class Toolchain:
    """A C compiler with its flags, and the flags for GSL if GSL is installed."""

    cc: tuple[str, ...]
    flags: tuple[str, ...]
    gsl_cflags: tuple[str, ...] | None
    gsl_libs: tuple[str, ...]
    version: str
    target: str  # Digest of the compiler's macros, which describe the processor.

    @property
    def has_gsl(self) -> bool:
        return self.gsl_cflags is not None


def find_toolchain() -> Toolchain:
    """Returns `$CC` if set, else the first compiler of gcc, clang and cc. Raises BuildError."""
    wanted = os.environ.get("CC")
    candidates = [_words("CC", wanted)] if wanted else [["gcc"], ["clang"], ["cc"]]
    for candidate in candidates:
        if candidate and shutil.which(candidate[0]):
            version, native, macros = _asked(tuple(candidate), shutil.which(candidate[0]))
            flags = FLAGS + native + tuple(_words("CFLAGS", os.environ.get("CFLAGS", "")))
            cflags, libs = find_gsl()
            return Toolchain(
                tuple(candidate),
                flags,
                cflags,
                libs,
                version.partition("\n")[0],
                hashlib.sha256(macros.encode()).hexdigest()[:24],
            )
    raise BuildError(
        f"no C compiler found (looked for {', '.join(c[0] for c in candidates if c)}); "
        "install gcc, or name one with the environment variable CC"
    )


def _words(name: str, text: str) -> list[str]:
    """Splits the value of an environment variable into words as a shell does. Raises BuildError."""
    try:
        return shlex.split(text)
    except ValueError as error:
        raise BuildError(
            f"the environment variable {name} is {text}: {str(error).lower()}"
        ) from None


@cache  # a compiler, at the place `found`, is asked once, since two calls of it cost 13 ms
def _asked(cc: tuple[str, ...], found: str | None) -> tuple[str, tuple[str, ...], str]:
    """Returns the compiler's version, its flags for this computer's processor, and the macros that
    it then predefines, which describe the processor."""
    version = _output([*cc, "--version"]) or ""
    for flags in NATIVE:
        macros = _output([*cc, *flags, "-dM", "-E", "-x", "c", os.devnull])
        if macros is not None:
            return version, flags, macros
    return version, (), ""


@cache
def find_gsl() -> tuple[tuple[str, ...] | None, tuple[str, ...]]:
    """Returns GSL's flags for the compiler (None without GSL) and for the linker."""
    config = shutil.which("gsl-config")
    if config is None:
        return None, ()
    cflags = shlex.split(_output([config, "--cflags"]) or "")
    libs = shlex.split(_output([config, "--libs"]) or "-lgsl -lgslcblas")
    # /usr/include is searched anyway; -I would put it before the compiler's own headers.
    return tuple(f for f in cflags if f != "-I/usr/include"), tuple(libs)


def _output(command: list[str]) -> str | None:
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=30, check=True, **children.group()
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout


def compile_c(tools: Toolchain, arguments: list[str], directory: Path) -> None:
    include = f"-I{RUNTIME / 'include'}"
    run([*tools.cc, STANDARD, DECLARED, *tools.flags, include, *arguments], directory)


def run(command: list[str], directory: Path) -> None:
    try:
        done = subprocess.run(
            command,
            cwd=directory,
            env={**os.environ, "TMPDIR": str(directory)},  # For the temporary files of gcc.
            capture_output=True,
            text=True,
            timeout=TIMEOUT_SECONDS,
            **children.group(),
        )
    except OSError as error:
        raise BuildError(f"cannot run {command[0]}: {error.strerror}") from None
    except subprocess.TimeoutExpired:
        raise BuildError(
            f"{command[0]} took more than {TIMEOUT_SECONDS} s: the model is too large"
        ) from None
    if done.returncode != 0:
        said = done.stderr.strip()[-4000:]
        raise BuildError(f"{shlex.join(command)}\nfailed:\n{said}")
    trace(f"ran {shlex.join(command)}")
