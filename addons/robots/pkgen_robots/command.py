"""`pkgen import`: converts a robot in URDF or MJCF to a model."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from pkgen import limits
from pkgen.compiler import check_model
from pkgen.front.read import from_text
from pkgen.system.exits import DONE
from pkgen.system.files import replace
from pkgen.system.resources import ResourcesExceeded, bounded
from pkgen_robots.read import imported

EXAMPLES = """
pkgen import robot.urdf -o robot.lag
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("model", metavar="ROBOT", help="a file in URDF or MJCF")
    add("-o", dest="output", metavar="FILE.lag", help="default: standard output")
    add("--base", choices=("fixed", "free"), default="fixed", help="how the root is held")


def run(options: argparse.Namespace) -> int:
    """Write a robot as a .lag file of bodies and joints; say what is left out of it."""
    text, robot = imported(options.model, options.base)
    notes = [*robot.notes(), *_checked(options.output or "robot.lag", text)]
    if options.output and options.output != "-":
        replace({Path(options.output): text})
    elif not options.json:
        sys.stdout.write(text)
    if options.json:
        made = {"file": options.output, "bodies": len(robot.links), "joints": len(robot.joints)}
        print(json.dumps(made | {"notes": notes}))
        return DONE
    for line in (f"{len(robot.links)} bodies, {len(robot.joints)} joints", *notes):
        print(line, file=sys.stderr)
    return DONE


def _checked(name: str, text: str) -> list[str]:
    """Checks the model as `pkgen check` does; returns notes. Raises ModelError."""
    try:
        with bounded(limits.CPU_SECONDS, limits.MEMORY_BYTES):
            check_model(from_text(name, text))
    except ResourcesExceeded:
        return ["not checked to the end, since it is large: pkgen check --max-seconds 100"]
    return []
