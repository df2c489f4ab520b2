"""`pkgen describe`: prints the names in a model, or all its data as JSON."""

from __future__ import annotations

import argparse
import json

from ..describe.page_data import describe
from .arguments import as_of_a_run, of_a_motion, own_methods
from .compilation import compile_within_limits

MOST = 12  # largest number of names per line of text

EXAMPLES = """
pkgen describe models/double_pendulum.lag
pkgen describe models/heavy_top.lag --scene nutation --json
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    as_of_a_run(parser)
    of_a_motion(parser)
    own_methods(parser)


def run(options: argparse.Namespace) -> None:
    """Names, units, bounds, starts, outputs, events, methods and drawings of a model, as JSON with
    --json."""
    found = describe(
        options, lambda options, **how: compile_within_limits(options, **how)
    ).description
    if options.json:
        print(json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False))
    else:
        print("\n".join(_lines(found)))


def _lines(found: dict) -> list[str]:
    """Returns lines of text with the names in a description."""
    lines = [f"{found['model']}: {found['description']}".rstrip(": ")]
    told = "parameters inputs coordinates states outputs constants events contacts"
    for what in told.split():
        names = [item["name"] for item in found.get(what, ()) if not item.get("hidden")]
        if names:
            more = f", ... ({len(names)})" if len(names) > MOST else ""
            lines.append(f"{what + ':':13} {', '.join(names[:MOST])}{more}")
    good = [m["name"] for m in found["methods"] if m["applies"]]
    lines.append(f"{'methods:':13} {', '.join(good)}")
    lines += [f"{'':13} not {m['name']}: {m['why']}" for m in found["methods"] if not m["applies"]]
    kinds = [shape["kind"] for shape in found["drawing"]["shapes"]]
    counted = ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))
    view = found["drawing"]["view"]
    where = "space" if view["kind"] == "space" else f"the plane {''.join(view['axes'])}"
    lines.append(f"{'drawing:':13} {counted} in {where}")
    return lines
