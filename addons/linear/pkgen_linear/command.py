"""`pkgen linearise`: the linear model beside an equilibrium, a trim, or a state of the motion."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pkgen.api import arguments as of_call
from pkgen.api.arguments import in_words
from pkgen.api.model import Model
from pkgen.back.kernels import all_but
from pkgen.cli import arguments as shared
from pkgen.cli import pictures
from pkgen.cli.compilation import compile_within_limits
from pkgen.cli.messages import needs
from pkgen.run.values import Values
from pkgen.scenes.compile_plan import whole
from pkgen.system.exits import DONE, UsageError

from .linearise import of_model
from .plots import KINDS, LinearModel, picture

EXAMPLES = """
pkgen linearise models/heavy_top.lag --at equilibrium
pkgen linearise models/controlled/cart_pole_swing_up.lag --at trim --want "theta=0" --json
pkgen linearise models/double_pendulum.lag --at t=2 --matlab
pkgen linearise models/controlled/cart_pole_swing_up.lag --plot bode -o bode.svg
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
    add("--plot", choices=KINDS, help="a picture of these")
    help_ = "of --plot bode or root_locus (default: all)"
    add("--transfer", metavar="OUTPUT,INPUT", help=help_)
    help_ = "of --plot: FILE.svg, .png or .pdf; default: in the terminal"
    add("-o", dest="output", metavar="FILE", help=help_)


def run(options: argparse.Namespace) -> int:
    """Print A, B, C, D of dx/dt = A x + B u, y = C x + D u, their names and the poles."""
    _refuse(options)
    compilation = compile_within_limits(options, **_how(options))
    found = of_model(options, compilation)
    if options.period is not None:
        found = found.discrete(Values(compilation).positive("--period", options.period, "s"))
    if options.plot is not None:
        _draw(options, found)
    elif options.json:
        print(json.dumps(found.record(), indent=1))
    else:
        print(found.matlab() if options.matlab else found.text(), end="")
    return DONE


def linearise(
    model: Model,
    at: str | float = "equilibrium",
    *,
    want: Mapping[str, of_call.Value] | None = None,
    start: Mapping[str, of_call.Value] | None = None,
    inputs: Mapping[str, of_call.Value] | None = None,
) -> LinearModel:
    """Returns the linear model beside the equilibrium nearest to the start; at="trim": beside the
    steady state at which the quantities of `want` have these values; at=2.5: beside the state at
    this time. Raises UsageError, ModelError, RunError."""
    with in_words():
        options = of_call.options(model, {"start": start, "inputs": inputs})
        options.at_state = at if isinstance(at, str) else f"t={at!r}"
        options.want = [f"{k}={of_call.text(x)}" for k, x in (want or {}).items()]
        return of_model(options, model._compiled(options, **_how(options)))


def _how(options: argparse.Namespace) -> dict[str, Any]:
    return {"unroll": None, "kernels": all_but("r_p", "out_p"), "use": whole(options)}


def _refuse(options: argparse.Namespace) -> None:
    if options.plot is None:
        if options.transfer or options.output:
            raise UsageError(f"--transfer and -o are of a picture: --plot {' or '.join(KINDS)}")
        return
    needs("matplotlib")
    if options.json or options.matlab:
        raise UsageError("--plot is a picture: leave --json or --matlab away")
    if options.output is not None:
        pictures.picture_file("-o", options.output)


def _draw(options: argparse.Namespace, found: LinearModel) -> None:
    pairs = []
    if options.transfer is not None:
        pair = tuple(name.strip() for name in options.transfer.split(","))
        if len(pair) != 2:
            raise UsageError(f"--transfer {options.transfer}: give an output and an input, y,u")
        pairs = [pair]
    made = picture(found, options.plot, pairs)
    pictures.write(made, options.output and Path(options.output), None)
    if options.output is None:
        from pkgen.plot.terminal import show

        show(made)
