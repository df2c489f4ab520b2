"""`pkgen optimise`: the inputs and parameters of the best motion."""

from __future__ import annotations

import argparse
import json
import re

from pkgen.api.model import load
from pkgen.cli import arguments as shared
from pkgen.cli.compilation import within_limits
from pkgen.cli.pictures import picture_file
from pkgen.plot import style
from pkgen.run import named
from pkgen.run.values import assignment
from pkgen.scenes import lengths
from pkgen.system.exits import DONE, UsageError
from pkgen.system.files import replace

from .optimise import INTERVALS, ITERATIONS, optimised

EXAMPLES = """
pkgen optimise cart_pole.lag --integral "F^2" --input F=-20:20 --end theta=3.14159 --until 2
pkgen optimise block.lag --minimise t --input F=-1:1 --end x=1 --end "x'=0" --until 0.5:5
pkgen optimise thrown.lag --maximise x --free angle=0:1.5 --until 2 --json
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.as_of_a_run(parser)
    shared.of_a_state(parser)
    text = f"""
        --minimise    COLUMN        its last value is the objective; t: the duration
        --maximise    COLUMN        likewise, made largest
        --integral    EXPR          its integral over time is added to the objective
        --free-start  NAMES         coordinates, rates and states whose start is free
        --intervals   int:N         of shooting (default: {INTERVALS})
        --linear      -             inputs are linear in an interval (default: constant)
        --method      NAME          of the runs
        --step        H             of a method of fixed steps
        --rtol        R             of an adaptive method
        --solver      NAME          ipopt (default where it is installed) or slsqp
        --iterations  int:N         most iterations (default: {ITERATIONS})
        -o            FILE          a picture of the optimum
    """
    shared.rows(parser, text)
    more = {"action": "append", "default": []}
    add = parser.add_argument
    add("--input", metavar="NAME=LOW:HIGH", help="an input that is free", **more)
    add("--free", metavar="NAME=LOW:HIGH", help="a parameter that is free", **more)
    help_ = "terminal constraint: the value of a column at the end, or its range"
    add("--end", metavar="NAME=VALUE|LOW:HIGH", help=help_, **more)
    help_ = "path constraint: a column at the ends of all intervals"
    add("--path", metavar="NAME=LOW:HIGH", help=help_, **more)
    help_ = "the column ends with its start value; NAME=COLUMN: NAME starts with the end value of "
    add("--periodic", metavar="NAME", help=help_ + "COLUMN", **more)
    help_ = "first guess: linear from A to B; of t, the mean; of a parameter, A"
    add("--guess", metavar="NAME=A:B", help=help_, **more)
    add("--until", metavar="T|LOW:HIGH", required=True, help="the duration, or its range")


def run(options: argparse.Namespace) -> int:
    """Find inputs, parameters, starts and a duration at which an objective is least or largest."""
    picture = picture_file("-o", options.o) if options.o else None
    with within_limits(options):
        model = load(options.model, options.scene, lengths.given(options.size))
    inputs = named.inputs(model.compilation)
    held = [x for x in options.set if x.partition("=")[0].strip() in inputs]
    options.set = [x for x in options.set if x not in held]
    given = {k: getattr(options, k) for k in ("minimise", "maximise", "integral", "until")}
    ranges = {k: _ranges(f"--{k}", getattr(options, k)) for k in ("free", "end", "path", "guess")}
    found = optimised(
        model,
        options,
        **{k: x or "" for k, x in given.items()},
        **ranges,
        inputs=_ranges("--input", [*options.input, *held]),
        free_start=re.findall(r"[^\s,]+", options.free_start or ""),
        periodic=options.periodic,
        intervals=INTERVALS if options.intervals is None else options.intervals,
        linear=options.linear,
        solver=options.solver or "",
        iterations=ITERATIONS if options.iterations is None else options.iterations,
    )
    print(json.dumps(found.record(), indent=1) if options.json else found.text())
    if picture:
        replace({picture: style.encoded(found.plot(), picture.suffix[1:])})
    return DONE


def _ranges(option: str, texts: list[str]) -> dict[str, str | None]:
    """Returns texts of ranges by name; a name alone is free without ends."""
    pairs = [assignment(option, text) if "=" in text else (text, None) for text in texts]
    if len(dict(pairs)) < len(pairs):
        raise UsageError(f"{option}: a name is there twice")
    return dict(pairs)
