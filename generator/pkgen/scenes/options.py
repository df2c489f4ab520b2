"""Options that act like clauses of a scene: `--set` of an input to a function of t, and `--record`
of defined quantities. They are checked as a scene that is appended to the text of the model."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable
from dataclasses import replace

from ..front.check.check import check_text
from ..model import Model, Scene
from ..source import ModelError, Source
from ..system.exits import UsageError
from . import scene as scenes

OPTIONS = "0_options"  # name of the scene made from options if no scene is chosen
_WRITTEN = re.compile(r".*''|omega\(.*'|error\(")  # columns that are not names


def is_motion(text: str) -> bool:
    """Whether the value of an assignment, such as `u=sin(t)`, is a function of t."""
    _, _, value = text.partition("=")
    return bool(re.search(r"\bt\b", re.sub(r"\[[^\]]*\]", "", value)))


def _stems(column: str) -> set[str]:
    """Returns two names for a column such as `leg[2].com.x'`: `leg.com.x`, without indices and
    primes, and `leg.com`, without the last component."""
    name = re.sub(r"\[[^\]]*\]", "", column).partition("'")[0]
    return {name, name.rpartition(".")[0]}


def numbers(options: argparse.Namespace) -> list[str]:
    """Returns the assignments of `--set`, except those of functions of t."""
    return [text for text in options.set if not is_motion(text)]


def with_options(model: Model, options: argparse.Namespace, columns: Iterable[str]) -> Model:
    """Extends the chosen scene of a model by functions of t and columns in options. If no scene is
    chosen, adds a scene OPTIONS."""
    lets = {item.name for item in (*model.definitions, *model.inputs)}
    named = [c for c in columns if lets & _stems(c) or _WRITTEN.match(c)]
    clauses = [f"set {text}" for text in options.set if is_motion(text)]
    clauses += [f"record {', '.join(named)}"] if named else []
    own = [x for scene in model.scenes if scene.name == options.scene for x in scene.exacts]
    if clauses and own:
        clauses += [f"exact {', '.join(model.source.written(x.span) for x in own)}"]
    made, source = Scene(name=OPTIONS, span=model.span, exacts=model.exacts), model.source
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


def _made(model: Model, clauses: list[str]) -> tuple[Scene, Source]:
    """Returns a scene that consists of `clauses`, and the text of the model with this scene
    appended. Raises UsageError."""
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


def record_columns(options: argparse.Namespace) -> tuple[str, ...] | None:
    """Returns the names of columns in `--record`, or None if it is not set."""
    if options.record is None:
        return None
    names = (name.strip() for name in options.record.split(","))
    return tuple(re.sub(r"\s*([^\w\s])\s*", r"\1", name) for name in names)
