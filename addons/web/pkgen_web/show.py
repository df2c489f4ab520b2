"""`pkgen show`: a model as a live page."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from pkgen.back.wasm.build import wasm
from pkgen.cli import arguments as shared
from pkgen.cli.compilation import compile_within_limits
from pkgen.cli.explain import explained
from pkgen.cli.messages import refuse_both
from pkgen.describe.page_data import describe
from pkgen.middle.refused import refuse_statements
from pkgen.system import addons
from pkgen.system.exits import DONE, UsageError
from pkgen.system.files import STANDARD, replace

from .page import packed

SWARM = Path(__file__).parent / "swarm.c"

EXAMPLES = """
pkgen show models/double_pendulum.lag -o pendulum.html
pkgen show flips --map theta1,theta2 -o flips.html
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.as_of_a_run(parser)
    shared.of_a_motion(parser)
    shared.own_methods(parser)
    add = parser.add_argument
    add("-o", dest="page", metavar="FILE.html", help="default: NAME.html, here")
    add("--map", metavar="a,b", help="the axes of a sweep's map (default: the first two)")
    add("--columns", metavar="NAME", help="what is kept that it shows (default: the first)")
    add("--member", type=int, metavar="N", help="the motion of one of a sweep's")


def run(options: argparse.Namespace) -> int:
    """Make one HTML file that simulates the model in a browser, by its C as WebAssembly, with
    controls for parameters, starts and methods; it needs no other files."""
    refuse_both(options, options.page)
    folder, shown = addons.of_folder(options.model), None
    if folder:
        shown = folder.taken(options)
    elif options.map or options.columns or options.member is not None:
        raise UsageError("--map, --columns and --member are of a sweep: give its folder")
    found = describe(options, lambda options, **how: compile_within_limits(options, **how))
    path = Path(options.page or f"{found.compilation.model.name}.html")
    if path != STANDARD and path.suffix not in (".html", ".htm"):
        raise UsageError(f"-o {path}: the file's name must end in .html")
    if shown is not None:
        found.description["map"] = folder.described(shown, found.compilation)
    compilation = found.compilation
    refuse_statements(compilation.declared, "pkgen show")
    model = compilation.model
    code = wasm(compilation.files, model.name, model.methods, (SWARM,))
    text = packed(found.description, code, *explained(options))
    replace({path: text})
    if options.json:
        print(json.dumps({"page": str(path), "bytes": len(text.encode())}))
    elif path != STANDARD:
        print(f"{path}: {len(text.encode()) / 1000:.0f} kB; open it in a browser")
    return DONE
