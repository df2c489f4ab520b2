"""`pkgen check`: reports the errors and warnings of a model."""

from __future__ import annotations

import argparse
import json

from ..compiler import check_model
from ..front.read import read
from ..scenes import check as scene_check
from ..scenes import lengths
from ..source import ModelError
from . import arguments as shared
from .compilation import warn, within_limits

EXAMPLES = """
pkgen check models/double_pendulum.lag
pkgen check - < models/heavy_top.lag
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.unrolling(parser)


def run(options: argparse.Namespace) -> None:
    """Report the errors and warnings of a model, and write nothing."""
    source = read(options.model)
    sizes = lengths.given(options.size)
    with within_limits(options):
        unroll = 0 if options.unroll is None else lengths.unroll(options)
        model, warnings = check_model(source, sizes=sizes, unroll=unroll)
        # A scene that --size makes invalid is an error only in commands that run this scene.
        scenes = [item for item in model.scenes if item.listed and not item.misfits]
        wrong = [d for item in scenes for d in scene_check.wrong(model, sizes, item)]
    if wrong:
        raise ModelError(source, wrong)
    if options.json:
        print(json.dumps({"diagnostics": [w.record(source) for w in warnings]}))
    else:
        warn(source, warnings)
