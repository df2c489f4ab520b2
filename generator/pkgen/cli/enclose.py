"""`pkgen run --enclose`: rows within rigorous bounds."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from ..scenes import use
from ..system.children import stopping
from ..system.exits import DONE, INTERRUPTED, NUMERICS_FAILED
from ..system.files import replace
from ..system.progress import progress
from .compilation import compile_within_limits


def arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("--enclose", action="store_true", help="within rigorous bounds: a radius beside each value")
    add("--digits", metavar="N", help="that --enclose is to certify (default 15)")


def run(options: argparse.Namespace) -> int:
    """Rows to standard output or to a file, a report to standard error."""
    from ..analysis.enclose import ask, text
    from ..analysis.enclose.domains import flint
    from ..analysis.enclose.enclose import enclose

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
