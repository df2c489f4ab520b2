"""`pkgen build`: builds a standalone program for a model or one of its scenes."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import replace
from pathlib import Path

from ..api.prepare import prepare
from ..run.build import build_program
from ..run.library import initializer, load
from ..run.simulate import build as library_of
from ..system.exits import UsageError
from . import arguments as shared
from .compilation import compile_within_limits

EXAMPLES = """
pkgen build models/double_pendulum.lag -o swing
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.as_of_a_run(parser)
    add = parser.add_argument
    add("--scene", metavar="NAME", help="the scene whose settings are its defaults")
    add("--static", action="store_true", help="needs no shared library where it runs")
    add("--native", action="store_true", help="for this processor alone, and faster")
    add("--gsl", action="store_true", help="with the methods of GSL; it is then under the GPL")
    add("-o", dest="program", required=True, metavar="FILE", help="the program")


def run(options: argparse.Namespace) -> None:
    """Make a program that integrates the model and has the options of `pkgen run`."""
    path = Path(options.program)
    if path.is_dir():
        raise UsageError(f"-o {path}: it is a directory; give the program's name")
    what = prepare(options, compile_within_limits)
    if what.ensemble is not None:
        raise UsageError(
            f"--scene {options.scene}: a swarm is for pkgen run; give the program a table"
        )
    what.compilation.declared.refuse_long("pkgen build")
    for note in what.notes:
        print(note, file=sys.stderr)
    settings = what.settings
    if not what.spaced:
        settings = replace(settings, every=None)  # The program computes `every` from the duration.
    library = load(library_of(what.compilation, settings, None))
    build_program(
        what.compilation.files,
        what.compilation.model.name,
        initializer(library.settings(settings)),
        path,
        *settings.methods,
        parts=what.compilation.blocks,
        static=options.static,
        native=options.native,
        gsl=options.gsl,
        own=what.compilation.model.methods,
    )
    if options.json:
        print(json.dumps({"program": str(path)}))
