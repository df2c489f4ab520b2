"""`pkgen explain`: prints equations, their structure, and how scenes simplify them."""

from __future__ import annotations

import argparse
import dataclasses
import json
from importlib.util import find_spec
from pathlib import Path

from ..compiler import Compilation
from ..equations import Equations
from ..explain import scenes as explain_scenes
from ..explain.explain import explain, record
from ..explain.scenes import SceneShown, scene_shown
from ..middle.dependence import to_be_shown
from ..scenes import compile_plan as scene_use
from ..scenes import lengths
from ..system import addons
from ..system.exits import UsageError
from ..system.files import replace
from ..system.progress import say
from . import arguments as shared
from .compilation import compile_within_limits, within_limits

EXAMPLES = """
pkgen explain models/double_pendulum.lag
pkgen explain models/heavy_top.lag --scene nutation
"""
PAGE = "explain.html"  # entry point of the add-on that writes HTML


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scene", metavar="NAME", help="what one scene leaves of the model")
    shared.no_reduce(parser)
    shared.canonical(parser)
    shared.unrolling(parser)
    parser.add_argument("--html", metavar="FILE", help="a page with the equations typeset")


def explained(options: argparse.Namespace) -> tuple[str, str]:
    """Returns HTML about a model and its scenes (or the chosen scene), and the CSS of the HTML.
    Both are "" if SymPy or the add-on that writes pages is missing."""
    if find_spec("sympy") is None:
        return "", ""
    if where := addons.missing(addons.points("pages").get(PAGE)):
        say(f"no equations on the page: they are {where}")
        return "", ""
    page = addons.load("pages", PAGE)
    compilation = _shown(compile_within_limits(options, quiet=True, c=False, symmetric=True))
    scenes = _scenes(options, compilation, options.scene)
    with within_limits(options):
        return page.fragment(compilation, scenes, level=3), page.style()


def _shown(compilation: Compilation) -> Compilation:
    """Returns the compilation with M and f (of M a = f) simplified for display."""
    e = compilation.equations
    if not isinstance(e, Equations):
        return compilation
    return dataclasses.replace(compilation, equations=to_be_shown(e))


def _scenes(
    options: argparse.Namespace, compilation: Compilation, only: str | None = None
) -> list[SceneShown]:
    """Compiles each scene, or only the scene `only`; limits of time apply to each."""
    scenes = [s for s in compilation.declared.scenes if only == s.name or (s.listed and not only)]
    made = []
    for scene in scenes:
        with within_limits(options):
            made.append(scene_shown(compilation, lengths.given(options.size), scene))
    return made


def run(options: argparse.Namespace) -> None:
    """Show a model's equations and structure."""
    html = addons.load("pages", PAGE).html if options.html else None
    if find_spec("sympy") is None:
        raise UsageError("explain shows equations by SymPy, which is not installed; C needs none")
    compilation = compile_within_limits(
        options,
        c=False,
        symmetric=True,
        canonical=options.canonical,
        unroll=0 if options.unroll is None else lengths.unroll(options),
        use=scene_use.of_compile(options),
    )
    compilation = _shown(compilation)
    scenes = [] if options.scene else _scenes(options, compilation)
    with within_limits(options):
        written = html(compilation, scenes) if html else ""
        text = ""
        if options.json:
            found = record(compilation) | {"scenes": explain_scenes.record(scenes)}
            text = json.dumps(found, indent=1)
        elif not options.html:
            text = explain(compilation, options.verbose).rstrip("\n")
            text += f"\n\n{explain_scenes.text(scenes)}" if scenes else ""
    if options.html:
        replace({Path(options.html): written})
    if text:
        print(text)
