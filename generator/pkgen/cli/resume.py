"""`pkgen resume`: continues a run from its checkpoint."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from ..system.exits import UsageError
from . import checkpoints
from . import run as running

EXAMPLES = """
pkgen run models/double_pendulum.lag --until 1e6 -o rows.csv --checkpoint swing.ck
pkgen resume swing.ck
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("checkpoint", metavar="FILE", help="of pkgen run --checkpoint FILE")


def run(options: argparse.Namespace) -> int:
    """Continue a run that was stopped or killed. Rows after the checkpoint are removed and computed
    again; the result is the same, to the bit, as without the interruption."""
    from .commands import parser_of

    path = Path(options.checkpoint).absolute()
    found = checkpoints.note(path)
    of_run = parser_of("run").parse_intermixed_args(found["words"])
    if not os.path.isdir(found["folder"]):
        raise UsageError(f"{path}: its run was in {found['folder']}, which is not there")
    os.chdir(found["folder"])
    of_run.words, of_run.checkpoint, of_run.resume = found["words"], str(path), found
    of_run.json, of_run.quiet, of_run.verbose = options.json, options.quiet, options.verbose
    return running.run(of_run)
