"""The command line. Nothing else in pkgen prints or exits.

Exit codes: 0 done; 1 the model is wrong; 2 usage; 3 the C compiler failed; 4 the numerics
failed; 130 interrupted.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
from collections.abc import Callable, Iterable
from contextlib import suppress
from importlib import import_module
from types import ModuleType

from . import __version__
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

# What each way to fail ends with.
CODES: dict[type[BaseException], int] = {
    ResourcesExceeded: MODEL_WRONG,
    UsageError: USAGE,
    BuildError: COMPILER_FAILED,
    NumericsFailed: NUMERICS_FAILED,
    KeyboardInterrupt: INTERRUPTED,
}


def module_of(command: str) -> ModuleType:
    """The file of a command, imported for it alone."""
    return import_module(f"{__package__}.cli.{command}")


def parser_of(command: str) -> argparse.ArgumentParser:
    module = module_of(command)
    parser = argparse.ArgumentParser(
        prog=f"pkgen {command}",
        usage=getattr(module, "USAGE", None),
        description=module.run.__doc__,
        allow_abbrev=False,
    )
    if getattr(module, "MODEL", True):
        from .cli.arguments import of_a_model

        parser.add_argument("model", metavar="MODEL.lag")
        of_a_model(parser)
    parser.add_argument("--json", action="store_true", help="machine-readable results")
    module.arguments(parser)
    return parser


LATER = frozenset(("sweep", "fmt"))

OVERVIEW = """usage: pkgen MODEL.lag [-o DIR]    write DIR/NAME.h and DIR/NAME.c (default: here)
       pkgen check MODEL.lag        errors and warnings only
       pkgen explain MODEL.lag      equations, structure
       pkgen run MODEL.lag          compile and integrate; CSV to standard output
       pkgen plot MODEL.lag|FILE.csv pictures of motions, in the terminal or -o FILE.svg
       pkgen film MODEL.lag -o FILE  a film of the motion: MP4, WebM, GIF, SVG
       pkgen build MODEL.lag -o FILE a program of its own, with the options of run
       pkgen chart MODEL.lag        accuracy against cost, by every method that applies
       pkgen stability MODEL.lag    where each method fails, predicted and measured
       pkgen show MODEL.lag         a live page: one file that opens in a browser
       pkgen describe MODEL.lag     names, units, bounds, methods, drawings as data
       pkgen export MODEL.lag --as N for other programs: FMI, Python, C and others
       pkgen import ROBOT.urdf -o F the bodies and joints of a robot, as a model
       pkgen methods                the methods, orders, what each requires
       pkgen COMMAND --help         the options of a command ('compile' for the first line's)
       pkgen --version"""
COMMANDS = ("compile", *re.findall(r"pkgen ([a-z]+)", OVERVIEW))


def main(words: list[str] | None = None) -> int:
    """Run one command; returns the exit code."""
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
        code = DONE  # whoever read our output has gone
    except OSError as error:
        code = USAGE
        with suppress(OSError):
            print(f"pkgen: standard output: {error.strerror}", file=sys.stderr)
    # What is left of it must not fail again at exit.
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    return code


def _main(words: list[str] | None) -> int:
    words = sys.argv[1:] if words is None else words
    if not words or words[0] in ("-h", "--help"):
        print(OVERVIEW, file=sys.stdout if words else sys.stderr)
        return DONE if words else USAGE
    if words[0] == "--version":
        print(f"pkgen {__version__}")
        return DONE
    if words[0] in LATER and not os.path.exists(words[0]):
        return _misused(f"'{words[0]}' is not there yet\n\n{OVERVIEW}")
    command = words[0] if words[0] in COMMANDS else "compile"
    if command != words[0] and words[0].isalpha() and not os.path.exists(words[0]):
        return _misused(f"there is no command '{words[0]}'; {_near(words[0], COMMANDS)}")
    parser = parser_of(command)
    words = words[1:] if command == words[0] else words
    several = getattr(module_of(command), "SEVERAL", False)  # files, and options between them
    parse = parser.parse_known_intermixed_args if several else parser.parse_known_args
    options, unknown = parse(words)
    if unknown:
        flag = unknown[0].partition("=")[0]
        said = f"there is no option {flag}; {_near(flag, parser._option_string_actions)}"
        said = said if flag.startswith("-") else f"one model at a time: what is {flag}?"
        return _misused(said)
    return _guarded(module_of(command).run, options)


def _misused(said: str) -> int:
    print(f"pkgen: {said}", file=sys.stderr)
    return USAGE


def _open_streams() -> None:
    """Occupies the numbers of closed standard streams, so that no other file gets them; writing to
    closed output then fails, as it should."""
    for fd, how in enumerate((os.O_RDONLY, os.O_RDONLY, os.O_WRONLY)):
        try:
            os.fstat(fd)
        except OSError:
            os.open(os.devnull, how)  # the lowest number that is free
    if sys.stdout is None:
        sys.stdout = open(1, "w", closefd=False)  # noqa: SIM115
    if sys.stderr is None:
        sys.stderr = open(2, "w", closefd=False)  # noqa: SIM115


def _near(word: str, known: Iterable[str]) -> str:
    from .system.near import near

    return near(word, [name for name in known if name not in ("-h", "--help")], "option")


def _guarded(command: Callable[[argparse.Namespace], int], options: argparse.Namespace) -> int:
    """Run a command, every way it can fail turned into a message and an exit code."""
    try:
        return command(options)
    except ModelError as error:
        if options.json:
            print(json.dumps({"diagnostics": [d.record(error.source) for d in error.diagnostics]}))
        else:
            print(error.text(), file=sys.stderr)
        return MODEL_WRONG if os.path.isfile(options.model) else USAGE
    except tuple(CODES) as error:
        code = next(code for kind, code in CODES.items() if isinstance(error, kind))
        return _fail(options, str(error) or "interrupted", code)
    except OSError as error:
        if error.filename is None:  # a stream's
            raise
        return _fail(options, f"{error.filename}: {error.strerror}", USAGE)
    except Exception as error:
        return _fail(
            options,
            f"internal error ({type(error).__name__}: {error}); this is a defect of pkgen: "
            "please report it together with the model",
            MODEL_WRONG,
        )


def _fail(options: argparse.Namespace, message: str, code: int) -> int:
    if options.json:
        print(json.dumps({"error": message, "code": code}))
    else:
        print(f"pkgen: {message}", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())
