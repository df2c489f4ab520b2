"""The command line. Nothing else in pkgen prints or exits.

Exit codes: 0 done; 1 the model is wrong; 2 usage; 3 the C compiler failed; 4 the numerics
failed; 130 interrupted.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterable
from contextlib import suppress

from . import __version__
from .cli import arguments, commands
from .cli import chart as chart_command
from .cli import run as run_command
from .cli import stability as stability_command
from .compiler import STAGES
from .run.diagnostics import NAMES
from .run.values import near
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


def parser_of(command: str) -> argparse.ArgumentParser:
    usage = {"compile": "pkgen MODEL.lag [-o DIR] [options]"}.get(command)
    about = COMMANDS[command].__doc__
    parser = argparse.ArgumentParser(
        prog=f"pkgen {command}", usage=usage, description=about, allow_abbrev=False
    )
    if command != "methods":
        parser.add_argument("model", metavar="MODEL.lag")
        parser.add_argument(
            "--size", action="append", default=[], metavar="N=64", help="length of a family"
        )
        parser.add_argument("--max-seconds", metavar="S", help="CPU time that compiling may take")
    parser.add_argument("--json", action="store_true", help="machine-readable results")
    ARGUMENTS.get(command, lambda _: None)(parser)
    return parser


def _compile_arguments(parser: argparse.ArgumentParser) -> None:
    arguments.directory(parser)
    parser.add_argument("--scene", metavar="NAME", help="compile one scene of the model")
    _no_reduce_argument(parser)
    parser.add_argument("--kernels", metavar="LIST", help="only these, e.g. mass,force")
    _sincos_arguments(parser)
    _canonical_argument(parser)
    parser.add_argument("--self-test", action="store_true", help="a program that tests the kernels")
    parser.add_argument(
        "--dump", choices=STAGES, metavar="STAGE", help="show a stage's result as text"
    )


def _explain_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scene", metavar="NAME", help="what one scene leaves of the model")
    _no_reduce_argument(parser)
    _canonical_argument(parser)
    parser.add_argument("--html", metavar="FILE", help="a page with the equations typeset")


def _canonical_argument(parser: argparse.ArgumentParser) -> None:
    help_ = "the canonical form too: H(q, p) and its gradients"
    parser.add_argument("--canonical", action="store_true", help=help_)


def _sincos_arguments(parser: argparse.ArgumentParser) -> None:
    help_ = "sine and cosine of the C library, not the inline pair"
    parser.add_argument("--libm", action="store_true", help=help_)
    help_ = "no fused multiply-add: the same bits on processors with it and without"
    parser.add_argument("--portable", action="store_true", help=help_)


def _no_reduce_argument(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--no-reduce",
        nargs="?",
        const="all",
        metavar="LIST",
        help="keep all that a scene does not need, or make all reductions but these: "
        "fold,outputs,unconnected,cyclic,apart,exact",
    )


def _run_arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    arguments.of_a_motion(parser, "10")
    add(
        "--method",
        metavar="NAME",
        help="see pkgen methods; default gauss, or dop853 for kinks (abs, min, max, step) and "
        "for --rtol above 1e-5",
    )
    add("--step", metavar="H", help="of a method with fixed steps; else the first step")
    add("--max-step", metavar="H", help="of an adaptive method")
    add("--rtol", metavar="R", help="of an adaptive method (default 1e-10)")
    add("--atol", metavar="A", help="default: R times the scale that the motion shows")
    add("--every", metavar="DT", help="time between rows (default: a thousandth of the duration)")
    add("--units", action="store_true", help="units in the header of the CSV")
    add("--record", metavar="a,b,energy", help="only these columns, behind t")
    add("--at", metavar="EVENT", help="a row at each crossing, and by time only with --every")
    add("--ensemble", metavar="FILE.csv", help="a row a trajectory: parameters, starts, inputs")
    add("--threads", type=int, metavar="N", help="of an ensemble (default: all cores)")
    arguments.of_implicit_methods(parser)
    add("--diagnose", metavar="LIST", help=f"{','.join(NAMES)}, or all")
    _sincos_arguments(parser)
    _no_reduce_argument(parser)
    add("--max-steps", type=int, default=1_000_000_000, metavar="N")
    add(
        "-o",
        dest="output",
        metavar="FILE",
        help="FILE.csv or FILE.npy; default: standard output",
    )


def _as_of_a_run(
    own: Callable[[argparse.ArgumentParser], None],
) -> Callable[[argparse.ArgumentParser], None]:
    """A command's own options; what it has none for is as in a run."""

    def add(parser: argparse.ArgumentParser) -> None:
        of_run = argparse.ArgumentParser()
        _run_arguments(of_run)
        parser.set_defaults(**vars(of_run.parse_args([])))
        own(parser)

    return add


COMMANDS: dict[str, Callable[[argparse.Namespace], int]] = {
    "compile": commands.compile_to_c,
    "check": commands.check,
    "explain": commands.explain,
    "run": run_command.run,
    "chart": chart_command.run,
    "stability": stability_command.run,
    "methods": commands.methods,
}
ARGUMENTS = {
    "compile": _compile_arguments,
    "explain": _explain_arguments,
    "run": _run_arguments,
    "chart": _as_of_a_run(chart_command.arguments),
    "stability": _as_of_a_run(stability_command.arguments),
}

LATER = frozenset(("export", "sweep", "fmt"))

OVERVIEW = """usage: pkgen MODEL.lag [-o DIR]    write DIR/NAME.h and DIR/NAME.c (default: here)
       pkgen check MODEL.lag        errors and warnings only
       pkgen explain MODEL.lag      equations, structure
       pkgen run MODEL.lag          compile and integrate; CSV to standard output
       pkgen chart MODEL.lag        accuracy against cost, by every method that applies
       pkgen stability MODEL.lag    where each method fails, predicted and measured
       pkgen methods                the methods, orders, what each requires
       pkgen COMMAND --help         the options of a command ('compile' for the first line's)
       pkgen --version"""


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
        print(f"pkgen: '{words[0]}' is not there yet\n\n{OVERVIEW}", file=sys.stderr)
        return USAGE
    command = words[0] if words[0] in COMMANDS else "compile"
    if command != words[0] and words[0].isalpha() and not os.path.exists(words[0]):
        said = f"there is no command '{words[0]}'; {_near(words[0], COMMANDS)}"
        print(f"pkgen: {said}", file=sys.stderr)
        return USAGE
    parser = parser_of(command)
    options, unknown = parser.parse_known_args(words[1:] if command == words[0] else words)
    if unknown:
        flag = unknown[0].partition("=")[0]
        said = f"there is no option {flag}; {_near(flag, parser._option_string_actions)}"
        said = said if flag.startswith("-") else f"one model at a time: what is {flag}?"
        print(f"pkgen: {said}", file=sys.stderr)
        return USAGE
    return _guarded(COMMANDS[command], options)


def _open_streams() -> None:
    """Where a standard stream is closed, no other file gets its number; what is written to standard
    output then fails, as it is to."""
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
    except ResourcesExceeded as error:
        return _fail(options, str(error), MODEL_WRONG)
    except UsageError as error:
        return _fail(options, str(error), USAGE)
    except BuildError as error:
        return _fail(options, str(error), COMPILER_FAILED)
    except NumericsFailed as error:
        return _fail(options, str(error), NUMERICS_FAILED)
    except KeyboardInterrupt:
        return _fail(options, "interrupted", INTERRUPTED)
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
