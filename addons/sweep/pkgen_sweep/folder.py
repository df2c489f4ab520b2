"""Lets commands take the folder of a sweep in place of a model. The commands use the options of the
sweep's plan, the sweep's map, and its members."""

from __future__ import annotations

import argparse

from pkgen.compiler import Compilation
from pkgen.plot import view as views
from pkgen.plot.picture import Picture
from pkgen.run.ensemble import Settable
from pkgen.system.exits import UsageError

from . import map, page
from .job import AT_START
from .map import Map
from .shards import is_sweep
from .store import is_folder, place
from .sweep import lying

OF_A_MODEL = ("scene", "set", "start", "size", "until")


def is_one(name: str) -> bool:
    return is_sweep(place(name))


def picture(name: str, axes: list[str], column: str) -> Picture:
    """Returns the map of a sweep, for `pkgen plot`. Raises UsageError."""
    return map.read(place(name), axes, column).picture()


def taken(options: argparse.Namespace) -> Map:
    """Returns the map of a sweep. Sets `options` to the model in its folder and to the options of
    its plan; options that are given take precedence. Raises UsageError."""
    path = place(options.model)
    if not is_folder(path):
        raise UsageError(f"{path}: a live page is of a folder: copy it here first")
    axes = [] if options.map is None else views.split("--map", options.map)
    found = map.read(path, axes, options.columns or "", page.PIXELS)
    _, plan, _ = lying(path, options)
    for name in OF_A_MODEL:
        value = plan.options.get(name)
        if isinstance(value, list):
            setattr(options, name, [*value, *(getattr(options, name, None) or [])])
        elif value is not None and getattr(options, name, None) is None:
            setattr(options, name, value)
    if options.member is not None:
        for name, value in map.member(path, options.member).items():
            of = options.start if name.endswith(AT_START) else options.set
            of.append(f"{name.removesuffix(AT_START)}={value!r}")
    return found


def described(found: Map, compilation: Compilation) -> dict[str, object]:
    """Returns the sweep's map for a live page. In the address of the page, sampled starts and
    parameters are named by their kind and name, such as p.NAME."""
    settable = Settable(compilation)
    keys = {}
    for name in found.drawn:
        column = settable[name.removesuffix(AT_START)]
        kind = {"param": "p", "input": "u"}.get(column.kind, column.kind)
        keys[name] = f"{kind}.{column.name.rstrip(chr(39))}"
    return page.described(found, keys)
