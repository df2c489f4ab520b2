"""A sweep's folder in place of a model: the options of its plan, its map, its members."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from ..compiler import Compilation
from ..front.read import from_text
from ..plot import sweep
from ..plot import view as views
from ..plot.sweep import Map
from ..run.ensemble import Settable
from ..sweep.plan import of_text
from ..system.exits import UsageError

OF_A_MODEL = ("scene", "set", "start", "size", "until")
AT_START = "(0)"


def taken(options: argparse.Namespace) -> Map:
    """Its map. The model is that of the folder, and what the plan sets comes before what options
    say. Raises UsageError."""
    path = Path(options.model)
    axes = [] if options.map is None else views.split("--map", options.map)
    from ..plot.sweep_page import PIXELS

    found = sweep.read(path, axes, options.columns or "", PIXELS)
    try:
        known = json.loads((path / sweep.PLAN).read_text("utf-8"))
        options.model = str(path / Path(known["file"]).name)
        plan = of_text(from_text(str(path / "plan.toml"), (path / "plan.toml").read_text("utf-8")))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UsageError(f"{path}: it is not as it was begun: {error}") from None
    for name in OF_A_MODEL:
        value = plan.options.get(name)
        if isinstance(value, list):
            setattr(options, name, [*value, *(getattr(options, name, None) or [])])
        elif value is not None and getattr(options, name, None) is None:
            setattr(options, name, value)
    if options.member is not None:
        for name, value in sweep.member(path, options.member).items():
            of = options.start if name.endswith(AT_START) else options.set
            of.append(f"{name.removesuffix(AT_START)}={value!r}")
    return found


def described(found: Map, compilation: Compilation) -> dict[str, object]:
    """For the page, whose address says starts and parameters by kind."""
    from ..plot.sweep_page import described

    settable = Settable(compilation)
    keys = {}
    for name in found.drawn:
        column = settable[name.removesuffix(AT_START)]
        kind = {"param": "p", "input": "u"}.get(column.kind, column.kind)
        keys[name] = f"{kind}.{column.name.rstrip(chr(39))}"
    return described(found, keys)
