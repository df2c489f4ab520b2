"""The same motions by the C of this machine, in this process: what the page is compared with."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from pkgen.__main__ import parser_of
from pkgen.cli.compilation import compile_within_limits
from pkgen.describe.page_data import Described, describe
from pkgen.methods import known
from pkgen.run.build import build_library
from pkgen.run.library import load
from pkgen.run.settings import Shown


def made(model: Path) -> Described:
    """The model as the page has it, and its library."""
    options = parser_of("describe").parse_args([str(model)])
    of = describe(options, lambda options, **how: compile_within_limits(options, **how))
    made = of.compilation
    library = build_library(made.files, made.model.name, own=made.model.methods)  # of all methods
    return replace(of, library=library)


def rows(of: Described, method: dict, **more: object) -> tuple[str, list[list[float]]]:
    """Why it ended early, or ""; t, q and v in the order of the engine."""
    coordinates = of.description["coordinates"]
    states = of.description["states"]
    turning = [name for r in of.description["rotations"] for name in r["rates"]]
    name = method["name"]
    n = len(coordinates) + len(turning) + len(states)
    show = [Shown("q", k, "") for k in range(len(coordinates))]
    show += [Shown("v", k, "") for k in range(n)]
    settings = replace(
        of.settings,
        method=name,
        rows="dense" if "dense" in known(of.compilation.model.methods)[name].traits else "",
        show=tuple(show),
        max_steps=10_000_000,
        **more,
    )
    found = load(of.library).run(settings)
    return found.messages if found.code else "", found.rows().tolist()
