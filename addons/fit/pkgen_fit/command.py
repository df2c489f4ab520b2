"""`pkgen fit`: parameters and starts of a model from measured motions."""

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

from .fit import fitted, read_number
from .search import TRIES

EXAMPLES = """
pkgen fit pendulum.lag swing.csv --free l,c --free-start theta
pkgen fit pendulum.lag a.csv b.csv --free l --free-start "theta,theta'" --sigma "theta=0.5 [deg]"
pkgen fit pendulum.lag swing.csv --free l,c --bound l=0.1:2 --prior "c=0.1+-0.05" --json
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.as_of_a_run(parser)
    parser.add_argument("data", nargs="+", metavar="DATA.csv", help="columns t, theta [deg], ...")
    shared.of_a_state(parser)
    text = f"""
        --free        NAMES         parameters, and inputs that are constant: l,c
        --free-start  NAMES         coordinates and rates whose start is sought
        --prior       NAME=VALUE+-S+  known beside the data, with standard deviation S
        --sigma       NAME=VALUE+   standard deviation of a column (default: of its residuals)
        --huber       -             outliers count less
        --tries       int:N         starts besides the model's own values (default: {TRIES})
        --method      NAME          of the runs
        --step        H             of a method of fixed steps
        --rtol        R             of an adaptive method
        -o            FILE          a picture of the residuals
    """
    shared.rows(parser, text)
    more = {"action": "append", "default": []}
    help_ = "between these (default: the bounds of the model)"
    parser.add_argument("--bound", metavar="NAME=LOW:HIGH", help=help_, **more)


def run(options: argparse.Namespace) -> int:
    """Fit parameters and starts to measured motions, by least squares from several starts."""
    picture = picture_file("-o", options.o) if options.o else None
    model = load(options.model, options.scene, sizes=_sizes(options))
    inputs, of = {}, model.compilation
    for text in options.set:
        name, value = assignment("--set", text)
        if name in {x.name for x in of.equations.inputs}:
            inputs[name] = value
        else:
            model.params[name] = value
    start = dict(assignment("--start", text) for text in options.start)

    def each(option: str, parts: str) -> dict[str, list[float]]:
        found = {}
        for text in getattr(options, option.strip("-")):
            name, value = assignment(option, text)
            words = value.split(parts) if parts else [value]
            if len(words) != (2 if parts else 1):
                raise UsageError(f"{option} {text}: give {option} NAME=A{parts}B")
            found[name] = [read_number(of, option, word.strip(), name) for word in words]
        return found

    of_run = {k: getattr(options, k) for k in ("method", "step", "rtol")}
    known = {
        "bounds": {k: (a, b) for k, (a, b) in each("--bound", ":").items()},
        "priors": {k: (a, b) for k, (a, b) in each("--prior", "+-").items()},
        "sigma": {k: a for k, (a,) in each("--sigma", "").items()},
    }
    more = {"start": start, "inputs": inputs, **{k: x for k, x in of_run.items() if x is not None}}
    free = _names(options.free), _names(options.free_start)
    tries = TRIES if options.tries is None else options.tries
    found = fitted(model, options.data, *free, known, options.huber, tries, more)
    print(json.dumps(found.record(), indent=1) if options.json else found.text(), end="")
    if picture:
        replace({picture: style.encoded(found.plot(), picture.suffix[1:])})
    return DONE


def _names(text: str | None) -> list[str]:
    return [name.strip() for name in (text or "").split(",") if name.strip()]


def _sizes(options: argparse.Namespace) -> dict[str, int]:
    return {k: int(x) for k, x in (text.split("=", 1) for text in getattr(options, "size", []))}
