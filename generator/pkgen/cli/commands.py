"""What each command does: from its options to its exit code."""

from __future__ import annotations

import argparse
import json
import math
import sys
from contextlib import AbstractContextManager
from importlib.util import find_spec
from pathlib import Path

from .. import limits
from ..back.c.kernels import KERNELS
from ..back.c.kernels_canonical import CANONICAL
from ..compiler import Compilation, check_model, compile_model
from ..explain import explain as explanation
from ..explain import scenes as explain_scenes
from ..explain.dump import dump
from ..explain.html import html
from ..explain.loops import explain_loops, record_loops
from ..explain.scenes import scenes_shown
from ..front.read import read
from ..run.build import driver_methods
from ..run.methods_table import methods_text
from ..scenes import asked as parsing
from ..scenes import check as scene_check
from ..scenes import scene
from ..scenes import use as scene_use
from ..source import Diagnostic, ModelError, Source
from ..system.exits import DONE, UsageError
from ..system.files import replace
from ..system.resources import bounded

SECONDS = (1e-3, 1_000_000)  # of --max-seconds


def within_limits(options: argparse.Namespace) -> AbstractContextManager[None]:
    seconds = limits.CPU_SECONDS
    if options.max_seconds is not None:
        try:
            seconds = float(options.max_seconds)
        except ValueError:
            seconds = math.nan
        if not SECONDS[0] <= seconds <= SECONDS[1]:
            raise UsageError(
                f"--max-seconds {options.max_seconds}: give seconds, "
                f"from {SECONDS[0]:g} to {SECONDS[1]:,}"
            )
    return bounded(seconds, limits.MEMORY_BYTES)


def compile_within_limits(
    options: argparse.Namespace, source: Source | None = None, **more: object
) -> Compilation:
    """Compile the model of the command line; warnings go to standard error."""
    source = source or read(options.model)
    with within_limits(options):
        compilation = compile_model(source, sizes=parsing.sizes(options.size), **more)
    if not options.json:
        _warn(source, compilation.warnings)
    return compilation


def _warn(source: Source, warnings: tuple[Diagnostic, ...]) -> None:
    for warning in warnings:
        print(warning.text(source), file=sys.stderr)


def compile_to_c(options: argparse.Namespace) -> int:
    """Compile a model to C: DIR/NAME.h and DIR/NAME.c."""
    source = read(options.model)
    kernels = parsing.kernels(options.kernels, KERNELS)
    if options.dump:
        with within_limits(options):
            text = dump(options.dump, source, parsing.sizes(options.size), kernels, options.libm)
        print(text)
        return DONE
    compilation = compile_within_limits(
        options,
        source,
        kernels=kernels,
        self_test=options.self_test,
        canonical=options.canonical or bool(kernels and kernels & CANONICAL),
        libm=options.libm,
        portable=options.portable,
        use=scene_use.of_compile(options),
        symmetric=True,
    )
    if options.scene:
        chosen = scene.chosen(compilation.declared, options.scene)
        scene_check.refuse_method(compilation, chosen)
    directory = parsing.directory(options.directory)
    directory.mkdir(parents=True, exist_ok=True)
    replace({directory / name: text for name, text in compilation.files.items()})
    if options.json:
        files = [str(directory / name) for name in compilation.files]
        warnings = [w.record(source) for w in compilation.warnings]
        print(json.dumps({"files": files, "warnings": warnings}))
    return DONE


def check(options: argparse.Namespace) -> int:
    """Report the errors and warnings of a model, and write nothing."""
    source = read(options.model)
    sizes = parsing.sizes(options.size)
    with within_limits(options):
        model, warnings = check_model(source, sizes=sizes)
        # What other sizes than the file's make wrong of a scene, who chooses it hears.
        scenes = [item for item in model.scenes if not item.misfits]
        wrong = [d for item in scenes for d in scene_check.wrong(model, sizes, item)]
    if wrong:
        raise ModelError(source, wrong)
    if options.json:
        print(json.dumps({"diagnostics": [w.record(source) for w in warnings]}))
    else:
        _warn(source, warnings)
    return DONE


def explain(options: argparse.Namespace) -> int:
    """Show a model's equations and structure."""
    if find_spec("sympy") is None:
        raise UsageError("explain shows equations by SymPy, which is not installed; C needs none")
    compilation = compile_within_limits(
        options, symmetric=True, canonical=options.canonical, use=scene_use.of_compile(options)
    )
    with within_limits(options):
        if compilation.looped:
            shown, record = explain_loops, record_loops
        else:
            shown, record = explanation.explain, explanation.record
        scenes = [] if options.scene else scenes_shown(compilation, parsing.sizes(options.size))
        written = html(compilation, scenes) if options.html else ""
        text = ""
        if options.json:
            found = record(compilation) | {"scenes": explain_scenes.record(scenes)}
            text = json.dumps(found, indent=1)
        elif not options.html:
            text = shown(compilation).rstrip("\n")
            text += f"\n\n{explain_scenes.text(scenes)}" if scenes else ""
    if options.html:
        replace({Path(options.html): written})
    if text:
        print(text)
    return DONE


def methods(options: argparse.Namespace) -> int:
    """List the integration methods."""
    found = driver_methods()
    if options.json:
        print(json.dumps(found, indent=1))
        return DONE
    print(methods_text(found))
    return DONE
