"""The command line: runs a command, turns its failures into messages and exit codes.

Exit codes: 0 success; 1 error in the model; 2 wrong usage; 3 the C compiler failed; 4 the numerics
failed; 75 stopped early with a checkpoint; 130 interrupted.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable
from contextlib import suppress

from . import __version__
from .cli.commands import overview, parsed, parser_of
from .cli.messages import findings, told
from .front.data import bringing, of_options
from .front.read import STANDARD, allowing
from .source import ModelError
from .system import children
from .system.exits import (
    COMPILER_FAILED,
    DONE,
    INTERRUPTED,
    MODEL_WRONG,
    NUMERICS_FAILED,
    USAGE,
    NumericsFailed,
    UsageError,
)
from .system.resources import ResourcesExceeded
from .system.toolchain import BuildError

__all__ = ["main", "parser_of"]

OPTIONAL = {"matplotlib", "rich", "scipy"}  # packages imported only where they are used
# Exit codes for exceptions.
CODES: dict[type[BaseException], int] = {
    ResourcesExceeded: MODEL_WRONG,
    UsageError: USAGE,
    BuildError: COMPILER_FAILED,
    NumericsFailed: NUMERICS_FAILED,
    KeyboardInterrupt: INTERRUPTED,
}


def main(words: list[str] | None = None) -> int:
    """Runs one command; returns the exit code."""
    _open_streams()
    try:
        with children.ended_by_signals():
            try:
                return _main(words)
            finally:
                sys.stdout.flush()
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        code = DONE  # the reader of the output, such as `head`, has closed the pipe
    except OSError as error:
        code = USAGE
        with suppress(OSError):
            print(f"pkgen: standard output: {error.strerror}", file=sys.stderr)
    # Python flushes stdout at exit, which must not fail again.
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    return code


def _main(words: list[str] | None) -> int:
    words = sys.argv[1:] if words is None else words
    if not words or words[0] in ("-h", "--help"):
        print(overview(), file=sys.stdout if words else sys.stderr)
        return DONE if words else USAGE
    if words[0] in ("-V", "--version"):
        print(f"pkgen {__version__}")
        _warn_of_the_other()
        return DONE
    try:
        command, options = parsed(words)
    except UsageError as error:
        return _fail("--json" in words, str(error), USAGE)
    try:
        tables = of_options(getattr(options, "table", ()))
    except UsageError as error:
        return _fail("--json" in words, str(error), USAGE)
    with allowing(*getattr(options, "allow_path", ())), bringing(tables):
        return _guarded(command.module.run, options)


def _warn_of_the_other() -> None:
    """Warns if PyPI's `pkgen` is installed, another project with the same import name."""
    from importlib.metadata import PackageNotFoundError, version

    with suppress(PackageNotFoundError):
        said = f"the distribution 'pkgen' {version('pkgen')} is here too, which has the same files"
        print(f"pkgen: {said}: pip uninstall pkgen, then install pkgen-lag again", file=sys.stderr)


def _open_streams() -> None:
    """Opens /dev/null for closed standard streams, so that no other file gets their descriptors. A
    closed stdout is opened for reading only, so that writing to it fails."""
    for fd, how in enumerate((os.O_RDONLY, os.O_RDONLY, os.O_WRONLY)):
        try:
            os.fstat(fd)
        except OSError:
            os.open(os.devnull, how)  # gets the lowest free descriptor
    if sys.stdout is None:
        sys.stdout = open(1, "w", closefd=False)  # noqa: SIM115
    if sys.stderr is None:
        sys.stderr = open(2, "w", closefd=False)  # noqa: SIM115


def _guarded(command: Callable[[argparse.Namespace], int], options: argparse.Namespace) -> int:
    """Runs a command; turns each failure into a message and an exit code."""
    try:
        return told(command, options)
    except ModelError as error:
        if options.json:
            print(json.dumps({"diagnostics": [d.record(error.source) for d in error.diagnostics]}))
        else:
            findings(error.text())
        model = getattr(options, "model", "")
        there = model == STANDARD or os.path.isfile(model)
        return MODEL_WRONG if there else USAGE
    except tuple(CODES) as error:
        code = next(code for kind, code in CODES.items() if isinstance(error, kind))
        return _fail(options.json, str(error) or "interrupted", code)
    except OSError as error:
        if error.filename is None:  # error of a standard stream, handled in main()
            raise
        return _fail(options.json, f"{error.filename}: {error.strerror}", USAGE)
    except Exception as error:
        missing = error.name or "" if isinstance(error, ModuleNotFoundError) else ""
        if (name := missing.partition(".")[0]) in OPTIONAL:
            said = f"pip install {name} (Debian: apt install python3-{name})"
            return _fail(options.json, f"this needs {name}, which is optional: {said}", USAGE)
        return _fail(
            options.json,
            f"internal error ({type(error).__name__}: {error}); this is a defect of pkgen: "
            "please report it together with the model",
            MODEL_WRONG,
        )


def _fail(as_json: bool, message: str, code: int) -> int:
    if as_json:
        print(json.dumps({"error": message, "code": code}))
    else:
        print(f"pkgen: {message}", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())
