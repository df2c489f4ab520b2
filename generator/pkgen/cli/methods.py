"""`pkgen methods`: the integration methods."""

from __future__ import annotations

import argparse
import json

from ..run.build import runtime_methods
from ..run.methods_table import methods_text
from ..system.exits import DONE

MODEL = False  # it takes none


def arguments(parser: argparse.ArgumentParser) -> None:
    """None of its own."""


def run(options: argparse.Namespace) -> int:
    """List the integration methods."""
    found = runtime_methods()
    if options.json:
        print(json.dumps(found, indent=1))
        return DONE
    print(methods_text(found))
    return DONE
