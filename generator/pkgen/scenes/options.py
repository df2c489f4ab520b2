"""What options of the command line say as a scene does: `--set` of an input to a function of t and
`--record` of definitions are checked as clauses of a scene behind the text of the model."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterable
from dataclasses import replace

from ..front.check.check import check_text
from ..model import Model, Scene
from ..source import ModelError, Source
from ..system.exits import UsageError
from . import model as scene_model
from . import scene as scenes

OPTIONS = "0_options"  # the scene that options make where none is chosen
_ACCELERATION = re.compile(r".*''|omega\(.*'")


def is_motion(text: str) -> bool:
    """Whether an assignment of the command line is of a function of t."""
    _, _, value = text.partition("=")
    return bool(re.search(r"\bt\b", re.sub(r"\[[^\]]*\]", "", value)))


def _stems(column: str) -> set[str]:
    """What the name of a column may be of, with and without a component: of `leg.com.x'` both
    `leg.com.x` and `leg.com`, of a member `leg[2].com.x` of a family too."""
    name = re.sub(r"\[[^\]]*\]", "", column).partition("'")[0]
    return {name, name.rpartition(".")[0]}


def numbers(options: argparse.Namespace) -> list[str]:
    """`--set`, but what has become part of the model."""
    return [text for text in options.set if not is_motion(text)]


def with_options(options: argparse.Namespace, columns: Iterable[str]) -> Callable[[Model], Model]:
    """What makes the chosen scene one with the inputs that options drive, and with the columns that
    are definitions; of neither there is a scene without clauses."""

    def declared(model: Model) -> Model:
        lets = {item.name for item in (*model.definitions, *model.inputs)}
        named = [c for c in columns if lets & _stems(c) or _ACCELERATION.match(c)]
        clauses = [f"set {text}" for text in options.set if is_motion(text)]
        clauses += [f"record {', '.join(named)}"] if named else []
        source = model.source
        made = Scene(name=OPTIONS, span=model.span)
        if clauses:
            made, source = _made(model, clauses)
        model = replace(model, source=source)
        if options.scene is None:
            return replace(model, scenes=(*model.scenes, replace(made, name=OPTIONS)))
        chosen = scenes.chosen(model, options.scene)
        record = chosen.record
        if made.record is not None:
            record = replace(record or made.record, columns=made.record.columns)
        both = (*chosen.assignments, *made.assignments)
        merged = replace(chosen, assignments=both, record=record)
        kept = (merged if s is chosen else s for s in model.scenes)
        return replace(model, scenes=tuple(kept))

    return declared


def _made(model: Model, clauses: list[str]) -> tuple[Scene, Source]:
    """The clauses as a scene. Raises UsageError with their place on the command line."""
    name = "_options"
    for text in clauses:
        if set(text) & {"\n", "#"}:
            raise UsageError(f"--{text[:60]}: one value on one line is needed")
    source = model.source.with_options(name, clauses)
    try:
        found, _ = check_text(source, {size.name: size.value for size in model.sizes})
    except ModelError as error:
        said = (d.text(source) for d in error.diagnostics)
        raise UsageError("\n".join(said)) from None
    return scenes.chosen(found, name), source


def columns_of(options: argparse.Namespace, declared: Model) -> tuple[str, ...]:
    """`--record`: vectors by their components."""
    name = options.scene or OPTIONS
    chosen = next((s for s in declared.scenes if s.name == name), None)
    return scene_model.written_out(declared, options.record.split(","), chosen)
