"""Compiles and describes a model from the options of a command."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from ..compiler import Compilation
from ..record import record
from ..run.library import load
from ..run.settings import Settings
from ..run.simulate import build
from ..scenes import compile_plan as scene_use
from ..scenes import lengths, scene
from ..scenes import run_settings as asked
from ..system.exits import NumericsFailed
from .describe import described
from .drawing import drawn


@record
class Described:
    """A compiled model and its description. No coordinates, parameters or kernels are left out of
    the model."""

    compilation: Compilation
    settings: Settings
    library: Path
    description: dict[str, object]


def describe(
    options: argparse.Namespace, compiled: Callable[..., Compilation], draw: bool = True
) -> Described:
    """Compiles a model, by `compiled(options, **how)`, and describes it. If `draw` is false, the
    compiled C has no outputs for the drawing. Raises UsageError, ModelError, BuildError, or
    NumericsFailed if the runtime refuses the parameters."""
    use = scene_use.whole(options)
    compilation = compiled(options, unroll=lengths.UNROLL, use=drawn(use) if draw else use)
    chosen = scene.of(options, compilation.declared)
    settings = asked.settings(options, compilation, chosen=chosen)
    library = build(compilation, settings, None)
    run = load(library).run(settings, idle=True, bare=True)
    if run.messages.strip():
        raise NumericsFailed(run.messages.strip())
    found = described(compilation, settings, run.given(), chosen, draw)
    return Described(compilation, settings, library, found)
