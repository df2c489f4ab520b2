"""`pkgen continue`: equilibria and periodic orbits along a parameter."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy

from pkgen.api import arguments as of_api
from pkgen.cli import arguments as shared
from pkgen.cli.compilation import compile_within_limits
from pkgen.compiler import Compilation
from pkgen.scenes.compile_plan import whole
from pkgen.system.exits import DONE, UsageError

from .branches import Branches, made
from .family import Family, asked

EXAMPLES = """
pkgen continue models/bead_on_hoop.lag --free Omega=0:8
pkgen continue models/particles/kepler.lag --orbit start --free energy=-1:-0.3 --json
"""
PICTURES = (".svg", ".png", ".pdf")


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.as_of_a_run(parser)
    shared.of_a_state(parser)
    text = """
        --period   T     first guess of the period; with a periodic forcing: its period
        --section  EVENT orbits as fixed points of the map from one such event to the next
        --close    a=b,… of --section: starts or parameters, and what has their values again
        --show     NAME  state on the picture, or period (default: the first)
    """
    help_ = "a parameter or input and its range, or of an orbit the energy"
    parser.add_argument("--free", metavar="NAME=FROM:TO", help=help_)
    shared.rows(parser, text)
    help_ = "a picture: FILE.svg, FILE.png or FILE.pdf"
    parser.add_argument("-o", "--output", metavar="FILE", help=help_)
    help_ = "periodic orbits from the motion of the start, from small ones about an equilibrium, "
    help_ += "or from each Hopf bifurcation of the equilibria"
    parser.add_argument("--orbit", choices=("start", "centre", "hopf"), help=help_)
    parser.set_defaults(until=None)


def run(options: argparse.Namespace) -> int:
    """Follow equilibria or periodic orbits along a parameter; their bifurcations and stability."""
    if options.free is None:
        raise UsageError("give a parameter and its range: --free NAME=FROM:TO")
    picture = options.output and Path(options.output)
    if picture and picture.suffix not in PICTURES:
        raise UsageError(f"-o {picture}: the file's name must end in .svg, .png or .pdf")
    if options.show and not picture:
        raise UsageError("--show is of a picture: -o FILE.svg")
    _keep_free(options)
    found = of_compiled(options, compile_within_limits(options, unroll=None, use=whole(options)))
    if picture:
        found.plot(picture, options.show)
    print(json.dumps(found.record(), indent=1) if options.json else found.text())
    return DONE


def _keep_free(options: argparse.Namespace) -> None:
    """Adds the free parameter to --set, so that a scene does not fold it to a constant. `energy` is
    no parameter."""
    name, low, _ = asked(options.free)
    given = [x.partition("=")[0].strip() for x in options.set]
    options.own_set = options.set
    if options.scene and name != "energy" and name not in given:
        options.set = [*options.set, f"{name}={low}"]


def of_model(model: Any, free: str, range: tuple[Any, Any], **more: Any) -> Branches:
    """Returns the branches of a pkgen.Model."""
    given = {k: more.pop(k, None) for k in ("start", "inputs")}
    kinds = ("orbit", "period", "section", "close")
    if unknown := more.keys() - {*kinds}:
        raise TypeError(f"branches() has no argument {sorted(unknown)[0]!r}")
    with of_api.in_words():
        options = of_api.options(model, given)
        low, high = (of_api.text(x) for x in range)
        options.free = f"{free}={low}:{high}"
        for name in kinds:
            value = more.get(name)
            setattr(options, name, value if value is None else of_api.text(value))
        _keep_free(options)
        return of_compiled(options, model._compiled(options, unroll=None, use=whole(options)))


@numpy.errstate(all="ignore")
def of_compiled(options: argparse.Namespace, compilation: Compilation) -> Branches:
    """Returns the branches of a compiled model. Raises UsageError, ModelError, BuildError."""
    from . import begin
    from .equilibria import Equilibria
    from .follow import followed
    from .returns import Returns

    family = Family(options, compilation)
    sets = () if family.name is None else (family.name,)
    found = []
    if options.section is not None:
        if options.orbit is not None:
            raise UsageError("--section finds orbits by itself, without --orbit")
        problem = Returns(family, options)
        found += made("returns", followed(problem.seeds(), family.range), sets)
        return Branches(compilation.model.name, family.title, family.unit, tuple(found))
    if options.close is not None:
        raise UsageError("--close is of a return map: --section EVENT")
    if options.orbit in (None, "hopf"):
        if family.name is None:
            raise UsageError("--free energy is of orbits: --orbit start or centre")
        paths = followed(Equilibria(family).seeds(), family.range)
        found += made("equilibria", paths, sets)
    if options.orbit is not None:
        seeds = {
            "start": lambda: begin.from_start(family, options.period),
            "centre": lambda: begin.from_centre(family),
            "hopf": lambda: begin.from_hopf(family, paths),
        }[options.orbit]()
        found += made("orbits", followed(seeds, family.range), sets)
    return Branches(compilation.model.name, family.title, family.unit, tuple(found))
