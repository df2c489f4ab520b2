"""Add-ons: extensions in other Python packages, found by entry points such as

    [project.entry-points."pkgen.commands"]
    film = "pkgen_film.command"

KINDS describes the objects of each group. An entry point may name a package that is not installed;
then `package` and `load` raise an error when the entry point is used.
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
    "methods": "a function of a Model, its method in Python: fit",
    "options": "a module with arguments(), for the command before the dot: run.enclose",
    "folders": "a module with is_one(), picture(), taken(): a folder in place of a model",
    "pages": "a module with html(), by the command and option that write the page: run.report",
}


@cache
def points(kind: str) -> dict[str, EntryPoint]:
    """Returns the entry points of the group "pkgen.KIND", by name."""
    from importlib.metadata import entry_points  # not at the top, since this import takes 35 ms

    return {point.name: point for point in sorted(entry_points(group=f"pkgen.{kind}"))}


def missing(point: EntryPoint | None) -> str:
    """Returns a hint on how to install the package of an entry point; "" if the package is
    installed."""
    if point is None:
        return "of an add-on, which is not here: install all of pkgen-lag"
    name = _package_name(point)
    try:
        import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        addon = name.removeprefix("pkgen_")
        whole = point.dist.name if point.dist else "it"
        return f"of the add-on {addon}, which is not here: install all of {whole}"
    return ""


def package(point: EntryPoint) -> ModuleType:
    """Imports an add-on's package. Raises UsageError if it is not installed."""
    if where := missing(point):
        raise UsageError(f"{_shown(point.name)} is {where}")
    return import_module(_package_name(point))


def load(kind: str, name: str) -> Any:
    """Loads an add-on's object. Raises UsageError if it is not installed."""
    point = points(kind).get(name)
    if where := missing(point):
        raise UsageError(f"{_shown(name)} is {where}")
    return point.load()


def _package_name(point: EntryPoint) -> str:
    return point.value.partition(":")[0].partition(".")[0]


def _shown(name: str) -> str:
    return name.replace(".", " --")


def here(kind: str) -> dict[str, EntryPoint]:
    """Returns the entry points of a kind whose packages are installed."""
    return {name: point for name, point in points(kind).items() if not missing(point)}


def of_folder(name: str) -> ModuleType | None:
    """Returns the add-on that handles `name`, which a user gives in place of a model file. Returns
    None if `name` is no folder or URL, or if no add-on handles it."""
    if not (Path(name).is_dir() or "://" in name):
        return None
    modules = (load("folders", kind) for kind in here("folders"))
    return next((module for module in modules if module.is_one(name)), None)
