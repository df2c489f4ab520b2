"""The architecture on one page: from the text of a model to the text of its C.

    parse    text                 -> File        statements, each with its place
    check    File                 -> Model       names, units, bounds; every error of the author's
    derive   Model                -> Equations   M, f, p, h, Jacobians on one expression graph
    analyze  Equations            -> Structure   facts, each proved
    reduce   Equations, Structure -> the same    no more than is needed, with a report of what went
    lower    Equations, Structure -> Program     straight-line code, shared and hoisted
    render   Program              -> {name: text}

Each stage imports only what is above it, changes nothing that it is given, and prints nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .back import lower, render
from .back.lower import Program
from .equations import Equations, Structure
from .front import check
from .middle import analyze, derive, reduce
from .model import Model
from .source import Diagnostic, Source


@dataclass(frozen=True)
class Compilation:
    """What each stage made of one model."""

    model: Model
    warnings: tuple[Diagnostic, ...]
    equations: Equations
    structure: Structure
    report: reduce.Report
    program: Program
    files: dict[str, str]


def compile_model(
    source: Source,
    *,
    sizes: Mapping[str, int] | None = None,
    kernels: frozenset[str] | None = None,
    self_test: bool = False,
) -> Compilation:
    """Compile a model to C.

    `sizes` overrides `size` statements; `kernels` names those to emit (None: all);
    `self_test` adds a program that checks the kernels against each other.
    Raises ModelError with every finding of the stage that could not go on.
    """
    model, warnings = check.check_text(source, sizes or {})
    equations = derive.derive(model, kernels)
    structure = analyze.analyze(equations)
    equations, report = reduce.reduce(equations, structure)
    program = lower.lower(equations, structure, kernels)
    files = render.render(program, self_test=self_test)
    return Compilation(model, warnings, equations, structure, report, program, files)
