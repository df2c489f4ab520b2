"""`pkgen optimise`: the inputs and parameters of the best motion."""

from __future__ import annotations

import argparse
import json

from pkgen.api.model import load
from pkgen.cli import arguments as shared
from pkgen.cli.pictures import picture_file
from pkgen.plot import style
from pkgen.run.values import assignment
from pkgen.system.exits import DONE, UsageError
from pkgen.system.files import replace
from pkgen.system.near import near

from .optimise import ITERATIONS, PIECES, optimised

EXAMPLES = """
pkgen optimise cart_pole.lag --integral "F^2" --input F=-20:20 --end theta=3.14159 --until 2
pkgen optimise block.lag --minimise t --input F=-1:1 --end x=1 --end "x'=0" --until 0.5:5
pkgen optimise thrown.lag --maximise x --free angle=0:1.5 --until 2 --json
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.as_of_a_run(parser)
    shared.of_a_state(parser)
    text = f"""
        --minimise    COLUMN        its last value is the aim; t: the duration
        --maximise    COLUMN        likewise
        --integral    EXPR          its integral over time is added to the aim
        --free-start  NAMES         coordinates and rates whose start is free
        --pieces      int:N         of the motion (default: {PIECES})
        --linear      -             inputs are linear in a piece (default: constant)
        --method      NAME          of the motions
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
    add("--end", metavar="NAME=VALUE", help="a column at the end, or LOW:HIGH", **more)
    add("--path", metavar="NAME=LOW:HIGH", help="a column at the ends of all pieces", **more)
    help_ = "it ends as it starts; NAME=COLUMN: it starts where that column ends"
    add("--periodic", metavar="NAME", help=help_, **more)
    add("--guess", metavar="NAME=A:B", help="the search goes from A to B; of t the mean", **more)
    add("--until", metavar="T", required=True, help="the duration, or LOW:HIGH")


def run(options: argparse.Namespace) -> int:
    """Find inputs, parameters, starts and a duration at which a motion is best."""
    picture = picture_file("-o", options.o) if options.o else None
    model = load(options.model, options.scene)
    inputs = {x.name for x in model.compilation.equations.inputs}
    for text in options.set:
        name, value = assignment("--set", text)
        if name in inputs:
            options.input.append(text)
        elif name in model.params:
            model.params[name] = value
        else:
            raise UsageError(f"--set {name}: {near(name, [*model.params], 'parameter')}")
    given = {k: getattr(options, k) for k in ("minimise", "maximise", "integral", "until")}
    ranges = {k: _ranges(f"--{k}", getattr(options, k)) for k in ("input", "free", "end", "path")}
    of_run = {k: getattr(options, k) for k in ("method", "step", "rtol")}
    found = optimised(
        model,
        **{k: x or "" for k, x in given.items()},
        inputs=ranges.pop("input"),
        **ranges,
        free_start=[x.strip() for x in (options.free_start or "").split(",") if x.strip()],
        periodic=options.periodic,
        pieces=PIECES if options.pieces is None else options.pieces,
        linear=options.linear,
        guess=_ranges("--guess", options.guess),
        solver=options.solver or "",
        iterations=ITERATIONS if options.iterations is None else options.iterations,
        start=dict(assignment("--start", text) for text in options.start),
        **{k: x for k, x in of_run.items() if x is not None},
    )
    print(json.dumps(found.record(), indent=1) if options.json else found.text(), end="")
    if picture:
        replace({picture: style.encoded(found.plot(), picture.suffix[1:])})
    return DONE


def _ranges(option: str, texts: list[str]) -> dict[str, str | None]:
    """Returns texts of ranges by name; a name alone is free without ends."""
    pairs = [assignment(option, text) if "=" in text else (text, None) for text in texts]
    if len(dict(pairs)) < len(pairs):
        raise UsageError(f"{option}: a name is there twice")
    return dict(pairs)
