"""Add-ons: what packages beside pkgen bring, found by their entry points.

    [project.entry-points."pkgen.commands"]
    film = "pkgen_film.command"

KINDS says what each group holds. A distribution may name an add-on that is not in it: that is said
when somebody asks for it.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from .exits import UsageError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

KINDS = {
    "commands": "a module with arguments(), run() and EXAMPLES; its package has the row, COMMANDS",
    "exports": "a Host of back/exported.py, by the name that --as takes",
    "options": "a module with arguments(), for the command before the dot: run.enclose",
    "folders": "a module with is_one(), picture(), taken(): a folder in place of a model",
}


@cache
def points(kind: str) -> dict[str, EntryPoint]:
    """The entry points of the group pkgen.KIND, by name."""
    from importlib.metadata import entry_points  # takes 35 ms: not for every command

    return {point.name: point for point in sorted(entry_points(group=f"pkgen.{kind}"))}


def package(point: EntryPoint) -> ModuleType:
    """The package of an add-on. Raises UsageError where it is not here."""
    name = point.value.partition(":")[0].partition(".")[0]
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        addon = name.removeprefix("pkgen_")
        whole = point.dist.name if point.dist else "it"
        raise UsageError(
            f"{point.name} is of the add-on {addon}, which is not here: install all of {whole}"
        ) from None


def load(kind: str, name: str) -> Any:
    """What an add-on brings. Raises UsageError where it is not here."""
    point = points(kind)[name]
    package(point)
    return point.load()


def here(kind: str) -> dict[str, EntryPoint]:
    """The entry points of a kind whose add-on is here."""
    found = {}
    for name, point in points(kind).items():
        try:
            package(point)
        except UsageError:
            continue
        found[name] = point
    return found


def of_folder(name: str) -> ModuleType | None:
    """The add-on whose folder stands there in place of a model or of rows."""
    if not (Path(name).is_dir() or "://" in name):
        return None
    modules = (load("folders", kind) for kind in here("folders"))
    return next((module for module in modules if module.is_one(name)), None)
