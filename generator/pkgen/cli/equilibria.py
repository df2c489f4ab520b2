"""`pkgen equilibria`: where a model rests, or goes on steadily, and its small motions there."""

from __future__ import annotations

import argparse
import json

from ..analysis.linear import report
from ..analysis.linear.equilibria import of_model
from ..scenes.compile_plan import whole
from ..system.exits import DONE
from . import arguments as shared
from .compilation import compile_within_limits

EXAMPLES = """
pkgen equilibria models/heavy_top.lag
pkgen equilibria models/particles/restricted_three_body.lag --json
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.as_of_a_run(parser)
    shared.of_a_state(parser)
    shared.rows(parser, "--tries  int:N  starts of the search (default: 100)")


def run(options: argparse.Namespace) -> int:
    """List the equilibria and the steady motions of a model, with frequencies and stability."""
    compilation = compile_within_limits(options, unroll=None, use=whole(options))
    found = report.record(compilation, of_model(options, compilation))
    print(json.dumps(found, indent=1) if options.json else report.text(found))
    return DONE
