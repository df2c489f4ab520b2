"""`pkgen methods`: lists the integration methods, or properties of user-defined methods."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from ..front.read import read_text
from ..own.given import given
from ..own.made import facts, fit
from ..own.tableau import read_tableau
from ..run.build import own_methods, runtime_methods
from ..run.methods_table import methods_text, own_text
from . import arguments as shared

EXAMPLES = """
pkgen methods
pkgen methods --composition "1/2,1/2"
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.own_methods(parser)
    parser.set_defaults(model="")


def run(options: argparse.Namespace) -> None:
    """List the integration methods, or the properties of a tableau or composition."""
    own = options.tableau or options.composition
    found, text = (_own(options), own_text) if own else (runtime_methods(), methods_text)
    print(json.dumps(found, indent=1) if options.json else text(found))


def _own(options: argparse.Namespace) -> list[dict[str, object]]:
    """Returns descriptions of the methods in options. pkgen cannot run implicit tableaux and
    describes only their coefficients."""
    found, run = [], []
    for path in options.tableau:
        tableau = read_tableau(read_text(path, "a tableau file"))
        if tableau.kind == "explicit":
            run.append(path)
        else:
            found.append({"name": fit(Path(path).stem), "facts": facts(tableau), "runs": False})
    own = given(argparse.Namespace(tableau=run, composition=options.composition))
    for one, described in zip(own, own_methods(own), strict=True):
        found.append({**described, "facts": dict(one.facts), "runs": True})
    return found
