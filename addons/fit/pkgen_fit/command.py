"""`pkgen fit`: parameters and start values of a model from measured motions."""

from __future__ import annotations

import argparse
import json
import re

from pkgen.api.model import Model, load
from pkgen.cli import arguments as shared
from pkgen.cli.compilation import within_limits
from pkgen.cli.pictures import picture_file
from pkgen.plot import style
from pkgen.run import named
from pkgen.run.values import Values, assignment
from pkgen.scenes import lengths
from pkgen.system.exits import DONE, UsageError
from pkgen.system.files import replace
from pkgen.system.near import near

from .fit import UNBOUNDED, Known, fitted
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
        --free-start  NAMES         coordinates, rates and states whose start is free
        --prior       NAME=VALUE+-S+  prior value and standard deviation
        --sigma       NAME=VALUE+   standard deviation of a column (default: rms of its residuals)
        --huber       -             outliers count less
        --tries       int:N         starts besides the model's own values (default: {TRIES})
        --method      NAME          of the runs
        --step        H             of a method of fixed steps
        --rtol        R             of an adaptive method
        -o            FILE          a picture of the data, the motion and the residuals
    """
    shared.rows(parser, text)
    more = {"action": "append", "default": []}
    help_ = "range, within the bounds of the model; an end may be left out"
    parser.add_argument("--bound", metavar="NAME=LOW:HIGH", help=help_, **more)


def run(options: argparse.Namespace) -> int:
    """Fit parameters and start values to measured data, by least squares from several starts."""
    picture = picture_file("-o", options.o) if options.o else None
    with within_limits(options):
        model = load(options.model, options.scene, lengths.given(options.size))
    known = Known(
        {k: (a, b) for k, (a, b) in _numbers(options, model, "bound", ":").items()},
        {k: (a, b) for k, (a, b) in _numbers(options, model, "prior", "+-").items()},
        {k: a for k, (a,) in _numbers(options, model, "sigma", "").items()},
    )
    free = [re.findall(r"[^\s,]+", text or "") for text in (options.free, options.free_start)]
    tries = TRIES if options.tries is None else options.tries
    found = fitted(model, options.data, *free, known, options, huber=options.huber, tries=tries)
    print(json.dumps(found.record(), indent=1) if options.json else found.text())
    if picture:
        replace({picture: style.encoded(found.plot(), picture.suffix[1:])})
    return DONE


def _numbers(
    options: argparse.Namespace, model: Model, name: str, parts: str
) -> dict[str, list[float]]:
    """Returns the numbers of an option by the names of quantities, in SI units. A range may
    lack an end. Raises UsageError."""
    of, option, found = model.compilation, f"--{name}", {}
    values, units = Values(of), named.units(of, named.parameters(of))
    for text in getattr(options, name):
        left, value = assignment(option, text)
        words = value.split(parts) if parts else [value]
        if len(words) != (2 if parts else 1):
            raise UsageError(f"{option} {text}: give {option} NAME=A{parts}B")
        if left not in units:
            raise UsageError(f"{option} {left}: {near(left, [*units], 'quantity')}")
        found[left] = [
            end
            if parts == ":" and not word.strip()
            else values.value(option, word.strip(), units[left], left)
            for word, end in zip(words, UNBOUNDED, strict=False)
        ]
    return found
