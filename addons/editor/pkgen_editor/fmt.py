"""`pkgen fmt`: formats the text of models."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from pkgen.cli.messages import findings
from pkgen.front.read import STANDARD, UnreadableModel, read_text
from pkgen.source import ModelError
from pkgen.system.exits import DONE, MODEL_WRONG, USAGE
from pkgen.system.files import replace

from .layout import laid_out

EXAMPLES = """
pkgen fmt models/double_pendulum.lag
pkgen fmt --check models/double_pendulum.lag models/heavy_top.lag
pkgen fmt - < models/heavy_top.lag
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    help_ = "written in place; -: from the standard input to the standard output"
    parser.add_argument("files", nargs="+", metavar="MODEL.lag", help=help_)
    help_ = "write nothing; 1 where a text is not in its layout"
    parser.add_argument("--check", action="store_true", help=help_)


def run(options: argparse.Namespace) -> int:
    """Format the text of models: only spaces and columns change, not words or comments. A text with
    an unknown character or an unbalanced bracket is left as it is."""
    changed, wrong, code = [], [], DONE
    for name in dict.fromkeys(options.files):
        try:
            source = read_text(name, "a .lag file")
            text = laid_out(source)
        except ModelError as error:
            code = max(code, USAGE if isinstance(error, UnreadableModel) else MODEL_WRONG)
            wrong += [d.record(error.source) for d in error.diagnostics]
            if not options.json:
                findings(error.text())
            continue
        path = Path(name)
        before = source.text.encode() if name == STANDARD else path.read_bytes()
        if text.encode() != before:
            changed.append(name)
        if not options.check and (name == STANDARD or name in changed):
            replace({path: text})
    if options.json and not (STANDARD in options.files and not options.check):
        print(json.dumps({"changed": changed, "diagnostics": wrong}))
    elif options.check:
        for name in changed:
            print(f"pkgen: {name}: not in its layout; pkgen fmt {name}", file=sys.stderr)
    return max(code, MODEL_WRONG) if options.check and changed else code
