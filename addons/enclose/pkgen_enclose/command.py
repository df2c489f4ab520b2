"""The option --enclose of `pkgen run`: rows with rigorous bounds."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from pkgen.cli.compilation import compile_within_limits
from pkgen.scenes import compile_plan as use
from pkgen.system.children import stopping
from pkgen.system.exits import DONE, INTERRUPTED, NUMERICS_FAILED, UsageError
from pkgen.system.files import replace
from pkgen.system.progress import progress


def arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    help_ = "within rigorous bounds: a radius beside each value"
    add("--enclose", dest="instead", action="store_const", const=run, help=help_)
    add("--digits", action=_Digits, metavar="N", help="that --enclose is to certify (default 15)")


class _Digits(argparse.Action):
    """Stores the option --digits; without --enclose the run is refused."""

    def __call__(self, parser: object, options: argparse.Namespace, value: str, *_: object) -> None:
        options.digits = value
        options.instead = options.instead or _refuse


def _refuse(options: argparse.Namespace) -> int:
    raise UsageError("--digits is for --enclose; a run's accuracy is --rtol's")


def run(options: argparse.Namespace) -> int:
    """Write rows with bounds to standard output or to a file, and a report to standard error."""
    from . import ask, text
    from .domains import flint
    from .enclose import enclose

    if options.checkpoint:
        raise UsageError("--checkpoint is for a run by steps, without --enclose")
    digits = ask.digits(options.digits)
    ask.refuse_options(options)
    flint()
    both = ask.ends(options)
    compilation = compile_within_limits(both[0], unroll=None, use=use.enclosed(both[0]))
    given = ask.given(both, compilation)
    with progress(compilation.model.name) as show, stopping() as stopped:
        found = enclose(given, digits, show or (lambda _: None), stopped)
    content = "\n".join(text.lines(found)) + "\n"
    if options.output not in (None, "-"):
        replace({Path(options.output): content})
    if options.json:
        print(json.dumps(text.record(found), indent=1))
    else:
        if options.output in (None, "-"):
            print(content, end="", flush=True)
        for line in text.report(found, "" if compilation.model.dimensionless else "s"):
            print(line, file=sys.stderr)
    if found.interrupted:
        return INTERRUPTED
    return DONE if found.whole else NUMERICS_FAILED
