"""`pkgen lsp`: the language server."""

from __future__ import annotations

import argparse
import sys
from importlib.util import find_spec

from pkgen.system.exits import DONE, UsageError
from pkgen.system.progress import say

EXAMPLES = """
pkgen lsp
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--stdio", action="store_true", help="as some editors say; there is no other"
    )


def run(options: argparse.Namespace) -> int:
    """Serve an editor over standard input and output by the Language Server Protocol: errors,
    hover, completion, definitions, renaming, units, quick fixes, formatting. Editors start it."""
    if find_spec("pygls") is None or find_spec("pygls.lsp.server") is None:
        raise UsageError("lsp needs pygls 2, which is not here: pip install 'pygls>=2'")
    if sys.stdin.isatty():
        say("an editor starts this and speaks to it (addons/editor/README.md); Ctrl-C ends it")
    from .server import serve

    serve()
    return DONE
