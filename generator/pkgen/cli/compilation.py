"""Compiles the model of a command within limits of time and memory, and prints warnings."""

from __future__ import annotations

import argparse
import math
from contextlib import AbstractContextManager

from .. import limits
from ..compiler import Compilation, compile_model
from ..front.read import read
from ..own.given import given
from ..scenes import lengths
from ..source import Diagnostic, Source
from ..system.exits import UsageError
from ..system.resources import bounded
from .messages import findings

SECONDS = (1e-3, 1_000_000)  # range of --max-seconds


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
    options: argparse.Namespace, source: Source | None = None, quiet: bool = False, **more: object
) -> Compilation:
    """Compiles a model; prints its warnings unless `quiet` or --json is set."""
    source = source or read(options.model)
    with within_limits(options):
        compilation = compile_model(
            source, sizes=lengths.given(options.size), own=given(options), **more
        )
    if not (options.json or quiet):
        warn(source, compilation.warnings)
    return compilation


def warn(source: Source, warnings: tuple[Diagnostic, ...]) -> None:
    for warning in warnings:
        findings(warning.text(source))
