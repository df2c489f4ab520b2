"""`pkgen linearise`: the linear model beside an equilibrium, a trim, or a state of the motion."""

from __future__ import annotations

import argparse
import json

from ..analysis.linear import linearise
from ..run.values import Values
from ..scenes.compile_plan import whole
from ..system.exits import DONE
from . import arguments as shared
from .compilation import compile_within_limits

EXAMPLES = """
pkgen linearise models/heavy_top.lag --at equilibrium
pkgen linearise models/controlled/cart_pole_swing_up.lag --at trim --want "theta=0" --json
pkgen linearise models/double_pendulum.lag --at t=2 --matlab
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.as_of_a_run(parser)
    shared.of_a_state(parser)
    add = parser.add_argument
    help_ = "equilibrium (the nearest to the start), trim, or a time of the motion: t=2"
    add("--at", dest="at_state", metavar="STATE", default="equilibrium", help=help_)
    help_ = "of a trim: a state, rate, input or output that is to have this value"
    add("--want", metavar="NAME=VALUE", action="append", default=[], help=help_)
    add("--period", metavar="T", help="of samples: the discrete model, inputs held in between")
    add("--matlab", action="store_true", help="text for MATLAB and Octave")


def run(options: argparse.Namespace) -> int:
    """Print A, B, C, D of dx/dt = A x + B u, y = C x + D u, their names and the poles."""
    how = {"unroll": None, "kernels": linearise.kernels(), "use": whole(options)}
    compilation = compile_within_limits(options, **how)
    found = linearise.of_model(options, compilation)
    if options.period is not None:
        found = found.discrete(Values(compilation).positive("--period", options.period, "s"))
    if options.json:
        print(json.dumps(found.record(), indent=1))
    else:
        print(found.matlab() if options.matlab else found.text(), end="")
    return DONE
