"""`pkgen show`: a model as a live page."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from ..back.web.build import wasm
from ..back.web.page import packed
from ..describe.made import describe
from ..explain.style import style
from ..sweep.shards import is_sweep
from ..sweep.store import place
from ..system.exits import DONE, UsageError
from ..system.files import STANDARD, replace
from . import arguments as shared
from .compilation import compile_within_limits
from .explain import explained
from .said import refuse_both

EXAMPLES = """
pkgen show models/double_pendulum.lag -o pendulum.html
pkgen show flips --map theta1,theta2 -o flips.html
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.as_of_a_run(parser)
    shared.of_a_motion(parser, "10")
    shared.own_methods(parser)
    parser.add_argument("-o", dest="page", metavar="FILE.html", help="default: NAME.html, here")
    shared.of_a_map(parser)
    parser.add_argument("--member", type=int, metavar="N", help="the motion of one of a sweep's")


def run(options: argparse.Namespace) -> int:
    """Make one file that opens in a browser and needs nothing else: the model moves in it,
    computed there by its own C, with all its parameters and methods at hand."""
    refuse_both(options, options.page)
    shown = None
    if is_sweep(place(options.model)):
        from . import swept

        shown = swept.taken(options)
    elif options.map or options.columns or options.member is not None:
        raise UsageError("--map, --columns and --member are of a sweep: give its folder")
    found = describe(options, lambda options, **how: compile_within_limits(options, **how))
    path = Path(options.page or f"{found.compilation.model.name}.html")
    if path != STANDARD and path.suffix not in (".html", ".htm"):
        raise UsageError(f"-o {path}: the file's name must end in .html")
    if shown is not None:
        found.description["map"] = swept.described(shown, found.compilation)
    compilation = found.compilation
    code = wasm(compilation.files, compilation.model.name, compilation.model.methods)
    text = packed(found.description, code, explained(options), style())
    replace({path: text})
    if options.json:
        print(json.dumps({"page": str(path), "bytes": len(text.encode())}))
    elif path != STANDARD:
        print(f"{path}: {len(text.encode()) / 1000:.0f} kB; open it in a browser")
    return DONE
